"""A region and its border: is a point in it, and by how much is a swept footprint inside it?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from trackmarshal.backends.reference.geometry.boxes import STRETCH, Box, box_of
from trackmarshal.backends.reference.geometry.curve import Placed, curve, placed
from trackmarshal.backends.reference.geometry.footprint import convex_hull, depth, swept_corners
from trackmarshal.points import (
    Point,
    Pose,
    Segment,
    chain,
    distance,
    nearest,
    segment,
    side,
    sized,
    usable,
)

#: The margin of a hull that the border enters by less than any measure below can show.
LEAST = -2.2250738585072014e-308


#: Segments of a border that follow each other, and their box.
Stretch = tuple[Box, tuple[tuple[Point, Point], ...]]


@dataclass(frozen=True)
class Region:
    """A closed region of the plane: its border, segment by segment, and how to tell its inside."""

    border: tuple[tuple[Point, Point], ...]
    #: A point is inside when a ray from it crosses the sides of any one group an odd number of times.
    groups: tuple[tuple[tuple[Point, Point], ...], ...]

    @cached_property
    def stretches(self) -> list[Stretch]:
        """The border in stretches, each with its box."""
        parts = [self.border[at : at + STRETCH] for at in range(0, len(self.border), STRETCH)]
        return [(box_of([point for ends in part for point in ends]), part) for part in parts]

    @cached_property
    def levels(self) -> list[list[tuple[float, float, tuple[tuple[Point, Point], ...]]]]:
        """The sides of each group in stretches, with the least and the greatest y of each."""
        parts = ([group[at : at + STRETCH] for at in range(0, len(group), STRETCH)] for group in self.groups)
        return [
            [(around.low, around.high, part) for part in of for around in [box_of([p for ends in part for p in ends])]]
            for of in parts
        ]  # fmt: skip

    def holds(self, x: float, y: float) -> bool:
        """Whether a point that is not on the border lies inside."""
        return any(
            # a stretch that does not reach to both sides of the ray has no side that crosses it
            odd_crossings(x, y, [ends for low, high, part in group if low <= y < high for ends in part])
            for group in self.levels
        )


class Outside(Region):
    """All that is not strictly inside a region, with the same border."""

    def holds(self, x: float, y: float) -> bool:
        return not super().holds(x, y)


def odd_crossings(x: float, y: float, sides: Sequence[tuple[Point, Point]]) -> bool:
    """Whether the ray from a point along +x crosses the sides an odd number of times."""
    inside = False
    for a, b in sides:
        low, high = (
            (a, b) if a[1] < b[1] else (b, a)
        )  # one direction, so that neighbours agree on a shared side
        if low[1] <= y < high[1] and side(segment(low, high), x, y) > 0.0:
            inside = not inside
    return inside


def point_margin(region: Region, x: float, y: float) -> float:
    """The signed distance [m] of a point from the border, positive inside."""
    if not usable(x, y):
        return math.nan
    reach = min(distance(x, y, segment(a, b)) for a, b in region.border)
    return reach if reach == 0.0 or region.holds(x, y) else -reach


def hull_margin(
    region: Region, pose0: Pose, pose1: Pose, length: float, width: float, bend: Sequence[float] = ()
) -> float:
    """The signed margin [m] of `what a vehicle sweeps between two poses lies inside a region`; NaN for a pose or a size that is none.

    bend: the curvatures [1/m] at both poses, where the vehicle follows a curve; empty where it goes straight.
    """
    if not usable(*pose0, *pose1, *bend) or not sized(length, width):
        return math.nan
    first, second = placed(pose0), placed(pose1)
    if not bend:
        return piece_margin(region, first, second, length, width)
    way = curve(first, second, bend, length, width)
    return min(piece_margin(region, *ends, length, width) for ends in pairwise(way.poses)) - way.more


def piece_margin(region: Region, first: Placed, second: Placed, length: float, width: float) -> float:
    """The signed margin [m] of the convex hull of two footprints inside a region.

    Inside: its distance from the border. Otherwise minus the largest of: the distance from the border of each corner of
    the two footprints outside the region, and the depth inside the hull of each border vertex strictly inside it.
    Where neither exists (the border passes through between corners), minus the depth of the middle of the longest
    stretch of a border segment inside the hull.
    """
    origin = x0, y0 = first.x, first.y
    corners = swept_corners(first, second, length, width)
    hull = chain(convex_hull(corners), True)
    stretches = [(around.seen_from(*origin), part) for around, part in region.stretches]
    reach = first_reach(stretches, corners[0], origin)
    border = near(stretches, corners, reach, origin)
    entering = [s for s in border if enters(s, hull)]
    if not entering and region.holds((x0 + second.x) / 2, (y0 + second.y) / 2):
        return gap(corners, hull, border)
    worst = 0.0
    # A corner is no farther from the border than the first corner is, and the way to it.
    around_all = near(stretches, corners, reach + box_of(corners).size, origin)
    for x, y in corners:
        reach = min(distance(x, y, s) for s in around_all)
        if reach > 0.0 and not region.holds(x + x0, y + y0):
            worst = max(worst, reach)
    for s in border:
        worst = max(worst, depth(s.ax, s.ay, hull))
    if worst == 0.0:
        worst = max((depth(*middle(s, hull), hull) for s in entering), default=0.0)
    return min(LEAST, -worst)


def enters(s: Segment, hull: Sequence[Segment]) -> bool:
    """Whether a segment has a point strictly inside a convex polygon: no side and no line of its own separates them."""
    for edge in hull:
        if side(edge, s.ax, s.ay) <= 0.0 and side(edge, s.bx, s.by) <= 0.0:
            return False
    turns = [side(s, edge.ax, edge.ay) for edge in hull]
    return min(turns) < 0.0 < max(turns)


def first_reach(stretches: Sequence[Stretch], corner: Point, origin: Point) -> float:
    """How far a corner is from the stretch of a border that looks nearest: it is no farther from the border."""
    x, y = corner
    at = Box(x, x, y, y)
    _, looks = min(stretches, key=lambda stretch: stretch[0].apart(at))
    return min(distance(x, y, segment(a, b, origin)) for a, b in looks)


def near(
    stretches: Sequence[Stretch], corners: Sequence[Point], known: float, origin: Point
) -> list[Segment]:
    """The segments of a border, seen from an origin, without those that are surely farther from the hull of corners than is `known`: they do
    not enter it, and have no end in it."""
    box = box_of(corners)
    x, y = origin
    found = []
    for around, part in stretches:
        limit = surely(known, around.size)
        if around.apart(box) > limit:
            continue
        left, right, low, high = box.wider(limit)
        for a, b in part:
            # `beyond` of the `segment`, written out: most are, and need not be made.
            ax, ay, bx, by = a[0] - x, a[1] - y, b[0] - x, b[1] - y
            if not (ax < left > bx or ax > right < bx or ay < low > by or ay > high < by):
                found.append(Segment(ax, ay, bx, by, b[0] - a[0], b[1] - a[1]))
    return found


def gap(corners: Sequence[Point], hull: Sequence[Segment], border: Sequence[Segment]) -> float:
    """The distance of a hull from a border that does not enter it: a corner of one is nearest to a side of the other."""
    around = box_of(corners)
    least, close = math.inf, []
    for s in border:
        if beyond(s, around.wider(surely(least, abs(s.ex) + abs(s.ey)))):
            continue  # farther than another one: so is its start
        close.append((s.ax, s.ay))
        least = min(least, nearest(corners, s))
    left, right, low, high = around.wider(surely(least, 0.0))
    close = [(x, y) for x, y in close if left <= x <= right and low <= y <= high]  # no other one is nearer
    from_border = min(nearest(close, edge) for edge in hull)
    return min(least, from_border)


def beyond(s: Segment, box: Box) -> bool:
    """Whether a segment lies on one side of a box."""
    left, right, low, high = box
    ax, ay, bx, by, _, _ = s
    return ax < left > bx or ax > right < bx or ay < low > by or ay > high < by


def surely(known: float, size: float) -> float:
    """How far something of a size has to be away to be farther than known, however distances are rounded.

    By a billionth of all lengths from which distances are computed, which round by a millionth of that.
    """
    return known + 3e-9 * (known + size)


def middle(s: Segment, hull: Sequence[Segment]) -> Point:
    """The middle of the part of a segment inside a convex polygon that it enters."""
    first, last = 0.0, 1.0
    for edge in hull:
        start, end = side(edge, s.ax, s.ay), side(edge, s.bx, s.by)
        if start < end:
            first = max(first, start / (start - end))
        elif start > end:
            last = min(last, start / (start - end))
    t = (first + last) / 2
    return s.ax + t * s.ex, s.ay + t * s.ey
