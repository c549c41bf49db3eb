"""Times of a timeline's samples, and windows of temporal operators: whole nanoseconds, as over the run, so that 0.7 s and 0.1 s are 0.8 s."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.runtime.frame import Columns

if TYPE_CHECKING:
    from numpy import float64
    from numpy.typing import NDArray

    Floats = NDArray[float64]

#: s; times farther away stand there, so that each is finite in nanoseconds, too.
_FARTHEST = 1e299


class Measured(NamedTuple):
    """When samples begin and end, and the bounds of a window, in whole nanoseconds: (count,) float64, never decreasing. ends: None where each is a moment."""

    begins: Floats
    ends: Floats | None
    lower: float | None
    upper: float | None


def measured(columns: Columns, lower: float | None, upper: float | None) -> Measured:
    """Of a timeline, and a window of it, s. Samples within a nanosecond of each other are at one time."""
    joined = columns.joined
    if joined is None:
        begins, ends = (columns.column("t").clip(-_FARTHEST, _FARTHEST) * 1e9).round(), None
    else:
        begins, ends = joined.begin, joined.end
    return Measured(begins, ends, _bound(lower), _bound(upper))


def _bound(seconds: float | None) -> float | None:
    return None if seconds is None else float(nanoseconds(seconds))
