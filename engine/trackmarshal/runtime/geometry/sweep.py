"""What a rectangle sweeps between two poses: the convex hulls of many pairs of footprints at once."""

from __future__ import annotations

import numpy as np

from trackmarshal.runtime.geometry.arrays import LIMIT, Bools, Complexes, Floats

#: Sides of a hull shorter than this [m] have no direction worth the name and are left out; their ends stay corners.
SHORTEST = 1e-7
#: Quarter turns that bring the sides of a rectangle, in their order, to the first one's direction.
_TURNED_BACK = np.array([1.0, -1j, -1.0, 1j])[:, None]
_NEXT, _BEFORE = np.array([1, 2, 3, 0]), np.array([3, 0, 1, 2])


class Sweeps:
    """Hulls of the footprints of N pairs of poses, all relative to the first pose's position (x, y).

    `sides` has shape (6, 8, N): x and y of each of the eight corners, then of the side of the hull that begins at that
    corner its vector x, y, its square and its length. The side is NaN for a corner inside the hull and for a side shorter
    than `SHORTEST`. Corners are those of one footprint, counter-clockwise, then those of the other.
    """

    __slots__ = ("corners", "excess", "heading", "middle", "radius", "sides", "size", "usable", "x", "y")

    def __init__(self, poses: Floats, length: float | Floats, width: float | Floats) -> None:
        """`poses`: (6, N) with rows x0, y0, heading0, x1, y1, heading1; `length`, `width`: numbers or (N,)."""
        self.size = poses.shape[1]
        poses, length, width, self.usable = _usable(poses, length, width)
        self.x, self.y = poses[0], poses[1]
        move = poses[3:5] - poses[0:2]
        halves = 0.5 * length, 0.5 * width
        cos, sin = np.cos(poses[2::3]), np.sin(poses[2::3])
        # Axes 1 and 2: coordinate, footprint. Rows: centre, centre to front, centre to left, unit vector.
        frame = np.empty((4, 2, 2, self.size))
        frame[0, :, 0], frame[0, :, 1] = 0.0, move
        frame[1, 0], frame[1, 1] = halves[0] * cos, halves[0] * sin
        frame[2, 0], frame[2, 1] = -(halves[1] * sin), halves[1] * cos
        frame[3, 0], frame[3, 1] = cos, sin
        self.middle = 0.5 * move
        self.radius = np.sqrt(self.middle[0] * self.middle[0] + self.middle[1] * self.middle[1])
        self.radius += np.sqrt(halves[0] * halves[0] + halves[1] * halves[1])
        turn_cos = cos[0] * cos[1] + sin[0] * sin[1]
        turn_sin = cos[0] * sin[1] - sin[0] * cos[1]
        if (turn_cos < np.abs(turn_sin)).any():
            turn_cos, turn_sin = _quarter_turns(frame, turn_cos, turn_sin)
        # The one that is turned further to the left, by less than half a quarter, comes second.
        frame = np.where(turn_sin < 0.0, frame[:, :, ::-1], frame)
        turn_sin = np.abs(turn_sin)
        #: By how much the box around a footprint, along the other one, may exceed its corners.
        self.excess = turn_sin * (2.0 * np.maximum(*halves))
        self._outline(frame, turn_cos, turn_sin)

    def _outline(self, frame: Floats, turn_cos: Floats, turn_sin: Floats) -> None:
        """Corners, and the sides of the hull: going round once, which footprint reaches further out in the direction of
        each of the eight sides' normals? Between two such directions the hull changes over at most once."""
        self.sides = np.empty((6, 8, self.size))
        shaped = self.sides.reshape(6, 2, 4, self.size)
        corner, vector = shaped[0:2], shaped[2:4]
        both, across = frame[1] + frame[2], frame[1] - frame[2]
        np.add(frame[0], both, out=corner[:, :, 0])
        np.subtract(frame[0], across, out=corner[:, :, 1])
        np.subtract(frame[0], both, out=corner[:, :, 2])
        np.add(frame[0], across, out=corner[:, :, 3])
        first, second = corner[:, 0], corner[:, 1]
        self.corners = np.empty((2, 4, self.size), dtype=np.complex128)
        self.corners.real, self.corners.imag = corner
        self.heading = np.empty(self.size, dtype=np.complex128)
        self.heading.real, self.heading.imag = frame[3, :, 0]
        # From the second's corner before to the first's corner, seen along the first's normal and along its side. The
        # second's normal lies between those two, so its sign cannot contradict both.
        ahead = (self.corners[0] - self.corners[1].take(_BEFORE, axis=0)) * (
            self.heading.conj() * _TURNED_BACK
        )
        at_first = ahead.real >= 0.0
        at_second = turn_cos * ahead.real + turn_sin * ahead.imag >= 0.0
        at_first_next, at_second_next = at_first.take(_NEXT, axis=0), at_second.take(_NEXT, axis=0)
        first_next = first.take(_NEXT, axis=1)
        to = np.where(at_second, second, second.take(_BEFORE, axis=1))
        np.subtract(np.where(at_first_next, first_next, to), first, out=vector[:, 0])
        to = np.where(at_first_next, first, first_next)
        np.subtract(np.where(at_second_next, to, second.take(_NEXT, axis=1)), second, out=vector[:, 1])
        vector = self.sides[2:4]
        square = np.add(vector[0] * vector[0], vector[1] * vector[1], out=self.sides[4])
        none = square < SHORTEST * SHORTEST
        none[:4] |= ~(at_first | at_second | at_first_next)
        none[4:] |= at_second & at_first_next & at_second_next
        np.copyto(self.sides[2:5], np.nan, where=none)
        np.sqrt(square, out=self.sides[5])

    def boxes(self) -> tuple[Complexes, Complexes, Floats]:
        """Boxes around the hulls, along `heading`: lowest and highest corner, as complex numbers, and an excess.

        A point that is `d` from the box is between `d` and `d` plus the excess from the hull.
        """
        local = (self.corners * self.heading.conj()).view(np.float64)
        lows, highs = np.minimum.reduce(local, axis=1), np.maximum.reduce(local, axis=1)
        low, high = np.minimum(lows[0], lows[1]), np.maximum(highs[0], highs[1])
        apart = np.maximum(np.abs(lows[0] - lows[1]), np.abs(highs[0] - highs[1]))
        return (
            low.view(np.complex128),
            high.view(np.complex128),
            self.excess + np.minimum(apart[0::2], apart[1::2]),
        )


def _usable(
    poses: Floats, length: float | Floats, width: float | Floats
) -> tuple[Floats, float | Floats, float | Floats, Bools | None]:
    """Poses and sizes with unusable ones replaced, and a mask of the usable ones, None where all are."""
    fine = np.logical_and.reduce(np.abs(poses) <= LIMIT, axis=0)
    for size in (length, width):
        fine &= (np.asarray(size) > 0.0) & (np.asarray(size) <= LIMIT)
    if fine.all():
        return poses, length, width, None
    return np.where(fine, poses, 0.0), np.where(fine, length, 1.0), np.where(fine, width, 1.0), fine


def _quarter_turns(frame: Floats, turn_cos: Floats, turn_sin: Floats) -> tuple[Floats, Floats]:
    """Name the second rectangle's sides anew, so that it is turned by at most half a quarter; in place."""
    for turned, ahead, left in (
        (turn_cos < -np.abs(turn_sin), -1.0, 0.0),
        (turn_sin >= np.abs(turn_cos), 0.0, -1.0),
        (-turn_sin >= np.abs(turn_cos), 0.0, 1.0),
    ):
        which = np.flatnonzero(turned)
        if not which.size:
            continue
        front, side, (ux, uy) = (frame[row, :, 1, which].T.copy() for row in (1, 2, 3))
        frame[1, :, 1, which] = (ahead * front + left * side).T
        frame[2, :, 1, which] = (ahead * side - left * front).T
        frame[3, :, 1, which] = np.stack([ahead * ux - left * uy, ahead * uy + left * ux]).T
        turn_cos, turn_sin = (
            np.where(turned, ahead * turn_cos - left * turn_sin, turn_cos),
            np.where(turned, ahead * turn_sin + left * turn_cos, turn_sin),
        )
    return turn_cos, turn_sin
