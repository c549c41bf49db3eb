"""Tables that are not `linear clamp` of one argument, as functions of arrays: the steps of `ir.tables`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from trackmarshal.ir.spec import TableInfo
from trackmarshal.ir.tables import Way


class _Spots(NamedTuple):
    """`ir.tables.Spot` of an array, and where the table has a value."""

    low: Any
    high: Any
    start: Any
    end: Any
    at: Any
    known: Any

    def between(self, low: Any, high: Any) -> Any:
        slope = (high - low) / (self.end - self.start)
        return np.where(self.low == self.high, low, low + slope * (self.at - self.start))


class _Axis:
    """The knots of one argument."""

    def __init__(self, knots: Sequence[float], way: Way) -> None:
        self.knots, self.way = np.array(knots), way

    def spots(self, given: Any) -> _Spots:
        x, knots, way, last = np.asarray(given), self.knots, self.way, len(self.knots) - 1
        known = np.isfinite(x)
        if way.length > 0.0:
            x = _wrapped(x, way.length)
            index = np.asarray(knots.searchsorted(x, side="right")) - 1
            low = np.where(index < 0, last, index)
            high = np.where(low == last, 0, low + 1)
            start, end = knots.take(low), np.where(low == last, knots[0] + way.length, knots.take(high))
            x = np.where(index < 0, x + way.length, x)
        else:
            first, end_ = knots[0], knots[last]
            low = np.clip(np.asarray(knots.searchsorted(x, side="right")) - 1, 0, last)
            high = np.where((x <= first) | (x >= end_), low, np.minimum(low + 1, last))
            start, end = knots.take(low), knots.take(high)
            if not way.clamped:
                known = known & (x >= first) & (way.steps | (x <= end_))
        return _Spots(low, low if way.steps else high, start, end, x, known)


def _wrapped(x: Any, length: float) -> Any:
    rest = np.fmod(x, length)
    rest = np.where(rest < 0.0, rest + length, rest)
    return np.where(rest >= length, 0.0, rest)


class Steps:
    """A table of one argument."""

    def __init__(self, knots: Sequence[float], values: Sequence[float], way: Way) -> None:
        self._axis, self._values = _Axis(knots, way), np.array(values)

    def __call__(self, x: Any) -> Any:
        spots = self._axis.spots(x)
        value = spots.between(self._values.take(spots.low), self._values.take(spots.high))
        return np.where(spots.known, value, np.nan)


class Grid:
    """A table of two arguments."""

    def __init__(self, table: TableInfo) -> None:
        assert table.across is not None
        self._rows, self._columns = _Axis(table.knots, table.way), _Axis(table.across.knots, table.across.way)
        self._cells = np.array(table.values).reshape(len(table.knots), len(table.across.knots))

    def __call__(self, x: Any, y: Any) -> Any:
        down, across = self._rows.spots(x), self._columns.spots(y)
        ends = [
            across.between(self._cells[row, across.low], self._cells[row, across.high])
            for row in (down.low, down.high)
        ]
        return np.where(down.known & across.known, down.between(*ends), np.nan)
