"""What a rectangle sweeps between two poses: the convex hulls of many pairs of footprints at once."""

from __future__ import annotations

import numpy as np

from trackmarshal.runtime.geometry.arrays import LIMIT, SMALLEST, Bools, Floats, Ints

#: Sides of a hull shorter than this [m] have no direction worth the name and are left out; their ends stay corners.
SHORTEST = 1e-7
#: Of the directions of a rectangle's sides, in their order, which coordinate of the first one's each coordinate is, and its sign.
_AXES, _SIGNS = (
    np.array([[0, 1, 0, 1], [1, 0, 1, 0]]),
    np.array([[1.0, -1.0, -1.0, 1.0], [1.0, 1.0, -1.0, -1.0]])[..., None],
)
_NEXT, _BEFORE = np.array([1, 2, 3, 0]), np.array([3, 0, 1, 2])


class Sweeps:
    """Hulls of the footprints of N pairs of poses, all relative to the first pose's `position`, (2, N).

    `sides` has shape (6, 8, N): x and y of each of the eight corners, then of the side of the hull that begins at that
    corner its vector x, y, its square and its length. The side is NaN for a corner inside the hull and for a side shorter
    than `SHORTEST`. Corners are those of one footprint, counter-clockwise, then those of the other.
    """

    __slots__ = (
        "_sides", "_turn", "excess", "frame", "front", "inner", "middle", "midway", "move", "position", "radius", "side", "size", "units",
        "usable",
    )  # fmt: skip

    def __init__(
        self, poses: Floats, length: float | Floats, width: float | Floats, units: Floats | None = None
    ) -> None:
        """`poses`: (6, N) with rows x0, y0, heading0, x1, y1, heading1; `length`, `width`: numbers or (N,).

        units: (2, 2, N), the cosines and the sines of both headings, where they are known; headings are then not looked at, and
        poses and sizes are taken as they are.
        """
        self.size = poses.shape[1]
        self.usable: Bools | None = None
        if units is None:
            poses, length, width, self.usable = usable_bodies(poses, length, width)
        front, side = self.front, self.side = 0.5 * length, 0.5 * width
        self.position = poses[0:2]
        # Axes 1 and 2: coordinate, footprint. Rows: centre, centre to front, centre to left, unit vector.
        frame = np.empty((4, 2, 2, self.size))
        centre, ahead, left, unit = frame
        #: From the first footprint's middle to the second's; and x and y of the directions of both.
        self.move = move = poses[3:5] - poses[0:2]
        centre[:, 1] = move
        centre[:, 0] = 0.0
        if units is None:
            np.cos(poses[2::3], out=unit[0])
            np.sin(poses[2::3], out=unit[1])
            self.units = unit.copy()  # sides may be named anew
        else:
            unit[...] = self.units = units
        np.multiply(unit, front, out=ahead)
        np.multiply(unit[0], side, out=left[1])
        np.multiply(unit[1], -side, out=left[0])
        self.middle = 0.5 * move
        self.radius = np.sqrt(np.add.reduce(self.middle * self.middle, axis=0))
        self.radius += np.sqrt(front * front + side * side)
        #: As far from the middle as this, all is in the hull: in the hull of the discs in both footprints.
        self.inner, outer = np.minimum(front, side), np.maximum(front, side)
        product = unit[:, 0] * unit[:, 1]
        turn_cos = product[0] + product[1]
        turn_sin = unit[0, 0] * unit[1, 1] - unit[1, 0] * unit[0, 1]
        size = np.abs(turn_sin)
        if 1 in (turn_cos < size).tobytes():
            turn_cos, turn_sin = _quarter_turns(frame, turn_cos, turn_sin)
            size = np.abs(turn_sin)
        # The one that is turned further to the left, by less than half a quarter, comes second.
        right = turn_sin < 0.0
        if 1 in right.tobytes():
            frame = np.where(right, frame[:, :, ::-1], frame)
        self.frame = frame
        # Midway between the directions of both footprints, half the turn from either.
        self.midway = frame[3, :, 0] + frame[3, :, 1]
        reach = np.sqrt(np.add.reduce(self.midway * self.midway, axis=0))
        self.midway /= reach
        #: By how much the box around a footprint, in the direction midway, may exceed it.
        self.excess = size / reach * (2.0 * outer)
        self._turn = turn_cos, size
        self._sides: Floats | None = None

    @property
    def sides(self) -> Floats:
        """The corners and sides of the hulls; worked out when first asked for."""
        if self._sides is None:
            self._sides = self._outline()
        return self._sides

    def some(self, rows: Ints) -> Sweeps:
        """Some of the hulls, by their numbers, for whoever asks for their sides."""
        made: Sweeps = object.__new__(Sweeps)
        made.size = rows.size
        made.position, made.frame = self.position.take(rows, axis=1), self.frame.take(rows, axis=3)
        turn_cos, turn_sin = self._turn
        made._turn = turn_cos.take(rows), turn_sin.take(rows)
        made._sides = None
        return made

    def centres(self, rows: Ints) -> Floats:
        """The middles of some hulls, by their numbers: (2, rows)."""
        first, second = self.frame[0].take(rows, axis=2).swapaxes(0, 1)
        middles: Floats = self.position.take(rows, axis=1) + 0.5 * (first + second)
        return middles

    def turn_of(self, row: int) -> tuple[float, float]:
        """Cosine and sine of the turn from the first footprint of a hull to the second."""
        turn_cos, turn_sin = self._turn
        return float(turn_cos[row]), float(turn_sin[row])

    def _outline(self) -> Floats:
        """Corners, and the sides of the hull: going round once, which footprint reaches further out in the direction of
        each of the eight sides' normals? Between two such directions the hull changes over at most once."""
        sides = np.empty((6, 8, self.size))
        shaped = sides.reshape(6, 2, 4, self.size)
        corner, vector = shaped[0:2], shaped[2:4]
        (centre, ahead, left, unit), (turn_cos, turn_sin) = self.frame, self._turn
        half = np.empty((2, 2, 2, self.size))
        np.add(ahead, left, out=half[:, :, 0])
        np.subtract(left, ahead, out=half[:, :, 1])
        np.add(centre[:, :, None], half, out=corner[:, :, :2])
        np.subtract(centre[:, :, None], half, out=corner[:, :, 2:])
        first, second = corner[:, 0], corner[:, 1]
        before, following = corner[:, 1].take(_BEFORE, axis=1), corner.take(_NEXT, axis=2)
        # Directions of the first's sides, in their order. Products of real numbers: where a processor can fuse a product and a sum, numpy does so
        # with complex ones, and which corners are on one line would depend on the machine, and on who asks (`alone` does not fuse).
        side_x, side_y = unit[:, 0].take(_AXES, axis=0) * _SIGNS
        dx, dy = first - before
        # From the second's corner before to the first's corner, seen along the first's normal and along its side. The
        # second's normal lies between those two, so its sign cannot contradict both.
        along, across = dx * side_x + dy * side_y, dy * side_x - dx * side_y
        at_first = along >= 0.0
        at_second = turn_cos * along + turn_sin * across >= 0.0
        at_first_next, at_second_next = at_first.take(_NEXT, axis=0), at_second.take(_NEXT, axis=0)
        to = np.where(at_first_next, following[:, 0], np.where(at_second, second, before))
        np.subtract(to, first, out=vector[:, 0])
        to = np.where(at_second_next, np.where(at_first_next, first, following[:, 0]), following[:, 1])
        np.subtract(to, second, out=vector[:, 1])
        vector = sides[2:4]
        square = np.add.reduce(vector * vector, axis=0, out=sides[4])
        none = square < SHORTEST * SHORTEST
        none[:4] |= ~(at_first | at_second | at_first_next)
        none[4:] |= at_second & at_first_next & at_second_next
        np.copyto(sides[2:5], np.nan, where=none)
        np.sqrt(square, out=sides[5])
        return sides

    def boxes(self) -> tuple[Floats, Floats, Floats]:
        """Boxes around the hulls, in a frame midway between those of the footprints.

        The lowest and the highest corner in it, (2, N), and an excess [m].        A point that is `d` from the box is between `d` and `d` plus the excess from the hull.
        """
        # Axes: centre, half length and half width; coordinate; footprint.
        local = self.frame[:3] * self.midway[0]
        across = self.frame[:3] * self.midway[1]
        local[:, 0] += across[:, 1]
        local[:, 1] -= across[:, 0]
        half = np.abs(local[1:])
        reach = half[0] + half[1]
        ends = np.empty((2, *reach.shape))
        np.subtract(local[0], reach, out=ends[0])
        np.add(local[0], reach, out=ends[1])
        first, second = ends[:, :, 0], ends[:, :, 1]
        x, y = np.maximum.reduce(np.abs(first - second), axis=0)
        return (
            np.minimum(first[0], second[0]),
            np.maximum(first[1], second[1]),
            self.excess + np.minimum(x, y),
        )


class Boxes:
    """Rectangles that stand: corners (2, 4, N) relative to their centres at `position`, counter-clockwise."""

    __slots__ = ("corners", "position", "size", "usable")

    def __init__(self, poses: Floats, length: float | Floats, width: float | Floats) -> None:
        """`poses`: (3, N) with rows x, y, heading; `length`, `width`: numbers or (N,)."""
        self.size = poses.shape[1]
        poses, length, width, self.usable = usable_bodies(poses, length, width)
        self.position = poses[0:2]
        unit = np.stack([np.cos(poses[2]), np.sin(poses[2])])
        ahead = unit * (0.5 * length)
        left = np.stack([unit[1] * (-0.5 * width), unit[0] * (0.5 * width)])
        self.corners = np.empty((2, 4, self.size))
        np.add(ahead, left, out=self.corners[:, 0])
        np.subtract(left, ahead, out=self.corners[:, 1])
        np.negative(self.corners[:, :2], out=self.corners[:, 2:])


def usable_bodies(
    poses: Floats, length: float | Floats, width: float | Floats
) -> tuple[Floats, float | Floats, float | Floats, Bools | None]:
    """Poses and sizes with unusable ones replaced, and a mask of the usable ones, None where all are."""
    extremes = [
        (size, size) if isinstance(size, float) else (size.min(), size.max()) for size in (length, width)
    ]
    if np.abs(poses).max() <= LIMIT and all(low >= SMALLEST and high <= LIMIT for low, high in extremes):
        return poses, length, width, None
    fine: Bools = np.logical_and.reduce(np.abs(poses) <= LIMIT, axis=0)
    for size in (length, width):
        fine &= (np.asarray(size) >= SMALLEST) & (np.asarray(size) <= LIMIT)
    return np.where(fine, poses, 0.0), np.where(fine, length, 1.0), np.where(fine, width, 1.0), fine


def _quarter_turns(frame: Floats, turn_cos: Floats, turn_sin: Floats) -> tuple[Floats, Floats]:
    """Name the second rectangle's sides anew, so that it is turned by at most half a quarter; in place."""
    for turned, ahead, left in (
        (turn_cos < -np.abs(turn_sin), -1.0, 0.0),
        (turn_sin >= np.abs(turn_cos), 0.0, -1.0),
        (-turn_sin >= np.abs(turn_cos), 0.0, 1.0),
    ):
        which = turned.nonzero()[0]
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
