"""Corridors and polygons: prepared once, asked many times."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from trackmarshal.runtime.geometry.arrays import (
    LIMIT,
    SAME,
    Bools,
    Floats,
    as_points,
    coordinates_fault,
    distinct,
    place,
    vector,
)
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.crossings import meeting_fault, turns
from trackmarshal.runtime.geometry.curve import Curves
from trackmarshal.runtime.geometry.least import least_inside, nearest_inside
from trackmarshal.runtime.geometry.polyline import Polyline, centre_line
from trackmarshal.runtime.geometry.quads import union_of_quads
from trackmarshal.runtime.geometry.region import Region

Points = ArrayLike | Sequence[Sequence[float]]


class Area:
    """A region or what is wrong with it: with a `fault`, every margin is NaN. Immutable."""

    def __init__(self, region: Region | str) -> None:
        #: What makes the area unusable, with the place; None for a usable one.
        self.fault = region if isinstance(region, str) else None
        self._region = None if isinstance(region, str) else region

    def margin_inside(
        self,
        x0: ArrayLike,
        y0: ArrayLike,
        heading0: ArrayLike,
        x1: ArrayLike,
        y1: ArrayLike,
        heading1: ArrayLike,
        length: ArrayLike,
        width: ArrayLike,
        *bend: ArrayLike,
    ) -> Floats:
        """By how much what a vehicle sweeps between two poses lies inside [m]: (N,), NaN where there is no answer.

        Poses: in m and rad, of the centre of the vehicle's length x width rectangle; all arguments broadcast, to N bodies in all.
        At least 0 where the swept area lies in the (closed) region. `bend`: the curvatures at both poses [1/m], for a vehicle that
        follows a curve; nothing for one that goes straight.
        """
        poses, long, wide, bends = _bodies((x0, y0, heading0, x1, y1, heading1), length, width, bend)
        if self._region is None:
            return np.full(poses.shape[1], np.nan)
        if bends is None or not poses.size:
            return self._region.margin_inside(poses, long, wide)
        return self._region.margin_along(Curves(poses, bends, long, wide))

    def least_inside(self, body: Sequence[ArrayLike], size: int, counted: Bools) -> tuple[Floats, Bools]:
        """The same of a body (the arguments above), and which margins are exact, cheaper: of each group of `size` in a row,
        only the least margin of those that are `counted` is sure to be, and the others are no less."""
        poses, long, wide, bends = _bodies(body[:6], body[6], body[7], body[8:])
        if self._region is None:
            return np.full(poses.shape[1], np.nan), np.ones(poses.shape[1], dtype=np.bool_)
        return least_inside(self._region, poses, long, wide, bends, size, counted)

    def nearest_inside(self, body: Sequence[ArrayLike], size: int, counted: Bools) -> Floats | None:
        """The same of few groups: margins, of which the least of each group is exact and the others are no less; None where that takes more
        than a look at what is nearest."""
        if self._region is None:
            return None
        poses, long, wide, bends = _bodies(body[:6], body[6], body[7], body[8:])
        return nearest_inside(self._region, poses, long, wide, bends, size, counted)

    @property
    def border(self) -> Border | None:
        """The border, the region on its left; None where there is none."""
        return None if self._region is None else self._region.border

    def near(self, x: Floats, y: Floats) -> bool:
        """Whether some of these points may be in the region, or have no answer; False if all are off its bounding box."""
        if self._region is None:
            return True
        left, right, low, high = self._region.box
        if x.size and y.size:
            ends = (
                (np.minimum.reduce(x, None), np.minimum.reduce(y, None)),
                (np.maximum.reduce(x, None), np.maximum.reduce(y, None)),
            )
            (first_x, first_y), (last_x, last_y) = ends
            # Each of them by itself: what is greater of a number and of NaN depends on which of them comes first.
            fine = first_x >= -LIMIT and last_x <= LIMIT and first_y >= -LIMIT and last_y <= LIMIT
            if fine and (first_x > right or last_x < left or first_y > high or last_y < low):
                return False
        # Points that are none are off no box.
        off: Bools = (x < left) | (x > right) | (y < low) | (y > high)
        return not (off & (np.abs(x) <= LIMIT) & (np.abs(y) <= LIMIT)).all()

    def signed_distance(self, x: ArrayLike, y: ArrayLike) -> Floats:
        """The distance of points from the border [m], positive inside: (N,)."""
        if self._region is None:
            return np.full(np.broadcast(x, y).size, np.nan)
        return self._region.signed_distance(vector(x), vector(y))


class Corridor(Area):
    """The region between two borders, each (n, 2) points: with straight ends, or closed (two rings, or crossing borders
    of equally many points, as of a figure of eight)."""

    def __init__(self, left: Points, right: Points, closed: bool = False) -> None:
        self.left, self.right, self.closed = as_points(left), as_points(right), bool(closed)
        super().__init__(corridor_region(self.left, self.right, self.closed))

    @cached_property
    def centre(self) -> Polyline:
        """The line midway between the borders; made when first asked for."""
        return Polyline(centre_line(self.left, self.right, self.closed), self.closed)


class Polygon(Area):
    """The inside of a simple polygon, (n, 2) points in either direction."""

    def __init__(self, points: Points) -> None:
        self.points = as_points(points)
        super().__init__(polygon_region(self.points))


def corridor_region(left: Floats, right: Floats, closed: bool) -> Region | str:
    """The region between two borders, or what is wrong with them."""
    for name, points in (("left border", left), ("right border", right)):
        fault = coordinates_fault(name, points, 3 if closed else 2, closed)
        if fault:
            return fault
    lefts, rights = distinct(left, closed), distinct(right, closed)
    if not closed:
        for name, points in (("left border", lefts), ("right border", rights)):
            if (points[0] == points[-1]).all():  # it would be said to cross itself
                return f"{name} ends where it begins, at {place(*points[0])}, and the corridor is not closed"
        # Where both borders end in one point there is no end to cross.
        apart = [bool((np.abs(lefts[at] - rights[at]) > SAME).any()) for at in (0, -1)]
        ends = [["end of the corridor"] * there for there in apart]
        names = ["left border"] * (len(lefts) - 1) + ends[1] + ["right border"] * (len(rights) - 1) + ends[0]
        ring = distinct(np.concatenate([lefts, rights[::-1]]), True)
        fault = meeting_fault(Border([ring], closed=True), names)
        if fault is None:
            return Region([counter_clockwise(ring)])
        turned = Border([distinct(np.concatenate([lefts, rights]), True)], closed=True)
        opposed = meeting_fault(turned, ["border"] * turned.size) is None
        return f"{fault}, as the borders run in opposite directions" if opposed else fault
    border = Border([lefts, rights], closed=True)
    fault = meeting_fault(border, ["left border"] * len(lefts) + ["right border"] * len(rights))
    if fault:
        rings = union_of_quads(left, right)
        return fault if rings is None else Region(rings)
    lefts, rights = counter_clockwise(lefts), counter_clockwise(rights)
    if inside_ring(lefts[0], rights):
        return Region([rights, lefts[::-1].copy()])
    if inside_ring(rights[0], lefts):
        return Region([lefts, rights[::-1].copy()])
    return f"neither border encloses the other: the left one begins at {place(*left[0])}, the right one at {place(*right[0])}"


def polygon_region(points: Floats) -> Region | str:
    """The inside of a simple polygon, or what is wrong with it."""
    fault = coordinates_fault("polygon", points, 3, True)
    if fault:
        return fault
    ring = distinct(points, True)
    border = Border([ring], closed=True)
    return meeting_fault(border, ["polygon"] * len(ring)) or Region([counter_clockwise(ring)])


def counter_clockwise(ring: Floats) -> Floats:
    """A simple ring, its inside on the left. Its leftmost (and of those, lowest) point turns as the whole does."""
    lowest = np.lexsort((ring[:, 1], ring[:, 0]))[0]
    around = ring[[lowest - 1, lowest, (lowest + 1) % len(ring)]]
    return ring if turns(*around[..., None].reshape(6, 1))[0] > 0 else ring[::-1].copy()


def inside_ring(point: Floats, ring: Floats) -> bool:
    """Whether a point that is not on a ring lies inside it: an odd number of crossings of a ray along +x."""
    end = np.roll(ring, -1, axis=0)
    upward = (ring[:, 1] < end[:, 1])[:, None]
    low, high = np.where(upward, ring, end), np.where(upward, end, ring)
    across = (low[:, 1] <= point[1]) & (point[1] < high[:, 1])
    low, high = low[across], high[across]
    px, py = np.full(len(low), point[0]), np.full(len(low), point[1])
    left = turns(low[:, 0], low[:, 1], high[:, 0], high[:, 1], px, py) > 0
    return bool(left.sum() % 2)


def _bodies(
    columns: Sequence[ArrayLike], length: ArrayLike, width: ArrayLike, bend: Sequence[ArrayLike]
) -> tuple[Floats, float | Floats, float | Floats, Floats | None]:
    """A table of poses, (6, N), sizes, numbers or (N,), and curvatures, (2, N), where there are any; all arguments broadcast, to N
    bodies in all."""
    if len(bend) not in (0, 2):
        raise AssertionError(f"a way has no curvatures or two, not {len(bend)}")
    arrays = [np.asarray(column, dtype=np.float64) for column in (*columns, *bend, length, width)]
    shape = np.broadcast(*arrays).shape
    count = 6 + len(bend)
    table = np.empty((count, *shape))
    for row in range(count):
        table[row] = arrays[row]
    table = table.reshape(count, -1)
    long, wide = (
        float(size) if size.ndim == 0 else np.broadcast_to(size, shape).reshape(-1) for size in arrays[count:]
    )
    return table[:6], long, wide, table[6:] if bend else None
