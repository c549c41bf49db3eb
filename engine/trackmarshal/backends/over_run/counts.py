"""Counts of cycles, or of samples: a range of numbers where nothing is known of some, compared with a number."""

from __future__ import annotations

import math
from typing import NamedTuple, assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import COMPARISONS, Measure
from trackmarshal.runtime.kleene import UNDEFINED
from trackmarshal.runtime.verdict import Bound, Truth


class Range(NamedTuple):
    """In how many cycles, or at how many samples, something held: surely, and possibly."""

    sure: int
    possible: int


def compared(node: ir.Counted | ir.Tallied, count: Range, limit: float) -> Truth:
    """The value of a comparison of a count with a number."""
    if not math.isfinite(limit):
        return UNDEFINED
    measure, at_zero = COMPARISONS[node.op]
    sure, possible = float(count.sure), float(count.possible)
    nearest = min(max(round(limit), count.sure), count.possible)
    farthest = max(abs(sure - limit), abs(possible - limit))
    match measure:
        case Measure.ROOM:  # of the left side below the right one
            ends = (sure - limit, possible - limit) if node.turned else (limit - possible, limit - sure)
        case Measure.NEARNESS:
            ends = (-farthest, -abs(nearest - limit))
        case Measure.DISTANCE:
            ends = (abs(nearest - limit), farthest)
        case Measure.SAMENESS:
            raise AssertionError("a count is no member of an enumeration")
        case _:
            assert_never(measure)
    worst, best = (Bound(end > 0.0 or (at_zero and end == 0.0), end) for end in ends)
    return Truth(worst, best)
