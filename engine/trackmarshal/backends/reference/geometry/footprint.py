"""The footprint of a pose, what it sweeps between two poses, and how two convex shapes stand to each other."""

from __future__ import annotations

import math
from collections.abc import Sequence

from trackmarshal.backends.reference.geometry.points import (
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
    x, y = pose[0] - origin[0], pose[1] - origin[1]
    fx, fy = 0.5 * length * math.cos(pose[2]), 0.5 * length * math.sin(pose[2])
    lx, ly = -(0.5 * width * math.sin(pose[2])), 0.5 * width * math.cos(pose[2])
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
            while len(kept) >= 2 and side(chain(kept[-2:], False)[0], x, y) <= 0.0:
                kept.pop()
            kept.append((x, y))
        return kept[:-1]

    return half(ordered) + half(ordered[::-1])


def swept_corners(pose0: Pose, pose1: Pose, length: float, width: float) -> list[Point]:
    """The eight corners of both footprints, seen from the first pose."""
    origin = (pose0[0], pose0[1])
    return footprint(pose0, length, width, origin) + footprint(pose1, length, width, origin)


def swept(pose0: Pose, pose1: Pose, length: float, width: float) -> list[Point]:
    """The convex hull of the footprints of two poses, counter-clockwise."""
    if not usable(*pose0, *pose1) or not sized(length, width):
        raise ValueError("a swept footprint needs finite poses and positive sizes")
    return [(x + pose0[0], y + pose0[1]) for x, y in convex_hull(swept_corners(pose0, pose1, length, width))]


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
    pose0: Pose, pose1: Pose, length: float, width: float, box: Pose, box_length: float, box_width: float
) -> float:
    """The signed distance [m] of what a vehicle sweeps between two poses from a box (pose, length, width)."""
    return swept_clearance(pose0, pose1, length, width, box, box, box_length, box_width)


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
    """The signed distance [m] of what two bodies sweep, each between two poses of its own."""
    if not usable(*pose0, *pose1, *other0, *other1):
        return math.nan
    if not sized(length, width) or not sized(other_length, other_width):
        return math.nan
    origin = (pose0[0], pose0[1])
    body = convex_hull(swept_corners(pose0, pose1, length, width))
    corners = footprint(other0, other_length, other_width, origin) + footprint(
        other1, other_length, other_width, origin
    )
    return convex_clearance(body, convex_hull(corners))
