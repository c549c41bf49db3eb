"""Times of a timeline's samples, and windows of temporal operators, in one unit."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.runtime.frame import Columns


class Measured(NamedTuple):
    """When samples begin and end, and the bounds of a window. ends: None where each sample is a moment."""

    begins: Sequence[float]
    ends: Sequence[float] | None
    lower: float | None
    upper: float | None


def measured(columns: Columns, lower: float | None, upper: float | None) -> Measured:
    """Seconds along what is given; whole nanoseconds along a course, which joins stamps of a run."""
    if columns.joined is None:
        return Measured(columns.listed("t"), None, lower, upper)
    begin, end = columns.joined.begin.tolist(), columns.joined.end.tolist()
    return Measured(begin, end, _bound(lower), _bound(upper))


def _bound(seconds: float | None) -> float | None:
    return None if seconds is None else float(nanoseconds(seconds))
