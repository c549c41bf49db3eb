"""From metres to pixels: a plan view turned so that what matters fills the picture, the same scale both ways."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from trackmarshal.trace.report.svg.axis import nice_step

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Frame:
    """A picture's size in pixels: its width, and how high it may become."""

    width: float
    highest: float
    #: Whether the main direction of travel points up instead of to the right.
    upright: bool
    #: Long straight scenes are cut into strips: at most so many, of about so many pixels a metre.
    most_strips: int = 1
    strip_scale: float = 1.0


WIDE = Frame(1000.0, 520.0, upright=False, most_strips=4, strip_scale=6.0)
NARROW = Frame(380.0, 640.0, upright=True, most_strips=7, strip_scale=4.0)
#: For one moment from near.
WIDE_NEAR = Frame(1000.0, 420.0, upright=False)
NARROW_NEAR = Frame(380.0, 440.0, upright=True)
#: Pixels around what is shown, pixels below for the scale bar, and the least height.
PAD, FOOT, LOWEST = 14.0, 36.0, 90.0
#: The least extent of a picture, in m.
SMALLEST = 40.0


@dataclass(frozen=True, slots=True)
class View:
    """x_pixel = a x + c y + e and y_pixel = b x + d y + f (the order of SVG's matrix)."""

    a: float
    b: float
    c: float
    d: float
    e: float
    f: float
    scale: float
    width: float
    height: float

    def at(self, x: float, y: float) -> Point:
        return self.a * x + self.c * y + self.e, self.b * x + self.d * y + self.f

    def path(self, points: Iterable[Point]) -> list[Point]:
        a, b, c, d, e, f = self.a, self.b, self.c, self.d, self.e, self.f
        return [(a * x + c * y + e, b * x + d * y + f) for x, y in points]

    def inside(self, point: Point, room: float = 0.0) -> bool:
        return -room <= point[0] <= self.width + room and -room <= point[1] <= self.height + room

    def box(self, x: float, y: float, heading: float, length: float, width: float) -> list[Point]:
        """The corners of a rectangle about its centre; front left first, then clockwise on the road."""
        forward, side = (math.cos(heading), math.sin(heading)), (-math.sin(heading), math.cos(heading))
        corners = ((0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5))
        return [
            self.at(
                x + i * length * forward[0] + j * width * side[0],
                y + i * length * forward[1] + j * width * side[1],
            )
            for i, j in corners
        ]

    def scale_bar(self) -> tuple[float, float]:
        """A round length in m and its pixels, at most a quarter of the width."""
        metres = nice_step(self.width / self.scale, 10)
        return metres, metres * self.scale


def fit(
    points: Sequence[Point], frame: Frame, direction: float | None = None, largest: float = math.inf
) -> View:
    """The view that holds all points; turned to `direction` (rad), or else to that in which they extend most.

    `largest` limits the scale, in pixels a metre.
    """
    known = [p for p in points if math.isfinite(p[0]) and math.isfinite(p[1])] or [(0.0, 0.0)]
    turn = main_direction(known) if direction is None else direction
    if frame.upright:
        turn -= math.pi / 2
    cos, sin = math.cos(turn), math.sin(turn)
    across = [cos * x + sin * y for x, y in known]
    up = [-sin * x + cos * y for x, y in known]
    left, right, low, high = min(across), max(across), min(up), max(up)
    extent, rise = max(right - left, SMALLEST), max(high - low, SMALLEST / 3)
    scale = min((frame.width - 2 * PAD) / extent, (frame.highest - 2 * PAD) / rise, largest)
    drawn = max(rise * scale + 2 * PAD, LOWEST)
    x0 = frame.width / 2 - scale * (left + right) / 2
    y0 = drawn / 2 + scale * (low + high) / 2
    return View(scale * cos, scale * sin, scale * sin, -scale * cos, x0, y0, scale, frame.width, drawn)


def main_direction(points: Sequence[Point]) -> float:
    """The direction of the largest spread, the way from the first to the last point."""
    count = len(points)
    mx, my = sum(p[0] for p in points) / count, sum(p[1] for p in points) / count
    xx = sum((p[0] - mx) ** 2 for p in points)
    yy = sum((p[1] - my) ** 2 for p in points)
    xy = sum((p[0] - mx) * (p[1] - my) for p in points)
    angle = 0.5 * math.atan2(2 * xy, xx - yy)
    ahead = math.cos(angle) * (points[-1][0] - points[0][0]) + math.sin(angle) * (
        points[-1][1] - points[0][1]
    )
    return angle if ahead >= 0 else angle + math.pi
