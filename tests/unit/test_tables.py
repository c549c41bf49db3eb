"""The shipped tables are those of the grammar; what is damaged or of another grammar is never used."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from random import Random

import pytest

from support.length import amount
from trackmarshal.source import SourceFile
from trackmarshal.syntax import grammar as grammar_module
from trackmarshal.syntax import tables as module
from trackmarshal.syntax.parser import parse
from trackmarshal.syntax.tables import SHIPPED, grammar_hash, seal, tables

SPEC = SourceFile("t.spec", "module m\nrule r\n  require a <= b\n")
COMMAND = "python -m trackmarshal.syntax.tabulate"


@pytest.fixture
def fresh(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A place for tables of one's own, a cache of one's own, and nothing read yet."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    path = tmp_path / "spec.tables"
    shutil.copy(SHIPPED, path)
    monkeypatch.setattr(module, "SHIPPED", path)
    tables.cache_clear()
    grammar_hash.cache_clear()
    yield path
    tables.cache_clear()
    grammar_hash.cache_clear()


def test_the_command_that_renews_them_is_named_where_the_grammar_is_edited() -> None:
    assert COMMAND in SHIPPED.with_name("spec.lark").read_text("utf-8")


@pytest.mark.parametrize("order", ["1", pytest.param("2", marks=pytest.mark.acceptance)])
def test_the_shipped_tables_are_those_of_the_grammar_whatever_the_order_of_sets(order: str) -> None:
    code = (
        "import sys; sys.modules['interegular'] = None\n"  # the look for colliding terminals is for tests of the grammar
        "from trackmarshal.syntax.tabulate import tabulate; sys.stdout.buffer.write(tabulate())"
    )
    environment = {**os.environ, "PYTHONHASHSEED": order}
    done = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, check=True)
    assert done.stdout == SHIPPED.read_bytes(), f"the grammar has changed: `{COMMAND}` makes its tables anew"


def test_reading_the_shipped_tables_needs_no_lark_and_no_cache(tmp_path: Path) -> None:
    code = (
        "import sys; from trackmarshal.syntax.parser import parse; from trackmarshal.source import SourceFile;"
        f"tree, found = parse(SourceFile('t.spec', {SPEC.text!r})); print(len(tree.items), found, 'lark' in sys.modules)"
    )
    environment = {**os.environ, "TRACKMARSHAL_CACHE": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True
    )
    assert done.stdout == "2 [] False\n"
    assert not list(tmp_path.glob("cache/*"))


def test_any_flipped_bit_is_noticed(fresh: Path) -> None:
    whole = SHIPPED.read_bytes()
    head = whole.index(b"\n") + 1
    random = Random(1)
    for at in [*range(head), *(random.randrange(head, len(whole)) for _ in range(amount(100, 500)))]:
        damaged = bytearray(whole)
        damaged[at] ^= 1 << random.randrange(8)
        fresh.write_bytes(damaged)
        assert module._opened(fresh) is None


@pytest.mark.parametrize("damage", ["empty", "half", "longer", "missing", "folder", "another form"])
def test_damaged_tables_are_made_anew_and_kept(
    damage: str, fresh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = SHIPPED.read_bytes()
    fresh.unlink()
    if damage == "folder":
        fresh.mkdir()
    elif damage != "missing":
        changed = {
            "empty": b"", "half": whole[: len(whole) // 2], "longer": whole + b" ", "another form": whole.replace(b" 1 ", b" 0 ", 1),
        }  # fmt: skip
        fresh.write_bytes(changed[damage])
    made: list[int] = []

    def again() -> bytes:
        made.append(1)
        return whole

    monkeypatch.setattr("trackmarshal.syntax.tabulate.tabulate", again)
    for _ in range(2):
        tables.cache_clear()
        assert not parse(SPEC)[1]
    assert made == [1]


@pytest.mark.parametrize("by", ["exchange", pytest.param("lark", marks=pytest.mark.acceptance)])
def test_a_changed_grammar_is_used_at_once(by: str, fresh: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the tables that lark makes of it, which takes its time, or with the shipped ones in which one word is another."""
    grammar = grammar_module.grammar
    text = SourceFile("t.spec", "module m\nrule r\n  demand a <= b\n")
    assert parse(text)[1]

    def changed() -> str:
        return grammar().replace("/require(?!", "/demand(?!")

    monkeypatch.setattr(grammar_module, "grammar", changed)
    monkeypatch.setattr(module, "grammar", changed)
    if by == "exchange":
        body = SHIPPED.read_bytes().partition(b"\n")[2].decode("ascii")
        word = '["_REQUIRE","word","require","r"]'
        assert body.count(word) == 1
        monkeypatch.setattr(
            "trackmarshal.syntax.tabulate.tabulate",
            lambda: seal(body.replace(word, '["_REQUIRE","word","demand","d"]').encode("ascii")),
        )
    tables.cache_clear()
    grammar_hash.cache_clear()
    tree, found = parse(text)
    assert not found
    assert len(tree.items) == 2
    # The tables in the cache, of this grammar, are of no use to the other one.
    monkeypatch.undo()
    tables.cache_clear()
    grammar_hash.cache_clear()
    assert parse(text)[1]
