"""Whatever lies in the cache, a file's tree is the one that parsing gives."""

from __future__ import annotations

import contextlib
import os
import pickle
import subprocess
import sys
import time
from pathlib import Path
from random import Random

import pytest

from support.length import amount
from trackmarshal.node import Node
from trackmarshal.source import SourceFile, Span
from trackmarshal.syntax import ast, trees
from trackmarshal.syntax.packed import unpack
from trackmarshal.syntax.parser import parse
from trackmarshal.syntax.trees import parse_kept

TEXT = 'module m\nrule r "Title"\n  for all p in plan where not (p.x < 1 m)\n  require (a <= b) and p.v in [0 m/s, 5 m/s]\n'
SAMPLE = Path(__file__).parents[1] / "property" / "strategies" / "sample.spec"


@pytest.fixture(autouse=True)
def root(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    path = tmp_path / "cache"
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(path))
    return path


def spec(text: str = TEXT) -> SourceFile:
    return SourceFile("t.spec", text)


def entries(root: Path) -> list[Path]:
    return [path for path in sorted(root.rglob("*")) if path.is_file() and "grammar" not in path.name]


def entry(root: Path) -> Path:
    """The file of the cache that holds the tree of TEXT."""
    assert not parse_kept(spec())[1]
    (path,) = entries(root)
    return path


def places(tree: ast.Module) -> list[tuple[str, int, int, str, bool]]:
    """What equality leaves out."""
    spans: list[tuple[Node, Span]] = [(node, node.__dict__["span"]) for node in tree.walk()]
    return [(type(node).__name__, s.start, s.end, s.file.path, s.file.text == TEXT) for node, s in spans]


def same(tree: ast.Module) -> bool:
    expected = parse(spec())[0]
    return (
        tree == expected
        and places(tree) == places(expected)
        and parenthesised(tree) == parenthesised(expected)
    )


def parenthesised(tree: ast.Module) -> list[bool]:
    return [ast.is_parenthesised(node) for node in tree.walk() if isinstance(node, ast.Expr)]


def test_a_kept_tree_is_the_parsed_one(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry(root)
    monkeypatch.setattr(trees, "parse", lambda file: pytest.fail("parsed again"))
    tree, found = parse_kept(spec())
    assert not found
    assert same(tree)
    assert any(parenthesised(tree))


def test_a_flipped_bit_in_any_byte_is_noticed(root: Path) -> None:
    path = entry(root)
    whole = path.read_bytes()
    expected = parse(spec())[0]
    random = Random(1)
    for at in (*range(90), *range(90, len(whole), amount(5, 1))):  # the head, and what its hash is of
        damaged = bytearray(whole)
        damaged[at] ^= 1 << random.randrange(8)
        path.write_bytes(damaged)
        tree, found = parse_kept(spec())
        assert not found
        assert path.read_bytes() == whole  # made anew
        assert tree == expected
    assert same(tree)


@pytest.mark.parametrize(
    "damage",
    ["empty", "half", "a byte less", "a byte more", "zeros", "folder", "pickle", "JSON", "head only"],
)
def test_damaged_entries_are_made_anew(damage: str, root: Path) -> None:
    path = entry(root)
    whole = path.read_bytes()
    path.unlink()
    if damage == "folder":
        path.mkdir()
    else:
        changed = {
            "empty": b"", "half": whole[: len(whole) // 2], "a byte less": whole[:-1], "a byte more": whole + b"\n",
            "zeros": bytes(len(whole)), "pickle": pickle.dumps(os.getcwd), "JSON": b"[0, 0, 0]", "head only": whole.split(b"\n")[0],
        }  # fmt: skip
        path.write_bytes(changed[damage])
    assert same(parse_kept(spec())[0])
    assert same(parse_kept(spec())[0])


def test_the_entry_of_another_file_is_not_taken(root: Path) -> None:
    path = entry(root)
    parse_kept(spec(TEXT.replace("<=", ">=")))
    (other,) = set(entries(root)) - {path}
    os.replace(other, path)
    assert same(parse_kept(spec())[0])


def test_nothing_of_the_cache_is_run(root: Path, tmp_path: Path) -> None:
    path = entry(root)
    code = f"""c__main__\n(S'touch {tmp_path / "run"}'\ntR."""
    for text in (
        code.encode(),
        pickle.dumps(spec),
        b"cos\nsystem\n(S'touch %s'\ntR." % str(tmp_path / "run").encode(),
    ):
        path.write_bytes(text)
        assert same(parse_kept(spec())[0])
    assert not (tmp_path / "run").exists()
    code = "import sys; sys.argv = ['', 'check', '--quiet', 'specs/supervisor']; from trackmarshal.cli.main import main; main(sys.argv[1:])"
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", f"{code}; print('pickle' in sys.modules)"],
            cwd=SAMPLE.parents[3],
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.splitlines()[-1] == "False"


def test_random_trees_with_the_right_hash_never_raise(root: Path) -> None:
    # Nobody damages a hash with its content; what reads the content may not rely on that.
    path = entry(root)
    whole = path.read_bytes().partition(b"\n")[2]
    random = Random(2)
    for turn in range(1000):
        body = bytearray(whole)
        for _ in range(random.randrange(1, 4)):
            at = random.randrange(len(body))
            body[at : at + random.choice([0, 1, 1, 5])] = random.choice(
                [b"[", b"]", b"9", b"-", b",", b'"', b"null", b"[]", b"1e9", b"true"]
            )
        with contextlib.suppress(ValueError):  # what is refused so is made anew
            assert isinstance(unpack(bytes(body), spec()), ast.Module)
        if turn % amount(10, 1):
            continue
        path.write_bytes(trees._head(path.name, bytes(body)) + b"\n" + bytes(body))
        tree, found = parse_kept(spec())
        assert not found
        assert isinstance(tree, ast.Module)


def test_files_with_findings_are_not_kept(root: Path) -> None:
    for _ in range(2):
        assert [d.code for d in parse_kept(spec("module m\nrule r require a = b\n"))[1]] == ["E101"]
    assert entries(root) == []


def test_the_same_text_under_another_name_reports_its_own_name(root: Path) -> None:
    entry(root)
    tree, _ = parse_kept(SourceFile("other.spec", TEXT))
    assert {node.__dict__["span"].file.path for node in tree.walk()} == {"other.spec"}


def test_two_thousand_files_are_all_kept(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = [spec(f"module m{number}\n") for number in range(2000)]
    for file in files:
        parse_kept(file)
    monkeypatch.setattr(trees, "parse", lambda file: pytest.fail("parsed again"))
    for file in files:
        assert parse_kept(file)[0].items[0].__dict__["name"] == file.text.split()[1]


def test_what_was_not_used_for_longest_goes(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    files = [spec(f"module m{number}\n") for number in range(20)]
    written: dict[Path, int] = {}
    for number, file in enumerate(files):
        parse_kept(file)
        (path,) = set(entries(root)) - set(written)
        written[path] = number
        os.utime(path, (time.time() - 1e6 + number,) * 2)
    left = next(iter(written)).parent / "left.tmp"
    left.write_bytes(b"")
    os.utime(left, (1e9, 1e9))
    parse_kept(files[0])  # a use
    monkeypatch.setattr(trees, "BUDGET", 4096 * 12)
    trees._swept.cache_clear()
    parse_kept(spec("module one_more\n"))
    kept = {written[path] for path in entries(root) if path in written}
    assert kept == {0, *range(10, 20)}
    assert not left.exists()


@pytest.mark.parametrize(
    "broken", ["a file", "below a file", "no home", "trees is a file", "not writable", "full"]
)
def test_without_a_cache_everything_is_parsed(
    broken: str, root: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    if broken == "a file":
        root.write_bytes(b"")
    elif broken == "below a file":
        (tmp_path / "file").write_bytes(b"")
        monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "file" / "cache"))
    elif broken == "no home":
        monkeypatch.delenv("TRACKMARSHAL_CACHE")
        monkeypatch.delenv("XDG_CACHE_HOME", raising=False)

        def homeless() -> Path:
            raise RuntimeError("Could not determine home directory.")

        monkeypatch.setattr(Path, "home", homeless)
    elif broken == "trees is a file":
        root.mkdir()
        (root / "trees").write_bytes(b"")
    elif broken == "not writable":
        monkeypatch.setattr(os, "access", lambda path, mode: False)
    else:

        def full(*_: object, **__: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(os, "replace", full)
    for _ in range(2):
        tree, found = parse_kept(spec())
        assert not found
        assert same(tree)
    assert not list(tmp_path.rglob("*.tmp"))


def test_processes_at_once_see_whole_trees(root: Path) -> None:
    code = (
        "from trackmarshal.syntax.trees import parse_kept\nfrom trackmarshal.syntax.parser import parse\n"
        "from trackmarshal.source import read\nfrom pathlib import Path\nimport os, sys\n"
        f"file = read(Path({str(SAMPLE)!r})); expected = parse(file)[0]\n"
        f"for turn in range({amount(80, 200)}):\n"
        "    assert parse_kept(file)[0] == expected\n"
        "    if turn % 3 == 0:\n"
        "        for path in Path(os.environ['TRACKMARSHAL_CACHE']).rglob('*'):\n"
        "            try: path.is_file() and path.unlink()\n"
        "            except OSError: pass\n"
    )
    running = [subprocess.Popen([sys.executable, "-c", code]) for _ in range(3)]
    assert [process.wait() for process in running] == [0, 0, 0]


def test_the_version_of_the_tool_is_part_of_the_key(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    entry(root)
    monkeypatch.setattr(trees, "_tool_digest", lambda: b"another version")
    parse_kept(spec())
    assert len(entries(root)) == 2
