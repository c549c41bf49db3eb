"""`assess` of this project in a process of its own, with nothing kept, and again: CPU seconds of the command."""

from __future__ import annotations

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

COLD = "assess this project, nothing kept"
WARM = "assess this project again"
LIMITS = {COLD: 5.0, WARM: 1.5}
_ROOT = Path(__file__).parents[2]


def measure() -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "project"
        for part in ("specs", "requirements", "docs"):
            shutil.copytree(_ROOT / part, root / part)
        for part in (
            "engine",
            "trace",
            "tests",
        ):  # source code that says what it implements, and what shows it
            (root / part).symlink_to(_ROOT / part)
        cold, warm = [], []
        for number in range(3):
            shutil.rmtree(root / "out", ignore_errors=True)
            kept = {**os.environ, "TRACKMARSHAL_CACHE": str(Path(folder) / f"cache{number}")}
            cold.append(_cost(root, kept))
            warm.append(_cost(root, kept))
    return {COLD: statistics.median(cold), WARM: statistics.median(warm)}


def _cost(root: Path, environment: dict[str, str]) -> float:
    """CPU seconds of the command; gaps, where a copy without its history has some, are no matter here."""
    command = [sys.executable, "-m", "trackmarshal.cli.main", "--quiet", "assess", "--project", str(root)]
    with subprocess.Popen(
        command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, env=environment
    ) as process:
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
        said = process.stderr.read() if process.stderr else b""
    assert process.returncode in (0, 1), said.decode()
    return used.ru_utime + used.ru_stime
