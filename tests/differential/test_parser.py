"""Our parser against lark's own, which is made from the same grammar: the same tree, or an error at the same place."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from random import Random
from typing import Any
from unittest import mock

import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st
from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from property.strategies.ast import modules
from support.length import amount, shared_out
from trackmarshal.source import SourceFile
from trackmarshal.syntax import ast, lalr
from trackmarshal.syntax.format import format_module
from trackmarshal.syntax.grammar import make_parser
from trackmarshal.syntax.parser import _START

REPOSITORY = Path(__file__).parents[2]
#: Those that parse, and those that messages are held against.
SHIPPED = [
    *REPOSITORY.glob("specs/**/*.spec"),
    *REPOSITORY.glob("engine/trackmarshal/prelude/*.spec"),
    REPOSITORY / "tests" / "property" / "strategies" / "sample.spec",
]
GOLDEN = sorted(REPOSITORY.glob("tests/golden/s*/**/*.spec"))
SPECS = [*SHIPPED, *GOLDEN]
unhurried = settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
    max_examples=amount(20, 150),
)


@cache
def lark() -> Lark:
    """Without a look for colliding terminals, which takes most of the time: that is for tests of the grammar."""
    with mock.patch("lark.lexer.has_interegular", False):
        return make_parser()


class Recorder:
    """A builder that only notes what it is called with."""

    def __getattr__(self, node: str) -> Callable[[tuple[int, int], list[Any]], Any]:
        return lambda place, children: (node, place, [self.noted(child) for child in children])

    @staticmethod
    def noted(child: Any) -> Any:
        return (child.type, str(child), child.start_pos) if isinstance(child, lalr.Token) else child


def noted(tree: Any) -> Any:
    """Lark's tree in the same form."""
    if isinstance(tree, Tree):
        return (
            str(tree.data),
            (tree.meta.start_pos, tree.meta.end_pos),
            [noted(child) for child in tree.children],
        )
    if isinstance(tree, Token):
        return (tree.type, str(tree), tree.start_pos)
    return tree


def pieces(text: str) -> list[str]:
    starts = [match.start() for match in _START.finditer(text)]
    return [text[start:end] for start, end in zip(starts, [*starts[1:], len(text)])]


def agree(text: str) -> bool:
    """Hold both parsers' answers on one declaration against each other; whether it parsed."""
    try:
        expected = noted(lark().parse(text))
    except UnexpectedInput as error:
        with pytest.raises(lalr.Unexpected) as caught:
            lalr.parse(text, Recorder(), len(text) + 10)
        ours = caught.value
        if isinstance(error, UnexpectedToken):
            if error.token.type == "$END":
                assert ours.found == ""
            else:
                assert (ours.start, ours.found) == (error.token.start_pos, str(error.token))
        else:
            assert isinstance(error, UnexpectedCharacters)
            assert ours.start == error.pos_in_stream
            assert ours.found is None
        assert lalr.accepted(text[: ours.start]) == accepted(text[: ours.start])
        return False
    assert lalr.parse(text, Recorder(), len(text) + 10) == expected
    return True


def accepted(before: str) -> set[str]:
    interactive = lark().parse_interactive(before)
    try:
        interactive.exhaust_lexer()
    except UnexpectedInput as error:
        return set(getattr(error, "accepts", None) or getattr(error, "allowed", None) or ())
    return set(interactive.accepts())  # type: ignore[no-untyped-call]


@pytest.mark.parametrize("path", [*SHIPPED, *shared_out(GOLDEN, 3)], ids=lambda path: path.stem)
def test_every_declaration_of_the_specs_at_hand(path: Path) -> None:
    """Of tests, of which some specs have hundreds that are written alike, one in four every day: of all text at hand they are four fifths."""
    found = pieces(path.read_text("utf-8-sig", "replace").replace("\r\n", "\n"))
    tests = [piece for piece in found if piece.startswith("test ")]
    left_out = {*tests} - {*tests[:: amount(4, 1)]}
    for piece in found:
        if piece not in left_out:
            agree(piece)


def test_the_specs_at_hand_parse() -> None:
    found = [piece for path in SHIPPED for piece in pieces(path.read_text("utf-8"))]
    for piece in found:
        lalr.parse(piece, Recorder(), len(piece) + 10)
    assert len(found) > 300


@unhurried
@given(modules())
def test_generated_declarations(module: ast.Module) -> None:
    for piece in pieces(format_module(module, SourceFile("made.spec", ""))):
        assert agree(piece)


@unhurried
@given(st.sampled_from(SPECS), st.randoms(use_true_random=False))
def test_damaged_declarations(path: Path, random: Random) -> None:
    text = path.read_text("utf-8-sig", "replace").replace("\r\n", "\n")
    piece = random.choice(pieces(text) or [text])
    words = text.split()
    for _ in range(random.randrange(1, 4)):
        at = random.randrange(len(piece) + 1)
        put = random.choice(
            [random.choice(words), f" {random.choice(words)} ", *' ()[]{}|:,.;=<>!^*/+-~"\n²√≤∈−κ5m']
        )
        piece = piece[:at] + put + piece[at + random.choice([0, 0, 1, 3]) :]
    agree(piece)


@unhurried
@given(st.text(st.sampled_from("am1. -/^*²·κ\n(),:<=>in[]%E"), max_size=12))
@example("3 m/s/ s")
@example("1 1/m")
@example("A-1-b")
@example("5 m/x")
@example("- - a")
@example("---")
def test_numbers_units_and_names_side_by_side(text: str) -> None:
    agree(f"rule r require a {text}")
    agree(f"param p : {text} = 1")
    agree(f"rule {text}")
