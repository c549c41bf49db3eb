"""A revision is read from the repository around the project, whichever one the environment names, as hooks of git do."""

from __future__ import annotations

import io
import subprocess
import tarfile
from pathlib import Path

import pytest

from trackmarshal.cli import revisions
from trackmarshal.cli.git import asking, surroundings
from trackmarshal.errors import TrackmarshalError


def _repository(folder: Path, spec: str) -> Path:
    folder.mkdir()
    (folder / "a.spec").write_text(spec, "utf-8")
    who = ("-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false")
    for words in (("init", "-q"), ("add", "-A"), ("commit", "-qm", "first")):
        subprocess.run(["git", *who, *words], cwd=folder, check=True, env=surroundings())
    return folder


def test_git_has_nothing_to_add(tmp_path: Path) -> None:
    """What it says beside its answer stands in messages."""
    own = _repository(tmp_path / "own", "module own\n")
    said = subprocess.run(
        asking(own, "log", "--oneline"), capture_output=True, check=True, env=surroundings()
    )
    assert said.stderr == b""


def test_whatever_repository_the_environment_names(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    own, other = (_repository(tmp_path / name, f"module {name}\n") for name in ("own", "other"))
    monkeypatch.setenv("GIT_DIR", str(other / ".git"))
    found = revisions.read("HEAD", own, tmp_path / "into")
    assert [path.read_text("utf-8") for path in found.rglob("*.spec")] == ["module own\n"]


def test_a_repository_that_git_does_not_trust(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a container that checks out as another user than it runs as: git's help stood in the message, and another one under it."""
    own = _repository(tmp_path / "own", "module own\n")
    monkeypatch.setenv("GIT_TEST_ASSUME_DIFFERENT_OWNER", "1")
    with pytest.raises(TrackmarshalError, match="no revision: git: detected dubious ownership in") as caught:
        revisions.read("HEAD", own, tmp_path / "into")
    assert "\n" not in caught.value.message
    assert caught.value.help is not None
    assert "git config --global --add safe.directory" in caught.value.help


def test_on_python_before_3_11_4(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Archives are unpacked without a filter there, as Debian 12 has it: every comparison with a revision was an internal error."""

    def none(*_: object) -> None:
        pytest.fail("what lies outside of a folder is written by `extract`, unless it has a filter")

    monkeypatch.setattr(tarfile.TarFile, "extract", none)
    monkeypatch.setattr(tarfile.TarFile, "extractall", none)
    own = _repository(tmp_path / "own", "module own\n")
    found = revisions.read("HEAD", own, tmp_path / "into")
    assert [path.read_text("utf-8") for path in found.rglob("*.spec")] == ["module own\n"]


@pytest.mark.parametrize("name", ["../out.spec", "/out.spec", "a/../../out.spec"])
def test_nothing_is_written_elsewhere(tmp_path: Path, name: str) -> None:
    stream = io.BytesIO()
    with tarfile.open(fileobj=stream, mode="w") as archive:
        archive.addfile(tarfile.TarInfo(name))
    stream.seek(0)
    with pytest.raises(tarfile.TarError, match="no file of the project"):
        revisions._unpack(stream, tmp_path / "into", lambda _: True)
    assert list(tmp_path.rglob("*.spec")) == []


@pytest.mark.parametrize(
    ("cut", "message", "help_"),
    [
        ("", "which is not here", "`git -C 'the lib' fetch`"),
        ("shallow", "which is not here", "`git -C 'the lib' fetch --unshallow`"),
        ("moved", "git: not a git repository", None),
    ],
)
def test_a_submodule_without_the_commit(cut: str, message: str, help_: str | None, tmp_path: Path) -> None:
    """What did not help was recommended: to fetch where the history is cut, or where git does not take the folder at all, by a path in two words."""
    own = _repository(tmp_path / "own", "module own\n")
    sub = _repository(own / "the lib", "module lib\n")
    who = ("-c", "user.name=n", "-c", "user.email=e", "-c", "commit.gpgsign=false")
    lost = f"160000,{'1' * 40},the lib"
    for words in (("update-index", "--add", "--cacheinfo", lost), ("commit", "-qm", "with a submodule")):
        subprocess.run(["git", *who, *words], cwd=own, check=True, env=surroundings())
    if cut == "shallow":
        head = (sub / ".git" / "HEAD").read_text("utf-8").removeprefix("ref: ").strip()
        (sub / ".git" / "shallow").write_text((sub / ".git" / head).read_text("utf-8"), "utf-8")
    elif cut == "moved":
        (sub / ".git").rename(tmp_path / "elsewhere")
        (sub / ".git").write_text("gitdir: ../nowhere\n", "utf-8")
    with pytest.raises(TrackmarshalError) as caught:
        revisions.read("HEAD", own, tmp_path / "into")
    assert message in caught.value.message
    assert help_ is None or caught.value.help == help_
    assert help_ is not None or "fetch" not in (caught.value.help or "")
