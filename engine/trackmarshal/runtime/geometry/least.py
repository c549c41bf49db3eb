"""The least margin of each of many groups of hulls: what a bound proves to be farther from the border is not worked out."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from trackmarshal.runtime.geometry import alone
from trackmarshal.runtime.geometry.approach import Approach
from trackmarshal.runtime.geometry.arrays import Bools, Floats, Ints, counts_of, starts_of
from trackmarshal.runtime.geometry.curve import MOST, Curves
from trackmarshal.runtime.geometry.region import AT_ONCE, Region
from trackmarshal.runtime.geometry.sweep import Sweeps

#: A hull that is farther than this from the border lies on one side of it, beyond all rounding [m].
CLEAR = 1e-3
#: Ways of so many pieces at most are bounded piece by piece in the first place, the others only where the bound of the whole leaves
#: them.
FEW = 2
#: So many pairs of hull and segment are looked at faster one by one.
ALONE = 4
#: Ways of any number of pieces that are bounded at once, piece by piece.
PIECEWISE = 256
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


def nearest_inside(
    region: Region, poses: Floats, length: float | Floats, width: float | Floats, bends: Floats | None, size: int, counted: Bools
) -> Floats | None:  # fmt: skip
    """The same of few groups, without a search: margins, of which the least of each group is exact, and no other is less than that.

    None where it takes more than distances from the nearest segments: where the border may meet a hull, or a group is not inside.
    """
    if 0 in _in_one_piece(poses, (length, width), size, counted).tobytes():
        return None
    groups, hulls = np.arange(poses.shape[1]) // size, None
    if bends is None:
        sweeps = Sweeps(poses, length, width)
        usable = sweeps.usable
    else:
        curves = Curves(poses, bends, length, width)
        hulls, usable = curves.hulls(MOST), curves.usable
        sweeps, groups, counted = hulls.sweeps, groups.take(hulls.ways), counted.take(hulls.ways)
    if usable is not None:
        return None
    low, high, _ = boxes = sweeps.boxes()
    rows, k, nearest = region.candidates(sweeps, boxes, groups, counted, hulls)
    if not rows.size or not nearest.min() > region.slack:  # NaN is not
        return None
    bound = _beside(region, sweeps, low[1:], high[1:], rows, starts_of(rows), k)
    if not bound.min() > CLEAR:
        return None
    if hulls is not None:
        bound -= hulls.reach.take(rows)
    of = groups.take(rows)
    starts = starts_of(of)
    if starts.size < poses.shape[1] // size:  # of one nothing is asked
        return None
    counts = counts_of(starts, of.size)
    margin, inside = [math.inf] * poses.shape[1], [False] * starts.size
    least = [math.inf] * starts.size
    limit = np.minimum.reduceat(bound, starts) + region.rounding
    looked = np.zeros(of.size, dtype=np.bool_)
    look = bound <= limit.repeat(counts)
    while 1 in look.tobytes():
        looked |= look
        pairs = look.nonzero()[0]
        for row, distance, left in _distances(region, sweeps, rows.take(pairs), k.take(pairs)):
            way, group = row, int(groups[row])
            if hulls is not None:
                distance -= float(hulls.reach[row])
                way = int(hulls.ways[row])
            margin[way] = min(margin[way], distance)
            if distance < least[group]:
                least[group], inside[group] = distance, left
        look = bound <= np.array(least).repeat(counts)
        look &= ~looked
    # The pair that is nearest to the border of all of a group says on which side its hull lies, and so all of the group.
    return np.array(margin) if all(inside) and min(least) > CLEAR else None


def _distances(region: Region, sweeps: Sweeps, rows: Ints, k: Ints) -> Iterator[tuple[int, float, bool]]:
    """Which hulls are how far from their segments, and whether they lie left of the border, if no other is nearer."""
    if rows.size <= ALONE:
        found = [
            (row, *alone.distance(region.border, sweeps, row, at))
            for row, at in zip(rows.tolist(), k.tolist())
        ]
        if not any(left is None for _, _, left in found):
            yield from ((row, distance, bool(left)) for row, distance, left in found)
            return
    begins = starts_of(rows)
    which = rows.take(begins)
    numbers = np.arange(which.size).repeat(counts_of(begins, rows.size))
    distances, inside = Approach(region.border, sweeps.some(which), numbers, k).nearest()
    yield from zip(which.tolist(), distances.tolist(), inside.tolist())


def _in_one_piece(poses: Floats, sizes: tuple[float | Floats, ...], size: int, counted: Bools) -> Bools:
    """Which groups sweep from pose to pose, each hull from where the one before ends: if the border meets none of them, they
    all lie on the same side of it."""
    of_groups = poses.reshape(6, -1, size)
    begins, ends = of_groups[:3, :, 1:], of_groups[3:, :, :-1]
    if all(isinstance(side, float) for side in sizes) and 0 not in (begins == ends).tobytes():
        return np.ones(of_groups.shape[1], dtype=np.bool_)  # whatever counts, as of most trajectories
    on = np.ones(poses.shape[1], dtype=np.bool_)
    on[1:] = np.logical_and.reduce(poses[:3, 1:] == poses[3:, :-1], axis=0)
    for side in sizes:
        if not isinstance(side, float):
            on[1:] &= side[1:] == side[:-1]
    on[::size] = True
    one: Bools = np.logical_and.reduce((on | ~counted).reshape(-1, size), axis=1)
    return one


class _Search:
    """The search in some groups; writes margins, and which are exact."""

    def __init__(
        self, region: Region, poses: Floats, length: float | Floats, width: float | Floats, bends: Floats | None, size: int,
        counted: Bools, margin: Floats, exact: Bools,
    ) -> None:  # fmt: skip
        self.region, self.poses, self.sizes, self.bends = region, poses, (length, width), bends
        self.margin, self.exact, self.counted = margin, exact, counted
        #: Views of the same, a group a row.
        self.margins, self.exacts = margin.reshape(-1, size), exact.reshape(-1, size)
        self.one = _in_one_piece(poses, (length, width), size, counted)
        self.groups = np.arange(margin.size) // size
        #: Ways that are bounded as a whole though they are of several pieces.
        self.whole = np.zeros(margin.size, dtype=np.bool_)
        step = max(1, AT_ONCE // size) * size
        for first in range(0, margin.size, step):
            self._bound(slice(first, first + step), FEW)
        margin[~counted] = np.inf

    def run(self) -> None:
        """Look at the hull with the least bound of each group, then at whatever may be nearer."""
        wanted = self._nearest(self.counted)
        while wanted.any():
            least = self._looked_at(wanted)
            # The hulls that may still matter; those without a bound do.
            wanted = self.counted & ~(self.exact | (self.margin > least))
            rough = (wanted & self.whole & np.isfinite(least)).nonzero()[0]
            if rough.size:
                for first in range(0, rough.size, PIECEWISE):
                    self._bound(rough[first : first + PIECEWISE], MOST)
                wanted = self._nearest(wanted & ~(self.margin > least))

    def _nearest(self, among: Bools) -> Bools:
        """Those of the least bound of each group, or of none."""
        bounds = np.where(among, self.margin, np.inf).reshape(self.margins.shape)
        nearest = np.fmin.reduce(bounds, axis=1).repeat(bounds.shape[1])
        least: Bools = among & ~(self.margin > nearest + self.region.rounding)
        return least

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

    def _bound(self, part: slice | Ints, most: int) -> None:
        """Bounds on the distance of hulls from the border; infinite for those that are not the nearest of their group, NaN for those
        of which nothing is known. Ways along curves of at most so many pieces are bounded piece by piece."""
        long, wide = (side if isinstance(side, float) else side[part] for side in self.sizes)
        counted, groups = self.counted[part], self.groups[part]
        hulls = ways = None
        if self.bends is None:
            sweeps = Sweeps(self.poses[:, part], long, wide)
            usable = sweeps.usable
        else:
            curves = Curves(self.poses[:, part], self.bends[:, part], long, wide)
            hulls, usable = curves.hulls(most), curves.usable
            sweeps, ways, self.whole[part] = hulls.sweeps, hulls.ways, hulls.whole
        if usable is not None:
            counted = counted & usable
        if ways is not None:
            counted, groups = counted.take(ways), groups.take(ways)
        low, high, _ = boxes = sweeps.boxes()
        rows, k, nearest = self.region.candidates(sweeps, boxes, groups, counted, hulls)
        margin = np.full(self.margin[part].size, np.inf)
        if rows.size:
            starts = starts_of(rows)
            beside = _beside(self.region, sweeps, low[1:], high[1:], rows, starts, k)
            beside[np.isnan(nearest)] = np.nan
            of, least = rows.take(starts), np.minimum.reduceat(beside, starts)
            if hulls is not None:
                least -= hulls.reach.take(of)
                of = hulls.ways.take(of)
                starts = starts_of(of)
                of, least = of.take(starts), np.minimum.reduceat(least, starts)
            margin[of] = least
        if usable is not None:
            margin[~usable] = np.nan
        self.margin[part] = margin


def _beside(
    region: Region, sweeps: Sweeps, low: Floats, high: Floats, rows: Ints, starts: Ints, k: Ints
) -> Floats:
    """A bound on the distance of hulls from segments, pair by pair.

    The greater of: what lies between the footprints and the segment's line; what lies between the long sides, `low` and `high`, of
    the box around the hull and the segment.
    """
    # Of each hull its position, the way to the second footprint, both directions, the box's direction and its sides.
    rest = [sweeps.midway, low, high]
    sized = not (isinstance(sweeps.front, float) and isinstance(sweeps.side, float))
    if sized:
        rest += [np.broadcast_to(size, (1, sweeps.size)) for size in (sweeps.front, sweeps.side)]
    frame = np.concatenate([sweeps.position, sweeps.move, sweeps.units.reshape(4, -1), *rest])
    frame = (
        frame.take(rows, axis=1)
        if starts.size == rows.size
        else frame.take(rows.take(starts), axis=1).repeat(counts_of(starts, rows.size), axis=1)
    )
    ax, ay, ex, ey, _, length = region.border.table.take(k, axis=1)
    x, y, dx, dy = frame[:4]
    unit_x, unit_y = frame[4:8].reshape(2, 2, -1)
    ahead, aside, low, high = frame[8:12]
    front, side = frame[12:] if sized else (sweeps.front, sweeps.side)
    ax -= x
    ay -= y
    # How far both footprints (axis 0) reach across the segment's line, and how far left of it their middles lie.
    across = ex * unit_y
    across -= ey * unit_x
    reach = np.abs(across, out=across)
    reach *= front
    along = ex * unit_x
    along += ey * unit_y
    np.abs(along, out=along)
    along *= side
    reach += along
    start = ex * ay - ey * ax
    end = ex * dy - ey * dx
    end -= start
    first, second = reach
    beside: Floats = np.minimum(-start - first, end - second)
    np.maximum(beside, np.minimum(start - first, -end - second), out=beside)
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
