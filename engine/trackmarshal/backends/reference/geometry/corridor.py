"""Corridors and polygons as regions: their rings, and what makes them unusable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

from trackmarshal.backends.reference.geometry.quads import union_of_quads
from trackmarshal.backends.reference.geometry.region import (
    Outside,
    Region,
    hull_margin,
    odd_crossings,
    point_margin,
)
from trackmarshal.points import (
    LIMIT,
    Point,
    Pose,
    distinct,
    folds_back,
    meet,
    meeting_place,
    same,
    segment,
    side,
    usable,
)

Side = tuple[Point, Point]
Points = Sequence[Sequence[float]]

LEFT, RIGHT, CAP, POLYGON = "left border", "right border", "end of the corridor", "polygon"


def hull_inside_margin(
    left: Points,
    right: Points,
    closed: bool,
    pose0: Pose,
    pose1: Pose,
    length: float,
    width: float,
    bend: Sequence[float] = (),
) -> float:
    """The signed margin [m] of what a vehicle sweeps between two poses inside a corridor; NaN for an unusable one."""
    return hull_margin_in(region_between(left, right, closed), pose0, pose1, length, width, bend)


def hull_meets_margin(
    left: Points,
    right: Points,
    closed: bool,
    pose0: Pose,
    pose1: Pose,
    length: float,
    width: float,
    bend: Sequence[float] = (),
) -> float:
    """How far what a vehicle sweeps between two poses reaches into a corridor [m]; negative: how far apart they are. NaN for an unusable one.

    It is minus the margin of lying outside: 0 where they touch.
    """
    region = region_between(left, right, closed)
    if isinstance(region, str):
        return math.nan
    return -hull_margin(Outside(region.border, region.groups), pose0, pose1, length, width, bend)


def hull_margin_in(
    region: Region | str, pose0: Pose, pose1: Pose, length: float, width: float, bend: Sequence[float] = ()
) -> float:
    """The signed margin [m] of what a vehicle sweeps between two poses inside a region; NaN for what is none."""
    return math.nan if isinstance(region, str) else hull_margin(region, pose0, pose1, length, width, bend)


def region_between(left: Points, right: Points, closed: bool) -> Region | str:
    """The region between two borders, or what is wrong with them."""
    return corridor_region(_frozen(left), _frozen(right), closed)


def region_of(points: Points) -> Region | str:
    """The inside of a simple polygon, or what is wrong with it."""
    return polygon_region(_frozen(points))


def in_zone_margin(x: float, y: float, points: Points) -> float:
    """The signed distance [m] of a point from the border of a simple polygon, positive inside."""
    region = region_of(points)
    return math.nan if isinstance(region, str) else point_margin(region, x, y)


def corridor_fault(left: Points, right: Points, closed: bool) -> str | None:
    """What makes a corridor unusable, with the place; None for a usable one."""
    region = region_between(left, right, closed)
    return region if isinstance(region, str) else None


def zone_fault(points: Points) -> str | None:
    """What makes a polygon unusable, with the place; None for a usable one."""
    region = region_of(points)
    return region if isinstance(region, str) else None


def _frozen(points: Points) -> tuple[Point, ...]:
    return tuple((float(x), float(y)) for x, y in points)


@lru_cache(maxsize=64)
def corridor_region(left: tuple[Point, ...], right: tuple[Point, ...], closed: bool) -> Region | str:
    """The region between two borders, or what is wrong with them.

    Open: the ring of the left border and the reversed right one, so with straight ends. Closed: what lies between two
    rings, either of which may be the outer one; or, where borders of equally many points cross as those of a figure of
    eight do, the union of the quadrilaterals between paired points.
    """
    for name, points in ((LEFT, left), (RIGHT, right)):
        fault = _coordinates_fault(name, points, 3 if closed else 2, closed)
        if fault:
            return fault
    lefts, rights = distinct(left, closed), distinct(right, closed)
    if not closed:
        for name, border in ((LEFT, lefts), (RIGHT, rights)):
            if border[0] == border[-1]:  # it would be said to cross itself
                return f"{name} ends where it begins, at {_place(border[0])}, and the corridor is not closed"
        # Where both borders end in one point there is no end to cross.
        near, far = ([] if same(lefts[at], rights[at]) else [CAP] for at in (0, -1))
        names = [LEFT] * (len(lefts) - 1) + far + [RIGHT] * (len(rights) - 1) + near
        ring = distinct(lefts + rights[::-1], True)
        sides = list(zip(ring, [*ring[1:], ring[0]], names))
        outline = _to_the_left([(a, b) for a, b, _ in sides])
        fault = _crossing_fault([sides])
        if fault is None:
            return Region(outline, (outline,))
        turned = distinct(lefts + rights, True)
        opposed = _crossing_fault([[(a, b, LEFT) for a, b in zip(turned, [*turned[1:], turned[0]])]]) is None
        return f"{fault}, as the borders run in opposite directions" if opposed else fault
    rings = [
        [(a, b, name) for a, b in zip(points, [*points[1:], points[0]])]
        for name, points in ((LEFT, lefts), (RIGHT, rights))
    ]
    fault = _crossing_fault(rings)
    if fault:
        return union_of_quads(left, right) or fault
    outlines = [_to_the_left([(a, b) for a, b, _ in ring]) for ring in rings]
    if odd_crossings(*lefts[0], outlines[1]):
        inner, outer = outlines
    elif odd_crossings(*rights[0], outlines[0]):
        outer, inner = outlines
    else:
        return f"neither border encloses the other: the left one begins at {_place(lefts[0])}, the right one at {_place(rights[0])}"
    between = outer + tuple((b, a) for a, b in reversed(inner))
    return Region(between, (between,))


@lru_cache(maxsize=64)
def polygon_region(points: tuple[Point, ...]) -> Region | str:
    """The inside of a simple polygon, or what is wrong with it."""
    fault = _coordinates_fault(POLYGON, points, 3, True)
    if fault:
        return fault
    corners = distinct(points, True)
    sides = list(zip(corners, [*corners[1:], corners[0]]))
    outline = _to_the_left(sides)
    return _crossing_fault([[(a, b, POLYGON) for a, b in sides]]) or Region(outline, (outline,))


def _to_the_left(sides: Sequence[Side]) -> tuple[Side, ...]:
    """The outline of a simple polygon, its inside on the left."""
    origin = sides[0][0]
    doubled = sum(side(segment(origin, a), *b) for a, b in sides)
    return tuple(sides) if doubled > 0.0 else tuple((b, a) for a, b in reversed(sides))


def _coordinates_fault(name: str, points: Sequence[Point], least: int, closed: bool) -> str | None:
    for index, (x, y) in enumerate(points):
        if not usable(x, y):
            return f"{name}: point {index} is ({x:g}, {y:g}), not finite or beyond {LIMIT:g} m"
    if len(distinct(points, closed)) < least:
        return f"{name} has fewer than {least} distinct points"
    return None


def _crossing_fault(rings: Sequence[Sequence[tuple[Point, Point, str]]]) -> str | None:
    """The first place where rings touch, cross or fold back; segments that follow each other share their common point."""
    sides = [
        (*side, ring, index) for ring, ring_sides in enumerate(rings) for index, side in enumerate(ring_sides)
    ]
    boxes = [(min(a[0], b[0]), max(a[0], b[0]), min(a[1], b[1]), max(a[1], b[1])) for a, b, *_ in sides]
    beside: list[list[int]] = [[] for _ in sides]
    # From left to right: what begins behind the end of a box is not beside it, and neither is what follows.
    by_left = sorted(range(len(sides)), key=lambda i: boxes[i][0])
    for place, i in enumerate(by_left, 1):
        _, right, low, high = boxes[i]
        for j in by_left[place:]:
            start, _, bottom, top = boxes[j]
            if start > right:
                break
            if bottom <= high and top >= low:
                beside[min(i, j)].append(max(i, j))
    for i, (a, b, first, ring, at) in enumerate(sides):
        count = len(rings[ring])
        following = rings[ring][(at + 1) % count]
        if folds_back(a, b, following[1]):
            return f"{first} folds back on itself near {_place(b)}"
        for c, d, second, other, place in map(sides.__getitem__, sorted(beside[i])):
            neighbours = ring == other and (place - at in (1, count - 1))
            if not neighbours and meet(a, b, c, d):
                where = _place(meeting_place(a, b, c, d))
                return (
                    f"{first} crosses itself near {where}"
                    if first == second
                    else f"{first} meets {second} near {where}"
                )
    return None


def _place(point: Point) -> str:
    return f"({point[0]:.3f}, {point[1]:.3f})"
