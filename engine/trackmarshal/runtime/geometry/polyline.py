"""Lines: curvilinear coordinates of many points, and distances from many paths."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from trackmarshal.runtime.geometry.arrays import (
    LIMIT,
    Floats,
    as_points,
    coordinates_fault,
    distinct,
    points_of,
    vector,
)
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.quads import opposite


class Polyline:
    """A line of (n, 2) points, open or closed, prepared once; immutable.

    With a `fault`, whatever is asked is NaN.
    """

    def __init__(self, points: ArrayLike | Sequence[Sequence[float]], closed: bool = False) -> None:
        self.points, self.closed = as_points(points), bool(closed)
        #: What makes the line unusable; None for a usable one.
        self.fault = coordinates_fault("line", self.points, 3 if closed else 2, closed)
        self.length = math.nan
        if self.fault is not None:
            return
        border = self._border = Border([distinct(self.points, self.closed)], self.closed)
        #: The station at which each segment begins.
        self._station = np.concatenate([[0.0], np.cumsum(border.length)])
        self._direction = np.array([math.atan2(y, x) for x, y in zip(border.ex.tolist(), border.ey.tolist())])
        self.length = float(self._station[-1])

    def project(self, x: ArrayLike, y: ArrayLike) -> tuple[Floats, Floats, Floats]:
        """Station [m], offset [m, positive to the left] and direction [rad] of points: three arrays (N,).

        The nearest segment wins, of equally near ones the first. Beyond the ends of an open line its first and last
        segment go on as rays; on a closed line the station is in [0, length).
        """
        px, py, fine = points_of(x, y)
        if self.fault is not None or not px.size:
            nan = np.full(px.size, np.nan)
            return nan, nan.copy(), nan.copy()
        border = self._border
        k, distance = border.nearest(px, py)
        ax, ay, ex, ey, square, length = border.table.take(k, axis=1)
        rx, ry = px - ax, py - ay
        product = ex * rx + ey * ry
        advance, offset = product / length, (ex * ry - ey * rx) / length
        before, after = product <= 0.0, product >= square
        if not self.closed:
            before &= k > 0
            after &= k < border.size - 1
        outer = before | after
        if 1 in outer.tobytes():
            advance = np.where(before, 0.0, np.where(after, length, advance))
            offset = np.where(outer, np.copysign(distance, offset), offset)
        station = self._station[k] + advance
        if self.closed:
            station[station >= self.length] = 0.0
        direction = self._direction[k]
        if fine is not None:
            station, offset, direction = (
                np.where(fine, part, np.nan) for part in (station, offset, direction)
            )
        return station, offset, direction

    def distance(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """The distance of points from the line [m]: (N,)."""
        px, py, fine = points_of(x, y)
        if self.fault is not None or not px.size:
            return np.full(px.size, np.nan)
        distance = self._border.nearest(px, py)[1]
        return distance if fine is None else np.where(fine, distance, np.nan)

    def feet(self, x: Floats, y: Floats) -> Floats | None:
        """The point of the line nearest to each of some usable points: (N, 2); None for an unusable line."""
        if self.fault is not None:
            return None
        border = self._border
        k, _ = border.nearest(x, y)
        rx, ry, sx, sy = x - border.ax[k], y - border.ay[k], x - border.bx[k], y - border.by[k]
        t = (border.ex[k] * rx + border.ey[k] * ry) / border.square[k]
        at_start = rx * rx + ry * ry <= sx * sx + sy * sy
        beside = (t > 0.0) & (t < 1.0)
        feet = [
            np.where(beside, a + t * e, np.where(at_start, a, b))
            for a, e, b in (
                (border.ax[k], border.ex[k], border.bx[k]),
                (border.ay[k], border.ey[k], border.by[k]),
            )
        ]
        return np.stack(feet, axis=1)

    def gap(self, s_from: ArrayLike, s_to: ArrayLike) -> Floats:
        """How far `s_to` lies ahead of `s_from` [m], of arrays that broadcast, (N,) of numbers; on a closed line the shorter way, in
        (-length/2, length/2]."""
        start, end = vector(s_from), vector(s_to)
        fine = np.isfinite(start) & np.isfinite(end)
        if 0 in fine.tobytes():
            start, end = np.where(fine, start, np.nan), np.where(fine, end, np.nan)
        gap = end - start
        if self.closed:
            gap -= self.length * np.ceil(gap / self.length - 0.5)
        return gap if self.fault is None else np.full(gap.shape, np.nan)

    def stretch_room(self, station: ArrayLike, start: ArrayLike, end: ArrayLike) -> Floats:
        """How far inside the stretch from `start` ahead to `end` stations lie, along the line [m]: (N,); negative: outside.

        On a closed line a stretch goes on over the finish line; one that ends where it begins is the whole lap. On an open line it
        ends ahead of where it begins, or where it does; otherwise NaN.
        """
        s, a, b = np.broadcast_arrays(vector(station), vector(start), vector(end))
        if self.fault is not None:
            return np.full(s.size, np.nan)
        with np.errstate(invalid="ignore", over="ignore"):
            fine = np.isfinite(s) & np.isfinite(a) & np.isfinite(b)
            if not self.closed:
                return np.where(fine & (a <= b), np.minimum(s - a, b - s), np.nan)
            s, a, b = self._on_lap(s), self._on_lap(a), self._on_lap(b)
            # Which side it is on is compared, not computed, so that rounding cannot change it.
            inside = np.where(a < b, (a <= s) & (s <= b), (a <= s) | (s <= b))
            within = np.minimum(self._ahead(a, s), self._ahead(s, b))
            outside = -np.minimum(self._ahead(s, a), self._ahead(b, s))
            return np.where(fine, np.where(inside, within, outside), np.nan)

    def _on_lap(self, station: Floats) -> Floats:
        """Stations of a closed line in [0, length)."""
        rest = np.fmod(station, self.length)
        rest = np.where(rest < 0.0, rest + self.length, rest)
        return np.where(rest >= self.length, 0.0, rest)

    def _ahead(self, start: Floats, end: Floats) -> Floats:
        """How far it is from stations in [0, length) ahead to others [m]."""
        way = end - start
        return np.where(start <= end, way, way + self.length)


def centre_line(left: Floats, right: Floats, closed: bool = False) -> Floats:
    """The line midway between two borders: midpoints of points that lie opposite each other, in pairs, or else from each left point to the
    right border.

    An empty line where a border has unusable points, or the right one no two distinct ones.
    """
    if not (np.abs(left) <= LIMIT).all():
        return np.empty((0, 2))
    if len(left) == len(right) and (np.abs(right) <= LIMIT).all() and opposite(left, right, closed):
        return (left + right) / 2
    feet = Polyline(right, closed).feet(*left.T)
    return np.empty((0, 2)) if feet is None else (left + feet) / 2
