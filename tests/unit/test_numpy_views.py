"""One case's values out of arrays of many: the entry that numpy itself has there, however the array is shared among cases and variables."""

from __future__ import annotations

import itertools
import math
import random

import numpy as np
import pytest

from trackmarshal.backends.numpy.logic import ABOVE, AT_LEAST, BOTH, NEITHER, Side, Value
from trackmarshal.backends.numpy.views import LISTED, Reading


def shapes(size: int) -> list[tuple[int, ...]]:
    """Of arrays of cases and two variables: what has one value for all has length 1; the last ones have more than are listed."""
    many = LISTED + 1
    lengths = itertools.product((1, size), (1, 3), (1, 2))
    return [(), *lengths, (size, many, 1), (size, 7, many), (1, 1, size * many + 1)]


@pytest.mark.parametrize("size", [1, 5])
def test_every_entry(size: int) -> None:
    draw = random.Random(size)
    for shape in shapes(size):
        count = math.prod(shape)
        numbers = [draw.choice((draw.gauss(0.0, 1.0), 0.0, -0.0, math.nan, math.inf)) for _ in range(count)]
        margin = np.array(numbers).reshape(shape)
        if len(shape) == 3:  # as many operations leave them: not in the order of C
            margin = np.asfortranarray(margin)
        apart = np.array([draw.random() < 0.5 for _ in range(count)]).reshape(shape)
        whole = (size, *np.broadcast_shapes(shape[1:], (3, 2) if shape[1:] in ((1, 1), ()) else shape[1:]))
        margins, sats = np.broadcast_to(margin, whole), np.broadcast_to(apart, whole)
        sides = {
            says: Side(margin, says, apart if says == NEITHER else None)
            for says in (AT_LEAST, ABOVE, BOTH, NEITHER)
        }
        readings = {says: Reading(Value(side, side), size) for says, side in sides.items()}
        # The best case may be shared among more cases than the worst one.
        apart_of_best = {
            says: Reading(Value(side, Side(np.array(7.0), BOTH)), size) for says, side in sides.items()
        }
        for index, first, second in itertools.product(*map(range, whole)):
            wanted = float(margins[index, first, second])
            holds = {
                AT_LEAST: wanted >= 0.0, BOTH: wanted >= 0.0, ABOVE: wanted > 0.0, NEITHER: bool(sats[index, first, second]),
            }  # fmt: skip
            for says, reading in readings.items():
                truth = reading.at(index, {0: first, 1: second})
                assert truth.best is truth.worst
                found = truth.worst
                other = apart_of_best[says].at(index, {0: first, 1: second})
                assert repr(other.worst) == repr(found)
                assert other.best == (True, 7.0)
                assert np.float64(found.margin).tobytes() == np.float64(wanted).tobytes()
                assert found.sat is holds[says]
                assert type(found.margin) is float


@pytest.mark.parametrize("position", [-1, 3, 4])
def test_an_entry_beyond_the_axis_is_not_another_case(position: int) -> None:
    side = Side(np.arange(6.0).reshape(2, 3), BOTH)
    with pytest.raises(IndexError):
        Reading(Value(side, side), 2).at(0, {0: position})
