"""What is made of a border once: what its grid lists, which of its segments are compared with each other, and which of its points are. Nothing that counts is left out."""

from __future__ import annotations

import random
from fractions import Fraction
from itertools import combinations, pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from property.test_border_search import Point, looked_at_all, road, segments
from property.test_over_run import EXAMPLES
from trackmarshal.runtime.geometry.arrays import SAME, distinct
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.cells import Cells
from trackmarshal.runtime.geometry.crossings import meetings


def turn(a: Point, b: Point, p: Point) -> int:
    """The sign of the turn a, b, p, exactly."""
    ax, ay, bx, by, px, py = map(Fraction, (*a, *b, *p))
    area = (bx - ax) * (py - ay) - (by - ay) * (px - ax)
    return (area > 0) - (area < 0)


def meet(one: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    """Whether two segments have a point in common."""
    apart = any(
        max(p[axis] for p in a) < min(p[axis] for p in b)
        for a, b in ((one, other), (other, one))
        for axis in (0, 1)
    )
    return not apart and all(turn(*a, b[0]) * turn(*a, b[1]) <= 0 for a, b in ((one, other), (other, one)))


def check_meetings(chains: list[list[Point]]) -> None:
    every = segments(chains, True)
    firsts = [sum(len(chain) for chain in chains[:at]) for at in range(len(chains) + 1)]
    after = {
        k: begin if k + 1 == end else k + 1 for begin, end in pairwise(firsts) for k in range(begin, end)
    }
    wanted = [
        (i, j)
        for i, j in combinations(range(len(every)), 2)
        if j != after[i] and i != after[j] and meet(every[i], every[j])
    ]
    found = list(meetings(Border([np.array(chain) for chain in chains], True)))
    assert [pair for i, j in found for pair in zip(i.tolist(), j.tolist(), strict=True)] == wanted
    assert all(i.size for i, _ in found)


@given(st.integers(0, 2**32), st.lists(st.integers(3, 40), min_size=1, max_size=3))
@settings(max_examples=EXAMPLES, deadline=None)
def test_all_that_meet_are_found_in_order(seed: int, lengths: list[int]) -> None:
    """On a grid, where many segments meet in their ends, or lie on one another."""
    draw = random.Random(seed)
    chains = []
    for length in lengths:
        chain = [(0.0, 0.0)]
        while len(chain) < length or chain[-1] == chain[0]:
            point = (float(draw.randint(-9, 9)), float(draw.randint(-9, 9)))
            chain += [point] if point != chain[-1] else []
        chains.append(chain)
    check_meetings(chains)


@pytest.mark.parametrize("length", [3, 7, 8, 9, 16, 63, 64, 65, 70])
def test_groups_that_are_not_full(length: int) -> None:
    """A comb: its last segment goes back over all the others."""
    check_meetings([[(float(k), float(k % 2)) for k in range(length - 1)] + [(float(length), 0.5)]])


@given(st.integers(0, 2**32), st.integers(3, 150), st.sampled_from([0.5, 2.0, 6.0]))
@settings(max_examples=EXAMPLES, deadline=None)
def test_what_is_listed_holds_what_is_nearest_whenever_it_is_asked(
    seed: int, count: int, size: float
) -> None:
    """Point by point, a few fields at a time; and all points at once."""
    draw = random.Random(seed)
    way = road(draw, count)
    chain = [way[0], *(point for before, point in pairwise(way) if point != before)]
    if len(chain) < 3 or chain[0] == chain[-1]:
        return
    border, every = Border([np.array(chain)], True), segments([chain], True)
    points = np.array(
        [[part + draw.uniform(-9, 9) for part in draw.choice(chain)] for _ in range(12)]
    ).T  # most of them near
    radius = np.array([draw.choice((0.0, 0.0, 3.0, 9.0)) for _ in range(12)])
    bit_by_bit, at_once = Cells(border, size), Cells(border, size)
    rows, tiles, unknown = at_once.tiles_around(points, radius)
    for k in range(12):
        _, own, own_unknown = bit_by_bit.tiles_around(points[:, k : k + 1], radius[k : k + 1])
        assert (own_unknown is not None) == (unknown is not None and bool(unknown[k]))
        if own_unknown is None:
            x, y = points[:, k].tolist()
            reaches = [looked_at_all(a, b, x, y) for a, b in every]
            least = min(reaches) + float(radius[k])
            nearest = {at for at, reach in enumerate(reaches) if reach <= least}
            assert nearest <= set(own.ravel().tolist())
            assert nearest <= set(tiles[:, rows == k].ravel().tolist())


@given(
    st.lists(
        st.tuples(*[st.sampled_from([0.0, 0.4e-9, 0.9e-9, 1e-9, 1.1e-9, -0.6e-9, 1.0])] * 2), max_size=14
    ),
    st.booleans(),
)
@settings(max_examples=3 * EXAMPLES, deadline=None)
def test_points_are_compared_with_the_last_one_kept(steps: list[Point], closed: bool) -> None:
    """Not with the one before, from which a chain of small steps would lead anywhere."""
    points = np.cumsum(np.array(steps, dtype=np.float64).reshape(-1, 2), axis=0)
    kept: list[Point] = []
    for x, y in points.tolist():
        if not kept or max(abs(x - kept[-1][0]), abs(y - kept[-1][1])) > SAME:
            kept.append((x, y))
    while (
        closed and len(kept) > 1 and max(abs(a - b) for a, b in zip(kept[0], kept[-1], strict=True)) <= SAME
    ):
        kept.pop()
    assert distinct(points, closed).tolist() == [list(point) for point in kept]
