"""A region and its border: is a point in it, and by how much is a swept footprint inside it?"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from operator import itemgetter
from typing import NamedTuple

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
#: The same seen from a body: how far its box is from the one of the body [m].
Seen = tuple[float, tuple[tuple[Point, Point], ...]]


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
    def largest(self) -> float:
        """How large the largest stretch is [m]."""
        return max(box.size for box, _ in self.stretches)

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
    x0, y0 = first.x, first.y
    corners = swept_corners(first, second, length, width)
    hull, body = chain(convex_hull(corners), True), Body.of(corners, first)
    stretches = [(box.apart(body.around, x0, y0), part) for box, part in region.stretches]
    reach = first_reach(stretches, body)
    border = near(stretches, body, reach, region.largest)
    entering = [s for off, s in border if off <= body.surely(0.0, s) and enters(s, hull)]
    if not entering and region.holds((x0 + second.x) / 2, (y0 + second.y) / 2):
        return gap(body, hull, border, reach)
    worst = 0.0
    # A corner is no farther from the border than another one is, and the way to that.
    around_all = near(stretches, body, reach + body.size, region.largest)
    for x, y in corners:
        reach = min(distance(x, y, s) for _, s in around_all)
        if reach > 0.0 and not region.holds(x + x0, y + y0):
            worst = max(worst, reach)
    for _, s in border:
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


class Body(NamedTuple):
    """The corners of what is swept, seen from the first of its poses, and boxes around them: of x and y, and of ahead of that pose and to its left."""

    corners: Sequence[Point]
    first: Placed
    around: Box
    along: Box
    size: float

    @classmethod
    def of(cls, corners: Sequence[Point], first: Placed) -> Body:
        """The body of corners that are seen from a pose."""
        ahead, aside, around = first.ahead, first.aside, box_of(corners)
        turned = [(x * ahead + y * aside, y * ahead - x * aside) for x, y in corners]
        return cls(corners, first, around, box_of(turned), around.size)

    def surely(self, known: float, s: Segment) -> float:
        """How far a segment has to be away to be farther than known, however distances are rounded."""
        return surely(known, self.size + abs(s.ex) + abs(s.ey))


def first_reach(stretches: Sequence[Seen], body: Body) -> float:
    """How far a corner is from the segment that looks nearest, of the stretch that does: it is no farther from the border."""
    _, s = min(near([min(stretches, key=itemgetter(0))], body, math.inf, math.inf))
    return nearest(body.corners, s)


def near(stretches: Sequence[Seen], body: Body, known: float, largest: float) -> list[tuple[float, Segment]]:
    """The segments of a border, seen as the body is, without those that are surely farther from it than is `known`: they do not enter it, and have no
    end in it. With each how far it is at least. largest: how large a stretch may be."""
    x, y, ahead, aside = body.first
    back, front, right, left = body.along
    limit = surely(known, body.size + largest)
    west, east, south, north = body.around.wider(limit)
    found = []
    for apart, part in stretches:
        if apart > limit:
            continue
        for a, b in part:
            # All written out: there are many, most lie on one side of the box, and need not be made.
            ax, ay, bx, by = a[0] - x, a[1] - y, b[0] - x, b[1] - y
            if ax < west > bx or ax > east < bx or ay < south > by or ay > north < by:
                continue
            u, v = ax * ahead + ay * aside, ay * ahead - ax * aside
            other_u, other_v = bx * ahead + by * aside, by * ahead - bx * aside
            if u > other_u:
                u, other_u = other_u, u
            if v > other_v:
                v, other_v = other_v, v
            du = u - front if u > front else back - other_u if other_u < back else 0.0
            dv = v - left if v > left else right - other_v if other_v < right else 0.0
            off = math.sqrt(du * du + dv * dv)
            if off <= limit:
                found.append((off, Segment(ax, ay, bx, by, b[0] - a[0], b[1] - a[1])))
    return found


def gap(body: Body, hull: Sequence[Segment], border: Sequence[tuple[float, Segment]], known: float) -> float:
    """The distance of a hull from a border that does not enter it: a corner of one is nearest to a side of the other. A corner is as far as is
    `known` from one of the segments."""
    least, close = known, []
    for off, s in sorted(border):
        if off <= body.surely(least, s):  # else farther than another one: so is its start
            close.append((s.ax, s.ay))
            least = min(least, nearest(body.corners, s))
    left, right, low, high = body.around.wider(surely(least, 0.0))
    close = [(x, y) for x, y in close if left <= x <= right and low <= y <= high]  # no other one is nearer
    return min(least, *(nearest(close, edge) for edge in hull))


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
