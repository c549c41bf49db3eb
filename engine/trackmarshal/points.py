"""Points and segments: cross product, distance, exact orientation. Everything else is made of these."""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import NamedTuple

Point = tuple[float, float]
Pose = tuple[float, float, float]

#: Numbers beyond this are no position: the spacing of doubles there exceeds a tenth of a micrometre.
LIMIT = 1e9
#: Points that are no farther apart than this in x and y are the same point [m].
SAME = 1e-9
#: A length or width below this is none [m].
SMALLEST = 1e-6


class Segment(NamedTuple):
    """A directed segment from (ax, ay) to (bx, by), and its vector (ex, ey)."""

    ax: float
    ay: float
    bx: float
    by: float
    ex: float
    ey: float


def segment(a: Point, b: Point, origin: Point = (0.0, 0.0)) -> Segment:
    """The segment from a to b, seen from an origin; its vector is taken before the shift."""
    return Segment(
        a[0] - origin[0], a[1] - origin[1], b[0] - origin[0], b[1] - origin[1], b[0] - a[0], b[1] - a[1]
    )


def usable(*numbers: float) -> bool:
    """Whether all numbers are finite and no larger than `LIMIT`."""
    return all(abs(number) <= LIMIT for number in numbers)


def sized(length: float, width: float) -> bool:
    """Whether a length and a width are those of a body."""
    return usable(length, width) and min(length, width) >= SMALLEST


def side(s: Segment, x: float, y: float) -> float:
    """Twice the signed area of (a, b, point): positive where the point lies left of the segment's line."""
    return s.ex * (y - s.ay) - s.ey * (x - s.ax)


def along(s: Segment, x: float, y: float) -> float:
    """The scalar product of the segment and the point seen from its start; between 0 and `square` beside it."""
    return s.ex * (x - s.ax) + s.ey * (y - s.ay)


def square(s: Segment) -> float:
    """The squared length of a segment."""
    return s.ex * s.ex + s.ey * s.ey


def distance(x: float, y: float, s: Segment) -> float:
    """The distance of a point from a segment: to its line where the foot lies within, else to the nearer end."""
    # `along`, `square`, `side` and `between`, written out: nothing is asked for as often.
    ax, ay, bx, by, ex, ey = s
    px, py = x - ax, y - ay
    squared = ex * ex + ey * ey
    if 0.0 < ex * px + ey * py < squared:
        return abs(ex * py - ey * px) / math.sqrt(squared)
    qx, qy = x - bx, y - by
    start, end = px * px + py * py, qx * qx + qy * qy
    return math.sqrt(end if end < start else start)


def nearest(points: Sequence[Point], s: Segment) -> float:
    """The least `distance` of points from a segment, to the bit: dividing by one length and taking roots keeps the order."""
    ax, ay, bx, by, ex, ey = s
    squared = ex * ex + ey * ey
    beside = ends = math.inf
    # `min` written out, as `distance` is: nothing but that is asked for as often.
    for x, y in points:
        px, py = x - ax, y - ay
        if 0.0 < ex * px + ey * py < squared:
            off = abs(ex * py - ey * px)
            beside = off if off < beside else beside
        else:
            qx, qy = x - bx, y - by
            start, end = px * px + py * py, qx * qx + qy * qy
            ends = start if start < ends else ends
            ends = end if end < ends else ends
    return min(beside / math.sqrt(squared), math.sqrt(ends)) if beside < math.inf else math.sqrt(ends)


def between(x0: float, y0: float, x1: float, y1: float) -> float:
    """The distance of two points."""
    dx, dy = x0 - x1, y0 - y1
    return math.sqrt(dx * dx + dy * dy)


def orientation(a: Point, b: Point, c: Point) -> int:
    """The exact sign of the turn a, b, c: 1 left, -1 right, 0 straight. Floats are fractions, so this is no estimate."""
    left, right = (b[0] - a[0]) * (c[1] - a[1]), (b[1] - a[1]) * (c[0] - a[0])
    turn = left - right
    if abs(turn) > 1e-15 * (abs(left) + abs(right)):
        return 1 if turn > 0.0 else -1
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    exact = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    return (exact > 0) - (exact < 0)


def folds_back(a: Point, b: Point, c: Point) -> bool:
    """Whether the way a, b, c turns round by exactly half a turn at b."""
    if orientation(a, b, c) != 0:
        return False
    (ax, ay), (bx, by), (cx, cy) = ((Fraction(x), Fraction(y)) for x, y in (a, b, c))
    return (bx - ax) * (cx - bx) + (by - ay) * (cy - by) < 0


def meet(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether the segments ab and cd have a point in common, decided exactly."""
    for i in (0, 1):
        if max(a[i], b[i]) < min(c[i], d[i]) or max(c[i], d[i]) < min(a[i], b[i]):
            return False
    return (
        orientation(a, b, c) * orientation(a, b, d) <= 0 and orientation(c, d, a) * orientation(c, d, b) <= 0
    )


def meeting_place(a: Point, b: Point, c: Point, d: Point) -> Point:
    """Where two segments that meet do so, for messages."""
    ex, ey, gx, gy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    turn = ex * gy - ey * gx
    if turn == 0.0:
        x = (max(min(a[0], b[0]), min(c[0], d[0])) + min(max(a[0], b[0]), max(c[0], d[0]))) / 2
        y = (max(min(a[1], b[1]), min(c[1], d[1])) + min(max(a[1], b[1]), max(c[1], d[1]))) / 2
        return x, y
    t = min(1.0, max(0.0, ((c[0] - a[0]) * gy - (c[1] - a[1]) * gx) / turn))
    return a[0] + t * ex, a[1] + t * ey


def same(a: Point, b: Point) -> bool:
    """Whether two points are one."""
    return abs(a[0] - b[0]) <= SAME and abs(a[1] - b[1]) <= SAME


def distinct(points: Sequence[Sequence[float]], closed: bool) -> list[Point]:
    """The points without repetitions of the last one kept; of a closed chain also without its repeated first point."""
    kept: list[Point] = []
    for x, y in points:
        if not kept or not same((x, y), kept[-1]):
            kept.append((float(x), float(y)))
    while closed and len(kept) > 1 and same(kept[-1], kept[0]):
        kept.pop()
    return kept


def chain(points: Sequence[Point], closed: bool) -> list[Segment]:
    """The segments of a chain of distinct points."""
    ends = [*points[1:], points[0]] if closed else points[1:]
    return [segment(a, b) for a, b in zip(points, ends)]
