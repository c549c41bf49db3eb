"""Signed distances between what vehicles sweep and boxes, or what other vehicles sweep."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from trackmarshal.runtime.geometry.arrays import Floats, Ints
from trackmarshal.runtime.geometry.sweep import Sweeps

#: Pairs of bodies that are worked on at once, so that all intermediate arrays stay in the processor's cache.
AT_ONCE = 1024


def boxes_clear(
    x0: ArrayLike,
    y0: ArrayLike,
    heading0: ArrayLike,
    x1: ArrayLike,
    y1: ArrayLike,
    heading1: ArrayLike,
    length: ArrayLike,
    width: ArrayLike,
    box_x: ArrayLike,
    box_y: ArrayLike,
    box_heading: ArrayLike,
    box_length: ArrayLike,
    box_width: ArrayLike,
) -> Floats:
    """The signed distance of what a vehicle sweeps between two poses from a box [m]; all arguments broadcast.

    Apart: the Euclidean distance. Overlapping: minus the shortest move that frees one of the other. NaN for a pose or size
    that is none.
    """
    body = (x0, y0, heading0, x1, y1, heading1, length, width)
    box = (box_x, box_y, box_heading, box_x, box_y, box_heading, box_length, box_width)
    return _clearance(body, box, 4)


def sweeps_clear(
    x0: ArrayLike,
    y0: ArrayLike,
    heading0: ArrayLike,
    x1: ArrayLike,
    y1: ArrayLike,
    heading1: ArrayLike,
    length: ArrayLike,
    width: ArrayLike,
    other_x0: ArrayLike,
    other_y0: ArrayLike,
    other_heading0: ArrayLike,
    other_x1: ArrayLike,
    other_y1: ArrayLike,
    other_heading1: ArrayLike,
    other_length: ArrayLike,
    other_width: ArrayLike,
) -> Floats:
    """The signed distance of what two bodies sweep, each between two poses of its own [m]; all arguments broadcast."""
    body = (x0, y0, heading0, x1, y1, heading1, length, width)
    other = (
        other_x0,
        other_y0,
        other_heading0,
        other_x1,
        other_y1,
        other_heading1,
        other_length,
        other_width,
    )
    return _clearance(body, other, 8)


def _clearance(body: tuple[ArrayLike, ...], other: tuple[ArrayLike, ...], corners: int) -> Floats:
    """Each body's hull is made once, however many others it is held against."""
    own, others = (
        np.broadcast_shapes(*(np.shape(column) for column in columns)) for columns in (body, other)
    )
    shape = np.broadcast_shapes(own, others)
    first, second = _sweeps(body, own), _sweeps(other, others)
    i = np.broadcast_to(np.arange(first.size).reshape(own), shape).ravel()
    j = np.broadcast_to(np.arange(second.size).reshape(others), shape).ravel()
    chunks = (slice(begin, begin + AT_ONCE) for begin in range(0, i.size, AT_ONCE))
    parts = [_pairs(first, second, i[chunk], j[chunk], corners) for chunk in chunks]
    return np.concatenate(parts).reshape(shape) if parts else np.empty(shape)


def _sweeps(columns: tuple[ArrayLike, ...], shape: tuple[int, ...]) -> Sweeps:
    table = np.empty((8, *shape))
    for row, column in enumerate(columns):
        table[row] = column
    flat = table.reshape(8, -1)
    return Sweeps(flat[:6], flat[6], flat[7])


def _pairs(bodies: Sweeps, others: Sweeps, i: Ints, j: Ints, corners: int) -> Floats:
    """The signed distances of hulls i of the bodies from hulls j, of `corners` corners, of the others."""
    x, y, gx, gy, g_square, g_length = bodies.sides.take(i, axis=2)[:, :, None]
    second = others.sides[:, :corners].take(j, axis=2)
    bx, by, ex, ey, square, length = second
    bx += others.x.take(j) - bodies.x.take(i)
    by += others.y.take(j) - bodies.y.take(i)
    if corners == 4:  # the sides of a box, as the reference has them: between corners seen from the body
        for side, corner in ((ex, bx), (ey, by)):
            np.subtract(corner[1:], corner[:-1], out=side[:-1])
            np.subtract(corner[0], corner[-1], out=side[-1])
        square = ex * ex + ey * ey
        length = np.sqrt(square)
    # Axes: corners (and sides) of the body, corners (and sides) of the other, pairs.
    rx, ry = x - bx, y - by
    nearest = np.sqrt(np.minimum.reduce(rx * rx + ry * ry, axis=(0, 1)))
    # The body's corners and the other's sides.
    across = ex * ry - ey * rx
    along = ex * rx + ey * ry
    apart = np.fmin.reduce(np.maximum.reduce(across, axis=0) / length, axis=0)
    beside = (along > 0.0) & (along < square)
    to_side = np.minimum.reduce(np.where(beside, np.abs(across), np.inf), axis=0) / length
    nearest = np.fmin(nearest, np.fmin.reduce(to_side, axis=0))
    # The other's corners and the body's sides.
    across = gy * rx - gx * ry
    along = gx * rx + gy * ry
    apart = np.fmin(apart, np.fmin.reduce(np.maximum.reduce(across, axis=1) / g_length[:, 0], axis=0))
    beside = (along < 0.0) & (along > -g_square)
    to_side = np.minimum.reduce(np.where(beside, np.abs(across), np.inf), axis=1) / g_length[:, 0]
    nearest = np.fmin(nearest, np.fmin.reduce(to_side, axis=0))
    margin: Floats = np.where(apart > 0.0, -apart, nearest)
    for hulls, rows in ((bodies, i), (others, j)):
        if hulls.usable is not None:
            margin[~hulls.usable[rows]] = np.nan
    return margin
