"""Directed segments in chains, and which of them are nearest to points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from trackmarshal.runtime.geometry.arrays import SLACK, Bools, Floats, Ints, starts_of, true_in

#: Consecutive segments that share a bounding disc, and how many of a block's segments share a smaller one.
BLOCK, PART = 16, 4
#: With more points than this it is worth looking for the parts of blocks that are near.
FEW_POINTS = 64
#: The sine of a bend below which both sides of the border count as straight: rounding could decide between them.
STRAIGHT = 1e-6
#: Distances that are held at once while blocks are searched, if they are those of more than a few points.
AT_ONCE, LEAST = 1 << 15, 64


class Border:
    """Segments of open or closed chains of distinct points; immutable once built.

    Segment k runs from (ax, ay) by (ex, ey) to (bx, by), of length `length`. `normals` has the sum of the
    unit normals, to the left, of the two segments that meet at its start: a point whose nearest border point is that start
    lies left of the border where its direction from there has a positive product with that sum.
    """

    def __init__(self, chains: Sequence[Floats], closed: bool) -> None:
        starts = [chain if closed else chain[:-1] for chain in chains]
        ends = [np.roll(chain, -1, axis=0) if closed else chain[1:] for chain in chains]
        self.ax, self.ay = np.ascontiguousarray(np.concatenate(starts).T)
        self.bx, self.by = np.ascontiguousarray(np.concatenate(ends).T)
        self.size = self.ax.size
        self.ex, self.ey = self.bx - self.ax, self.by - self.ay
        self.square = self.ex * self.ex + self.ey * self.ey
        self.length = np.sqrt(self.square)
        firsts = np.cumsum([0, *(len(start) for start in starts)])
        index = np.arange(self.size)
        self.next, before = index + 1, index - 1
        for first, last in pairwise(firsts.tolist()):
            self.next[last - 1], before[first] = first, last - 1
        normals = np.stack([-self.ey / self.length, self.ex / self.length])
        self.normals = normals + normals[:, before]
        #: At the start of each segment: 1 where the border bends to the right, so that points on its left are nearest to the
        #: start itself, -1 where it bends to the left, 0 where it hardly bends.
        turn = self.ex[before] * self.ey - self.ey[before] * self.ex
        turn /= self.length[before] * self.length
        self.bend = (turn < -STRAIGHT).astype(np.int8) - (turn > STRAIGHT).astype(np.int8)
        back = (np.abs(turn) <= STRAIGHT) & (self.ex[before] * self.ex + self.ey[before] * self.ey < 0.0)
        #: Segments with an end where the border turns round, as at the tip of a spike: rounding could decide which of its two sides is nearest,
        #: and their normals add up to nothing. None where it does so nowhere.
        self.spikes: Bools | None = back | back[self.next] if back.any() else None
        #: Rows ax, ay, ex, ey, square, length: what the distance of a hull takes of a segment, in one read.
        self.table = np.stack([self.ax, self.ay, self.ex, self.ey, self.square, self.length])
        #: Rows ax, ay, bx, by, ex, ey, square, length: what the distance of a point takes of a segment.
        self.segments = np.stack(
            [self.ax, self.ay, self.bx, self.by, self.ex, self.ey, self.square, self.length]
        )
        self._blocks(firsts)
        for array in (
            self.ax,
            self.ay,
            self.bx,
            self.by,
            self.ex,
            self.ey,
            self.square,
            self.length,
            self.table,
            self.segments,
        ):
            array.flags.writeable = False

    @property
    def _step(self) -> int:
        """Points that are searched for at once."""
        return max(LEAST, AT_ONCE // len(self.runs))

    def _blocks(self, firsts: Ints) -> None:
        """Bounding discs of runs of segments, and of the parts of those, each centred at a point of the border."""
        runs = []
        for first, last in pairwise(firsts.tolist()):
            begins = np.arange(first, last, BLOCK)
            runs.append(np.minimum(begins[:, None] + np.arange(BLOCK), last - 1))
        self.runs = np.concatenate(runs)
        #: The segments of each block, and of each part, one after the other: (segments, blocks or parts).
        self.run_segments, self.part_segments = (
            np.ascontiguousarray(of_each.T) for of_each in (self.runs, self.runs.reshape(-1, PART))
        )
        #: x, y and radius of the discs of blocks: (3, blocks).
        self.discs = np.stack(self._discs(self.run_segments))
        #: x, y and radius of the discs of a block's parts: (3, parts of a block, blocks).
        discs = np.stack(self._discs(self.part_segments)).reshape(3, len(self.runs), -1)
        self.part_discs = np.ascontiguousarray(discs.swapaxes(1, 2))

    def _discs(self, runs: Ints) -> tuple[Floats, Floats, Floats]:
        """Centres and radii of discs around runs of segments, (segments, runs)."""
        x, y = self.segments[:2].take(runs[len(runs) // 2], axis=1)
        ax, ay, bx, by = self.segments[:4].take(runs, axis=1)
        square = np.maximum((ax - x) ** 2 + (ay - y) ** 2, (bx - x) ** 2 + (by - y) ** 2)
        return x, y, np.sqrt(np.maximum.reduce(square, axis=0)) + SLACK

    def distance(self, x: Floats, y: Floats, k: Ints) -> Floats:
        """The distance of points from segments: to the line where the foot lies within, else to the nearer end."""
        ax, ay, bx, by, ex, ey, square, length = self.segments.take(k, axis=1)
        return _distance(x - ax, y - ay, x - bx, y - by, ex, ey, square, length)

    def distance_from(self, rx: Floats, ry: Floats, sx: Floats, sy: Floats, k: Ints) -> Floats:
        """The same, of points as seen from the segment's start (rx, ry) and from its end (sx, sy)."""
        return _distance(rx, ry, sx, sy, self.ex[k], self.ey[k], self.square[k], self.length[k])

    def near(self, x: Floats, y: Floats, reach: float | Floats = 0.0) -> tuple[Ints, Ints, Floats]:
        """All segments that are at most `reach` farther from a point than its nearest one.

        Returns rows (which point, ascending), segments (ascending within a row, possibly repeated) and distances [m].
        """
        if not x.size:
            return np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp), np.empty(0)
        step = self._step
        if x.size <= step:
            return self._near(x, y, reach)
        parts = []
        for first in range(0, x.size, step):
            chunk = slice(first, first + step)
            rows, k, distance = self._near(
                x[chunk], y[chunk], reach if isinstance(reach, float) else reach[chunk]
            )
            parts.append((rows + first, k, distance))
        rows, k, distance = (np.concatenate(part) for part in zip(*parts))
        return rows, k, distance

    def nearest(self, x: Floats, y: Floats) -> tuple[Ints, Floats]:
        """The nearest segment to each point, of equally near ones the first, and its distance."""
        if not x.size:
            return np.empty(0, dtype=np.intp), np.empty(0)
        step = self._step
        parts = [self._nearest(x[at : at + step], y[at : at + step]) for at in range(0, x.size, step)]
        if len(parts) == 1:
            return parts[0]
        k, distance = (np.concatenate(part) for part in zip(*parts))
        return k, distance

    def _nearest(self, x: Floats, y: Floats) -> tuple[Ints, Floats]:
        # Points stand along the last axis, where there are most: numpy goes along it without stopping.
        point, block = self._near_blocks(x, y, 0.0)
        if x.size > FEW_POINTS:
            point, k = self._near_parts(x, y, point, block)
        else:
            k = self.run_segments.take(block, axis=1)
        distance = self.distance(x.take(point), y.take(point), k)
        best = _least_of(point, distance, x.size)
        nearest = np.where(distance == best.take(point), k, self.size)  # of equally near ones the first
        return np.minimum.reduceat(np.minimum.reduce(nearest, axis=0), starts_of(point)), best

    def _near_blocks(self, x: Floats, y: Floats, reach: float | Floats) -> tuple[Ints, Ints]:
        """Points and blocks in pairs, where a block may have a segment at most `reach` farther than the nearest one."""
        some = self._blocks_around(x, y, reach)
        disc_x, disc_y, disc_radius = self.discs.take(some, axis=1)[:, :, None]
        dx, dy = x - disc_x, y - disc_y
        dx *= dx
        dy *= dy
        dx += dy
        centre = np.sqrt(dx, out=dx)
        limit = np.minimum.reduce(centre, axis=0) + (reach + SLACK)
        centre -= disc_radius
        near = np.empty(centre.shape[::-1], dtype=np.bool_)
        np.less_equal(centre, limit, out=near.T)
        point, block = true_in(near)
        return point, some.take(block)

    def _blocks_around(self, x: Floats, y: Floats, reach: float | Floats) -> Ints:
        """Blocks that may be such a pair with some of the points, or have the centre that is nearest to one: of points that lie together few are.

        Of a point within r of p, no centre is nearer than of p by more than r, and none farther.
        """
        px, py = x[x.size // 2], y[y.size // 2]  # any of them
        dx, dy, (from_x, from_y, radius) = x - px, y - py, self.discs
        spread = math.sqrt(np.maximum.reduce(dx * dx + dy * dy))
        from_x, from_y = from_x - px, from_y - py
        centre = np.sqrt(from_x * from_x + from_y * from_y)
        limit = np.minimum.reduce(centre) + (2.0 * spread + np.maximum.reduce(reach, axis=None) + 8.0 * SLACK)
        blocks: Ints = (~(centre - radius > limit)).nonzero()[0]  # all, where a number is none
        return blocks

    def _near_parts(self, x: Floats, y: Floats, point: Ints, block: Ints) -> tuple[Ints, Ints]:
        """Of points and blocks in pairs those of points and parts of blocks where a part may have the nearest segment: which points, and the
        segments of each part, (PART, pairs)."""
        px, py, radius = self.part_discs.take(block, axis=2)
        px -= x.take(point)
        py -= y.take(point)
        px *= px
        py *= py
        px += py
        centre = np.sqrt(px, out=px)
        nearest = _least_of(point, centre, x.size) + SLACK
        centre -= radius
        near = np.empty(centre.shape[::-1], dtype=np.bool_)
        np.less_equal(centre, nearest.take(point), out=near.T)
        pair, part = true_in(near)
        return point.take(pair), self.part_segments.take(block.take(pair) * (BLOCK // PART) + part, axis=1)

    def _near(self, x: Floats, y: Floats, reach: float | Floats) -> tuple[Ints, Ints, Floats]:
        point, block = self._near_blocks(x, y, reach)
        k = self.runs.take(block, axis=0)
        distance = self.distance(x.take(point)[:, None], y.take(point)[:, None], k)
        nearest = np.minimum.reduceat(distance.min(axis=1), starts_of(point)) + (reach + SLACK)
        kept = (distance <= nearest[point, None]).ravel().nonzero()[0]
        return point[kept // BLOCK], k.ravel()[kept], distance.ravel()[kept]

    def left_of(self, x: Floats, y: Floats, k: Ints, distance: Floats) -> Bools:
        """Whether points lie left of the border, each given a segment that is nearest to it, and its distance."""
        left = self.left_from(x - self.ax[k], y - self.ay[k], x - self.bx[k], y - self.by[k], k)
        return self.left_for_sure(left, self.unsure(k) | (distance < SLACK) & (distance > 0.0), x, y)

    def unsure(self, k: Ints) -> Bools:
        """Which nearest segments say nothing of the side on which something lies: those at a spike."""
        return np.zeros(k.size, dtype=np.bool_) if self.spikes is None else self.spikes.take(k)

    def left_for_sure(self, left: Bools, unsure: Bools, x: Floats, y: Floats) -> Bools:
        """The side that nearest segments say, and where they may be wrong that of a ray, as the reference has it."""
        which = unsure.nonzero()[0]
        if which.size:
            left[which] = self.encloses(x.take(which), y.take(which))
        return left

    def encloses(self, x: Floats, y: Floats) -> Bools:
        """Whether rays from points along +x cross closed chains an odd number of times, by the steps of the reference."""
        upward = self.ay < self.by
        ax, ex = np.where(upward, self.ax, self.bx), np.where(upward, self.ex, -self.ex)
        low, high = np.minimum(self.ay, self.by), np.maximum(self.ay, self.by)
        ey, odd = high - low, np.zeros(x.size, dtype=np.bool_)
        step = max(1, AT_ONCE // self.size)
        for first in range(0, x.size, step):
            px, py = x[first : first + step, None], y[first : first + step, None]
            crossed = (low <= py) & (py < high)
            crossed &= ex * (py - low) - ey * (px - ax) > 0.0
            odd[first : first + step] = np.logical_xor.reduce(crossed, axis=1)
        return odd

    def left_from(self, rx: Floats, ry: Floats, sx: Floats, sy: Floats, k: Ints) -> Bools:
        """What the nearest segment says, of points as seen from its start (rx, ry) and from its end (sx, sy)."""
        ex, ey = self.ex[k], self.ey[k]
        along = ex * rx + ey * ry
        beside = (along > 0.0) & (along < self.square[k])
        at_start = rx * rx + ry * ry <= sx * sx + sy * sy
        vertex = np.where(at_start, k, self.next[k])
        nx, ny = self.normals[:, vertex]
        corner = np.where(at_start, rx, sx) * nx + np.where(at_start, ry, sy) * ny
        left: Bools = np.where(beside, ex * ry - ey * rx, corner) > 0.0
        return left


def _least_of(point: Ints, numbers: Floats, count: int) -> Floats:
    """Of numbers (n, pairs), the pairs ordered by point, the least of each point, (count,): each of them has some."""
    least: Floats = np.minimum.reduceat(np.minimum.reduce(numbers, axis=0), starts_of(point))
    if least.size != count:
        raise AssertionError("each point has a nearest segment")
    return least


def _distance(
    rx: Floats, ry: Floats, sx: Floats, sy: Floats, ex: Floats, ey: Floats, square: Floats, length: Floats
) -> Floats:
    along = ex * rx + ey * ry
    beside = (along > 0.0) & (along < square)
    end = np.sqrt(np.minimum(rx * rx + ry * ry, sx * sx + sy * sy))
    distance: Floats = np.where(beside, np.abs(ex * ry - ey * rx) / length, end)
    return distance
