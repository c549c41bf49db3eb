"""What benchmarks measure with: CPU time, medians, taking turns, emptied caches, memory."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
#: The rules of specs/supervisor that there were when limits on a step were set, and what their lines are called.
WHEN_LIMITED = (
    "static_collision", "obstacle_collision", "contact", "safe_gap", "safe_gap_oncoming", "safe_side", "rss_eq1", "pose_match", "pose_on_path",
    "stamp_match", "place_match", "heading_match", "speed_match", "friction", "turn_radius", "drive_acceleration", "braking_limit", "ends_at_rest",
    "arc_length_integrity", "heading_integrity", "curvature_integrity", "acceleration_integrity", "speed_limit", "zone_speed_limit", "no_reversing",
)  # fmt: skip
THEN = f"with the {len(WHEN_LIMITED)} rules of when the limit was set"
#: The command, and on the last line of standard error what it took.
_MEASURED = """
import resource, sys
from trackmarshal.cli.main import main
status = main(sys.argv[1:])
used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
print(status, sum(one.ru_utime + one.ru_stime for one in used), max(one.ru_maxrss for one in used), file=sys.stderr)
"""


def command(*arguments: str, cache: str | None = None, out: Path | None = None) -> tuple[float, float]:
    """CPU seconds (user and system) and peak memory in bytes of one run of `trackmarshal`, from process start; `cache` is its cache folder, `out` where its
    output goes.

    That a gate fails, or a run is not as declared, is not its business; raises RuntimeError for all else.
    """
    environment = None if cache is None else {**os.environ, "TRACKMARSHAL_CACHE": cache}
    # A shell starts it: a child of this process would be charged with this process's own peak memory.
    call = ["sh", "-c", '"$0" "$@"; true', sys.executable, "-c", _MEASURED, *arguments]
    with (out or Path(os.devnull)).open("wb") as stream:
        done = subprocess.run(
            call, cwd=ROOT, env=environment, stdout=stream, stderr=subprocess.PIPE, text=True, check=False
        )
    status, seconds, most = done.stderr.splitlines()[-1].split()
    if status not in ("0", "1"):
        raise RuntimeError(f"trackmarshal {' '.join(arguments)} ended with {status}")
    return float(seconds), float(most) * 1024.0


def median(run: Callable[[], object], repeats: int) -> float:
    """Median CPU seconds, this process's children included."""
    run()
    spent = []
    for _ in range(repeats):
        before = time.process_time()
        run()
        spent.append(time.process_time() - before)
    return statistics.median(spent)


def by_turns(one: Callable[[], object], other: Callable[[], object], repeats: int) -> tuple[float, float]:
    """CPU seconds of two functions that run by turns: of each the fastest tenth, when nothing else was in the way."""
    spent = np.zeros((repeats, 2))
    for k in range(repeats):
        for side, run in enumerate((one, other)):
            before = time.process_time()
            run()
            spent[k, side] = time.process_time() - before
    first, second = np.quantile(spent, 0.1, axis=0)
    return float(first), float(second)


def emptied(run: Callable[[], object], repeats: int = 60) -> float:
    """Median CPU seconds of a function before each run of which memory is walked that is larger than all caches.

    So it is run by a loop with a planner in it. A run that returns a float says itself how long it took.
    """
    memory = np.zeros(_larger_than_caches(), dtype=np.uint8)
    spent = []
    for _ in range(repeats):
        memory[::64] += 1
        before = time.process_time()
        said = run()
        took = time.process_time() - before
        spent.append(said if isinstance(said, float) else took)
    return statistics.median(spent)


def _larger_than_caches() -> int:
    """Bytes: twice the largest cache, but at least 64 and at most 512 MiB."""
    largest = 0
    for path in Path("/sys/devices/system/cpu/cpu0/cache").glob("index*/size"):
        size = path.read_text().strip()
        largest = max(largest, int(size.removesuffix("K")) << 10 if size.endswith("K") else 0)
    return min(max(2 * largest, 64 << 20), 512 << 20)


def memory() -> int:
    """Bytes of this process that are in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE")
