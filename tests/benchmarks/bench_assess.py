"""`assess` of this project in a process of its own, with nothing kept, and again: CPU seconds of the command."""

from __future__ import annotations

import shutil
import statistics
import tempfile
from functools import partial
from pathlib import Path

from measuring import ROOT, command

COLD = "assess this project, nothing kept"
WARM = "assess this project again"
LIMITS = {COLD: 5.0, WARM: 1.5}


def measure() -> dict[str, float]:
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "project"
        for part in ("specs", "requirements", "docs"):
            shutil.copytree(ROOT / part, root / part)
        for part in (
            "engine",
            "trace",
            "tests",
        ):  # source code that says what it implements, and what shows it
            (root / part).symlink_to(ROOT / part)
        cold, warm = [], []
        for number in range(3):
            shutil.rmtree(root / "out", ignore_errors=True)
            assess = partial(
                command,
                "--quiet",
                "assess",
                "--project",
                str(root),
                cache=str(Path(folder) / f"cache{number}"),
            )
            cold.append(assess()[0])
            warm.append(assess()[0])
    return {COLD: statistics.median(cold), WARM: statistics.median(warm)}
