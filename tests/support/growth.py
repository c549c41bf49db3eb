"""Whether time grows as what is to be done does: by a ratio in one run, which no slow or busy machine changes much."""

from __future__ import annotations

import time
from collections.abc import Callable


def grows(work: Callable[[int], object], size: int, larger: int) -> float:
    """How many times as long the larger work takes, in CPU time: the least of three attempts, as whatever else runs may fall on one of them alone."""
    return min(_spent(work, larger) / _spent(work, size) for _ in range(3))


def _spent(work: Callable[[int], object], size: int) -> float:
    begin = time.process_time()
    work(size)
    return time.process_time() - begin
