"""A trajectory that may be driven: samples with the times at which they are due."""

from __future__ import annotations

import math
from bisect import bisect_right
from functools import cached_property
from typing import TYPE_CHECKING, Any

from trackmarshal.runtime.frame import Columns

if TYPE_CHECKING:
    from trackmarshal.runtime.frame import Floats


class Plan:
    """One candidate of one cycle, for good: nobody else has its memory.

    number, t: the cycle's. columns: the fields, in SI.
    """

    def __init__(self, candidate: str, number: int, t: float, columns: Columns) -> None:
        self.candidate, self.number, self.t, self.columns = candidate, number, t, columns

    @property
    def names(self) -> tuple[str, ...]:
        """The fields that are numbers, one a row of `matrix`."""
        return self.columns.names.numbers

    @property
    def matrix(self) -> Floats:
        """(fields, samples)."""
        return self.columns.values

    @cached_property
    def due(self) -> list[float]:
        """When each sample is due on the Supervisor's clock, in s."""
        times = self.columns.column("t")
        due: list[float] = (times - (times[0] - self.t)).tolist()
        return due

    @property
    def end(self) -> float:
        """When the last sample is due."""
        return self.due[-1]

    def first(self, now: float) -> int:
        """The last sample that is due by now; 0 before all."""
        return max(0, bisect_right(self.due, now) - 1)

    def samples(self, now: float) -> dict[str, Any]:
        """Columns from the last sample that is due by now on."""
        rest = self.matrix[:, self.first(now) :]
        return dict(zip(self.names, rest))

    def pose(self, t: float) -> tuple[float, float, float] | None:
        """x, y and heading at a time, straight between samples; None where the trajectory does not cover it."""
        if not self.due[0] <= t <= self.due[-1]:
            return None
        i = min(self.first(t), len(self.due) - 2)
        step = self.due[i + 1] - self.due[i]
        share = (t - self.due[i]) / step if step > 0.0 else 1.0
        x, y, heading = (self.columns.column(name)[i : i + 2].tolist() for name in _POSE)
        turn = math.remainder(heading[1] - heading[0], math.tau)
        return x[0] + share * (x[1] - x[0]), y[0] + share * (y[1] - y[0]), heading[0] + share * turn


_POSE = ("x", "y", "heading")
