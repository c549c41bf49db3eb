"""What the reference leaves out of a line is never what is nearest: the same bits, and the same segment, as from looking at all of them."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from property.test_over_run import EXAMPLES
from trackmarshal.backends.reference.geometry.curvilinear import Line
from trackmarshal.points import distance

#: On a grid, so that segments often are equally near, and anywhere.
_NUMBER = st.integers(-4, 4).map(float) | st.floats(-1e3, 1e3) | st.floats(-1e9, 1e9)
_POINT = st.tuples(_NUMBER, _NUMBER)


@given(st.lists(_POINT, min_size=3, max_size=90), st.lists(_POINT, min_size=1, max_size=5), st.booleans())
@settings(max_examples=20 * EXAMPLES, deadline=None)
def test_nearest(points: list[tuple[float, float]], asked: list[tuple[float, float]], closed: bool) -> None:
    line = Line(points, closed)
    if line.fault:
        return
    for x, y in (*asked, points[-1], points[len(points) // 2]):
        reaches = [distance(x, y, s) for s in line.segments]
        assert line.nearest(x, y) == (min(reaches), reaches.index(min(reaches)))


@given(
    st.lists(st.tuples(st.floats(0.5, 5.0), st.floats(-0.5, 0.5)), min_size=60, max_size=200),
    st.lists(st.tuples(st.integers(0, 199), st.floats(-60.0, 60.0), st.floats(-60.0, 60.0)), min_size=3, max_size=8),
)  # fmt: skip
@settings(max_examples=6 * EXAMPLES, deadline=None)
def test_beside_a_road(steps: list[tuple[float, float]], asked: list[tuple[int, float, float]]) -> None:
    """Stretches that lie one behind the other: the first that is looked at is often not the one with what is nearest."""
    points, heading = [(0.0, 0.0)], 0.0
    for length, turn in steps:
        heading += turn
        x, y = points[-1]
        points.append((x + length * math.cos(heading), y + length * math.sin(heading)))
    line = Line(points)
    for place, dx, dy in asked:
        x, y = points[place % len(points)][0] + dx, points[place % len(points)][1] + dy
        reaches = [distance(x, y, s) for s in line.segments]
        assert line.nearest(x, y) == (min(reaches), reaches.index(min(reaches)))


def test_far_ones_are_left_out() -> None:
    """A circle of a kilometre: nearly all of it is not looked at."""
    turns = [2 * math.pi * k / 1000 for k in range(1000)]
    line = Line([(1000 * math.cos(a), 1000 * math.sin(a)) for a in turns], True)
    looked = []

    class Counting(list):  # type: ignore[type-arg]
        def __iter__(self):  # type: ignore[no-untyped-def]
            looked.append(len(self))
            return super().__iter__()

    line.__dict__["stretches"] = [(at, box, Counting(part)) for at, box, part in line.stretches]
    assert line.nearest(990.0, 0.0)[0] == distance(990.0, 0.0, line.segments[0])
    assert sum(looked) <= 64
