"""Requirements files are read without trust: places are right, and whatever is not plain data is refused."""

from __future__ import annotations

import pytest

from trackmarshal.trace.documents import DOCUMENTS
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.tree import MAX_DEPTH, Listing, Mapping, Node, Scalar, parse
from trackmarshal.trace.values import Reader


def read(text: str | bytes) -> tuple[Node | None, list[Finding]]:
    found: list[Finding] = []
    return parse(text.encode() if isinstance(text, str) else text, "f.yaml", found), found


def plain(node: Node | None) -> object:
    match node:
        case Scalar():
            return node.text
        case Listing():
            return [plain(item) for item in node.items]
        case Mapping():
            return {key: plain(value) for key, value in node.entries.items()}
    return None


def test_values_and_places() -> None:
    node, found = read("a: 1\nb:\n  - x\n  - {c: 'y'}\n")
    assert found == []
    assert plain(node) == {"a": "1", "b": ["x", {"c": "y"}]}
    assert isinstance(node, Mapping)
    listing = node.entries["b"]
    assert isinstance(listing, Listing)
    assert [(item.line, item.column) for item in listing.items] == [(3, 5), (4, 5)]
    assert (node.keys["b"].line, node.keys["b"].column) == (2, 1)


@pytest.mark.parametrize("text", ["a: 1\r\nb: 2\r\n", "\ufeffa: 1\nb: 2\n"], ids=["CRLF", "byte order mark"])
def test_line_ends_and_byte_order_mark(text: str) -> None:
    node, found = read(text)
    assert found == []
    assert plain(node) == {"a": "1", "b": "2"}
    assert isinstance(node, Mapping)
    assert (node.keys["b"].line, node.keys["b"].column) == (2, 1)


def test_quotes_are_remembered() -> None:
    node, _ = read("a: 1\nb: '1'\n")
    assert isinstance(node, Mapping)
    values = [node.entries[key] for key in "ab"]
    assert [value.plain for value in values if isinstance(value, Scalar)] == [True, False]


@pytest.mark.parametrize(
    ("value", "comment"),
    [
        ("gate #4 and gate #5", "#4 and gate #5"),
        ("gate\t# four", "# four"),
        ("over\n  two lines # four", "# four"),
        ("größer \U0001f6a6  # four", "# four"),
        ("gate#4", ""),
        ("gate", ""),
        ("'gate #4' # four", ""),
        ('"gate" # four', ""),
        ("|- # four\n  gate #4", ""),
        ("gate\n# four", ""),
    ],
)
@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_a_comment_behind_a_text_without_quotes_is_remembered(value: str, comment: str, ends: str) -> None:
    node, found = read(f"\ufeffa: {value}\nb: c\n".replace("\n", ends))
    assert found == []
    assert isinstance(node, Mapping)
    scalar = node.entries["a"]
    assert isinstance(scalar, Scalar)
    assert scalar.comment == comment


@pytest.mark.parametrize(
    "line",
    [
        "    statement: The car shall stop before gate #4 and before every pedestrian.",
        "    rationale: Somebody stands there # or walks",
        "    foreign: {Release: autumn #2\n      }",
    ],
)
def test_no_text_is_cut_off_in_silence(line: str) -> None:
    """What ` #` begins was lost: of the first one, nobody was told that pedestrians are not demanded."""
    assert [finding.code for finding in _requirement(line)] == ["T114"]


@pytest.mark.parametrize(
    "line",
    [
        "    asil: QM # as the others",
        "    verification: [test] # and more",
        "    refines: [R-2, # the first\n      R-3] # the second",
        "    statement: 'The car shall stop.' # before gate 4",
        "    statement: >- # folded\n      The car shall stop before gate #4.",
    ],
)
def test_comments_elsewhere_are_comments(line: str) -> None:
    assert _requirement(line) == []


def _requirement(line: str) -> list[Finding]:
    """What is said of a requirement with this line, but for what it lacks."""
    text = f"document: requirements # all\ntitle: Conduct\nrequirements:\n  - id: R-1 # stays\n{line}\n"
    found: list[Finding] = []
    node, _ = read(text)
    assert node is not None
    Reader("f.yaml", found).table(node, DOCUMENTS["requirements"], "the document")
    return [finding for finding in found if finding.code != "T120"]


@pytest.mark.parametrize(
    ("text", "code", "line"),
    [
        (b"", "T103", 1),
        (b"\xef\xbb\xbf\n", "T103", 1),
        (b"# nothing\n", "T103", 1),
        (b"a: 1\nb: \xff\n", "T104", 2),
        ("a: ü\n".encode("utf-16"), "T104", 1),
        (b"a: 1\nb: \x00\n", "T105", 2),
        (b"a: [1\n", "T105", 2),
        (b"a: 1\n---\nb: 2\n", "T106", 2),
        (b"a: 1\n*x\n", "T105", 3),
        (b"a: &x 1\n", "T107", 1),
        (b"a: !!binary aGVsbG8=\n", "T108", 1),
        (b"a: 1\nb: 2\na: 3\n", "T109", 3),
        (b"a: {b: 1, b: 2}\n", "T109", 1),
        (b"? {x: 1}\n: 2\n", "T111", 1),
    ],
)
def test_refused(text: bytes, code: str, line: int) -> None:
    _, found = read(text)
    assert [finding.code for finding in found] == [code]
    assert found[0].place is not None
    assert found[0].place.line == line


def test_all_of_them_in_one_run() -> None:
    _, found = read("a: &x 1\nb: *x\nc: !t 2\na: 3\n? [k]\n: 4\n")
    assert [finding.code for finding in found] == ["T107", "T107", "T108", "T109", "T111"]


def test_depth_is_bounded_before_anything_is_built() -> None:
    _, found = read("a: " + "[" * 1_000_000)
    assert [finding.code for finding in found] == ["T110"]
    node, found = read("[" * MAX_DEPTH + "]" * MAX_DEPTH)
    assert found == []
    assert node is not None


def test_what_was_refused_is_not_judged_further() -> None:
    from trackmarshal.trace.documents import REQUIREMENTS
    from trackmarshal.trace.values import Reader

    node, found = read("document: requirements\ntitle: !!python/name:os.system x\nrequirements: []\n")
    assert node is not None
    table = Reader("f.yaml", found).table(node, REQUIREMENTS, "the document")
    assert [finding.code for finding in found] == ["T108"]
    assert table is not None
    assert "title" not in table
