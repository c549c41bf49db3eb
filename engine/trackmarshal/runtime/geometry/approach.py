"""Where hulls come nearest to a border: pairs of hull and segment, with the formulas of the reference in their order."""

from __future__ import annotations

import numpy as np

from trackmarshal.runtime.geometry.arrays import Bools, Floats, Ints, starts_of
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.sweep import Sweeps


class Approach:
    """Hulls `rows` against segments `k` of a border, pair by pair, ordered by hull; every hull occurs.

    Arrays have shape (8, pairs): the corners as seen from the segment's start (cx, cy), the sides of the hull (gx, gy), the
    side of the segment's line on which a corner lies, the depth of the segment's start behind a side's line [m].
    """

    def __init__(self, border: Border, sweeps: Sweeps, rows: Ints, k: Ints) -> None:
        self.border, self.sweeps, self.rows, self.k = border, sweeps, rows, k
        cx, cy, gx, gy, square, length = sweeps.sides.take(rows, axis=2)
        ax, ay, self.ex, self.ey, segment_square, segment_length = border.table.take(k, axis=1)
        cx -= ax - sweeps.x.take(rows)
        cy -= ay - sweeps.y.take(rows)
        self.cx, self.cy, self.gx, self.gy, self.length = cx, cy, gx, gy, length
        self.side = self.ex * cy - self.ey * cx
        along = self.ex * cx + self.ey * cy
        self.beside = (along > 0.0) & (along < segment_square)
        to_line = np.where(self.beside, np.abs(self.side), np.inf)
        self.to_line = np.minimum.reduce(to_line, axis=0) / segment_length
        self.ends = cx * cx + cy * cy
        self.to_corner = np.sqrt(np.minimum.reduce(self.ends, axis=0))
        self.depth = (gy * cx - gx * cy) / length
        along = gx * cx + gy * cy
        facing = (along < 0.0) & (along > -square)
        self.from_side = np.where(facing, np.abs(self.depth), np.inf)
        self.to_side = np.minimum.reduce(self.from_side, axis=0)

    def nearest(self) -> tuple[Floats, Bools]:
        """The distance of each hull from the border, and whether its point nearest to the border lies left of it.

        The latter is meaningless for hulls that touch the border or that it enters.
        """
        distance = np.minimum(np.minimum(self.to_line, self.to_corner), self.to_side)
        margin = np.minimum.reduceat(distance, starts_of(self.rows))
        pairs = np.flatnonzero(distance == margin.take(self.rows))
        if pairs.size > margin.size:
            pairs = pairs[starts_of(self.rows.take(pairs))]
        # Where a corner is nearest to the inside of a segment, all corners beside it lie on the same side.
        beside, side = self.beside.take(pairs, axis=1), self.side.take(pairs, axis=1)
        left = np.logical_or.reduce(beside & (side > 0.0), axis=0)
        at_start = np.flatnonzero(self.to_line.take(pairs) > margin)
        if at_start.size:
            left[at_start] = self._left_at_start(pairs[at_start])
        return margin, left

    def _left_at_start(self, pairs: Ints) -> Bools:
        """The same for pairs in which the segment's start is nearest to the hull."""
        corner = np.argmin(self.ends[:, pairs], axis=0)
        side = np.argmin(self.from_side[:, pairs], axis=0)
        at_corner = self.to_corner[pairs] <= self.to_side[pairs]
        dx = np.where(at_corner, self.cx[corner, pairs], -self.gy[side, pairs])
        dy = np.where(at_corner, self.cy[corner, pairs], self.gx[side, pairs])
        k = self.k[pairs]
        left: Bools = dx * self.border.nx[k] + dy * self.border.ny[k] > 0.0
        return left

    def entering(self) -> Ints:
        """The pairs in which the segment has a point strictly inside the hull: no line along either separates them."""
        turns = np.minimum.reduce(self.side, axis=0) < 0.0
        turns &= np.maximum.reduce(self.side, axis=0) > 0.0
        pairs = np.flatnonzero(turns)
        if not pairs.size:
            return pairs
        outside = (self.depth[:, pairs] <= 0.0) & (self.behind(pairs, self.border.bx, self.border.by) <= 0.0)
        entering: Ints = pairs[~outside.any(axis=0)]
        return entering

    def middles(self, pairs: Ints) -> Floats:
        """For segments that enter hulls: how deep in the hull the middle of the segment's part inside it is."""
        border, k, rows = self.border, self.k[pairs], self.rows[pairs]
        start, end = self.behind(pairs, border.ax, border.ay), self.behind(pairs, border.bx, border.by)
        cut = start / np.where(start == end, 1.0, start - end)
        first = np.maximum.reduce(np.where(start < end, cut, 0.0), axis=0, initial=0.0)
        last = np.minimum.reduce(np.where(start > end, cut, 1.0), axis=0, initial=1.0)
        t = (first + last) / 2.0
        x, y = (
            border.ax[k] - self.sweeps.x[rows] + t * border.ex[k],
            border.ay[k] - self.sweeps.y[rows] + t * border.ey[k],
        )
        depth: Floats = np.fmin.reduce(self._behind(pairs, x, y) / self.length[:, pairs], axis=0)
        return depth

    def behind(self, pairs: Ints, x: Floats, y: Floats) -> Floats:
        """On which side of the hull's sides a segment's start or end lies, positive inside: `depth` times length."""
        k, rows = self.k[pairs], self.rows[pairs]
        return self._behind(pairs, x[k] - self.sweeps.x[rows], y[k] - self.sweeps.y[rows])

    def _behind(self, pairs: Ints, x: Floats, y: Floats) -> Floats:
        corner_x, corner_y = self.sweeps.sides[0:2][:, :, self.rows[pairs]]
        behind: Floats = self.gx[:, pairs] * (y - corner_y) - self.gy[:, pairs] * (x - corner_x)
        return behind
