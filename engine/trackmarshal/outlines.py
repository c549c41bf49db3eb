"""What makes the points of a zone or a line unusable, and where: exactly, on the numbers as given."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

from trackmarshal.points import LIMIT, Point, folds_back, meet, meeting_place, orientation, same, usable


class Problem(NamedTuple):
    """What is wrong: in words that follow `the zone`, at which point, and beside which other one; what to do."""

    text: str
    at: int
    other: int | None
    hint: str


@lru_cache(maxsize=64)
def problem(kind: str, points: tuple[Point, ...], repeated: bool = True) -> Problem | None:
    """The first thing that is wrong with the points [m] of a `zone` (a ring, which closes by itself) or a `line`; None where they can be used.

    A zone is what one simple ring encloses. A line may cross itself, as a figure of eight does, and may not run back over itself: a
    place on it would have two stations. repeated: whether a point that stands twice in a row is wrong, too; else it is dropped.
    """
    for index, (x, y) in enumerate(points):
        if not usable(x, y):
            return Problem(
                f"has a point ({x:g}, {y:g}), beyond {LIMIT:g} m", index, None, "coordinates are in m"
            )
    closed = kind == "zone"
    kept: list[int] = []
    for k, point in enumerate(points):
        if not kept or not same(point, points[kept[-1]]):
            kept.append(k)
    while closed and len(kept) > 1 and same(points[kept[-1]], points[0]):
        again = kept.pop()
        if repeated:
            return Problem(
                "repeats its first point at the end", again, 0, "remove it: a zone closes by itself"
            )
    if repeated and len(kept) < len(points):
        again = next(k for k in range(len(points)) if k not in kept)
        return Problem("has the same point twice in a row", again, again - 1, "remove one of them")
    least = 3 if closed else 2
    if len(kept) < least:
        return Problem(f"has fewer than {least} different points", 0, None, "points within 1e-9 m are one")
    if closed and all(orientation(points[kept[0]], points[kept[1]], points[k]) == 0 for k in kept[2:]):
        return Problem(
            "has no area: all of its points lie on one line", kept[-1], None, "a zone encloses something"
        )
    return _turned_back(points, kept, closed) or _met(points, kept, closed)


def _turned_back(points: Sequence[Point], kept: Sequence[int], closed: bool) -> Problem | None:
    """A point at which the way goes back exactly as it came."""
    ring = [*kept, *kept[:2]] if closed else kept
    for before, here, after in zip(ring, ring[1:], ring[2:]):
        if folds_back(points[before], points[here], points[after]):
            where = _place(points[here])
            return Problem(
                f"folds back on itself at {where}", after, here, "remove the point, or move it aside"
            )
    return None


def _met(points: Sequence[Point], kept: Sequence[int], closed: bool) -> Problem | None:
    """Where two sides that do not follow each other meet; of a line, where they run along each other."""
    ends = [*zip(kept, kept[1:]), (kept[-1], kept[0])] if closed else [*zip(kept, kept[1:])]
    for i, j in _near(points, ends):
        if j - i == 1 or (closed and j - i == len(ends) - 1):
            continue
        (a, b), (c, d) = ([points[k] for k in ends[side]] for side in (i, j))
        if meet(a, b, c, d) and (closed or _along(a, b, c, d)):
            where = _place(meeting_place(a, b, c, d))
            said = f"crosses or touches itself near {where}" if closed else f"runs along itself near {where}"
            return Problem(said, ends[j][0], ends[i][0], "is the order of the points right?")
    return None


def _along(a: Point, b: Point, c: Point, d: Point) -> bool:
    """Whether two segments that meet have more than a point in common."""
    if orientation(a, b, c) != 0 or orientation(a, b, d) != 0:
        return False
    axis = 0 if a[0] != b[0] else 1
    (low, high), (left, right) = sorted((a[axis], b[axis])), sorted((c[axis], d[axis]))
    return max(low, left) < min(high, right)


def _near(points: Sequence[Point], ends: Sequence[tuple[int, int]]) -> Iterator[tuple[int, int]]:
    """Pairs of sides that are beside each other in x, the lower number first."""
    xs = [sorted((points[a][0], points[b][0])) for a, b in ends]
    spans = sorted((low, high, side) for side, (low, high) in enumerate(xs))
    open_: list[tuple[float, int]] = []
    for low, high, side in spans:
        open_ = [(until, other) for until, other in open_ if until >= low]
        yield from ((min(side, other), max(side, other)) for _, other in open_)
        open_.append((high, side))


def _place(point: Point) -> str:
    return f"({point[0]:.3f}, {point[1]:.3f})"
