"""Distances of points from the paths of many trajectories at once, each point from the path of its own case."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from trackmarshal.runtime.geometry.arrays import LIMIT, SAME, Bools, Floats


def distance_to_paths(
    x: ArrayLike, y: ArrayLike, path_x: ArrayLike, path_y: ArrayLike, lengths: ArrayLike
) -> Floats:
    """Distances [m], (cases, points), of points (cases, points) from paths (cases, samples).

    `lengths` says how many samples of each path count; the rest is padding. Samples that repeat the one before are none. From a path that stays in
    one place the distance is that from the place. A path with fewer than two samples, or with an unusable one, has no distance: NaN.
    """
    points = _pair(x, y)
    path = _pair(path_x, path_y)
    there: Bools = np.arange(path.shape[2]) < np.asarray(lengths, dtype=np.intp)[:, None]
    usable: Bools | None = None
    # Mostly all paths are equally long and all points are fine; NaN is not.
    if not (
        0 not in there.tobytes()
        and np.abs(points).max(initial=0.0) <= LIMIT
        and np.abs(path).max(initial=0.0) <= LIMIT
    ):
        sound: Bools = np.logical_and.reduce(np.abs(path) <= LIMIT, axis=0)
        fine: Bools = np.logical_and.reduce(sound | ~there, axis=1)
        usable = np.logical_and.reduce(np.abs(points) <= LIMIT, axis=0) & fine[:, None]
        points = np.where(usable, points, 0.0)
        path = np.where(there & fine[:, None], path, 0.0)
    points, path = points[..., None], path[:, :, None]
    side = path[..., 1:] - path[..., :-1]
    small = np.abs(side) <= SAME
    small = small[0] & small[1]
    if 1 in small.tobytes() and (small & (side != 0.0).any(axis=0)).any():
        path = _merged(path)
        side = path[..., 1:] - path[..., :-1]
    square = _sum(side * side)
    real = square > 0.0
    if usable is not None:
        real &= there[:, None, 1:]
    seen = points - path
    ends = _sum(seen * seen)
    seen = seen[..., :-1]
    along = _sum(side * seen)
    distance = np.sqrt(np.minimum(ends[..., :-1], ends[..., 1:]))
    beside = (along > 0.0) & (along < square)
    with np.errstate(divide="ignore", invalid="ignore"):
        across = np.abs(side[0] * seen[1] - side[1] * seen[0]) / np.sqrt(square)
    distance = np.where(beside, across, distance)
    if usable is None and real.size and 0 not in real.tobytes():
        nearest: Floats = np.minimum.reduce(distance, axis=2)
        return nearest
    nearest = np.minimum.reduce(np.where(real, distance, np.inf), axis=2, initial=np.inf)
    goes = np.logical_or.reduce(real, axis=2)
    if usable is None and goes.size and 0 not in goes.tobytes():  # so it has two samples at least
        return nearest
    begin = ends[..., :1].min(axis=2, initial=np.inf)
    nearest = np.where(goes, nearest, np.sqrt(begin))
    known = there[:, None, 1:].any(axis=2)
    return np.where(known if usable is None else usable & known, nearest, np.nan)


def _merged(path: Floats) -> Floats:
    """Paths (2, cases, 1, samples) in which a sample that repeats the last one kept stands in its place: then no way is between them."""
    merged = path.copy()
    for points in np.moveaxis(merged[:, :, 0], 1, 0):
        kept = 0
        for k in range(1, points.shape[1]):
            if (np.abs(points[:, k] - points[:, kept]) <= SAME).all():
                points[:, k] = points[:, kept]
            else:
                kept = k
    return merged


def _sum(products: Floats) -> Floats:
    x, y = products
    total: Floats = x + y
    return total


def _pair(x: ArrayLike, y: ArrayLike) -> Floats:
    x = np.asarray(x, dtype=np.float64)
    pair = np.empty((2, *x.shape))
    pair[0], pair[1] = x, y
    return pair
