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
