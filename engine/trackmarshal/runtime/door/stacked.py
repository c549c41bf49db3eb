"""Arrays of many cases, checked, without a frame for each: what all of them share, and what differs, one case after the other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.frame import Columns, Frame

Bools = NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class Stacked:
    """`size` cases. shared: what all have, with the faults of it; of a signal of `numbers` its columns are those of no case in particular.

    numbers, flags: by signal, (cases, numbers, count) and (cases, flags, count), with the columns that they have by `names`. events: (cases,) of
    1, 0, and -1 for a missing one. fine: (cases,) which of them nothing is wrong with. What is wrong with one by itself is a value, or an event that
    is missing: whatever reads that event is undefined.
    """

    size: int
    shared: Frame
    names: Mapping[str, Columns]
    numbers: Mapping[str, NDArray[np.float64]]
    flags: Mapping[str, NDArray[np.int8] | None]
    events: Mapping[str, NDArray[np.int8]]
    fine: Bools

    def unusable(self, reads: Iterable[tuple[str, str]]) -> Bools | None:
        """(cases,): in which of them what reads these (signal, field) pairs has no verdict; None: in none."""
        reads = list(reads)
        if self.shared.unusable(reads) is not None:
            return np.ones(self.size, dtype=bool)
        missing = [self.events[name] < 0 for name, _ in reads if name in self.events]
        return np.logical_or.reduce(missing) if missing else None
