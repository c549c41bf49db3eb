"""Tables as the language defines them: where an argument lies among the knots, and what the value there is.

The reference evaluator goes by these; the other two take the same floating point operations in the same order.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

NAN = math.nan


class Way(NamedTuple):
    """How a table is read along one argument.

    steps: the value of the last knot at or below counts; else it is linear between knots. clamped: the first and the last value count outside.
    length: that of a period, in SI, which begins at 0; 0.0: there is none.
    """

    steps: bool
    clamped: bool
    length: float = 0.0


#: `linear clamp`.
LINEAR_CLAMP = Way(False, True)


class Spot(NamedTuple):
    """Where an argument lies: at a knot's value (low is high), or between those of two knots, `at` from `start` towards `end`."""

    low: int
    high: int
    start: float
    end: float
    at: float


def wrapped(x: float, length: float) -> float:
    """A finite number as a place of a period, from 0 up to its length; the remainder is exact."""
    rest = math.fmod(x, length)
    if rest < 0.0:
        rest = rest + length
    return 0.0 if rest >= length else rest


def in_period(way: Way, knots: Sequence[float]) -> bool:
    """Whether ascending knots lie in the period, from 0 up to its length; without a period they do."""
    return way.length == 0.0 or (knots[0] >= 0.0 and knots[-1] < way.length)


def spot(knots: Sequence[float], way: Way, x: float) -> Spot | None:
    """Where x lies among ascending knots; None where the table has no value."""
    if not math.isfinite(x):
        return None
    last = len(knots) - 1
    if way.length > 0.0:
        x = wrapped(x, way.length)
        if x < knots[0] or x >= knots[last]:
            at = x + way.length if x < knots[0] else x
            return Spot(last, last if way.steps else 0, knots[last], knots[0] + way.length, at)
    elif x <= knots[0]:
        return Spot(0, 0, x, x, x) if way.clamped or x == knots[0] else None
    elif x >= knots[last]:
        return Spot(last, last, x, x, x) if way.clamped or way.steps or x == knots[last] else None
    low = 0
    while knots[low + 1] <= x:
        low += 1
    return Spot(low, low if way.steps else low + 1, knots[low], knots[low + 1], x)


def between(place: Spot, low: float, high: float) -> float:
    """The value at a spot, of those of its two knots."""
    if place.low == place.high:
        return low
    slope = (high - low) / (place.end - place.start)
    return low + slope * (place.at - place.start)


def read(knots: Sequence[float], values: Sequence[float], way: Way, x: float) -> float:
    """The value of a table of one argument; NaN where it has none."""
    found = spot(knots, way, x)
    return NAN if found is None else between(found, values[found.low], values[found.high])


def read_grid(
    rows: tuple[Sequence[float], Way],
    columns: tuple[Sequence[float], Way],
    cells: Sequence[float],
    x: float,
    y: float,
) -> float:
    """The value of a table of two arguments: along the columns in each of the two rows, then along the rows; NaN where it has none.

    rows, columns: their knots, and how they are read. cells: row by row.
    """
    down, across = spot(*rows, x), spot(*columns, y)
    if down is None or across is None:
        return NAN
    width = len(columns[0])
    ends = [
        between(across, cells[row * width + across.low], cells[row * width + across.high])
        for row in (down.low, down.high)
    ]
    return between(down, *ends)


__all__ = ["LINEAR_CLAMP", "Spot", "Way", "between", "in_period", "read", "read_grid", "spot", "wrapped"]
