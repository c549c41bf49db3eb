"""Names of array types, and the checks of coordinates that every prepared shape makes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.intp]
Bools = NDArray[np.bool_]

#: Numbers beyond this are no position: the spacing of doubles there exceeds a tenth of a micrometre.
LIMIT = 1e9
#: Points that are no farther apart than this in x and y are the same point [m].
SAME = 1e-9
#: A length or width below this is none [m].
SMALLEST = 1e-6
#: How much farther than the nearest a segment may seem and still be looked at exactly [m].
SLACK = 1e-6


def as_points(points: ArrayLike | Sequence[Sequence[float]]) -> Floats:
    """Points as an (n, 2) array of its own, that cannot be written to."""
    array = np.array(points, dtype=np.float64).reshape(-1, 2)
    array.flags.writeable = False
    return array


def coordinates_fault(name: str, points: Floats, least: int, closed: bool) -> str | None:
    """What makes a chain of points unusable: a coordinate that is none, or too few distinct points."""
    bad = np.flatnonzero(~(np.abs(points) <= LIMIT).all(axis=1))
    if bad.size:
        x, y = points[bad[0]].tolist()
        return f"{name}: point {bad[0]} is ({x:g}, {y:g}), not finite or beyond {LIMIT:g} m"
    if len(distinct(points, closed)) < least:
        return f"{name} has fewer than {least} distinct points"
    return None


def distinct(points: Floats, closed: bool) -> Floats:
    """The points without repetitions of the last one kept; of a closed chain also without its repeated first point."""
    again = np.flatnonzero((np.abs(points[1:] - points[:-1]) <= SAME).all(axis=1))
    if again.size:
        kept, at = np.ones(len(points), dtype=np.bool_), 0
        for last in again.tolist():
            if last >= at:  # else it is no longer the last one kept, or has been compared
                at = last + 1
                while at < len(points) and (np.abs(points[at] - points[last]) <= SAME).all():
                    kept[at] = False
                    at += 1
        points = points[kept]
    while closed and len(points) > 1 and (np.abs(points[-1] - points[0]) <= SAME).all():
        points = points[:-1]
    return points


def place(x: float, y: float) -> str:
    """A point in a message."""
    return f"({x:.3f}, {y:.3f})"


def vector(values: Any) -> Floats:
    """A number or numbers as a one-dimensional array."""
    array = np.asarray(values, dtype=np.float64)
    return array if array.ndim else array.reshape(1)


def points_of(x: Any, y: Any) -> tuple[Floats, Floats, Bools | None]:
    """Points with unusable ones replaced, and a mask of the usable ones, None where all are."""
    px, py = vector(x), vector(y)
    if px.size != py.size:
        px, py = np.broadcast_arrays(px, py)
    fine: Bools = (np.abs(px) <= LIMIT) & (np.abs(py) <= LIMIT)
    return (
        (px, py, None)
        if 0 not in fine.tobytes()
        else (np.where(fine, px, 0.0), np.where(fine, py, 0.0), fine)
    )


def true_in(flags: Bools) -> tuple[Ints, Ints]:
    """Rows and columns of what is true in a table, row by row. Along one axis numpy looks several times as fast as along two."""
    at = flags.reshape(-1).nonzero()[0]
    rows = at // flags.shape[1]
    return rows, at - rows * flags.shape[1]


def starts_of(rows: Ints) -> Ints:
    """Where each run of equal numbers begins."""
    begins = np.empty(rows.size, dtype=np.bool_)
    begins[:1] = True
    np.not_equal(rows[1:], rows[:-1], out=begins[1:])
    return begins.nonzero()[0]


def parts_of(rows: Ints, most: int) -> Iterator[slice]:
    """Ascending numbers in parts of about so many, that never come between equal ones; none is empty."""
    cuts = rows.searchsorted(rows[most::most]).tolist()
    return (slice(*ends) for ends in pairwise(dict.fromkeys([0, *cuts, rows.size])))


def counts_of(starts: Ints, size: int) -> Ints:
    """How long each run is, given where runs begin among so many numbers."""
    counts = np.empty_like(starts)
    np.subtract(starts[1:], starts[:-1], out=counts[:-1])
    counts[-1:] = size - starts[-1:]
    return counts
