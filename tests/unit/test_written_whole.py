"""Files that are written whole or not at all, and of which nothing is left behind."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.files import write_whole


def fails_with(error: BaseException) -> Any:
    def fail(self: Path, *_: object) -> None:
        self.touch()
        raise error

    return fail


@pytest.mark.parametrize("step", ["write_bytes", "replace"])
@pytest.mark.parametrize(
    ("error", "seen"),
    [(KeyboardInterrupt(), KeyboardInterrupt), (OSError(errno.ENOSPC, "No space left on device"), OSError)],
)
def test_nothing_is_left_of_what_was_not_written(
    step: str,
    error: BaseException,
    seen: type[BaseException],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    path = tmp_path / "said.json"
    path.write_bytes(b"before")
    with monkeypatch.context() as patched:
        patched.setattr(Path, step, fails_with(error))
        with pytest.raises(seen) as caught:
            write_whole(path, b"after")
    assert [each.name for each in tmp_path.iterdir()] == ["said.json"]
    assert path.read_bytes() == b"before"
    if isinstance(caught.value, OSError):
        assert (caught.value.errno, caught.value.filename) == (errno.ENOSPC, str(path))


def test_two_with_the_same_number_write_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As in two containers that share a folder, in each of which this is process 1: what one wrote was taken for the other's draft, which was gone then."""
    path, replaced = tmp_path / "said.json", Path.replace

    def meanwhile(self: Path, target: Path) -> Path:
        with monkeypatch.context() as patched:
            patched.setattr(Path, "replace", replaced)
            write_whole(path, b"the other's")
        return replaced(self, target)

    monkeypatch.setattr(Path, "replace", meanwhile)
    write_whole(path, b"its own")
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [("said.json", b"its own")]


def test_it_is_written(tmp_path: Path) -> None:
    write_whole(tmp_path / "said.json", b"after")
    assert [(each.name, each.read_bytes()) for each in tmp_path.iterdir()] == [("said.json", b"after")]


def test_a_link_stays_one(tmp_path: Path) -> None:
    """As where data lies on another disk: what it leads to is written."""
    (tmp_path / "disk").mkdir()
    link = tmp_path / "said.json"
    link.symlink_to(tmp_path / "disk" / "said.json")
    for data in (b"before", b"after"):
        write_whole(link, data)
        assert link.is_symlink()
        assert [(each.name, each.read_bytes()) for each in (tmp_path / "disk").iterdir()] == [
            ("said.json", data)
        ]


def test_what_is_no_file_is_not_put_aside(tmp_path: Path) -> None:
    """As `--out /dev/stdout`: a file stood in its place."""
    link = tmp_path / "nowhere"
    link.symlink_to(os.devnull)
    write_whole(link, b"after")
    assert link.is_symlink()
    assert link.is_char_device()


@pytest.mark.skipif(os.name != "posix", reason="modes are POSIX's")
def test_who_may_read_it_stays_the_same(tmp_path: Path) -> None:
    """What nobody else could read was readable to all."""
    path = tmp_path / "said.json"
    path.write_bytes(b"before")
    for mode in (0o600, 0o664):
        path.chmod(mode)
        write_whole(path, b"after")
        assert (path.stat().st_mode & 0o777, path.read_bytes()) == (mode, b"after")


def test_what_must_not_be_written_is_not(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that is for reading only was another one, since its folder is not."""
    path = tmp_path / "said.json"
    path.write_bytes(b"before")
    monkeypatch.setattr(os, "access", lambda *_, **__: False)  # who runs this as root may write everything
    with pytest.raises(PermissionError) as caught:
        write_whole(path, b"after")
    assert (caught.value.filename, path.read_bytes()) == (str(path), b"before")
    assert [each.name for each in tmp_path.iterdir()] == ["said.json"]


def test_links_that_lead_round_in_a_ring_stay(tmp_path: Path) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.symlink_to(there)
    there.symlink_to(here)
    with pytest.raises(OSError, match="symbolic links") as caught:
        write_whole(here, b"after")
    assert caught.value.filename == str(here)
    assert (here.is_symlink(), there.is_symlink()) == (True, True)


def test_a_long_name_is_one(tmp_path: Path) -> None:
    for name in ("x" * 255, "ü" * 127):
        write_whole(tmp_path / name, b"after")
        assert (tmp_path / name).read_bytes() == b"after"
