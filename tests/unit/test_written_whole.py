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
