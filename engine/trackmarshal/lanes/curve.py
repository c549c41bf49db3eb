"""The middle of a lane as a curve: station, offset and heading of points beside it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Curve:
    """A line of straight pieces, (points, 2) in m, no two points in a row in one place. At both ends it goes on straight."""

    def __init__(self, points: Array) -> None:
        self._start, steps = points[:-1], np.diff(points, axis=0)
        self._length = np.hypot(steps[:, 0], steps[:, 1])
        self._along = steps / self._length[:, None]
        self._station = np.concatenate([[0.0], np.cumsum(self._length)])
        bisected = self._along[:-1] + self._along[1:]
        #: Directions at the points: in corners, half way between both pieces.
        self._at = np.concatenate([self._along[:1], bisected / _norm(bisected)[:, None], self._along[-1:]])

    def places(self, points: Array) -> tuple[Array, Array, Array]:
        """Station and offset (to the left) in m, and the curve's direction in rad, of points (n, 2): beside the place that is nearest.

        The direction turns evenly from corner to corner; where it turns by half a circle or more it has none, and comes out as NaN.
        """
        away = points[:, None] - self._start
        along = np.einsum("nij,ij->ni", away, self._along)
        kept = np.clip(along, 0.0, self._length)
        kept[:, 0] = np.minimum(along[:, 0], self._length[0])
        kept[:, -1] = np.maximum(along[:, -1], 0.0) if kept.shape[1] > 1 else along[:, -1]
        rest = away - kept[..., None] * self._along
        distance = np.hypot(rest[..., 0], rest[..., 1])
        piece = np.argmin(distance, axis=1)
        row = np.arange(len(points))
        on, direction, before = kept[row, piece], self._along[piece], away[row, piece]
        side = direction[:, 0] * before[:, 1] - direction[:, 1] * before[:, 0]
        share = np.clip(on / self._length[piece], 0.0, 1.0)[:, None]
        mixed = (1.0 - share) * self._at[piece] + share * self._at[piece + 1]
        heading = np.where(_norm(mixed) > 0.0, np.arctan2(mixed[:, 1], mixed[:, 0]), np.nan)
        return self._station[piece] + on, np.copysign(distance[row, piece], side), heading


def distances(points: Array, line: Array) -> Array:
    """How far points (n, 2) are from a line of straight pieces, (m, 2); pieces may be of no length."""
    start, steps = line[:-1], np.diff(line, axis=0)
    away, square = points[:, None] - start, np.einsum("ij,ij->i", steps, steps)
    share = np.einsum("nij,ij->ni", away, steps) / np.where(square > 0.0, square, 1.0)
    rest = away - np.clip(share, 0.0, 1.0)[..., None] * steps
    found: Array = np.hypot(rest[..., 0], rest[..., 1]).min(axis=1)
    return found


def _norm(vectors: Array) -> Array:
    found: Array = np.hypot(vectors[:, 0], vectors[:, 1])
    return found
