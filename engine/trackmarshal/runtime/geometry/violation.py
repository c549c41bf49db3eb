"""By how much hulls fail to be inside a region: how far out their corners are, how deep in them the border is."""

from __future__ import annotations

import numpy as np

from trackmarshal.runtime.geometry.approach import Approach
from trackmarshal.runtime.geometry.arrays import SLACK, Floats, Ints, starts_of
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.sweep import Sweeps

#: The margin of a hull that the border enters by less than any measure here can show.
LEAST = -2.2250738585072014e-308


def violation(
    border: Border, sweeps: Sweeps, approach: Approach, entering: Ints, bad: Ints, around: tuple[Ints, Ints]
) -> Floats:
    """The negative margins of the hulls `bad`, of which the pairs `entering` name segments that enter them;
    `around` pairs their corners (eight times as many as hulls, the first of each first) with the segments near them.

    Minus the largest of: the distance from the border of each corner outside the region; the depth inside the hull of each
    border vertex strictly inside. Without either, minus the depth of the middle of a segment's part inside the hull.
    """
    worst = np.zeros(sweeps.size)
    worst[bad] = _corners_outside(border, sweeps, bad, *around)
    is_bad = np.zeros(sweeps.size, dtype=bool)
    is_bad[bad] = True
    pairs = np.flatnonzero(is_bad[approach.rows])
    depth = np.fmin.reduce(approach.depth[:, pairs], axis=0)
    inside = depth > 0.0
    np.maximum.at(worst, approach.rows[pairs[inside]], depth[inside])
    slivers = entering[worst[approach.rows[entering]] == 0.0]
    if slivers.size:
        np.maximum.at(worst, approach.rows[slivers], approach.middles(slivers))
    return np.minimum(LEAST, -worst[bad])


def _corners_outside(border: Border, sweeps: Sweeps, bad: Ints, rows: Ints, k: Ints) -> Floats:
    """The largest distance from the border of the corners of hulls that are outside the region; 0 where none is."""
    x, y = sweeps.position[:, bad]
    cx, cy = sweeps.sides[0][:, bad], sweeps.sides[1][:, bad]
    cx, cy, x, y = cx.ravel()[rows], cy.ravel()[rows], x[rows % bad.size], y[rows % bad.size]
    rx, ry, sx, sy = (
        cx - (border.ax[k] - x),
        cy - (border.ay[k] - y),
        cx - (border.bx[k] - x),
        cy - (border.by[k] - y),
    )
    distance = border.distance_from(rx, ry, sx, sy, k)
    nearest = np.minimum.reduceat(distance, starts_of(rows))
    first = np.flatnonzero(distance == nearest[rows])
    first = first[starts_of(rows[first])]
    left = border.left_from(rx[first], ry[first], sx[first], sy[first], k[first])
    unsure = border.unsure(k[first]) | (nearest < SLACK)
    left = border.left_for_sure(left, unsure, cx[first] + x[first], cy[first] + y[first])
    outside: Floats = np.where(left, 0.0, nearest).reshape(8, bad.size).max(axis=0)
    return outside
