"""Which two inputs of a demand are drawn, over what span, and what the others are fixed at.

The two are those that change the margin most: each is led through its whole span, with all others as they are in a boundary test; what counts is by
how much the margin changes on the way, in the boundary test in which that is most.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trackmarshal.reading.drawing.demand import BROKEN, HOLDS, Demand, Floats
from trackmarshal.reading.drawing.points import Points
from trackmarshal.reading.drawing.quantities import Quantity
from trackmarshal.runtime.frame import Settings

#: Of recorded values, how many are left out at each end of a span; how much room is left around what is shown, as a share of it.
_RARE, _ROOM = 0.005, 0.15
#: At how many values a margin is looked at on the way through a span; on how many by how many it is looked for where a demand ends to hold.
_STEPS, _LOOKS = 9, 25
#: Of what share of a picture both sides of a boundary are at least; how often a span is widened for that, and by what.
_SEEN = 0.05
_WIDER, _TIMES = 1.6, 30
#: By what a span is made smaller where it shows too little of what is thin.
_NEARER = 0.6
#: A declared range that is wider, in SI, says no more than that there are numbers in it.
_WIDEST = 1e6
#: Significant digits of what others are fixed at.
_DIGITS = 3


class Standing(NamedTuple):
    """A test: the values of all inputs where it is decided, what it expects, whether it is to stand on the boundary, and its own parameters and tables."""

    title: str
    values: Floats
    expects: str
    boundary: bool
    settings: Settings


class Known(NamedTuple):
    """What is known of a demand: its tests, and what was recorded."""

    tests: Sequence[Standing]
    recorded: Points | None

    def of(self, number: int) -> Floats:
        """All values of an input that are worth seeing: of boundary tests; of what was recorded and is nearer to the limit than the other half, the
        usual ones; and all that are against the rule. Where nothing was recorded, of all tests."""
        tests = [test.values[number] for test in self.tests]
        if self.recorded is None or not self.recorded.codes.size:
            return np.array(tests)
        column, margins = self.recorded.values[number], self.recorded.margins
        usual = np.quantile(column[margins <= np.median(margins)], (_RARE, 1.0 - _RARE))
        against = column[self.recorded.codes == BROKEN]
        ends = [against.min(), against.max()] if against.size else []
        near = [test.values[number] for test in self.tests if test.boundary] or tests
        return np.array([*near, *usual, *ends])


def typical(demand: Demand, known: Known) -> Floats:
    """What each input is fixed at where it is not drawn: its default, a parameter's value in force, or the middle of what was recorded, or else of the tests."""
    return np.array([_typical(demand, number, one, known) for number, one in enumerate(demand.quantities)])


def _typical(demand: Demand, number: int, one: Quantity, known: Known) -> float:
    signal, name = one.field
    if not signal and name:
        return demand.spec.params[name].value
    declared = demand.spec.field(signal, name) if signal else None
    if declared is not None and declared.default is not None:
        return declared.default
    column = np.array([test.values[number] for test in known.tests])
    if known.recorded is not None and known.recorded.codes.size:
        column = known.recorded.values[number]
    if not column.size:
        low, high = limits(demand, one)
        return min(max(0.0, low), high)
    # What is tiny beside its own span is none.
    middle, size = float(np.median(column)), float(np.abs(column).max())
    return float(f"{middle:.{_DIGITS}g}") + 0.0 if abs(middle) > 0.1**_DIGITS * size else 0.0


def limits(demand: Demand, one: Quantity) -> tuple[float, float]:
    """Between which values an input may lie at all, in SI."""
    signal, name = one.field
    if not name:
        return -np.inf, np.inf
    info = demand.spec.field(signal, name) if signal else demand.spec.params[name]
    assert info is not None
    return (
        -np.inf if info.lower is None else info.lower,
        np.inf if info.upper is None else info.upper,
    )


def span(demand: Demand, number: int, known: Known) -> tuple[float, float]:
    """From where to where an input is shown, in SI."""
    one = demand.quantities[number]
    values, to = known.of(number), limits(demand, one)
    if not values.size and 0.0 < to[1] - to[0] <= _WIDEST:
        return to  # nothing is known but between which values it lies
    values = values if values.size else np.array([_typical(demand, number, one, known)])
    low, high = float(values.min()), float(values.max())
    room = _ROOM * (high - low) if high > low else max(1.0, abs(high)) / 2.0
    return clipped((low - room, high + room), to)


def clipped(ends: tuple[float, float], to: tuple[float, float]) -> tuple[float, float]:
    """A span inside another one; not empty where they lie apart."""
    low, high = max(ends[0], to[0]), min(ends[1], to[1])
    return (low, high) if low < high else ends


def ranked(demand: Demand, known: Known) -> list[int]:
    """The numbers of all inputs, the most telling first; of those that tell alike, as they are written."""
    tests = [one for one in known.tests if one.boundary] or list(known.tests)
    starts = [(one.values, one.settings) for one in tests] or [(typical(demand, known), Settings())]
    told = []
    for number in range(len(demand.quantities)):
        way = np.linspace(*span(demand, number, known), _STEPS)
        changes = []
        for values, settings in starts:
            columns = [np.full(_STEPS, value) for value in values]
            columns[number] = way
            _, margins = demand.judge(columns, settings)
            finite = margins[np.isfinite(margins)]
            changes.append(float(np.ptp(finite)) if finite.size else 0.0)
        told.append(max(changes))
    return sorted(range(len(told)), key=lambda number: (-told[number], number))


def window(demand: Demand, axes: Sequence[int], fixed: Floats, known: Known) -> list[tuple[float, float]]:
    """The spans of the inputs that are drawn: wide enough to show where the demand ends to hold, if it does inside what may be."""
    spans = [span(demand, number, known) for number in axes]
    first, found = spans, False
    to = [limits(demand, demand.quantities[number]) for number in axes]
    for _ in range(_TIMES):
        ways = [np.linspace(*one, _LOOKS) for one in spans]
        grid = [one.ravel() for one in np.meshgrid(*ways)]
        columns = [np.full(grid[0].size, value) for value in fixed]
        for number, values in zip(axes, grid):
            columns[number] = values
        codes, _ = demand.judge(columns)
        wider = [
            clipped((middle - half * _WIDER, middle + half * _WIDER), most)
            for (low, high), most in zip(spans, to)
            for middle, half in [((low + high) / 2.0, (high - low) / 2.0)]
        ]
        shares = (codes == HOLDS).mean(), (codes == BROKEN).mean()
        found = min(shares) > 0.0
        if min(shares) >= _SEEN or wider == spans:
            break
        spans = wider
    spans = spans if found else first  # where nothing ends as far as anybody looks, what is known is shown
    dimensions = {demand.quantities[number].dimension for number in axes}
    if len(axes) > 1 and len(dimensions) == 1:
        # What can be compared has one scale: else a circle would be a line.
        half = max(high - low for low, high in spans) / 2.0
        spans = [clipped((middle - half, middle + half), most) for (low, high), most in zip(spans, to) for middle in [(low + high) / 2.0]]  # fmt: skip
    return spans


def nearer(
    spans: Sequence[tuple[float, float]], axes: Sequence[int], fixed: Floats, known: Known
) -> list[tuple[float, float]]:
    """Smaller spans, around the boundary tests, or around what others are fixed at where there are none."""
    near = [test.values for test in known.tests if test.boundary] or [fixed]
    found = []
    for number, (low, high) in zip(axes, spans):
        half = (high - low) * _NEARER / 2.0
        middle = min(max(float(np.mean([one[number] for one in near])), low + half), high - half)
        found.append((middle - half, middle + half))
    return found
