"""Whether a border meets itself: decided exactly, and with the place."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np

from trackmarshal.runtime.geometry.arrays import Floats, Ints, place
from trackmarshal.runtime.geometry.border import BLOCK, Border

#: Pairs of segments that are looked at together.
AT_ONCE = 1 << 21
#: A computed turn that is larger than this share of its two products has the right sign.
CERTAIN = 1e-15


def meeting_fault(border: Border, names: Sequence[str], pairs: tuple[Ints, Ints]) -> str | None:
    """The first place where a border folds back or meets itself; `names` has one for each segment, `pairs` those that meet."""
    folds = np.flatnonzero(border.ex * border.ex[border.next] + border.ey * border.ey[border.next] <= 0.0)
    folds = folds[[_folds_back(border, k) for k in folds.tolist()]] if folds.size else folds
    i, j = pairs
    if folds.size and (not i.size or folds[0] <= i[0]):
        k = folds[0]
        return f"{names[k]} folds back on itself near {place(border.bx[k], border.by[k])}"
    if not i.size:
        return None
    first, second = names[i[0]], names[j[0]]
    where = place(*meeting_place(border, int(i[0]), int(j[0])))
    return (
        f"{first} crosses itself near {where}" if first == second else f"{first} meets {second} near {where}"
    )


def meetings(border: Border) -> tuple[Ints, Ints]:
    """All pairs i < j of segments, in order, that have a point in common other than the one that neighbours share."""
    lows = np.minimum(border.ax, border.bx), np.minimum(border.ay, border.by)
    highs = np.maximum(border.ax, border.bx), np.maximum(border.ay, border.by)
    runs = border.runs
    overlap = np.ones((len(runs), len(runs)), dtype=bool)
    for low, high in zip(lows, highs):
        run_low, run_high = low[runs].min(axis=1), high[runs].max(axis=1)
        overlap &= (run_low[:, None] <= run_high) & (run_low <= run_high[:, None])
    one, other = np.nonzero(np.triu(overlap))
    found: list[tuple[Ints, Ints]] = []
    step = AT_ONCE // (BLOCK * BLOCK)
    for first in range(0, one.size, step):
        i, j = runs[one[first : first + step]][:, :, None], runs[other[first : first + step]][:, None, :]
        near = (i < j) & (border.next[i] != j) & (border.next[j] != i)
        for low, high in zip(lows, highs):
            near &= (low[i] <= high[j]) & (low[j] <= high[i])
        which = np.nonzero(near)
        found.append((i[which[0], which[1], 0], j[which[0], 0, which[2]]))
    i, j = (np.concatenate(part) for part in zip(*found))
    meet = (turn(border, i, j, 0) * turn(border, i, j, 1) <= 0) & (
        turn(border, j, i, 0) * turn(border, j, i, 1) <= 0
    )
    pairs = np.unique(np.stack([i[meet], j[meet]]), axis=1)
    return pairs[0], pairs[1]


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


def _folds_back(border: Border, k: int) -> bool:
    """Whether the border turns round by exactly half a turn at the end of a segment."""
    after = border.next[k]
    xs = (Fraction(float(part)) for part in (border.ax[k], border.bx[k], border.bx[after]))
    ys = (Fraction(float(part)) for part in (border.ay[k], border.by[k], border.by[after]))
    (ax, bx, cx), (ay, by, cy) = xs, ys
    return (bx - ax) * (cy - by) == (by - ay) * (cx - bx) and (bx - ax) * (cx - bx) + (by - ay) * (
        cy - by
    ) < 0
