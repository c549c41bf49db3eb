"""Git is asked of what is recorded in the repository around a folder, whatever this machine puts in its place."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

from support.planted.edits import run_git
from trackmarshal.cli.answers import commit
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


def test_the_index_of_another_repository(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a hook has it that runs for the repository around a submodule: all files were other ones, or there was no commit."""
    (root / "a.spec").write_text("module a\n", "utf-8")
    run_git(root, "add", ".")
    run_git(root, "commit", "-qm", "a")
    head = run_git(root, "rev-parse", "HEAD").strip()
    run_git(root, "worktree", "add", "-q", "--detach", str(root.parent / "tree"))
    for index in (root.parent / "other" / ".git" / "index", Path(".git", "index")):
        monkeypatch.setenv("GIT_INDEX_FILE", str(index))
        assert commit(root.parent / "tree") == head


def test_what_is_changed_in_a_submodule(root: Path) -> None:
    """Whatever is configured for those who do not want to see it."""
    other = root.parent / "other"
    (other / "a.spec").write_text("module a\n", "utf-8")
    run_git(other, "add", ".")
    run_git(other, "commit", "-qm", "a")
    run_git(root, "-c", "protocol.file.allow=always", "submodule", "add", "-q", str(other), "lib")
    run_git(root, "config", "-f", ".gitmodules", "submodule.lib.ignore", "all")
    run_git(root, "add", ".")
    run_git(root, "commit", "-qm", "lib")
    head = run_git(root, "rev-parse", "HEAD").strip()
    (root / "lib" / "build").write_text("of a compiler", "utf-8")
    assert commit(root) == head
    (root / "lib" / "a.spec").write_text("module a\n# more\n", "utf-8")
    assert commit(root) == head + "+"


def test_what_git_ignores_and_is_read_all_the_same(root: Path) -> None:
    """Evidence was of a commit that lacks the rule that it is of."""
    (root / ".gitignore").write_text("/mine\n/build/\n*.yml\nlocal*\n", "utf-8")
    run_git(root, "add", ".")
    run_git(root, "commit", "-qm", "a")
    head = run_git(root, "rev-parse", "HEAD").strip()
    for name in ("build/a.spec", "build/a.yml", "specs/local.txt"):
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_text("module a\n", "utf-8")
    assert commit(root) == head
    assert commit(root, ["../build", "/build"]) == head
    for name, specs in (
        ("specs/local.spec", []),
        ("mine/in/a.spec", ["specs", "mine"]),
        ("requirements/a.yml", []),
    ):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text("module a\n", "utf-8")
        assert commit(root, specs) == head + "+"
        (root / name).unlink()
        assert commit(root, specs) == head


def test_no_lock_is_taken(root: Path) -> None:
    """What somebody else did in the repository meanwhile, such as a commit, failed of it: `index.lock` was there."""
    (root / "a").write_text("a", "utf-8")
    run_git(root, "add", ".")
    (root / "a").touch()  # so that the index could be brought up to date
    before = (root / ".git" / "index").stat()
    os.utime(root / "a", (1, 1))
    assert commit(root).endswith("+")
    after = (root / ".git" / "index").stat()
    assert (before.st_ino, before.st_mtime_ns) == (after.st_ino, after.st_mtime_ns)


def test_an_answer_as_somebody_likes_to_read_it(root: Path) -> None:
    """Signatures stood among commits, a file was followed into the one that it was copied from, paths were those from elsewhere, and merges changed nothing."""
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
    run_git(root, "checkout", "-qb", "branch")
    run_git(root, "mv", "b", "c")
    run_git(root, "commit", "-qm", "c")
    run_git(root, "checkout", "-q", "-")
    run_git(root, "merge", "-q", "--no-ff", "-m", "merged", "branch")
    plain = _log(root, "--format=%H", "--", "b"), _log(root / "old", "-1", "--format=", "--name-only", "-m")
    assert plain[0].split() == [run_git(root, "rev-parse", "branch").strip(), signed]
    assert plain[1].split() == ["c"]
    for name in ("log.showSignature", "log.follow", "diff.relative"):
        run_git(root, "config", name, "true")
    run_git(root, "config", "log.diffMerges", "remerge")
    assert (
        _log(root, "--format=%H", "--", "b"),
        _log(root / "old", "-1", "--format=", "--name-only", "-m"),
    ) == plain


def _log(folder: Path, *words: str) -> str:
    folder.mkdir(exist_ok=True)
    command = asking(folder, "log", *words)
    return subprocess.run(command, capture_output=True, text=True, check=True, env=surroundings()).stdout
