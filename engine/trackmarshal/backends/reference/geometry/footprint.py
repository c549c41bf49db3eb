"""The footprint of a pose, what it sweeps between two poses, and how two convex shapes stand to each other."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from trackmarshal.backends.reference.geometry.curve import Placed, curve, placed
from trackmarshal.points import (
    Point,
    Pose,
    Segment,
    chain,
    distance,
    side,
    sized,
    usable,
)


def footprint(pose: Pose, length: float, width: float, origin: Point = (0.0, 0.0)) -> list[Point]:
    """The corners of the rectangle centred at a pose, counter-clockwise from the front left, seen from an origin."""
    return box(placed(pose), length, width, origin)


def box(at: Placed, length: float, width: float, origin: Point) -> list[Point]:
    """The same of a pose in place."""
    x, y = at.x - origin[0], at.y - origin[1]
    fx, fy = 0.5 * length * at.ahead, 0.5 * length * at.aside
    lx, ly = -(0.5 * width * at.aside), 0.5 * width * at.ahead
    return [
        (x + (fx + lx), y + (fy + ly)),
        (x - (fx - lx), y - (fy - ly)),
        (x - (fx + lx), y - (fy + ly)),
        (x + (fx - lx), y + (fy - ly)),
    ]


def convex_hull(points: Sequence[Point]) -> list[Point]:
    """The corners of the convex hull, counter-clockwise (Andrew's monotone chain); points on its sides are left out."""
    ordered = sorted(set(points))

    def half(ways: Sequence[Point]) -> list[Point]:
        kept: list[Point] = []
        for x, y in ways:
            while len(kept) >= 2:
                (ax, ay), (bx, by) = kept[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 0.0:  # `side` of a segment, written out
                    break
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return half(ordered) + half(ordered[::-1])


def swept_corners(first: Placed, second: Placed, length: float, width: float) -> list[Point]:
    """The eight corners of both footprints, seen from the first pose."""
    origin = (first.x, first.y)
    return box(first, length, width, origin) + box(second, length, width, origin)


def depth(x: float, y: float, hull: Sequence[Segment]) -> float:
    """How far a point lies inside a convex polygon: its distance from the nearest side's line, negative outside."""
    return min(side(s, x, y) / math.sqrt(s.ex * s.ex + s.ey * s.ey) for s in hull)


def convex_clearance(first: Sequence[Point], second: Sequence[Point]) -> float:
    """The signed distance of two convex polygons, counter-clockwise.

    Apart or touching: the Euclidean distance. Overlapping: minus the shortest way that one of them would have to be
    moved to be free, which is along the normal of one of the sides (separating-axis theorem).
    """
    a, b = chain(first, True), chain(second, True)
    ways = [max(side(s, x, y) / math.sqrt(s.ex * s.ex + s.ey * s.ey) for x, y in second) for s in a]
    ways += [max(side(s, x, y) / math.sqrt(s.ex * s.ex + s.ey * s.ey) for x, y in first) for s in b]
    if min(ways) > 0.0:
        return -min(ways)
    from_first = min(distance(x, y, s) for x, y in first for s in b)
    from_second = min(distance(x, y, s) for x, y in second for s in a)
    return min(from_first, from_second)


def clear_margin(
    pose0: Pose,
    pose1: Pose,
    length: float,
    width: float,
    box: Pose,
    box_length: float,
    box_width: float,
    bend: Sequence[float] = (),
) -> float:
    """The signed distance [m] of what a vehicle sweeps between two poses from a box (pose, length, width).

    bend: the curvatures [1/m] at both poses, where the vehicle follows a curve; empty where it goes straight.
    """
    if not bend:
        return swept_clearance(pose0, pose1, length, width, box, box, box_length, box_width)
    if (
        not usable(*pose0, *pose1, *box, *bend)
        or not sized(length, width)
        or not sized(box_length, box_width)
    ):
        return math.nan
    way = curve(placed(pose0), placed(pose1), bend, length, width)
    stands = placed(box)
    pieces = (
        _clearance((first, second), (length, width), (stands, stands), (box_length, box_width))
        for first, second in pairwise(way.poses)
    )
    return min(pieces) - way.more


def swept_clearance(
    pose0: Pose,
    pose1: Pose,
    length: float,
    width: float,
    other0: Pose,
    other1: Pose,
    other_length: float,
    other_width: float,
) -> float:
    """The signed distance [m] of what two bodies sweep, each straight between two poses of its own."""
    if not usable(*pose0, *pose1, *other0, *other1):
        return math.nan
    if not sized(length, width) or not sized(other_length, other_width):
        return math.nan
    body, other = (placed(pose0), placed(pose1)), (placed(other0), placed(other1))
    return _clearance(body, (length, width), other, (other_length, other_width))


def _clearance(
    body: tuple[Placed, Placed],
    size: tuple[float, float],
    other: tuple[Placed, Placed],
    other_size: tuple[float, float],
) -> float:
    origin = (body[0].x, body[0].y)
    corners = [corner for at in other for corner in box(at, *other_size, origin)]
    return convex_clearance(convex_hull(swept_corners(*body, *size)), convex_hull(corners))
