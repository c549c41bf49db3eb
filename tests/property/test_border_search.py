"""What the search among a border's segments leaves out is never nearest: the same segment, and the same bits, as from looking at all of them."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from property.test_over_run import EXAMPLES
from trackmarshal.points import distance
from trackmarshal.runtime.geometry.border import Border

Point = tuple[float, float]
#: As many points as are searched one way, as the other, and as are more than are held at once.
COUNTS = (1, 2, 63, 64, 65, 66, 200, 1500)


def segments(chains: list[list[Point]], closed: bool) -> list[tuple[Point, Point]]:
    return [pair for chain in chains for pair in zip(chain, chain[1:] + chain[:1] if closed else chain[1:])]


def looked_at_all(a: Point, b: Point, x: float, y: float) -> float:
    """The distance of a point from a segment; of none in length, from its point."""
    ex, ey, rx, ry = b[0] - a[0], b[1] - a[1], x - a[0], y - a[1]
    along, square = ex * rx + ey * ry, ex * ex + ey * ey
    if 0.0 < along < square:
        return abs(ex * ry - ey * rx) / math.sqrt(square)
    sx, sy = x - b[0], y - b[1]
    return math.sqrt(min(rx * rx + ry * ry, sx * sx + sy * sy))


def check(chains: list[list[Point]], closed: bool, points: list[Point]) -> None:
    with np.errstate(invalid="ignore", divide="ignore"):  # of segments without length
        border = Border([np.array(chain) for chain in chains], closed)
        x, y = np.array(points).T
        found, reach = border.nearest(x, y)
    every = segments(chains, closed)
    for point, k, own in zip(points, found.tolist(), reach.tolist(), strict=True):
        reaches = [looked_at_all(a, b, *point) for a, b in every]
        least = min(reaches)
        assert (k, own) == (reaches.index(least), least), f"of {len(points)} points, {point}"


def road(draw: random.Random, count: int) -> list[Point]:
    """Segments of very different lengths, that bend, stop and turn back."""
    points, heading = [(draw.uniform(-50, 50), draw.uniform(-50, 50))], draw.uniform(-3, 3)
    while len(points) < count:
        kind = draw.random()
        length = draw.choice((1e-7, 1e-3, 0.3, 2.0, 2.0, 2.0, 400.0)) if kind < 0.9 else 0.0
        heading += draw.choice((0.0, 0.1, -0.2, math.pi / 2, math.pi))
        x, y = points[-1]
        points.append((x + length * math.cos(heading), y + length * math.sin(heading)))
    return points


def around(draw: random.Random, chains: list[list[Point]], count: int) -> list[Point]:
    """On corners, in the middles of segments, beside them and far off."""
    corners = [point for chain in chains for point in chain]
    found = []
    for _ in range(count):
        (x, y), (u, v) = draw.choice(corners), draw.choice(corners)
        far = draw.choice((0.0, 0.0, 1e-9, 1.0, 30.0, 1e5))
        middle = draw.choice((0.0, 0.5))
        found.append(
            (x + middle * (u - x) + draw.uniform(-far, far), y + middle * (v - y) + draw.uniform(-far, far))
        )
    return found


@given(
    st.integers(0, 2**32),
    st.sampled_from(COUNTS[:-2]),
    st.lists(st.integers(3, 70), min_size=1, max_size=3),
    st.booleans(),
)
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_roads(seed: int, count: int, lengths: list[int], closed: bool) -> None:
    draw = random.Random(seed)
    chains = [road(draw, length) for length in lengths]
    check(chains, closed, around(draw, chains, count))


@given(st.integers(0, 2**32), st.sampled_from(COUNTS[:-2]), st.integers(2, 60), st.booleans())
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_on_a_grid_many_are_equally_near(seed: int, count: int, length: int, closed: bool) -> None:
    """The first one counts, in whichever block, and in whichever part of it; a chain twice is as near the second time."""
    draw = random.Random(seed)
    chain = [(float(draw.randint(-3, 3)), float(draw.randint(-3, 3))) for _ in range(length)]
    points = [(draw.randint(-8, 8) / 2, draw.randint(-8, 8) / 2) for _ in range(count)]
    check([chain, chain], closed, points)


@pytest.mark.parametrize("count", COUNTS)
def test_how_many_points_there_are_changes_nothing(count: int) -> None:
    draw = random.Random(count)
    chains = [road(draw, 150), road(draw, 33)]
    check(chains, True, around(draw, chains, count))


@pytest.mark.parametrize("count", [64, 65])
@pytest.mark.parametrize("length", [1, 2, 3, 4, 5, 15, 16, 17, 20, 33])
def test_blocks_that_are_not_full(length: int, count: int) -> None:
    """The last segment fills them up: each segment is the nearest of some point."""
    chain = [(4.0 * k, (-1.0) ** k) for k in range(length + 1)]
    points = [(4.0 * (k % length) + 2.0, 0.125) for k in range(count)]
    check([chain], False, points)
    border = Border([np.array(chain)], False)
    assert border.nearest(*np.array(points).T)[0].tolist() == [k % length for k in range(count)]


@pytest.mark.parametrize("count", [1, 64, 65, 300])
def test_a_long_segment_among_short_ones(count: int) -> None:
    """Its disc reaches far: what is nearest is often in a part whose centre is the farthest."""
    for at in range(20):
        chain = [(0.01 * k, 0.0) for k in range(at + 1)]
        chain += [(chain[-1][0], 1000.0), *((chain[-1][0] + 0.01 * k, 1000.0) for k in range(1, 21 - at))]
        draw = random.Random(at)
        check([chain], False, [(draw.uniform(-5, 5), draw.uniform(-5, 1005)) for _ in range(count)])


def test_the_yardstick_is_the_references_own() -> None:
    """Where all segments have a length, what is compared with here is what the reference takes for the distance."""
    from trackmarshal.backends.reference.geometry.curvilinear import Line

    draw = random.Random(3)
    for _ in range(20):
        chain = [(draw.uniform(-9, 9), draw.uniform(-9, 9)) for _ in range(12)]
        line = Line(chain, False)
        for x, y in around(draw, [chain], 20):
            own = [looked_at_all(a, b, x, y) for a, b in segments([chain], False)]
            assert own == [distance(x, y, one) for one in line.segments]


@pytest.mark.parametrize("at", [(0.0, 0.0), (40.0, 0.0), (39.0, 1.0), (1e5, -1e5), (1e9, 1e9)])
@pytest.mark.parametrize("spread", [0.0, 1e-9, 1.0, 60.0])
def test_points_that_lie_together(at: Point, spread: float) -> None:
    """In the middle of a ring, as far from all of it, on it, beside it and far off: of most of its blocks none of them is near."""
    draw = random.Random(round(at[0] + spread))
    ring = [(40.0 * math.cos(0.02 * k), 40.0 * math.sin(0.02 * k)) for k in range(314)]
    points = [
        (at[0] + draw.uniform(-spread, spread), at[1] + draw.uniform(-spread, spread)) for _ in range(5)
    ]
    check([ring], True, [at, *points])


def test_of_no_points_there_are_none() -> None:
    border = Border([np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])], True)
    none = np.empty(0)
    assert [part.size for part in (*border.nearest(none, none), *border.near(none, none, 1.0))] == [0] * 5
