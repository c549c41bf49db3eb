"""Curvilinear coordinates: where along a line, and how far beside it."""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from functools import cached_property, lru_cache

from trackmarshal.backends.reference.geometry.boxes import STRETCH, Box, box_of
from trackmarshal.backends.reference.geometry.quads import opposite
from trackmarshal.points import (
    Point,
    Segment,
    along,
    between,
    chain,
    distance,
    distinct,
    side,
    square,
    usable,
)

Points = Sequence[Sequence[float]]
#: A point, and in words where one of its coordinates is zero.
Place = tuple[float, float] | tuple[str, str]
NOWHERE = (math.nan, math.nan, math.nan)
#: Of so many points it is known at once where they are along a line.
KNOWN = 10_000


class Line:
    """The points of a line, and what whoever asks about it more than once need not work out again."""

    def __init__(self, points: Points, closed: bool = False) -> None:
        self.points = points
        self.closed = closed
        #: Where points are along it that were asked about: station, offset and direction of one are three questions, and the next cycle has many again.
        self.known: dict[Place, tuple[float, float, float]] = {}

    @cached_property
    def fault(self) -> str | None:
        """What makes it unusable; None for a usable one, which has segments."""
        return line_fault(self.points, self.closed)

    @cached_property
    def segments(self) -> list[Segment]:
        return chain(distinct(self.points, self.closed), self.closed)

    @cached_property
    def stations(self) -> list[float]:
        return stations(self.segments)

    @cached_property
    def stretches(self) -> list[tuple[int, Box, list[Segment]]]:
        """The segments in stretches: the number of the first of each, and the box around it."""
        parts = [(at, self.segments[at : at + STRETCH]) for at in range(0, len(self.segments), STRETCH)]
        return [
            (at, box_of([end for s in part for end in ((s.ax, s.ay), (s.bx, s.by))]), part)
            for at, part in parts
        ]

    def nearest(self, x: float, y: float) -> tuple[float, int]:
        """The distance of a point [m], and which segment is so near; of equally near ones the first."""
        here = Box(x, x, y, y)
        by_box = sorted((box.apart(here), at, part) for at, box, part in self.stretches)
        # More than any distance, or how far boxes are apart, is rounded.
        slack = 1e-9 * (1.0 + abs(x) + abs(y))
        best = math.inf, 0
        for apart, at, part in by_box:
            if apart > best[0] * (1.0 + 1e-9) + slack:
                break
            best = min(best, *((distance(x, y, s), number) for number, s in enumerate(part, at)))
        return best


def _line(points: Points | Line, closed: bool) -> Line:
    return points if isinstance(points, Line) else Line(points, closed)


def line_fault(points: Points, closed: bool = False) -> str | None:
    """What makes a line unusable; None for a usable one."""
    for index, (x, y) in enumerate(points):
        if not usable(x, y):
            return f"line: point {index} is ({x:g}, {y:g}), not finite or beyond 1e+09 m"
    least = 3 if closed else 2
    return f"line has fewer than {least} distinct points" if len(distinct(points, closed)) < least else None


def project(x: float, y: float, points: Points | Line, closed: bool = False) -> tuple[float, float, float]:
    """Station [m], offset [m, positive to the left] and direction [rad] of a point along a line.

    The nearest segment wins, of equally near ones the first. Beyond the ends of an open line its first and last segment
    go on as rays, so the station runs on below 0 and above the length. On a closed line it is in [0, length).
    """
    line = _line(points, closed)
    key: Place = (x, y) if x and y else (repr(x), repr(y))  # zeros that are equal may differ by their signs
    found = line.known.get(key)
    if found is None:
        if len(line.known) == KNOWN:
            line.known.clear()
        found = line.known[key] = _project(x, y, line)
    return found


def _project(x: float, y: float, line: Line) -> tuple[float, float, float]:
    if line.fault or not usable(x, y):
        return NOWHERE
    closed, segments = line.closed, line.segments
    reach, nearest = line.nearest(x, y)
    s = segments[nearest]
    length = math.sqrt(square(s))
    advance, offset = along(s, x, y) / length, side(s, x, y) / length
    before = advance <= 0.0 and (closed or nearest > 0)
    after = along(s, x, y) >= square(s) and (closed or nearest < len(segments) - 1)
    if before or after:
        advance = 0.0 if before else length
        offset = math.copysign(reach, offset)
    station = line.stations[nearest] + advance
    if closed and station >= line.stations[-1]:
        station = 0.0
    return station, offset, math.atan2(s.ey, s.ex)


def stations(segments: Sequence[Segment]) -> list[float]:
    """The station [m] of each point of a line; the last one is its length."""
    reached = [0.0]
    for s in segments:
        reached.append(reached[-1] + math.sqrt(square(s)))
    return reached


def station_gap(points: Points | Line, s_from: float, s_to: float, closed: bool = False) -> float:
    """How far `s_to` lies ahead of `s_from` [m]; on a closed line the shorter way round, in (-length/2, length/2]."""
    line = _line(points, closed)
    if line.fault or not (math.isfinite(s_from) and math.isfinite(s_to)):
        return math.nan
    gap = s_to - s_from
    if line.closed:
        length = line.stations[-1]
        rounds = gap / length - 0.5
        # Of numbers beyond all tracks it may be infinite, which Python has no whole number for.
        gap -= length * (math.ceil(rounds) if math.isfinite(rounds) else rounds)
    return gap


def stretch_room(
    points: Points | Line, station: float, start: float, end: float, closed: bool = False
) -> float:
    """How far inside the stretch from `start` ahead to `end` a station lies, along the line [m]; negative: outside.

    On a closed line the stretch goes on over the finish line; one that ends where it begins is the whole lap. On an open line it ends
    ahead of where it begins, or where it does; otherwise NaN.
    """
    line = _line(points, closed)
    if line.fault or not all(map(math.isfinite, (station, start, end))):
        return math.nan
    if not line.closed:
        return min(station - start, end - station) if start <= end else math.nan
    length = line.stations[-1]
    s, a, b = (on_lap(each, length) for each in (station, start, end))
    # Which side it is on is compared, not computed, so that rounding cannot change it.
    inside = a <= s <= b if a < b else a <= s or s <= b
    if inside:
        return min(ahead(a, s, length), ahead(s, b, length))
    return -min(ahead(s, a, length), ahead(b, s, length))


def on_lap(station: float, length: float) -> float:
    """A station of a closed line in [0, length)."""
    rest = math.fmod(station, length)
    if rest < 0.0:
        rest += length
    return 0.0 if rest >= length else rest


def ahead(start: float, end: float, length: float) -> float:
    """How far it is from one station in [0, length) ahead to another [m]."""
    return end - start if start <= end else (end - start) + length


def distance_to_line(x: float, y: float, points: Points | Line, closed: bool = False) -> float:
    """The distance [m] of a point from a line."""
    line = _line(points, closed)
    if line.fault or not usable(x, y):
        return math.nan
    return line.nearest(x, y)[0]


def distance_to_path(x: float, y: float, points: Points | Line) -> float:
    """The distance [m] of a point from the path of a trajectory; of one that stays in one place, from that place."""
    line = _line(points, False)
    if len(line.points) >= 2 and not line.segments and usable(x, y, *line.points[0]):
        return between(x, y, *line.points[0])
    return distance_to_line(x, y, line)


def centre_line(left: Points, right: Points, closed: bool = False) -> list[Point]:
    """The line midway between two borders: midpoints of points that lie opposite each other, in pairs, or else from each left point to the
    right border."""
    lefts, rights = [(p[0], p[1]) for p in left], [(p[0], p[1]) for p in right]
    if not all(usable(*point) for point in (*lefts, *rights)):
        return []
    if len(lefts) == len(rights) and opposite(lefts, rights, closed):
        return [((p[0] + q[0]) / 2, (p[1] + q[1]) / 2) for p, q in zip(lefts, rights)]
    if line_fault(rights, closed):
        return []
    border = chain(distinct(rights, closed), closed)
    feet = (foot(*p, min(border, key=lambda s: distance(*p, s))) for p in lefts)
    return [((p[0] + q[0]) / 2, (p[1] + q[1]) / 2) for p, q in zip(lefts, feet)]


def foot(x: float, y: float, s: Segment) -> Point:
    """The point of a segment nearest to a point."""
    t = along(s, x, y) / square(s)
    if 0.0 < t < 1.0:
        return s.ax + t * s.ex, s.ay + t * s.ey
    return (s.ax, s.ay) if between(x, y, s.ax, s.ay) <= between(x, y, s.bx, s.by) else (s.bx, s.by)


def line_again(points: Points, closed: bool) -> Line:
    """A line that may have been asked about before: most lines of a run are those of the cycle before, to the bit."""
    return _again(_bits(points), closed)


def centre_again(left: Points, right: Points, closed: bool) -> Line:
    """The line midway between two borders, which may have been asked about before."""
    return _centre_again(_bits(left), _bits(right), closed)


def _bits(points: Points) -> bytes:
    """Points that compare as equal may still differ: by the sign of a zero."""
    return array("d", [number for point in points for number in point]).tobytes()


def _points(bits: bytes) -> list[Point]:
    numbers = iter(array("d", bits))
    return list(zip(numbers, numbers))


@lru_cache(maxsize=32)
def _again(points: bytes, closed: bool) -> Line:
    return Line(_points(points), closed)


@lru_cache(maxsize=8)
def _centre_again(left: bytes, right: bytes, closed: bool) -> Line:
    return Line(centre_line(_points(left), _points(right), closed), closed)
