"""Drawings of boundaries: of one rule without recordings, and of all rules of this project with all that was recorded; the safety case with drawings that are kept."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from trackmarshal.cli.drawing import of_project
from trackmarshal.cli.main import main as command
from trackmarshal.reading.drawing.making import drawings
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import prepare

ROOT = Path(__file__).resolve().parents[2]


def measure(repeats: int = 5) -> dict[str, float]:
    """Median CPU seconds."""
    compiled = compile_paths([ROOT / "specs" / "supervisor"], ROOT)
    tests, spec = prepare(compiled)[0], compiled.spec
    friction = [rule for rule in spec.rules if rule.name == "friction"]
    recorded, distances = of_project(ROOT)
    made = {
        "drawing: friction, without recordings": _median(
            lambda: list(drawings(friction, spec, tests, ())), repeats
        ),
        f"drawing: {len(spec.rules)} rules, {len(recorded)} recordings read before": _median(
            lambda: list(drawings(spec.rules, spec, tests, recorded, distances)), 3
        ),
    }
    return made | {"drawing: `case`, HTML and PDF, drawings kept": _case()}


def _median(work: Callable[[], object], repeats: int) -> float:
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        taken.append(time.process_time() - start)
    return statistics.median(taken)


def _case() -> float:
    """A process of its own, after one that keeps what it draws."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "TRACKMARSHAL_CACHE": folder, "PYTHONPATH": os.pathsep.join(sys.path)}
        arguments = [
            sys.executable,
            "-m",
            command.__module__,
            "case",
            "--out",
            folder,
            "--exit-zero",
            "--quiet",
        ]
        taken = []
        for _ in range(3):
            before = os.times()
            subprocess.run(arguments, cwd=ROOT, env=environment, check=False, capture_output=True)
            after = os.times()
            taken.append(
                after.children_user + after.children_system - before.children_user - before.children_system
            )
    return statistics.median(taken)


def main() -> None:
    for name, value in measure().items():
        print(f"{name}: {value:.3f} s")


if __name__ == "__main__":
    main()
