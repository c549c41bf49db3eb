"""Where a window decides: found in one look along a piece, and as the definition of each operator says it, cycle by cycle."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from property.test_over_run import EXAMPLES
from property.test_whole_run import same
from trackmarshal.backends.numpy.whole.elements import elements
from trackmarshal.backends.numpy.whole.firsts import STAYS, Firsts

#: Surely, not, perhaps.
TRUTH = {True: (True, True), False: (False, False), None: (False, True)}
#: One cycle: how long after the one before, how many are missing between, and what two formulas are.
_CYCLE = st.tuples(st.integers(1, 4), st.sampled_from([0, 0, 0, 1]), st.sampled_from([True, False, None]), st.sampled_from([True, False, None]))  # fmt: skip


@given(st.lists(_CYCLE, min_size=1, max_size=14), st.integers(0, 5), st.integers(0, 8))
@settings(max_examples=20 * EXAMPLES, deadline=None)
def test_as_defined(cycles: list[Any], lower: int, length: int) -> None:
    stamps = np.cumsum([10 * cycle[0] for cycle in cycles]).astype(np.int64)
    own = elements(stamps, np.array([cycle[1] for cycle in cycles]), None)
    windows = own.ahead(10 * lower, 10 * (lower + length))
    places = range(len(own)) if own.cycles is None else own.cycles.tolist()
    held, goal = ({at: cycle[i] for at, cycle in zip(places, cycles)} for i in (2, 3))
    number = {at: float(place) for place, at in enumerate(places)}
    sides = [
        tuple(np.array([TRUTH[of.get(at)][best] for at in range(len(own))]) for best in (0, 1))
        for of in (held, goal)
    ]
    inside = [list(range(windows.start[at], windows.stop[at])) if windows.stop[at] else [] for at in places]

    found = Firsts(windows, own)
    assert found.place(sides[0][0]).tolist() == [
        min((number[j] for j in window if held.get(j) is True), default=math.inf) for window in inside
    ]
    assert found.none(sides[0][1]).tolist() == [
        all(held.get(j) is False for j in window) for window in inside
    ]
    true, false = found.until((sides[0][0], sides[0][1]), (sides[1][0], sides[1][1]))
    for at, window, is_true, is_false in zip(places, inside, true.tolist(), false.tolist()):
        reached = [
            j for j in window if goal.get(j) is True and all(held.get(i) is True for i in range(at, j))
        ]
        assert is_true == min((number[j] for j in reached), default=math.inf)
        broken = next((j for j in range(at, len(own)) if held.get(j, None) is False), None)
        end = windows.stop[at] if window else max(at, _end(windows, at))
        may = [j for j in window if goal.get(j) is not False and (broken is None or j <= broken)]
        if may:
            assert is_false == math.inf
        elif broken is not None and broken < end:
            assert is_false == number[broken]
        else:
            assert is_false == STAYS


def _end(windows: Any, at: int) -> int:
    """The end of an empty window: what has to hold has to hold until there."""
    return min(at + windows.end, windows.n) if isinstance(windows.end, int) else int(windows.end[at])


def test_an_operator_that_another_one_decides_earlier() -> None:
    """What `or` is known by one side before the other has said its last word."""
    for formula in (
        "(always[0 s, 1 s] ego.v > 0 m/s) and (always[0 s, 0.3 s] ego.w > 0 m/s)",
        "(eventually[0 s, 1 s] ego.v > 0 m/s) or (eventually[0.2 s, 0.3 s] ego.w > 0 m/s)",
        "(eventually[0 s, 1 s] ego.v > 3 m/s) iff (always[0.1 s, 0.5 s] ego.w > 0 m/s)",
    ):
        rows = [(2.0, 1.0), (1.0, 2.0), (0.5, -1.0), (-1.0, -2.0), (-3.0, 1.0), (5.0, 0.5), (0.25, 3.0)] * 3
        cycles: list[dict[str, Any] | None] = [
            {"id": i, "t": i / 10, "signals": {"ego": {"v": v, "w": w, "on": True}}}
            for i, (v, w) in enumerate(rows)
        ]
        same(f'{_MODULE}rule f "" require {formula}\n', cycles, [4, 5])


_MODULE = "module m\nsignal ego : state { v: m/s, w: m/s, on: bool }\n"
