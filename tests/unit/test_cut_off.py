"""Output whose reader went away: nobody may take that for a pass."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest


@pytest.mark.skipif(os.name == "nt", reason="there are no signals of pipes")
def test_a_command_whose_output_is_cut_off_has_not_passed() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    try:
        ended = subprocess.run(
            [sys.executable, "-m", "trackmarshal", "--help"], stdout=writer, check=False, timeout=60
        )
    finally:
        os.close(writer)
    assert ended.returncode == 141


@pytest.mark.skipif(os.name == "nt", reason="there is no shell that closes a stream")
def test_an_error_that_nobody_can_be_told_of_is_one_all_the_same(tmp_path: Path) -> None:
    path = tmp_path / "bad.spec"
    path.write_text('module bad\n\nrule x "y"\n  require a > 0\n', "utf-8")
    script = f'exec "{sys.executable}" -m trackmarshal check "{path}" 2>&-'
    ended = subprocess.run(["sh", "-c", script], capture_output=True, check=False, timeout=60)
    assert ended.returncode == 1
    assert ended.stdout == b""  # which may be a report that a program reads


@pytest.mark.skipif(os.name == "nt", reason="there are no signals of pipes")
def test_nothing_is_watched_for_a_reader_who_went_away(tmp_path: Path) -> None:
    (tmp_path / "a.spec").write_text("module a\n", "utf-8")
    reader, writer = os.pipe()
    os.close(reader)
    try:
        ended = subprocess.run(
            [sys.executable, "-m", "trackmarshal", "watch", str(tmp_path)],
            stdout=writer, stderr=subprocess.DEVNULL, check=False, timeout=60,
        )  # fmt: skip
    finally:
        os.close(writer)
    assert ended.returncode == 141
