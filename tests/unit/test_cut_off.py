"""Output whose reader went away: nobody may take that for a pass."""

from __future__ import annotations

import os
import subprocess
import sys

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
