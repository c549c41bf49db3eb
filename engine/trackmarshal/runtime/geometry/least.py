"""The least margin of each of many groups of hulls: what a bound proves to be farther from the border is not worked out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trackmarshal.runtime.geometry.arrays import Bools, Floats, Ints, counts_of, starts_of
from trackmarshal.runtime.geometry.curve import Curves
from trackmarshal.runtime.geometry.region import AT_ONCE, Region, Singles
from trackmarshal.runtime.geometry.sweep import Sweeps

#: A hull that is farther than this from the border lies on one side of it, beyond all rounding [m].
CLEAR = 1e-3
#: Hulls whose bounds are kept at once.
KEPT = 16 * AT_ONCE


def least_inside(
    region: Region,
    poses: Floats,
    length: float | Floats,
    width: float | Floats,
    bends: Floats | None,
    size: int,
    counted: Bools,
) -> tuple[Floats, Bools]:
    """The margins of hulls, or of ways along curves (with `bends`), inside a region, (N,), and which of them are exact.

    As `Region.margin_inside`, but of each group of `size` hulls in a row, only the least margin of those `counted` is sure to be
    exact: the others of them are no less than that, and those that are not exact are greater. Those that do not count are
    infinite.
    """
    count = poses.shape[1]
    margin, exact = np.empty(count), np.zeros(count, dtype=np.bool_)
    step = max(1, KEPT // size) * size
    for first in range(0, count, step):
        part = slice(first, first + step)
        long, wide = (side if isinstance(side, float) else side[part] for side in (length, width))
        bent = None if bends is None else bends[:, part]
        _Search(
            region, poses[:, part], long, wide, bent, size, counted[part], margin[part], exact[part]
        ).run()
    return margin, exact


class _Part(NamedTuple):
    """Hulls from one on, with what their bounds are made of: see `_beside`."""

    first: int
    frame: Floats
    rows: Ints
    k: Ints
    squared: Singles


class _Search:
    """The search in some groups; writes margins, and which are exact."""

    def __init__(
        self, region: Region, poses: Floats, length: float | Floats, width: float | Floats, bends: Floats | None, size: int,
        counted: Bools, margin: Floats, exact: Bools,
    ) -> None:  # fmt: skip
        self.region, self.poses, self.sizes, self.bends = region, poses, (length, width), bends
        #: How far what is swept may be beyond the hulls of the footprints at both ends [m].
        self.beyond = np.zeros(margin.size)
        self.margin, self.exact, self.counted = margin, exact, counted
        #: Views of the same, a group a row.
        self.margins, self.exacts = margin.reshape(-1, size), exact.reshape(-1, size)
        self.one = self._in_one_piece(size)
        self.parts = [self._near(first) for first in range(0, margin.size, AT_ONCE)]
        margin[~counted] = np.inf

    def run(self) -> None:
        """Look at the hull with the least bound of each group, then at whatever may be nearer, by better bounds."""
        least = self._looked_at(self._nearest(self.counted))
        self._closer(least)
        wanted = self._wanted(least)
        if wanted.any():
            least = self._looked_at(self._nearest(wanted) | (wanted & np.isinf(least)))
            while (wanted := self._wanted(least)).any():
                least = self._looked_at(wanted)

    def _wanted(self, least: Floats) -> Bools:
        """The hulls that may still matter; those without a bound do."""
        return self.counted & ~(self.exact | (self.margin > least))

    def _nearest(self, wanted: Bools) -> Bools:
        """Of some hulls the one with the least bound in each group."""
        chosen = np.zeros_like(self.exacts)
        among = np.where(wanted, self.margin, np.inf).reshape(chosen.shape)
        np.put_along_axis(chosen, among.argmin(axis=1)[:, None], True, axis=1)
        return chosen.ravel() & wanted

    def _looked_at(self, wanted: Bools) -> Floats:
        """Work hulls out. Below what margin, or bound, the rest of each group has to be looked at too, hull by hull."""
        chosen = wanted.nonzero()[0]
        long, wide = (side if isinstance(side, float) else side[chosen] for side in self.sizes)
        poses = self.poses[:, chosen]
        self.margin[chosen] = (
            self.region.margin_inside(poses, long, wide)
            if self.bends is None
            else self.region.margin_along(Curves(poses, self.bends[:, chosen], long, wide))
        )
        self.exact[chosen] = True
        least = np.fmin.reduce(self.margins, axis=1, where=self.exacts, initial=np.inf)
        # Where the border meets a hull, or is all but there, nothing follows for the hulls before and after it.
        return np.where(self.one & (least > CLEAR), least, np.inf).repeat(self.margins.shape[1])

    def _in_one_piece(self, size: int) -> Bools:
        """Which groups sweep from pose to pose, each hull from where the one before ends: if the border meets none of them, they
        all lie on the same side of it."""
        on = np.ones(self.margin.size, dtype=np.bool_)
        on[1:] = np.logical_and.reduce(self.poses[:3, 1:] == self.poses[3:, :-1], axis=0)
        for side in self.sizes:
            if not isinstance(side, float):
                on[1:] &= side[1:] == side[:-1]
        on[::size] = True
        one: Bools = np.logical_and.reduce((on | ~self.counted).reshape(-1, size), axis=1)
        return one

    def _near(self, first: int) -> _Part:
        """Hulls with the segments near them; how near the boxes around the hulls are to those becomes their bound."""
        part = slice(first, first + AT_ONCE)
        long, wide = (side if isinstance(side, float) else side[part] for side in self.sizes)
        usable: Bools | None
        if self.bends is None:
            sweeps = Sweeps(self.poses[:, part], long, wide)
            usable = sweeps.usable
        else:
            curves = Curves(self.poses[:, part], self.bends[:, part], long, wide)
            sweeps, usable = curves.straight(), curves.usable
            self.beyond[part] = curves.reach
        low, high, _ = boxes = sweeps.boxes()
        rows, k, squared = self.region.candidates(sweeps, boxes)
        frame = np.concatenate(
            [sweeps.frame[:3].reshape(12, -1), sweeps.position, sweeps.midway, low[1:], high[1:]]
        )
        nearest = np.minimum.reduceat(squared, starts_of(rows))
        self.margin[part] = np.sqrt(nearest, dtype=np.float64) - self.region.slack - self.beyond[part]
        if usable is not None:
            self.margin[part][~usable] = np.nan
        return _Part(first, frame, rows, k, squared)

    def _closer(self, least: Floats) -> None:
        """Better bounds, for hulls whose bound is not above the least that is known."""
        limit = np.where(
            self.exact | ~np.isfinite(least), -1.0, (least + self.region.slack + self.beyond) ** 2
        )
        for first, frame, rows, k, squared in self.parts:
            near = (squared <= limit[first : first + AT_ONCE].take(rows)).nonzero()[0]
            if not near.size:
                continue
            rows = rows.take(near)
            starts = starts_of(rows)
            beside = _beside(self.region, frame, rows, starts, k.take(near))
            # All other segments are farther than the least that is known.
            hulls = first + rows.take(starts)
            self.margin[hulls] = np.minimum.reduceat(beside, starts) - self.beyond.take(hulls)


def _beside(region: Region, frame: Floats, rows: Ints, starts: Ints, k: Ints) -> Floats:
    """A bound on the distance of hulls from segments, pair by pair.

    The greater of: what lies between the footprints and the segment's line; what lies between the long sides of the box around
    the hull and the segment. `frame`: x and y of centre, half length and half width of both footprints; x and y of the position, x
    and y of the box's direction, its low and its high side.
    """
    frame = (
        frame.take(rows, axis=1)
        if starts.size == rows.size
        else frame.take(rows.take(starts), axis=1).repeat(counts_of(starts, rows.size), axis=1)
    )
    ax, ay, ex, ey, _, length = region.border.table.take(k, axis=1)
    x, y, ahead, aside, low, high = frame[12:]
    ax -= x
    ay -= y
    # Axes: centre, half length, half width; footprint; pair. How far a centre lies left of the line, how far that reaches.
    x, y = frame[:12].reshape(3, 2, 2, -1).swapaxes(0, 1)
    across = ex * y
    across -= ey * x
    centre, reach = across[0], np.abs(across[1])
    reach += np.abs(across[2])
    centre -= ex * ay - ey * ax
    beside: Floats = np.minimum.reduce(centre - reach, axis=0)
    centre += reach
    np.maximum(beside, -np.maximum.reduce(centre, axis=0), out=beside)
    beside /= length
    start = ahead * ay - aside * ax
    end = ahead * ey - aside * ex
    end += start
    low -= np.maximum(start, end)
    np.maximum(beside, low, out=beside)
    np.minimum(start, end, out=start)
    start -= high
    np.maximum(beside, start, out=beside)
    beside -= region.rounding
    return beside
