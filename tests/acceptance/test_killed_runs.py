"""A run that is killed leaves a record: every completed cycle is in it, and it runs again the same, bit for bit."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from support import killed_runs
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.record.reading import read
from trackmarshal.supervision import box_of, nearest, rerun

pytestmark = pytest.mark.verifies("S-1-B-1")

#: Runs that `make test` kills; `make acceptance` kills 200.
KILLS = int(os.environ.get("TRACKMARSHAL_KILLS", "3"))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork and SIGKILL")
def test_killed_at_random_moments(tmp_path: Path) -> None:
    script = [sys.executable, str(Path(killed_runs.__file__)), str(tmp_path), str(KILLS), "20261121"]
    done = subprocess.run(script, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    outcomes = [json.loads(line) for line in done.stdout.splitlines()]
    assert len(outcomes) == KILLS
    spec = killed_runs.spec()
    lengths = set()
    for outcome in outcomes:
        path, completed = tmp_path / outcome["file"], outcome["completed"]
        try:
            run = read(path.read_bytes(), str(path))
        except (TrackmarshalError, OSError):
            assert completed == 0  # killed before the head was written
            continue
        assert completed <= len(run.cycles) <= completed + 1
        assert not run.ended
        box = box_of(run, spec)
        begin, refused = nearest(run, box, len(run.cycles))
        assert refused is None
        # What was begun is whole some cycles later.
        assert (0 if begin is None else begin.after) >= len(run.cycles) - 30
        for snapshot in (None, begin):
            found = [d for _, differing in rerun(run, box, snapshot) for d in differing]
            assert found == []
        lengths.add(completed)
    assert len(lengths) > KILLS // 3, "the moments were not random"
