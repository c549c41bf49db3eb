"""Git is asked of what is recorded in the repository around a folder, whatever this machine puts in its place."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from support.planted.edits import run_git
from trackmarshal.cli.git import asking, surroundings


def _count(root: Path) -> str:
    command = asking(root, "rev-list", "--count", "HEAD")
    return subprocess.run(command, capture_output=True, text=True, check=True, env=surroundings()).stdout


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / "here"
    for name, commits in (("here", 3), ("other", 1)):
        (tmp_path / name).mkdir()
        run_git(tmp_path / name, "init", "-q")
        for number in range(commits):
            run_git(tmp_path / name, "commit", "--allow-empty", "-qm", f"number {number}")
    return folder


def test_a_history_that_is_cut_off(root: Path) -> None:
    head = run_git(root, "rev-parse", "HEAD")
    (root / ".git" / "info" / "grafts").write_text(head, "utf-8")
    assert run_git(root, "rev-list", "--count", "HEAD").strip() == "1"
    assert _count(root).strip() == "3"


def test_another_repository_that_the_environment_names(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GIT_DIR", str(root.parent / "other" / ".git"))
    monkeypatch.setenv("GIT_WORK_TREE", str(root.parent / "other"))
    assert _count(root).strip() == "3"


def test_an_answer_as_somebody_likes_to_read_it(root: Path) -> None:
    """Signatures stood among commits, a file was followed into the one that it was copied from, and paths were those from elsewhere."""
    (root / "old").mkdir()
    (root / "old" / "a").write_text("text of some length, so that it is the same\n", "utf-8")
    run_git(root, "add", ".")
    run_git(root, "commit", "-qm", "a")
    run_git(root, "mv", "old/a", "b")
    run_git(root, "commit", "-qm", "b")
    said = run_git(root, "cat-file", "commit", "HEAD")
    signature = "gpgsig -----BEGIN SSH SIGNATURE-----\n AAAA\n -----END SSH SIGNATURE-----\n"
    (root / "signed").write_text(said.replace("\n\n", f"\n{signature}\n", 1), "utf-8")
    signed = run_git(root, "hash-object", "-t", "commit", "-w", "signed").strip()
    run_git(root, "update-ref", "HEAD", signed)
    plain = _log(root, "--format=%H", "--", "b"), _log(root / "old", "-1", "--format=", "--name-only", "-m")
    assert plain[0].split() == [signed]
    for name in ("log.showSignature", "log.follow", "diff.relative"):
        run_git(root, "config", name, "true")
    assert (
        _log(root, "--format=%H", "--", "b"),
        _log(root / "old", "-1", "--format=", "--name-only", "-m"),
    ) == plain


def _log(folder: Path, *words: str) -> str:
    folder.mkdir(exist_ok=True)
    command = asking(folder, "log", *words)
    return subprocess.run(command, capture_output=True, text=True, check=True, env=surroundings()).stdout
