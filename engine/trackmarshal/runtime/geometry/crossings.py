"""Whether a border meets itself: decided exactly, and with the place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

import numpy as np

from trackmarshal.runtime.geometry.arrays import Floats, Ints, parts_of, place
from trackmarshal.runtime.geometry.border import Border

#: Consecutive boxes that share a box; pairs of groups of them that are looked into together.
GROUP, AT_ONCE = 8, 1 << 10
#: A computed turn that is larger than this share of its two products has the right sign.
CERTAIN = 1e-15


def meeting_fault(border: Border, names: Sequence[str]) -> str | None:
    """The first place where a border folds back or meets itself; `names` has one for each segment."""
    back = fold(border)
    i, j = next(((int(i[0]), int(j[0])) for i, j in meetings(border)), (border.size, 0))
    if back is not None and back <= i:
        return f"{names[back]} folds back on itself near {place(border.bx[back], border.by[back])}"
    if i == border.size:
        return None
    where = place(*meeting_place(border, i, j))
    return (
        f"{names[i]} crosses itself near {where}"
        if names[i] == names[j]
        else f"{names[i]} meets {names[j]} near {where}"
    )


def meetings(border: Border) -> Iterator[tuple[Ints, Ints]]:
    """All pairs i < j of segments, in order, that have a point in common other than the one that neighbours share.

    They come in parts that are not empty, found as they are asked for.
    """
    begins, ends = border.segments[:2], border.segments[2:4]
    for i, j in _overlapping(np.minimum(begins, ends), np.maximum(begins, ends)):
        apart = ((i < j) & (border.next[i] != j) & (border.next[j] != i)).nonzero()[0]
        i, j = i[apart], j[apart]
        meet = turn(border, i, j, 0) * turn(border, i, j, 1) <= 0
        meet &= turn(border, j, i, 0) * turn(border, j, i, 1) <= 0
        if meet.any():
            yield i[meet], j[meet]


def _overlapping(low: Floats, high: Floats) -> Iterator[tuple[Ints, Ints]]:
    """All pairs one <= other of boxes, (2, n), that overlap, in order: in parts that have all pairs of each box that is first in some.

    Boxes around groups of them say which groups are worth looking into.
    """
    count = low.shape[1]
    groups: Iterable[tuple[Ints, Ints]]
    if count == 1:
        groups = [(np.zeros(1, dtype=np.intp), np.zeros(1, dtype=np.intp))]
    else:
        firsts = np.arange(0, count, GROUP)
        groups = _overlapping(
            np.minimum.reduceat(low, firsts, axis=1), np.maximum.reduceat(high, firsts, axis=1)
        )
    within = np.arange(GROUP)
    for left, right in groups:
        for part in parts_of(left, AT_ONCE):
            one = (left[part, None] * GROUP + within)[:, :, None]
            other = (right[part, None] * GROUP + within)[:, None, :]
            overlap = (one <= other) & (other < count)
            one, other = np.minimum(one, count - 1), np.minimum(other, count - 1)
            for axis in (0, 1):
                overlap &= (low[axis, one] <= high[axis, other]) & (low[axis, other] <= high[axis, one])
            pair, row, column = overlap.nonzero()
            one, other = one[pair, row, 0], other[pair, 0, column]
            order = np.argsort(one, kind="stable")
            yield one[order], other[order]


def turn(border: Border, i: Ints, j: Ints, end: int) -> Ints:
    """The exact sign of the turn from segments i to the start (`end` 0) or end (1) of segments j."""
    x, y = (border.bx, border.by) if end else (border.ax, border.ay)
    ax, ay, bx, by, px, py = border.ax[i], border.ay[i], border.bx[i], border.by[i], x[j], y[j]
    return turns(ax, ay, bx, by, px, py)


def turns(ax: Floats, ay: Floats, bx: Floats, by: Floats, px: Floats, py: Floats) -> Ints:
    """The exact sign of the turns a, b, p: 1 left, -1 right, 0 straight."""
    left, right = (bx - ax) * (py - ay), (by - ay) * (px - ax)
    sign: Ints = np.sign(left - right).astype(np.intp)
    for k in np.flatnonzero(np.abs(left - right) <= CERTAIN * (np.abs(left) + np.abs(right))):
        a, b, p = ((Fraction(x[k].item()), Fraction(y[k].item())) for x, y in ((ax, ay), (bx, by), (px, py)))
        exact = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        sign[k] = (exact > 0) - (exact < 0)
    return sign


def meeting_place(border: Border, i: int, j: int) -> tuple[float, float]:
    """Where two segments that meet do so."""
    ax, ay, ex, ey = (float(part[i]) for part in (border.ax, border.ay, border.ex, border.ey))
    cx, cy, gx, gy = (float(part[j]) for part in (border.ax, border.ay, border.ex, border.ey))
    across = ex * gy - ey * gx
    if across == 0.0:
        bx, by, dx, dy = (float(part) for part in (border.bx[i], border.by[i], border.bx[j], border.by[j]))
        x = (max(min(ax, bx), min(cx, dx)) + min(max(ax, bx), max(cx, dx))) / 2
        y = (max(min(ay, by), min(cy, dy)) + min(max(ay, by), max(cy, dy))) / 2
        return x, y
    t = min(1.0, max(0.0, ((cx - ax) * gy - (cy - ay) * gx) / across))
    return ax + t * ex, ay + t * ey


def fold(border: Border) -> int | None:
    """The first segment at whose end the border turns round by exactly half a turn."""
    after = border.next
    back = border.ex * border.ex[after] + border.ey * border.ey[after] <= 0.0
    k: int
    for k in back.nonzero()[0].tolist():
        ax, bx, cx = (Fraction(float(x)) for x in (border.ax[k], border.bx[k], border.bx[after[k]]))
        ay, by, cy = (Fraction(float(y)) for y in (border.ay[k], border.by[k], border.by[after[k]]))
        straight = (bx - ax) * (cy - by) == (by - ay) * (cx - bx)
        if straight and (bx - ax) * (cx - bx) + (by - ay) * (cy - by) < 0:
            return k
    return None
