"""Distances of points to the paths of many trajectories at once, each point to the path of its own case."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

#: Numbers beyond this are no position (docs/geometry.md).
LIMIT = 1e9


def distance_to_paths(x: Floats, y: Floats, path_x: Floats, path_y: Floats, lengths: NDArray[np.intp]) -> Floats:
    """Distances in metres, (cases, points), of points (cases, points) to paths (cases, longest).

    `lengths` says how many samples of each path count; the rest is padding. A path with fewer than two different
    points, or with one that is not finite, has no distance: NaN. The formula is that of the reference.
    """
    longest = path_x.shape[1]
    if longest < 2:
        return np.full(x.shape, np.nan)
    ax, ay = path_x[:, None, :-1], path_y[:, None, :-1]
    ex, ey = path_x[:, None, 1:] - ax, path_y[:, None, 1:] - ay
    dx, dy = x[:, :, None] - ax, y[:, :, None] - ay
    foot = ex * dx + ey * dy
    square = ex * ex + ey * ey
    bx, by = x[:, :, None] - path_x[:, None, 1:], y[:, :, None] - path_y[:, None, 1:]
    ends = np.minimum(np.sqrt(dx * dx + dy * dy), np.sqrt(bx * bx + by * by))
    with np.errstate(all="ignore"):
        line = np.abs(ex * dy - ey * dx) / np.sqrt(square)
    distance = np.where((foot > 0.0) & (foot < square), line, ends)
    inside = np.arange(longest - 1) < (lengths - 1)[:, None]
    nearest: Floats = np.where(inside[:, None, :], distance, np.inf).min(axis=2)
    counted = np.arange(longest) < lengths[:, None]
    fine = np.where(counted, (np.abs(path_x) <= LIMIT) & (np.abs(path_y) <= LIMIT), True).all(axis=1)
    moving = (inside & (square[:, 0] > 0.0)).any(axis=1)
    usable = (fine & moving)[:, None] & (np.abs(x) <= LIMIT) & (np.abs(y) <= LIMIT)
    return np.where(usable, nearest, np.nan)
