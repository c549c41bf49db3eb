"""In which commit a review stands, by whom: what a repository has of it, and nothing where that is not at hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.planted.edits import run_git
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
