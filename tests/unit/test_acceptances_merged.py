"""What was accepted on a branch and dropped by its merge is missed, whatever is not known of versions before."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from support.planted.edits import BASELINE, run_git
from trackmarshal.cli import acceptances

POINTER = "version https://git-lfs.github.com/spec/v1\noid sha256:00\nsize 1\n"


def accept(root: Path, *requirements: str) -> None:
    """Requirements more, in an acceptance that needs no name, and a commit."""
    path = root / BASELINE
    said = (
        json.loads(path.read_text("utf-8")) if path.is_file() and path.read_text("utf-8") != POINTER else {}
    )
    content = said.get("content", {}) | {f"requirement {name}": {"asil": "QM"} for name in requirements}
    whole = json.dumps(content, sort_keys=True, ensure_ascii=False).encode()
    made = {
        "on": "2026-01-01",
        "by": "",
        "reason": "",
        "weaker": [],
        "after": hashlib.sha256(whole).hexdigest(),
    }
    held = {"format": "trackmarshal-baseline", "version": 2, "content": content}
    path.write_text(json.dumps({**held, "acceptances": [*said.get("acceptances", []), made]}), "utf-8")
    commit(root)


def commit(root: Path) -> None:
    run_git(root, "add", "-A")
    run_git(root, "commit", "-qm", "more")


@pytest.fixture
def root(tmp_path: Path) -> Path:
    folder = tmp_path / "project"
    (folder / BASELINE).parent.mkdir(parents=True)
    model = "document: v-model\nproject: {baseline: requirements/baseline.json}\n"
    (folder / "requirements" / "v-model.yaml").write_text(model, "utf-8")
    run_git(folder, "init", "-qb", "main")
    return folder


def dropped(root: Path) -> None:
    """What a branch accepted, by a merge."""
    run_git(root, "checkout", "-qb", "branch")
    accept(root, "S-2")
    run_git(root, "checkout", "-q", "main")
    run_git(root, "commit", "-q", "--allow-empty", "-m", "meanwhile")
    run_git(root, "merge", "-qs", "ours", "-m", "merged", "branch")


def test_behind_a_first_version_that_git_lfs_kept(root: Path) -> None:
    """Once the filter was taken off, as T380 says, whatever was merged and dropped from then on went unheard."""
    (root / BASELINE).write_text(POINTER, "utf-8")
    commit(root)
    accept(root, "S-1")
    assert [one.code for one in acceptances.check(root, BASELINE)] == ["T381"]
    dropped(root)
    found = list(acceptances.check(root, BASELINE))
    assert [one.code for one in found] == ["T381", "T380"]
    assert "requirement S-2 is gone" in found[1].message


def test_in_a_submodule(root: Path, tmp_path: Path) -> None:
    """Which the project's repository has no versions of: edited by hand, it was called one that was never committed, and the gate passed."""
    accept(root, "S-1")
    origin = (root / "requirements").rename(tmp_path / "origin")
    run_git(origin, "init", "-q")
    commit(origin)
    commit(root)
    run_git(root, "-c", "protocol.file.allow=always", "submodule", "add", "-q", str(origin), "requirements")
    commit(root)
    (found,) = acceptances.check(root, BASELINE)
    assert (found.code, found.level) == ("T380", "error")
    assert "`requirements` is in another repository" in found.message
    (root / BASELINE).rename(root / "baseline.json")  # as the help says
    commit(root)
    assert list(acceptances.check(root, "baseline.json")) == []
    (root / "baseline.json").write_text(
        (root / "baseline.json").read_text("utf-8").replace("QM", "A"), "utf-8"
    )
    assert [one.code for one in acceptances.check(root, "baseline.json")] == ["T380"]


def test_in_a_history_that_is_cut_off(root: Path, tmp_path: Path) -> None:
    accept(root, "S-1")
    for _ in range(2):
        run_git(root, "commit", "-q", "--allow-empty", "-m", "before")
    run_git(tmp_path, "clone", "-q", "--depth", "1", root.as_uri(), "clone")
    assert [one.code for one in acceptances.check(tmp_path / "clone", BASELINE)] == ["T381"]
    dropped(tmp_path / "clone")
    assert [one.code for one in acceptances.check(tmp_path / "clone", BASELINE)] == ["T381", "T380"]


def test_in_a_history_that_is_as_long_as_was_asked_for(root: Path, tmp_path: Path) -> None:
    """Git calls that clone shallow, too: the warning stood there of a history that is whole."""
    accept(root, "S-1")
    accept(root, "S-2")
    for depth, found in (("1", ["T381"]), ("2", [])):
        run_git(tmp_path, "clone", "-q", "--depth", depth, root.as_uri(), depth)
        assert [one.code for one in acceptances.check(tmp_path / depth, BASELINE)] == found


def test_behind_more_versions_than_are_looked_at(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(acceptances, "MOST", 2)
    for name in ("S-1", "S-3", "S-4"):
        accept(root, name)
    assert [one.code for one in acceptances.check(root, BASELINE)] == ["T381"]
    dropped(root)
    assert [one.code for one in acceptances.check(root, BASELINE)] == ["T381", "T380"]
