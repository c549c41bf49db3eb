"""In which commit a review stands, by whom: what a repository has of it, and nothing where that is not at hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.planted.edits import run_git
from trackmarshal.cli.git import asking
from trackmarshal.cli.recorded import recorded
from trackmarshal.trace.case.inputs import Recorded

REVIEW = "reviews:\n  - id: RV-1\n    outcome: accepted\n"
NOT_KNOWN = Recorded("", "", "", False)


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / "project"
    folder.mkdir()
    (folder / "people.yaml").write_text(REVIEW, "utf-8")
    run_git(folder, "init", "-q")
    run_git(folder, "add", ".")
    run_git(folder, "commit", "-qm", "read", "--author", "Rolf Reader <rolf@example.org>")
    return folder


def found(root: Path) -> Recorded:
    return recorded(root, {"RV-1": ("people.yaml", 2)})["RV-1"]


@pytest.mark.parametrize(("depth", "author"), [(1, ""), (2, ""), (3, "Rolf Reader")])
def test_a_history_that_is_cut_off_has_no_commit_of_what_is_older(
    depth: int, author: str, root: Path, tmp_path: Path
) -> None:
    """To git, all that is older was written in the first commit that it has: whoever made that one, and signed it, was named for the review."""
    for number in range(2):
        run_git(root, "commit", "-q", "--allow-empty", "-m", f"something else {number}")
    run_git(tmp_path, "clone", "-q", "--depth", str(depth), root.as_uri(), "clone")
    said = found(tmp_path / "clone")
    assert said.author == author
    assert (said == NOT_KNOWN) is (not author)


def test_git_is_not_asked_of_each_review_whether_the_history_is_cut_off(root: Path, tmp_path: Path) -> None:
    text = "reviews:\n" + "".join(f"  - id: RV-{n}\n    outcome: accepted\n" for n in range(20))
    (root / "people.yaml").write_text(text, "utf-8")
    run_git(root, "commit", "-qam", "more")
    run_git(tmp_path, "clone", "-q", "--depth", "1", root.as_uri(), "clone")
    asked: list[tuple[str, ...]] = []

    def counted(folder: Path, *words: str) -> list[str]:
        asked.append(words)
        return asking(folder, *words)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("trackmarshal.cli.recorded.asking", counted)
        found = recorded(tmp_path / "clone", {f"RV-{n}": ("people.yaml", 2 + 2 * n) for n in range(20)})
    assert set(found.values()) == {NOT_KNOWN}
    assert len(found) == 20
    assert len(asked) < 20


@pytest.mark.parametrize(
    ("author", "name", "day"),
    [
        ("Rolf Reader <rolf@example.org> 1700000000 +9900", "Rolf Reader", "2023-11-14"),
        ("Rolf Reader <rolf@example.org> 1700000000 +051800", "Rolf Reader", "2023-11-14"),
        ("Rolf Reader <rolf@example.org> 1700000000 -2359", "Rolf Reader", "2023-11-13"),
        ("Rolf Reader <rolf@example.org> 99999999999999 +0000", "Rolf Reader", "@99999999999999"),
        ("Rolf Reader <rolf@example.org> -62135596801 +0000", "Rolf Reader", "@-62135596801"),
        ("Rolf Reader <ro<lf>@example.org> 1700000000 +0000", "Rolf Reader", "2023-11-14"),
        (" <rolf@example.org> 1700000000 +0000", "", "2023-11-14"),
        ("<rolf@example.org> 1700000000 +0000", "", "2023-11-14"),
    ],
)
def test_authors_as_they_come_from_elsewhere(author: str, name: str, day: str, root: Path) -> None:
    """Of a time on no day, and of a zone beyond a day, it was an internal error; of an author without a name, the review stood in no commit."""
    commit = rewritten(root, author.encode())
    assert found(root) == Recorded(commit, name, day, False)


@pytest.mark.parametrize("encoding", ["ISO-8859-1", "KOI8-R", "utf-8", "none that is known", "undefined"])
def test_an_author_in_the_encoding_of_the_commit(encoding: str, root: Path) -> None:
    name, there = (
        ("Лев" if encoding == "KOI8-R" else "Jörg"),
        "utf-8" if encoding.endswith(("known", "undefined")) else encoding,
    )
    author = f"{name} <j@example.org> 1700000000 +0000".encode(there)
    rewritten(root, author, f"\nencoding {encoding}".encode())
    assert found(root).author == name


def rewritten(root: Path, author: bytes, more: bytes = b"") -> str:
    """The commit with another author, as the one that is checked out."""
    head, _, message = run_git(root, "cat-file", "commit", "HEAD").encode().partition(b"\n\n")
    lines = [b"author " + author if line.startswith(b"author ") else line for line in head.split(b"\n")]
    (root / "commit").write_bytes(b"\n".join(lines) + more + b"\n\n" + message)
    made = run_git(root, "hash-object", "-t", "commit", "-w", "--literally", "commit").strip()
    run_git(root, "update-ref", "HEAD", made)
    return made
