"""Where hulls come nearest to a border: pairs of hull and segment, with the formulas of the reference in their order."""

from __future__ import annotations

import numpy as np

from trackmarshal.runtime.geometry.arrays import Bools, Floats, Ints, counts_of, starts_of
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.sweep import Sweeps

#: Farther than any distance is, by itself or divided by the length of a segment; cheaper to put than infinity [m].
FARTHEST = 1e300


class Approach:
    """Hulls `rows` against segments `k` of a border, pair by pair, ordered by hull; each of a run of hulls occurs.

    Arrays have shape (8, pairs): the corners as seen from the segment's start (cx, cy), the sides of the hull (gx, gy), the
    side of the segment's line on which a corner lies, the depth of the segment's start behind a side's line [m].
    """

    def __init__(self, border: Border, sweeps: Sweeps, rows: Ints, k: Ints) -> None:
        self.border, self.sweeps, self.rows, self.k = border, sweeps, rows, k
        self.starts = starts_of(rows)
        counts = counts_of(self.starts, rows.size)
        hulls = slice(rows[0], rows[-1] + 1)
        cx, cy, gx, gy, square, length = sweeps.sides[:, :, hulls].repeat(counts, axis=2)
        ax, ay, ex, ey, segment_square, segment_length = border.table.take(k, axis=1)
        x, y = sweeps.position[:, hulls].repeat(counts, axis=1)
        cx -= ax - x
        cy -= ay - y
        self.cx, self.cy, self.gx, self.gy, self.length = cx, cy, gx, gy, length
        self.side = ex * cy
        self.side -= ey * cx
        along = ex * cx
        along += ey * cy
        self.beside = along > 0.0
        self.beside &= along < segment_square
        self.to_line = _least(self.side, self.beside) / segment_length
        self.ends = cx * cx
        self.ends += cy * cy
        self.to_corner = np.sqrt(np.minimum.reduce(self.ends, axis=0))
        self.depth = gy * cx
        self.depth -= gx * cy
        self.depth /= length
        along = gx * cx
        along += gy * cy
        self.facing = along < 0.0
        self.facing &= along > -square
        self.to_side = _least(self.depth, self.facing)

    def nearest(self) -> tuple[Floats, Bools]:
        """The distance of each hull from the border, and whether its point nearest to the border lies left of it.

        The latter is meaningless for hulls that touch the border or that it enters.
        """
        distance = np.minimum(np.minimum(self.to_line, self.to_corner), self.to_side)
        margin = np.minimum.reduceat(distance, self.starts)
        pairs = (distance == margin.take(self.rows - self.rows[0])).nonzero()[0]
        if pairs.size > margin.size:
            pairs = pairs[starts_of(self.rows.take(pairs))]
        # Where a corner is nearest to the inside of a segment, all corners beside it lie on the same side.
        beside, side = self.beside.take(pairs, axis=1), self.side.take(pairs, axis=1)
        left = np.logical_or.reduce(beside & (side > 0.0), axis=0)
        at_start = (self.to_line.take(pairs) > margin).nonzero()[0]
        if at_start.size:
            bend = self.border.bend.take(self.k.take(pairs.take(at_start)))
            left[at_start] = bend > 0
            straight = at_start[bend == 0]
            if straight.size:
                left[straight] = self._left_at_start(pairs[straight])
        if self.border.spikes is not None:
            x, y = self.sweeps.centres(self.rows.take(pairs))
            left = self.border.left_for_sure(left, self.border.unsure(self.k.take(pairs)), x, y)
        return margin, left

    def _left_at_start(self, pairs: Ints) -> Bools:
        """The same for pairs in which the segment's start is nearest to the hull: to a corner, or to the inside of a side.

        The direction from there to the hull is that to the corner, or the side's normal into the hull.
        """
        nx, ny = self.border.normals.take(self.k.take(pairs), axis=1)
        ends, depth = self.ends.take(pairs, axis=1), np.abs(self.depth.take(pairs, axis=1))
        depth[~self.facing.take(pairs, axis=1)] = np.inf
        corner = (nx * self.cx.take(pairs, axis=1) + ny * self.cy.take(pairs, axis=1) > 0.0) & (
            ends == np.minimum.reduce(ends, axis=0)
        )
        side = (ny * self.gx.take(pairs, axis=1) - nx * self.gy.take(pairs, axis=1) > 0.0) & (
            depth == np.minimum.reduce(depth, axis=0)
        )
        at_corner = self.to_corner.take(pairs) <= self.to_side.take(pairs)
        left: Bools = np.logical_or.reduce(np.where(at_corner, corner, side), axis=0)
        return left

    def entering(self, touching: Bools) -> Ints:
        """The pairs, of those that may, in which the segment has a point strictly inside the hull.

        That is where no line along a side of the hull or along the segment separates them.
        """
        pairs: Ints = touching.nonzero()[0]
        if not pairs.size:
            return pairs
        side = self.side.take(pairs, axis=1)
        pairs = pairs[(np.minimum.reduce(side, axis=0) < 0.0) & (np.maximum.reduce(side, axis=0) > 0.0)]
        outside = (self.depth[:, pairs] <= 0.0) & (self.behind(pairs, self.border.bx, self.border.by) <= 0.0)
        inside: Bools = ~np.logical_or.reduce(outside, axis=0)
        return pairs[inside]

    def middles(self, pairs: Ints) -> Floats:
        """For segments that enter hulls: how deep in the hull the middle of the segment's part inside it is."""
        border, k, rows = self.border, self.k[pairs], self.rows[pairs]
        start, end = self.behind(pairs, border.ax, border.ay), self.behind(pairs, border.bx, border.by)
        cut = start / np.where(start == end, 1.0, start - end)
        first = np.maximum.reduce(np.where(start < end, cut, 0.0), axis=0, initial=0.0)
        last = np.minimum.reduce(np.where(start > end, cut, 1.0), axis=0, initial=1.0)
        t = (first + last) / 2.0
        x, y = self.sweeps.position[:, rows]
        x, y = border.ax[k] - x + t * border.ex[k], border.ay[k] - y + t * border.ey[k]
        depth: Floats = np.fmin.reduce(self._behind(pairs, x, y) / self.length[:, pairs], axis=0)
        return depth

    def behind(self, pairs: Ints, x: Floats, y: Floats) -> Floats:
        """On which side of the hull's sides a segment's start or end lies, positive inside: `depth` times length."""
        k, position = self.k[pairs], self.sweeps.position[:, self.rows[pairs]]
        return self._behind(pairs, x[k] - position[0], y[k] - position[1])

    def _behind(self, pairs: Ints, x: Floats, y: Floats) -> Floats:
        corner_x, corner_y = self.sweeps.sides[0:2][:, :, self.rows[pairs]]
        behind: Floats = self.gx[:, pairs] * (y - corner_y) - self.gy[:, pairs] * (x - corner_x)
        return behind


def _least(values: Floats, counted: Bools) -> Floats:
    """The least absolute value of each column among those that count; farther than anything where none does."""
    size = np.abs(values)
    np.fmax(size, np.multiply(~counted, FARTHEST), out=size)  # sides that are none are NaN, and do not count
    least: Floats = np.minimum.reduce(size, axis=0)
    return least
