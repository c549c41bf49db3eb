"""Whether time grows as what is to be done does: by a ratio in one run, which no slow or busy machine changes much."""

from __future__ import annotations

import time
from collections.abc import Callable


def grows_alike(work: Callable[[int], object], size: int, times: int = 4) -> bool:
    """Whether so many times as much takes less than twice as many times as long, in CPU time: of what takes the square of it, it does not.

    Three attempts, as whatever else runs may fall on one of them alone."""
    return any(_spent(work, times * size) < 2 * times * _spent(work, size) for _ in range(3))


def _spent(work: Callable[[int], object], size: int) -> float:
    begin = time.process_time()
    work(size)
    return time.process_time() - begin
