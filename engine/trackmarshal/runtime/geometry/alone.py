"""One hull against one segment of a border in plain numbers: the steps of `Sweeps` and `Approach`, for which arrays take longer than numbers."""

from __future__ import annotations

import math

from trackmarshal.runtime.geometry.approach import FARTHEST
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.sweep import SHORTEST, Sweeps

_NONE = SHORTEST * SHORTEST


def distance(border: Border, sweeps: Sweeps, row: int, k: int) -> tuple[float, bool | None]:
    """How far a hull is from a segment that does not enter it [m]; and, where no other is nearer to it, whether it lies left of the border: None
    where that takes a closer look."""
    (ax, ay, ex, ey, whole, length) = border.table[:, k].tolist()
    sx, sy = sweeps.position[:, row].tolist()
    sx, sy = ax - sx, ay - sy
    to_line, to_corner, to_side, left = FARTHEST, math.inf, FARTHEST, False
    for x, y, gx, gy, square in _outline(sweeps, row):
        cx, cy = x - sx, y - sy
        along = ex * cx + ey * cy
        if 0.0 < along < whole:
            side = ex * cy - ey * cx
            left |= side > 0.0
            to_line = min(to_line, abs(side))
        to_corner = min(to_corner, cx * cx + cy * cy)
        if square >= _NONE and 0.0 > gx * cx + gy * cy > -square:
            to_side = min(to_side, abs((gy * cx - gx * cy) / math.sqrt(square)))
    to_line /= length
    found = min(to_line, math.sqrt(to_corner), to_side)
    if border.spikes is not None and border.spikes[k]:
        return found, None
    if to_line > found:
        bend = int(border.bend[k])
        return found, bend > 0 if bend else None
    return found, left


def _outline(sweeps: Sweeps, row: int) -> list[tuple[float, float, float, float, float]]:
    """The corners of a hull, with the vector of the side that begins there and its square: 0 where none does."""
    (centre_x, centre_y), (ahead_x, ahead_y), (left_x, left_y), (unit_x, unit_y) = sweeps.frame[
        ..., row
    ].tolist()
    turn_cos, turn_sin = sweeps.turn_of(row)
    corners = []
    for f in (0, 1):
        x, y = centre_x[f], centre_y[f]
        fx, fy, bx, by = (
            ahead_x[f] + left_x[f],
            ahead_y[f] + left_y[f],
            left_x[f] - ahead_x[f],
            left_y[f] - ahead_y[f],
        )
        corners.append([(x + fx, y + fy), (x + bx, y + by), (x - fx, y - fy), (x - bx, y - by)])
    first, second = corners
    ux, uy = unit_x[0], unit_y[0]
    at_first, at_second = [], []
    for i, (side_x, side_y) in enumerate(((ux, uy), (-uy, ux), (-ux, -uy), (uy, -ux))):
        (x, y), (bx, by) = first[i], second[i - 1]
        dx, dy = x - bx, y - by
        along, across = dx * side_x + dy * side_y, dy * side_x - dx * side_y
        at_first.append(along >= 0.0)
        at_second.append(turn_cos * along + turn_sin * across >= 0.0)
    found = []
    for i in (0, 1, 2, 3):
        n = i - 3  # the next one
        to = first[n] if at_first[n] else second[i] if at_second[i] else second[i - 1]
        found.append(_side(first[i], to, at_first[i] or at_second[i] or at_first[n]))
    for i in (0, 1, 2, 3):
        n = i - 3
        to = (first[i] if at_first[n] else first[n]) if at_second[n] else second[n]
        found.append(_side(second[i], to, not (at_second[i] and at_first[n] and at_second[n])))
    return found


def _side(
    begin: tuple[float, float], end: tuple[float, float], there: bool
) -> tuple[float, float, float, float, float]:
    x, y = begin
    gx, gy = end[0] - x, end[1] - y
    return x, y, gx, gy, gx * gx + gy * gy if there else 0.0
