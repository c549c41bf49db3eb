"""Signed distances between what vehicles sweep and boxes, or what other vehicles sweep."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from trackmarshal.runtime.geometry.arrays import LIMIT, SMALLEST, Bools, Floats, Ints, counts_of, starts_of
from trackmarshal.runtime.geometry.curve import Curves
from trackmarshal.runtime.geometry.sweep import Boxes, Sweeps

#: Pairs of bodies that are worked on at once, so that all intermediate arrays stay in the processor's cache.
AT_ONCE = 512
_NEXT = np.array([1, 2, 3, 0])
#: Of pairs whose bounds differ by less than this, and this share of their largest coordinate, either may be the nearer one: far more
#: than rounding makes of any of them, and than next to zero is decided anew [m].
UNSURE, SHARE = 1e-5, 1e-13


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
    *bend: ArrayLike,
) -> Floats:
    """The signed distance of what a vehicle sweeps between two poses from a box [m]; all arguments broadcast.

    Apart: the Euclidean distance. Overlapping: minus the shortest move that frees one of the other. NaN for a pose or size
    that is none. `bend`: the curvatures at both poses [1/m], for a vehicle that follows a curve; nothing for one that goes straight.
    """
    if len(bend) not in (0, 2):
        raise AssertionError(f"a way has no curvatures or two, not {len(bend)}")
    body = _table((x0, y0, heading0, x1, y1, heading1, length, width, *bend))
    box = _table((box_x, box_y, box_heading, box_length, box_width))
    return _clearance(body, box)


def least_clear(
    args: Sequence[ArrayLike], asked: Bools | None, least: bool, floor: Floats | None = None
) -> Floats:
    """What `boxes_clear` gives of its arguments where it is asked for (None: everywhere), and infinity elsewhere.

    asked: of the shape that all arguments broadcast to. least: of each entry along the first axis only the least margin of what is asked
    for counts, so greater ones may be infinite too; what has no margin is NaN all the same. floor: of a shape that broadcasts to it; margins
    are raised to it before it is asked which is the least, so what has none may be infinite where its floor is greater than that.
    """
    body, box = _table((*args[:8], *args[13:])), _table(tuple(args[8:13]))
    shape = np.broadcast_shapes(body.shape[1:], box.shape[1:])
    i, j = _numbered(body, box, shape)
    margin = np.full(i.size, np.inf)
    pairs = np.arange(i.size) if asked is None else asked.reshape(-1).nonzero()[0]
    if pairs.size and least:
        groups = pairs // (i.size // shape[0])
        raised = None if floor is None else np.broadcast_to(floor, shape).reshape(-1).take(pairs)
        pairs = _maybe_least(body, box, i.take(pairs), j.take(pairs), pairs, groups, raised)
    if pairs.size:
        first, i = _used(body.reshape(len(body), -1), i.take(pairs))
        second, j = _used(box.reshape(len(box), -1), j.take(pairs))
        margin[pairs] = _margins(first, second, i, j)
    return margin.reshape(shape)


def _maybe_least(
    body: Floats, box: Floats, i: Ints, j: Ints, pairs: Ints, groups: Ints, floor: Floats | None
) -> Ints:
    """Those of some pairs that may have the least margin of their group (numbers, ascending), or none at all; of margins that are raised to
    a floor, those that may be the least.

    A vehicle is within a disc around the middle of its way, and beyond that by its `reach`; at the first pose it has a disc inside.
    """
    bodies, i = _used(body.reshape(len(body), -1), i)
    boxes, j = _used(box.reshape(len(box), -1), j)
    length, width, long, wide = bodies[6], bodies[7], boxes[3], boxes[4]
    x0, y0, _, x1, y1 = bodies[:5]
    with np.errstate(all="ignore"):
        half_x, half_y = 0.5 * (x1 - x0), 0.5 * (y1 - y0)
        outer = np.sqrt(half_x * half_x + half_y * half_y) + 0.5 * np.sqrt(length * length + width * width)
        if len(bodies) == 10:
            outer += Curves(bodies[:6], bodies[8:], length, width).reach
        inner, box_inner = 0.5 * np.minimum(length, width), 0.5 * np.minimum(long, wide)
        x, y = boxes[0].take(j) - x0.take(i), boxes[1].take(j) - y0.take(i)
        at_most = np.sqrt(x * x + y * y) - (inner.take(i) + box_inner.take(j))
        x -= half_x.take(i)
        y -= half_y.take(i)
        at_least = np.sqrt(x * x + y * y) - (
            outer.take(i) + (0.5 * np.sqrt(long * long + wide * wide)).take(j)
        )
        # What is none has no bounds; of what has none, nothing follows for others.
        none = _none(bodies).take(i) | _none(boxes).take(j)
        at_most[none], at_least[none] = np.inf, -np.inf
        if floor is not None:
            at_most, at_least = np.maximum(at_most, floor), np.maximum(at_least, floor)
        starts = starts_of(groups)
        counts = counts_of(starts, groups.size)
        most = np.minimum.reduceat(at_most, starts)
        scale = max(np.abs(table).max(where=np.abs(table) <= LIMIT, initial=0.0) for table in (bodies, boxes))
        near: Ints = pairs[~(at_least > most.repeat(counts) + (UNSURE + SHARE * scale))]
    return near


def _none(table: Floats) -> Bools:
    """Which columns have a number that is none, or no size: their margins are NaN."""
    sizes = slice(6, 8) if len(table) > 5 else slice(3, 5)
    fine: Bools = np.logical_and.reduce(np.abs(table) <= LIMIT, axis=0)
    fine &= np.logical_and.reduce(table[sizes] >= SMALLEST, axis=0)
    return ~fine


def _used(table: Floats, rows: Ints) -> tuple[Floats, Ints]:
    """The columns of a table that are used, and which of those each row is."""
    used = np.zeros(table.shape[1], dtype=np.bool_)
    used[rows] = True
    if used.all():
        return table, rows
    return table[:, used], (used.cumsum() - 1).take(rows)


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
    body = _table((x0, y0, heading0, x1, y1, heading1, length, width))
    other = _table(
        (other_x0, other_y0, other_heading0, other_x1, other_y1, other_heading1, other_length, other_width)
    )
    return _clearance(body, other)


def _table(columns: tuple[ArrayLike, ...]) -> Floats:
    """Numbers and arrays, broadcast to one shape, a row each."""
    table = np.empty((len(columns), *np.broadcast_shapes(*{np.shape(column) for column in columns})))
    for row, column in enumerate(columns):
        table[row] = column
    return table


def _clearance(body: Floats, other: Floats) -> Floats:
    """From tables of sweeps, and of sweeps or boxes; each hull is made once, however many others it is held against."""
    shape = np.broadcast_shapes(body.shape[1:], other.shape[1:])
    if 0 in shape:
        return np.empty(shape)
    i, j = _numbered(body, other, shape)
    return _margins(body.reshape(len(body), -1), other.reshape(len(other), -1), i, j).reshape(shape)


def _numbered(body: Floats, other: Floats, shape: tuple[int, ...]) -> tuple[Ints, Ints]:
    """Which columns of two tables, flattened, meet where these are broadcast."""
    i, j = (
        np.broadcast_to(np.arange(table[0].size).reshape(table.shape[1:]), shape).reshape(-1)
        for table in (body, other)
    )
    return i, j


def _margins(first: Floats, second: Floats, i: Ints, j: Ints) -> Floats:
    """The signed distances of columns i of a table of bodies from columns j of one of others, pair by pair."""
    others = (
        Sweeps(second[:6], second[6], second[7])
        if len(second) == 8
        else Boxes(second[:3], second[3], second[4])
    )
    if len(first) == 10:
        return _of_curves(Curves(first[:6], first[8:], first[6], first[7]), others, i, j)
    return _in_chunks(Sweeps(first[:6], first[6], first[7]), others, i, j)


def _of_curves(curves: Curves, others: Sweeps | Boxes, i: Ints, j: Ints) -> Floats:
    """The signed distances of what is swept along curves i from hulls j of others."""
    pieces = curves.pieces(slice(None))
    counts = curves.count.take(i)
    starts = counts.cumsum() - counts
    pair = np.arange(i.size).repeat(counts)
    piece = pieces.starts.take(i.take(pair)) + (np.arange(pair.size) - starts.take(pair))
    margin: Floats = np.minimum.reduceat(_in_chunks(pieces.sweeps, others, piece, j.take(pair)), starts)
    margin -= curves.more.take(i)
    if curves.usable is not None:
        margin[~curves.usable[i]] = np.nan
    return margin


def _in_chunks(bodies: Sweeps, others: Sweeps | Boxes, i: Ints, j: Ints) -> Floats:
    chunks = (slice(begin, begin + AT_ONCE) for begin in range(0, i.size, AT_ONCE))
    parts = [_pairs(bodies, others, i[chunk], j[chunk]) for chunk in chunks]
    margin = np.concatenate(parts)
    for hulls, rows in ((bodies, i), (others, j)):
        if hulls.usable is not None:
            margin[~hulls.usable[rows]] = np.nan
    return margin


def _pairs(bodies: Sweeps, others: Sweeps | Boxes, i: Ints, j: Ints) -> Floats:
    """The signed distances of the hulls i of bodies from hulls j of others, pair by pair."""
    x, y, gx, gy, square, length = bodies.sides.take(i, axis=2)[:, :, None]
    shift = (others.position.take(j, axis=1) - bodies.position.take(i, axis=1))[:, None]
    if isinstance(others, Boxes):  # its sides as the reference has them: between corners seen from the body
        bx, by = corners = others.corners.take(j, axis=2) + shift
        ex, ey = corners.take(_NEXT, axis=1) - corners
        other_square = ex * ex + ey * ey
        other_length = np.sqrt(other_square)
    else:
        bx, by, ex, ey, other_square, other_length = others.sides.take(j, axis=2)
        bx += shift[0]
        by += shift[1]
    # Axes: corners (and sides) of the body, corners (and sides) of the other, pairs.
    rx, ry = x - bx, y - by
    # The body's corners and the other's sides, then the other's corners and the body's sides.
    apart, near = _against(ex * ry - ey * rx, ex * rx + ey * ry, other_square, other_length, 0)
    apart_too, near_too = _against(gy * rx - gx * ry, -(gx * rx + gy * ry), square, length[:, 0], 1)
    apart, near = np.fmin(apart, apart_too), np.fmin(near, near_too)
    rx *= rx
    ry *= ry
    rx += ry
    near = np.fmin(near, np.sqrt(np.minimum.reduce(rx, axis=(0, 1))))
    margin: Floats = np.where(apart > 0.0, -apart, near)
    return margin


def _against(
    side: Floats, along: Floats, square: Floats, length: Floats, corners: int
) -> tuple[Floats, Floats]:
    """Corners of one hull (along the axis `corners`) and sides of another: how far the hulls overlap at most across a
    side, and how near a corner comes to the inside of a side. Sides that are none have a length of NaN."""
    beside = along > 0.0
    beside &= along < square
    overlap = np.maximum.reduce(side, axis=corners) / length
    near = np.minimum.reduce(np.where(beside, np.abs(side), np.inf), axis=corners) / length
    return np.fmin.reduce(overlap, axis=0), np.fmin.reduce(near, axis=0)
