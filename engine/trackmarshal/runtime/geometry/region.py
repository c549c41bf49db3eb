"""A closed region and its border: how far swept hulls and points are inside it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from trackmarshal.runtime.geometry.approach import Approach
from trackmarshal.runtime.geometry.arrays import LIMIT, SLACK, Floats, Ints, starts_of
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.cells import WIDTH, Cells
from trackmarshal.runtime.geometry.sweep import Sweeps
from trackmarshal.runtime.geometry.violation import violation

#: Hulls that are worked on at once, so that all intermediate arrays stay in the processor's cache.
AT_ONCE = 1024
#: Where the place of a segment that is none lies.
FAR = 1e30


class Region:
    """What lies left of closed chains of segments; immutable once built."""

    def __init__(self, rings: Sequence[Floats]) -> None:
        self.border = Border(rings, closed=True)
        perimeter = float(self.border.length.sum())
        # Cells as large as half a corridor is wide: with the neighbours of the border's cells they cover its inside.
        self.cells = Cells(self.border, abs(sum(area(ring) for ring in rings)) / perimeter)
        self._start = np.append(self.border.ax + 1j * self.border.ay, FAR)
        self._end = np.append(self.border.bx + 1j * self.border.by, FAR)

    def signed_distance(self, x: Floats, y: Floats) -> Floats:
        """The distance of points from the border, positive inside; NaN for a point that is none."""
        fine = (np.abs(x) <= LIMIT) & (np.abs(y) <= LIMIT)
        x, y = np.where(fine, x, 0.0), np.where(fine, y, 0.0)
        if not x.size:
            return x
        rows, k, distance = self.border.near(x, y)
        best = np.minimum.reduceat(distance, starts_of(rows))
        first = np.flatnonzero(distance == best.take(rows))
        inside = self.border.left_of(x, y, k[first[starts_of(rows[first])]]) | (best == 0.0)
        return np.where(fine, np.where(inside, best, -best), np.nan)

    def margin_inside(self, poses: Floats, length: float | Floats, width: float | Floats) -> Floats:
        """The signed margin of hulls inside the region: `poses` (6, N), sizes numbers or (N,)."""
        count = poses.shape[1]
        if count <= AT_ONCE:
            return self._margin(Sweeps(poses, length, width)) if count else np.empty(0)
        parts = []
        for first in range(0, count, AT_ONCE):
            chunk = slice(first, first + AT_ONCE)
            sizes = (size if isinstance(size, float) else size[chunk] for size in (length, width))
            parts.append(self._margin(Sweeps(poses[:, chunk], *sizes)))
        return np.concatenate(parts)

    def _margin(self, sweeps: Sweeps) -> Floats:
        rows, k = self._candidates(sweeps)
        approach = Approach(self.border, sweeps, rows, k)
        margin, inside = approach.nearest()
        close = np.flatnonzero(margin < SLACK)
        if close.size:
            # Too close to say on which side the nearest point of the hull is; its middle is far from the border.
            x, y = sweeps.x[close] + sweeps.middle[0][close], sweeps.y[close] + sweeps.middle[1][close]
            inside[close] = self.signed_distance(x, y) > 0.0
        entering = approach.entering()
        inside[rows[entering]] = False
        if not inside.all():
            bad = np.flatnonzero(~inside)
            margin[bad] = violation(self.border, sweeps, approach, entering, bad)
        return margin if sweeps.usable is None else np.where(sweeps.usable, margin, np.nan)

    def _candidates(self, sweeps: Sweeps) -> tuple[Ints, Ints]:
        """Hulls and segments in pairs: at least all that may make up a hull's distance from the border, or enter it."""
        x, y = sweeps.x + sweeps.middle[0], sweeps.y + sweeps.middle[1]
        rows, tiles, unknown = self.cells.tiles_around(x, y, sweeps.radius)
        if rows.size:
            rows, k = self._culled(sweeps, rows, self.cells.tiles.take(tiles, axis=1))
        if unknown is None:
            return rows, k
        which = np.flatnonzero(unknown)
        others, more, _ = self.border.near(x[which], y[which], sweeps.radius[which])
        if not rows.size:
            return which[others], more
        rows, k = np.concatenate([rows, which[others]]), np.concatenate([k, more])
        order = np.argsort(rows, kind="stable")
        return rows[order], k[order]

    def _culled(self, sweeps: Sweeps, rows: Ints, k: Ints) -> tuple[Ints, Ints]:
        """Of segments k (place in tile, tile) for hulls by tile, those that the box around the hull cannot rule out."""
        low, high, excess = sweeps.boxes()
        origin, turn = (sweeps.x + 1j * sweeps.y).take(rows), sweeps.heading.conj().take(rows)
        start, end = self._start.take(k), self._end.take(k)
        for points in (start, end):  # in the frame of the box
            points -= origin
            points *= turn
        a, b = start.view(np.float64), end.view(np.float64)
        lows, highs = low.take(rows).view(np.float64), high.take(rows).view(np.float64)
        # How near does the start of a segment come to the box for sure, and how near can the segment come at best?
        sure = _squares(lows - a, a - highs)
        best = _squares(lows - np.maximum(a, b), np.minimum(a, b) - highs)
        runs = starts_of(rows)
        limit = np.sqrt(np.minimum.reduceat(np.minimum.reduce(sure, axis=0), runs))
        limit += excess.take(rows[runs])
        limit += SLACK
        limit *= limit
        limits = np.repeat(limit, np.diff(runs, append=rows.size)) if runs.size < rows.size else limit
        kept = np.flatnonzero((best <= limits).T)
        tile = kept // WIDTH
        return rows.take(tile), k.take(kept % WIDTH * rows.size + tile)


def _squares(below: Floats, above: Floats) -> Floats:
    """The squared distance from a box, given how far below and above it something is in x and y side by side."""
    gap = np.maximum(below, above, out=below)
    np.maximum(gap, 0.0, out=gap)
    gap *= gap
    return gap[:, 0::2] + gap[:, 1::2]


def area(ring: Floats) -> float:
    """The signed area inside a closed chain, positive where it runs counter-clockwise."""
    x, y = (ring - ring[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
