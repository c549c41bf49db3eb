"""A trajectory that may be driven: samples with the times at which they are due."""

from __future__ import annotations

import math
from bisect import bisect_right
from typing import TYPE_CHECKING, Any, NamedTuple

from trackmarshal.runtime.contract.conditions import remainder
from trackmarshal.runtime.frame import Columns, Frame

if TYPE_CHECKING:
    from trackmarshal.runtime.frame import Floats


class Spot(NamedTuple):
    """A place of a trajectory's path: how far away it is, m, and heading and speed there, rad and m/s."""

    away: float
    heading: float
    v: float


class Plan:
    """One candidate of one cycle, for good: nobody else has its memory.

    number, t: the cycle's; times of samples count from the stamp t. columns: the fields, in SI; of a frame, when somebody asks for them.
    """

    __slots__ = ("candidate", "columns", "due", "number", "of", "t")

    columns: Columns
    #: When each sample is due on the Supervisor's clock, in s.
    due: list[float]

    def __init__(self, candidate: str, number: int, t: float, columns: Columns | Frame) -> None:
        self.candidate, self.number, self.t, self.of = candidate, number, t, columns

    def __getattr__(self, name: str) -> Any:
        """Of most plans, nobody asks for these; and Supervisors in C make plans."""
        if name == "columns":
            of = self.of
            self.columns = of if isinstance(of, Columns) else of.candidates[self.candidate]
            return self.columns
        if name == "due":
            self.due = [t + self.t for t in self.columns.listed("t")]
            return self.due
        raise AttributeError(name)

    @property
    def names(self) -> tuple[str, ...]:
        """The fields that are numbers, one a row of `matrix`."""
        return self.columns.names.numbers

    @property
    def matrix(self) -> Floats:
        """(fields, samples)."""
        return self.columns.values

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

    def station(self, t: float) -> float | None:
        """How far along its path, straight between samples, the trajectory is at a time, in m; None where it does not cover the time."""
        due, x, y = self.due, self.columns.listed("x"), self.columns.listed("y")
        if not due[0] <= t <= due[-1]:
            return None
        i = min(self.first(t), len(due) - 2)
        along = 0.0
        for k in range(i):
            along += _length(x[k + 1] - x[k], y[k + 1] - y[k])
        step = due[i + 1] - due[i]
        share = (t - due[i]) / step if step > 0.0 else 1.0
        return along + share * _length(x[i + 1] - x[i], y[i + 1] - y[i])

    def nearest(self, x: float, y: float, least: float, most: float) -> Spot:
        """The place of the path that is nearest to a point, of those from one station to another; the first of equally near ones."""
        px, py, heading, v = (self.columns.listed(name) for name in ("x", "y", "heading", "v"))
        best, begin = Spot(math.inf, math.nan, math.nan), 0.0
        for i in range(len(px) - 1):
            dx, dy = px[i + 1] - px[i], py[i + 1] - py[i]
            square = dx * dx + dy * dy
            length = math.sqrt(square)
            end = begin + length
            if end >= least and begin <= most:
                share = 0.0
                if square > 0.0:
                    share = ((x - px[i]) * dx + (y - py[i]) * dy) / square
                    share = min(max(share, (least - begin) / length, 0.0), (most - begin) / length, 1.0)
                away = _length(x - (px[i] + share * dx), y - (py[i] + share * dy))
                if away < best.away:
                    turn = remainder(heading[i + 1] - heading[i], math.tau)
                    best = Spot(away, heading[i] + share * turn, v[i] + share * (v[i + 1] - v[i]))
            begin = end
        return best


def _length(dx: float, dy: float) -> float:
    return math.sqrt(dx * dx + dy * dy)
