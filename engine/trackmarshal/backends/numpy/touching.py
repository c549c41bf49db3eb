"""Footprints that touch: margins next to zero by the steps of the definitions, so that all evaluators see one verdict.

Corners of a footprint's two poses that lie on one line are corners of their hull or not, as rounding has it. By which, margins differ
in the last bits: of no account, but for the sign of a margin that is zero or nearly so.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from trackmarshal.backends.reference import geometry
from trackmarshal.backends.reference.geometry.curve import curve, placed
from trackmarshal.backends.reference.geometry.region import Outside, Region, hull_margin
from trackmarshal.points import sized, usable
from trackmarshal.runtime.geometry.border import Border

#: Margins that are no farther from zero are computed anew; far more than rounding makes of tracks of any size [m].
NEAR = 1e-6
#: Segments of a border that are farther from a hull than this are not what it touches [m].
APART = 1.0


def settled(
    margin: Any, args: Sequence[Any], exactly: Callable[[tuple[int, ...], Sequence[float]], float]
) -> Any:
    """Margins [m] with those next to zero replaced: `exactly` gives one, of its place and the arguments there."""
    near = np.abs(margin) <= NEAR
    if 1 not in near.tobytes():
        return margin
    margin = np.array(margin)
    whole = [np.broadcast_to(arg, margin.shape) for arg in args]
    known: dict[tuple[float, ...], float] = {}  # what stands, touches at every sample alike
    for place in np.argwhere(near).tolist():
        at = tuple(place)
        row = tuple(float(arg[at]) for arg in whole)
        key = (float(at[0]) if at else 0.0, *row)
        if key not in known:
            known[key] = exactly(at, row)
        margin[at] = known[key]
    return margin


def clear(row: Sequence[float]) -> float:
    """The signed distance of what a box (two poses, length, width) sweeps from another (a pose, length, width); curvatures come last."""
    x0, y0, heading0, x1, y1, heading1, length, width, x, y, heading, box_length, box_width, *bend = row
    return geometry.clear_margin(
        (x0, y0, heading0), (x1, y1, heading1), length, width, (x, y, heading), box_length, box_width, bend
    )


def inside(border: Border, row: Sequence[float]) -> float:
    """The signed margin of what a box sweeps inside a region, whose border it touches."""
    x0, y0, heading0, x1, y1, heading1, length, width, *bend = row
    first, second = (x0, y0, heading0), (x1, y1, heading1)
    reach = length + width + APART
    if bend:  # a way along a curve is nearer to its chord than that is long
        more = curve(placed(first), placed(second), bend, length, width).more
        reach += math.hypot(x1 - x0, y1 - y0) + more
    left, right = min(x0, x1) - reach, max(x0, x1) + reach
    low, high = min(y0, y1) - reach, max(y0, y1) + reach
    ahead = ((border.ay >= low) | (border.by >= low)) & ((border.ay <= high) | (border.by <= high))
    ahead &= (border.ax >= left) | (border.bx >= left)  # what a ray along +x from the hull may cross
    near = ahead & ((border.ax <= right) | (border.bx <= right))
    region = Region(_segments(border, near), (_segments(border, ahead),))
    return hull_margin(region, first, second, length, width, bend)


def meets(border: Border, row: Sequence[float]) -> float:
    """How far what a box sweeps reaches into a region [m]; negative: how far apart they are. The reference's steps, with the segments that matter."""
    x0, y0, heading0, x1, y1, heading1, length, width, *bend = row
    if not usable(*row) or not sized(length, width):
        return math.nan
    first, second = (x0, y0, heading0), (x1, y1, heading1)
    reach = length + width + 2.0 * math.hypot(x1 - x0, y1 - y0)  # of all that is swept, from the first place
    if bend:
        reach += curve(placed(first), placed(second), bend, length, width).more
    # The nearest segment is at most `reach` farther from any part of what is swept, so one that is twice as far beyond it is nearest to none.
    ex, ey, px, py = border.bx - border.ax, border.by - border.ay, x0 - border.ax, y0 - border.ay
    along = np.clip((ex * px + ey * py) / (ex * ex + ey * ey), 0.0, 1.0)
    away = np.hypot(px - along * ex, py - along * ey)
    near = away <= away.min() + 2.0 * reach + APART
    low, high = y0 - reach - APART, y0 + reach + APART
    ahead = ((border.ay >= low) | (border.by >= low)) & ((border.ay <= high) | (border.by <= high))
    ahead &= (border.ax >= x0 - reach - APART) | (border.bx >= x0 - reach - APART)
    region = Outside(_segments(border, near), (_segments(border, ahead),))
    return -hull_margin(region, first, second, length, width, bend)


def _segments(border: Border, which: Any) -> tuple[tuple[tuple[float, float], tuple[float, float]], ...]:
    columns = (column[which].tolist() for column in (border.ax, border.ay, border.bx, border.by))
    return tuple(((ax, ay), (bx, by)) for ax, ay, bx, by in zip(*columns))
