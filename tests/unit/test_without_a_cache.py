"""Where no cache can be written, what is compiled stands in a folder that goes with the process."""

from __future__ import annotations

import atexit
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from trackmarshal.backends.c import build

pytestmark = pytest.mark.skipif(build.compiler() is None, reason="no C compiler")


@pytest.fixture
def ends(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[list[Callable[[], None]]]:
    """What is done at the end of a process that has no cache and makes temporary folders in `temporary`."""
    done: list[Callable[[], None]] = []
    (tmp_path / "temporary").mkdir()
    (tmp_path / "file").write_text("", "utf-8")
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    monkeypatch.setattr(atexit, "register", done.append)
    build._uncached.cache_clear()
    yield done
    build._uncached.cache_clear()


def test_nothing_is_left_behind(
    ends: list[Callable[[], None]], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Each program left a folder of its own, and was compiled anew."""
    source = tmp_path / "one.c"
    source.write_text("int one(void);\nint one(void) { return 1; }\n", "utf-8")
    made = build.small_library(source)
    assert build.loaded(made).one() == 1
    assert build.small_library(source) == made
    assert len(list((tmp_path / "temporary").iterdir())) == 1
    own = os.getpid()
    with monkeypatch.context() as forked:
        forked.setattr(os, "getpid", lambda: own + 1)
        for end in ends:
            end()
    assert made.exists()  # to the process that was forked, it is not its own
    for end in ends:
        end()
    assert not list((tmp_path / "temporary").iterdir())
