"""Tables as functions of arrays: linear between knots, clamped outside; the steps of `ir.tables`, for what most tables are."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmarshal.backends.numpy.grids import Steps
from trackmarshal.backends.numpy.logic import full, where
from trackmarshal.ir.tables import LINEAR_CLAMP, Way


class Curve:
    """One table; NaN for an argument that is not finite."""

    __slots__ = ("inner", "knots", "slopes", "values")

    def __init__(self, knots: Sequence[float], values: Sequence[float]) -> None:
        self.knots, self.values = np.array(knots), np.array(values)
        self.inner = self.knots[1:-1]
        with np.errstate(all="ignore"):
            self.slopes = (self.values[1:] - self.values[:-1]) / (self.knots[1:] - self.knots[:-1])

    def __call__(self, x: Any) -> Any:
        first, last = self.knots[0], self.knots[-1]
        between = self.values[-1]
        if len(self.slopes):
            index = self.inner.searchsorted(x, side="right")
            between = self.values.take(index) + self.slopes.take(index) * (x - self.knots.take(index))
        result = where(x <= first, self.values[0], where(x >= last, self.values[-1], between))
        known = np.isfinite(x)
        return result if full(known) else where(known, result, np.nan)


def reader(knots: Sequence[float], values: Sequence[float], way: Way) -> Curve | Steps:
    """A table of one argument, read in a way."""
    return Curve(knots, values) if way == LINEAR_CLAMP else Steps(knots, values, way)


class Curves:
    """A table that is another one in some cases: `rows` are the curves of the cases, in order."""

    def __init__(self, rows: Sequence[Curve | Steps], rank: int) -> None:
        self.rows = rows
        self.rank = rank

    def __call__(self, x: Any) -> Any:
        x = np.asarray(x)
        if x.ndim == 0 or x.shape[0] == 1:
            x = np.broadcast_to(x, (len(self.rows), *(x.shape[1:] if x.ndim else (1,) * (self.rank - 1))))
        return np.stack([curve(row) for curve, row in zip(self.rows, x)])
