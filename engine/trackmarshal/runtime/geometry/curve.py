"""The ways of vehicles between two samples, many at once: the pieces of `backends/reference/geometry/curve`, by the same steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from trackmarshal.runtime.geometry.arrays import LIMIT, Bools, Floats, Ints
from trackmarshal.runtime.geometry.sweep import Sweeps, usable_bodies

#: A way is cut into so many pieces at most.
MOST = 32
#: A way is cut until the hull of a piece exceeds what is swept by no more than this for turning, or into `MOST` pieces [m].
WANTED = 0.007
#: Into one piece more for each of these that the way of a corner exceeds [m].
STEPS = 2.0 * WANTED * np.arange(1, MOST)
#: A square of a way's length that is one of no direction [m^2].
NOWHERE = 1e-12
#: What is added to a way is left out where it is less than this: that is rounding [m].
ROUNDING = 1e-9
#: How much less the ends of a way that bends both ways count, for pieces of the whole: of 1, all but 0.26 (docs/geometry.md).
EVEN = 0.74
#: By how much the slope of a clothoid grows unevenly, of its lean times the square of what it turns (docs/geometry.md).
WINDING = 0.03125


class Pieces(NamedTuple):
    """Ways in pieces: `sweeps` of all pieces, those of a way in a row, which begin at `starts`."""

    sweeps: Sweeps
    starts: Ints


class Hulls(NamedTuple):
    """What ways are looked at by, roughly: their pieces, or hulls of the footprints at both ends; those of a way in a row.

    `ways`: of which way; `reach` and `short` as of `Curves`, of the hull: how far the way may reach beyond it, and how much farther than
    it the way may be from anything [m]; `whole`: of each way, whether it is one hull though it is of several pieces.
    """

    sweeps: Sweeps
    ways: Ints
    reach: Floats
    short: Floats
    whole: Bools


class Curves:
    """N ways, from pose to pose, with the curvatures at both.

    `count`: into how many pieces each is cut; `more`: how far beyond the pieces' hulls the vehicle may reach [m]; `reach`: how far
    it, or the hull of a piece, may be beyond the hull of the two footprints at the ends, with `more` [m]; `short`: how
    much farther than that hull from anything what is taken for swept may be (docs/geometry.md) [m]. (N,) each.
    """

    __slots__ = (
        "_ends", "_shape", "count", "length", "more", "poses", "reach", "short", "size", "units", "usable", "width"
    )  # fmt: skip

    def __init__(self, poses: Floats, bends: Floats, length: float | Floats, width: float | Floats) -> None:
        """`poses`: (6, N) as in `Sweeps`; `bends`: (2, N), curvatures [1/m] at both; `length`, `width`: numbers or (N,)."""
        self.size = poses.shape[1]
        poses, self.length, self.width, self.usable = usable_bodies(poses, length, width)
        if not np.abs(bends).max(initial=0.0) <= LIMIT:
            fine: Bools = np.logical_and.reduce(np.abs(bends) <= LIMIT, axis=0)
            bends = np.where(fine, bends, 0.0)
            self.usable = fine if self.usable is None else fine & self.usable
        self.poses = poses
        #: Axes: x and y, first and second pose, way.
        self.units = np.empty((2, 2, self.size))
        np.cos(poses[2::3], out=self.units[0])
        np.sin(poses[2::3], out=self.units[1])
        with np.errstate(all="ignore"):  # of ways that fit nothing, numbers are made and not used
            self._measure(bends)

    def _measure(self, bends: Floats) -> None:
        move = self.poses[3:5] - self.poses[0:2]
        dx, dy = move
        ux, uy = self.units
        along, aside = dx * ux + dy * uy, dx * uy - dy * ux
        square = dx * dx + dy * dy
        way = np.sqrt(square)
        half, side = 0.5 * self.length, 0.5 * self.width
        corner = np.sqrt(half * half + side * side)
        fits = (square > NOWHERE) & (along[0] * along[1] > 0.0)
        fits &= np.logical_and.reduce(np.abs(aside) <= np.abs(along), axis=0)
        slope = first, second = aside / along
        grow = 1.0 + slope * slope
        early, late = bends * way * (grow * np.sqrt(grow))
        turn = second - first
        lean = 0.5 * (early - late)
        sway = -3.0 * (first + second)
        slip = np.abs(lean - sway)
        even = np.abs(0.5 * (early + late) - turn)
        turn, sway, leaning = np.abs(turn), np.abs(sway), np.abs(lean)
        steep = turn + leaning
        steeper = steep * steep
        off = even + WINDING * leaning * steeper
        count = 1 + STEPS.searchsorted(corner * steep)
        turning = corner * (2.0 * leaning + steeper)
        bulge = way * (turn + sway * (1.0 - EVEN / count)) + turning
        more = bulge / (8.0 * count * count) + (0.0625 * (off + slip) * way + 0.5 * corner * off)
        whole = way * (turn + sway * (1.0 - EVEN)) + turning
        if 0 in fits.tobytes():
            odd = (~fits).nonzero()[0]
            more[odd] = self._at_random(odd, way, corner)
            count[odd] = 1
        whole[count == 1] = 0.0  # such a way is that hull, and `more` around it
        more[~(more > ROUNDING)] = 0.0
        self.count, self.more = count, more
        whole *= 0.125
        self.reach = more + whole
        self.short = np.where(count == 1, -more, whole + 0.5 * corner * turn)
        #: What the poses between both ends are made of: dx, dy, slopes at both ends, lean, the sign of the way.
        self._shape = np.array([dx, dy, first, second, lean, np.copysign(1.0, along[0])])

    def _at_random(self, which: Ints, way: Floats, corner: float | Floats) -> Floats:
        """Of some ways how far beyond the hull of both footprints a vehicle reaches that passes anywhere in the circle around the chord, and
        points anywhere between both headings [m]."""
        (first, second), way = self.units.take(which, axis=2).swapaxes(0, 1), way.take(which)
        apart = second - first
        if not (np.count_nonzero(apart) or np.count_nonzero(way)):  # what stands reaches nowhere
            return way
        corner, mean = corner if np.ndim(corner) == 0 else np.asarray(corner).take(which), second + first
        turned = apart[0] * apart[0] + apart[1] * apart[1]
        swing = corner * (turned / (4.0 + 2.0 * np.sqrt(mean[0] * mean[0] + mean[1] * mean[1])))
        found: Floats = swing + (np.minimum(way, corner * np.sqrt(turned)) + 0.5 * way)
        return found

    def hulls(self, most: int) -> Hulls:
        """The pieces of the ways that have `most` at most, and of the others the hulls of the footprints at both ends."""
        whole = self.count > most
        cuts, reach, short = self.count, self.more, -self.more
        if 1 in whole.tobytes():
            cuts = np.where(whole, 1, cuts)
            reach, short = np.where(whole, self.reach, reach), np.where(whole, self.short, short)
        ways = np.arange(self.size).repeat(cuts)
        return Hulls(self._cut(slice(None), cuts).sweeps, ways, reach.take(ways), short.take(ways), whole)

    def pieces(self, which: slice) -> Pieces:
        """The pieces of some ways."""
        return self._cut(which, self.count[which])

    def _cut(self, which: slice, count: Ints) -> Pieces:
        """Some ways in so many equal parts."""
        poses, units = self.poses[:, which], self.units[:, :, which]
        length, width = (
            size if isinstance(size, float) else size[which] for size in (self.length, self.width)
        )
        starts = count.cumsum() - count
        if count.max(initial=1) == 1:
            return Pieces(Sweeps(poses, length, width, units), starts)
        rows = np.arange(count.size).repeat(count)
        place = np.arange(rows.size) - starts.take(rows)
        cuts = count.take(rows)
        inner = place.nonzero()[0]
        points, ahead = self._between(which, rows.take(inner), place.take(inner) / cuts.take(inner))
        # Each piece but the first begins where the one before it ends.
        made, directions = poses.take(rows, axis=1), units.take(rows, axis=2)
        made[0:2, inner], directions[:, 0, inner] = points, ahead
        inner -= 1
        made[3:5, inner], directions[:, 1, inner] = points, ahead
        length, width = (size if isinstance(size, float) else size.take(rows) for size in (length, width))
        return Pieces(Sweeps(made, length, width, directions), starts)

    def _between(self, which: slice, rows: Ints, t: Floats) -> tuple[Floats, Floats]:
        """Where ways are at some part of them, and which way the vehicle points there."""
        dx, dy, slope0, slope1, lean, sign = self._shape[:, which].take(rows, axis=1)
        x0, y0 = self.poses[0:2, which].take(rows, axis=1)
        rest, bump = 1.0 - t, t * (1.0 - t)
        slope = (slope0 * rest + slope1 * t) + lean * bump
        left = bump * (slope0 * rest - slope1 * t)
        ex, ey = dx - slope * dy, dy + slope * dx
        size = np.sqrt(ex * ex + ey * ey) * sign
        points, ahead = np.empty((2, t.size)), np.empty((2, t.size))
        np.add(x0, t * dx - left * dy, out=points[0])
        np.add(y0, t * dy + left * dx, out=points[1])
        np.divide(ex, size, out=ahead[0])
        np.divide(ey, size, out=ahead[1])
        return points, ahead


def least_of(margin: Floats, pieces: Pieces, curves: Curves, which: slice) -> Floats:
    """The margins of ways, of the margins of their pieces."""
    least: Floats = np.minimum.reduceat(margin, pieces.starts) - curves.more[which]
    if curves.usable is not None:
        least[~curves.usable[which]] = np.nan
    return least
