"""Distances of points from the paths of many trajectories at once, each point from the path of its own case."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from trackmarshal.runtime.geometry.arrays import LIMIT, Bools, Floats


def distance_to_paths(
    x: ArrayLike, y: ArrayLike, path_x: ArrayLike, path_y: ArrayLike, lengths: ArrayLike
) -> Floats:
    """Distances [m], (cases, points), of points (cases, points) from paths (cases, samples).

    `lengths` says how many samples of each path count; the rest is padding. A path with fewer than two distinct points, or
    with an unusable one, has no distance: NaN.
    """
    points = np.stack([np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)])
    path = np.stack([np.asarray(path_x, dtype=np.float64), np.asarray(path_y, dtype=np.float64)])
    there: Bools = np.arange(path.shape[2]) < np.asarray(lengths, dtype=np.intp)[:, None]
    sound: Bools = np.logical_and.reduce(np.abs(path) <= LIMIT, axis=0)
    fine: Bools = np.logical_and.reduce(sound | ~there, axis=1)
    usable = np.logical_and.reduce(np.abs(points) <= LIMIT, axis=0) & fine[:, None]
    points = np.where(usable, points, 0.0)[..., None]
    path = np.where(there & fine[:, None], path, 0.0)[:, :, None]
    ex, ey = path[..., 1:] - path[..., :-1]
    square = ex * ex + ey * ey
    real = there[:, None, 1:] & (square > 0.0)
    (rx, sx), (ry, sy) = ((seen[..., :-1], seen[..., 1:]) for seen in points - path)
    along = ex * rx + ey * ry
    line = np.abs(ex * ry - ey * rx) / np.sqrt(np.where(real, square, 1.0))
    ends = np.sqrt(np.minimum(rx * rx + ry * ry, sx * sx + sy * sy))
    distance = np.where(real, np.where((along > 0.0) & (along < square), line, ends), np.inf)
    nearest: Floats = distance.min(axis=2, initial=np.inf)
    return np.where(usable & real.any(axis=2), nearest, np.nan)
