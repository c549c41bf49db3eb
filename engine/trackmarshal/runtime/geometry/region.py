"""A closed region and its border: how far swept hulls and points are inside it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.geometry.approach import Approach
from trackmarshal.runtime.geometry.arrays import (
    SLACK,
    Bools,
    Floats,
    Ints,
    counts_of,
    parts_of,
    points_of,
    starts_of,
)
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.cells import REACH, SHIFT, WIDTH, Cells
from trackmarshal.runtime.geometry.curve import Curves, Hulls, least_of
from trackmarshal.runtime.geometry.sweep import Sweeps
from trackmarshal.runtime.geometry.violation import violation

Singles = NDArray[np.float32]
#: Points and vectors x + iy in single precision: numpy turns them in one go.
Vectors = NDArray[np.complex64]

#: Hulls that are worked on at once, so that all intermediate arrays stay in the processor's cache.
AT_ONCE = 1536
#: Ways along curves that are worked on at once: they are mostly of a few pieces each.
WAYS_AT_ONCE = 512
#: Pairs of a hull and a segment that are worked on at once, for the same reason.
PAIRS_AT_ONCE = 5000
#: Points that are worked on at once, for the same reason.
POINTS_AT_ONCE = 6000
#: A border of at most so many segments has none that are not worth looking at.
FEW = 16
#: How far from a region's points its bounding box is drawn [m].
AROUND = 1e-3
#: More than one, by more than a sum of three numbers is rounded.
ROUNDED = 1.0 + 1e-15
#: Where the place of a segment that is none lies.
FAR = 1e15


class Region:
    """What lies left of closed chains of segments; immutable once built."""

    def __init__(self, rings: Sequence[Floats]) -> None:
        self.border = Border(rings, closed=True)
        #: Beyond these x and y lies no point of the region, however its distance is rounded [m].
        self.box = (
            float(self.border.ax.min()) - AROUND, float(self.border.ax.max()) + AROUND,
            float(self.border.ay.min()) - AROUND, float(self.border.ay.max()) + AROUND,
        )  # fmt: skip
        self._area = abs(sum(area(ring) for ring in rings))
        self._origin = np.array([[self.border.ax[0]], [self.border.ay[0]]])
        self._segments, reach = self._singles()
        #: How much farther than the nearest a segment may seem in single precision [m].
        self.slack = np.float32(SLACK + 16.0 * np.finfo(np.float32).eps * reach)

    @cached_property
    def cells(self) -> Cells:
        """The grid; laid out when first asked for, which of a corridor whose centre line alone is read nobody does."""
        # Cells as large as half a corridor is wide: with the neighbours of the border's cells they cover its inside.
        return Cells(self.border, self._area / float(self.border.length.sum()))

    @cached_property
    def rounding(self) -> float:
        """The slack in double precision, of segments that the grid knows to be near [m]."""
        span = float(self.border.length.max()) + 8.0 * (self.cells.size + REACH)
        return SLACK + 64.0 * float(np.finfo(np.float64).eps) * span

    def _singles(self) -> tuple[Vectors, float]:
        """The middles of the segments and half of each, in single precision, which is enough to rule most of them out; and how far
        they reach from the origin.

        x + iy, of shape (2, segments + 1), of axes: middle and half, segment. The last one is none: it is far away.
        """
        border = self.border
        starts = np.stack([border.ax, border.ay]) - self._origin
        half = 0.5 * np.stack([border.ex, border.ey])
        table = np.full((2, border.size + 1), FAR, dtype=np.complex64)
        table[0, :-1], table[1, :-1], table[1, -1] = _complex(starts + half), _complex(half), 0.0
        return table, float(np.abs(starts).max())

    def signed_distance(self, x: Floats, y: Floats) -> Floats:
        """The distance of points from the border, positive inside; NaN for a point that is none."""
        x, y, fine = points_of(x, y)
        if not x.size:
            return x
        parts = (slice(first, first + POINTS_AT_ONCE) for first in range(0, x.size, POINTS_AT_ONCE))
        margin = np.concatenate([self._signed_distance(x[part], y[part]) for part in parts])
        return margin if fine is None else np.where(fine, margin, np.nan)

    def _signed_distance(self, x: Floats, y: Floats) -> Floats:
        nearest = self._nearest_of_all if self.border.size <= FEW else self._nearest
        k, best = nearest(x, y)
        return np.where(self.border.left_of(x, y, k, best) | (best == 0.0), best, -best)

    def _nearest(self, x: Floats, y: Floats) -> tuple[Ints, Floats]:
        """The segment nearest to each point, and its distance."""
        rows, k = self._around(np.stack([x, y]))
        distance = self.border.distance(x[rows], y[rows], k)
        best = np.minimum.reduceat(distance, starts_of(rows))
        first = (distance == best.take(rows)).nonzero()[0]
        return k[first[starts_of(rows[first])]], best

    def _nearest_of_all(self, x: Floats, y: Floats) -> tuple[Ints, Floats]:
        """The same, looking at every segment: cheaper for a border of a few, a zone's."""
        distance = self.border.distance(x, y, np.arange(self.border.size)[:, None])
        best = np.minimum.reduce(distance, axis=0)
        return (distance == best).argmax(axis=0), best

    def margin_inside(self, poses: Floats, length: float | Floats, width: float | Floats) -> Floats:
        """The signed margin of hulls inside the region: `poses` (6, N), sizes numbers or (N,)."""
        count = poses.shape[1]
        if count <= AT_ONCE:
            return self._margin(Sweeps(poses, length, width)) if count else np.empty(0)
        parts = []
        for first in range(0, count, AT_ONCE):
            chunk = slice(first, first + AT_ONCE)
            long, wide = (size if isinstance(size, float) else size[chunk] for size in (length, width))
            parts.append(self._margin(Sweeps(poses[:, chunk], long, wide)))
        return np.concatenate(parts)

    def margin_along(self, curves: Curves) -> Floats:
        """The same of ways along curves."""
        parts = []
        for first in range(0, curves.size, WAYS_AT_ONCE):
            chunk = slice(first, first + WAYS_AT_ONCE)
            pieces = curves.pieces(chunk)
            parts.append(least_of(self._margin(pieces.sweeps), pieces, curves, chunk))
        return np.concatenate(parts) if parts else np.empty(0)

    def _margin(self, sweeps: Sweeps) -> Floats:
        rows, k, nearest = self.candidates(sweeps, sweeps.boxes())
        touching = ~(nearest > self.slack)
        if rows.size <= PAIRS_AT_ONCE:
            margin = self._judged(sweeps, rows, k, touching)
        else:
            parts = parts_of(rows, PAIRS_AT_ONCE)  # never within a hull
            margin = np.concatenate(
                [self._judged(sweeps, rows[part], k[part], touching[part]) for part in parts]
            )
        return margin if sweeps.usable is None else np.where(sweeps.usable, margin, np.nan)

    def _judged(self, sweeps: Sweeps, rows: Ints, k: Ints, touching: Bools) -> Floats:
        """The margins of consecutive hulls, from all pairs of hull and segment that matter."""
        approach = Approach(self.border, sweeps, rows, k)
        margin, inside = approach.nearest()
        first = rows[0]
        if margin.min() < SLACK:
            # Too close to say on which side the nearest point of the hull is; its middle is far from the border.
            close = (margin < SLACK).nonzero()[0]
            x, y = sweeps.position[:, first + close] + sweeps.middle[:, first + close]
            inside[close] = self.signed_distance(x, y) > 0.0
        entering = approach.entering(touching)
        if entering.size:
            inside[rows[entering] - first] = False
        if not inside.all():
            bad = first + (~inside).nonzero()[0]
            corners = sweeps.sides[:2, :, bad] + sweeps.position[:, None, bad]
            around = self._around(corners.reshape(2, -1))
            margin[bad - first] = violation(self.border, sweeps, approach, entering, bad, around)
        return margin

    def candidates(
        self, sweeps: Sweeps, boxes: tuple[Floats, ...],
        groups: Ints | None = None, counted: Bools | None = None, beyond: Hulls | None = None,
    ) -> tuple[Ints, Ints, Singles]:  # fmt: skip
        """Hulls and segments in pairs: at least all that may make up a hull's distance from the border, or enter it.

        With each a distance that is at most `slack` greater than theirs; NaN where nothing is known. Where `groups` numbers the
        hulls, ascending: at least all that may make up the distance of the nearest hull of each group, of those that are `counted`;
        or, with how far ways along curves go `beyond` them, the least margin of these ways.
        """
        middle = sweeps.position + sweeps.middle
        rows, tiles, unknown = self.cells.tiles_around(middle, sweeps.radius, sweeps.inner, counted)
        k, nearest = tiles[0], np.empty(0, dtype=np.float32)
        if rows.size:
            of = rows if groups is None else groups.take(rows)
            rows, k, nearest = self._culled(sweeps, boxes, rows, tiles, of, beyond)
        if unknown is None:
            return rows, k, nearest
        rows, k, order = self._with_unknown(rows, k, unknown, middle, sweeps.radius)
        more = np.full(rows.size - nearest.size, np.nan, dtype=np.float32)
        return rows, k, np.append(nearest, more)[order]

    def _around(self, points: Floats) -> tuple[Ints, Ints]:
        """Points and segments in pairs: at least all segments that may be nearest to a point."""
        rows, tiles, unknown = self.cells.tiles_around(points, np.zeros(points.shape[1]))
        k = tiles.T.ravel()
        real = (k < self.border.size).nonzero()[0]
        rows, k = rows.take(real >> SHIFT), k.take(real)
        if unknown is None:
            return rows, k
        return self._with_unknown(rows, k, unknown, points, np.zeros(points.shape[1]))[:2]

    def _with_unknown(
        self, rows: Ints, k: Ints, unknown: Bools, points: Floats, radius: Floats
    ) -> tuple[Ints, Ints, Ints]:
        """The same pairs, and after them those of the rows that the grid could not tell about, put in this order."""
        which = unknown.nonzero()[0]
        x, y = points[:, which]
        others, more, _ = self.border.near(x, y, radius[which])
        rows, k = np.concatenate([rows, which[others]]), np.concatenate([k, more])
        order = np.argsort(rows, kind="stable")
        return rows[order], k[order], order

    def _culled(
        self, sweeps: Sweeps, boxes: tuple[Floats, ...], rows: Ints, tiles: Ints, groups: Ints, beyond: Hulls | None
    ) -> tuple[Ints, Ints, Singles]:  # fmt: skip
        """Of the segments in tiles for hulls, in groups: those that may be nearest to a hull of their group, as far as the boxes around
        the hulls tell."""
        low, high, excess = boxes
        ahead, aside = sweeps.midway
        middle, (x, y) = 0.5 * (low + high), sweeps.position - self._origin
        # Of each hull: the middle of its box, its direction turned back, half its length and width.
        frames = np.empty((3, 2, sweeps.size), dtype=np.float32)
        np.add(x, ahead * middle[0] - aside * middle[1], out=frames[0, 0], casting="same_kind")
        np.add(y, aside * middle[0] + ahead * middle[1], out=frames[0, 1], casting="same_kind")
        frames[1, 0], frames[1, 1] = ahead, -aside
        np.multiply(0.5, high - low, out=frames[2], casting="same_kind")
        centre, back, size = _complex(frames.swapaxes(0, 1)).take(rows, axis=1)
        # Axes: middle and half of a segment, place in the tile, tile; and x and y in the direction of the box.
        seen = self._segments.take(tiles, axis=1)
        seen[0] -= centre
        seen *= back
        apart = seen.view(np.float32)
        np.abs(apart, out=apart)
        # What is beyond the box, max(x - half, 0): max(x, half) - half is the same, and several times as fast as numpy is with the number 0.
        sides, (middles, halves) = size.view(np.float32), apart
        np.maximum(middles, sides, out=middles)
        middles -= sides
        np.subtract(np.maximum(middles, halves), halves, out=halves)
        # How near does its middle come for sure, and how near can a segment come to the box at best?
        sure, best = np.abs(seen)
        limit = np.minimum.reduce(sure, axis=0)
        excess = excess + self.slack
        if beyond is None:
            limit += excess.take(rows)
        else:  # in double precision: ways may reach far
            limit = limit + (excess + beyond.short).take(rows)
        runs = starts_of(groups)
        if runs.size < rows.size:
            limit = np.minimum.reduceat(limit, runs).repeat(counts_of(runs, rows.size))
        if beyond is not None:
            limit += (beyond.reach * ROUNDED).take(rows)
            limit = np.minimum(limit, FAR).astype(np.float32)
        near = best <= limit
        some = np.logical_or.reduce(near, axis=0).nonzero()[0]  # of most tiles there is none
        kept = near.take(some, axis=1).T.reshape(-1).nonzero()[0]
        tile, place = some.take(kept >> SHIFT), kept & (WIDTH - 1)
        at = place * rows.size + tile
        return rows.take(tile), tiles.reshape(-1).take(at), best.reshape(-1).take(at)


def _complex(pair: NDArray[Any]) -> Vectors:
    """x and y, along the first axis, as x + iy."""
    made = np.empty(pair.shape[1:], dtype=np.complex64)
    made.real, made.imag = pair
    return made


def area(ring: Floats) -> float:
    """The signed area inside a closed chain, positive where it runs counter-clockwise."""
    x, y = (ring - ring[0]).T
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
