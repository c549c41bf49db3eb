"""A closed track whose borders cross: the union of the quadrilaterals between paired points (a figure of eight)."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise

from trackmarshal.backends.reference.geometry.region import Region, odd_crossings
from trackmarshal.points import (
    Point,
    along,
    distinct,
    folds_back,
    meet,
    meeting_place,
    orientation,
    same,
    segment,
    side,
)

Side = tuple[Point, Point]


def union_of_quads(left: Sequence[Point], right: Sequence[Point]) -> Region | None:
    """The region of a closed track with paired border points; None where it is no proper union.

    Proper: as many points left as right; each quadrilateral right, next right, next left, left is simple, and all turn
    the same way round; border segments that meet, other than neighbours, cross properly; none folds back.
    """
    pairs = paired(left, right)
    if pairs is None:
        return None
    corners = [distinct([r0, r1, l1, l0], True) for (l0, r0), (l1, r1) in zip(pairs, [*pairs[1:], pairs[0]])]
    if not all(_simple(quad) for quad in corners):
        return None
    areas = [_area(quad) for quad in corners]
    if max(areas) < 0.0:
        return union_of_quads(right, left)
    if min(areas) <= 0.0:
        return None
    quads = tuple(tuple(zip(quad, [*quad[1:], quad[0]])) for quad in corners)
    border = _border(pairs, quads)
    return None if border is None else Region(border, quads)


def paired(left: Sequence[Point], right: Sequence[Point]) -> list[tuple[Point, Point]] | None:
    """Left and right points in pairs, without repetitions; None for unequal counts or tiny steps."""
    if len(left) != len(right):
        return None
    pairs = _distinct(zip(left, right))
    while len(pairs) > 1 and _same(pairs[-1], pairs[0]):
        pairs.pop()
    steps = zip(pairs, [*pairs[1:], pairs[0]])
    if any(p != q and same(p, q) for pair, following in steps for p, q in zip(pair, following)):
        return None
    return pairs if len(pairs) >= 3 else None


def opposite(left: Sequence[Point], right: Sequence[Point], closed: bool) -> bool:
    """Whether points of two borders that have equally many lie opposite each other.

    They do where each quadrilateral from a pair to the next is simple, and all turn the same way round.
    """
    given = list(zip(left, right))
    pairs = _distinct([*given, *given[:1]] if closed else given)
    corners = [distinct([r0, r1, l1, l0], True) for (l0, r0), (l1, r1) in pairwise(pairs)]
    areas = [_area(quad) if _simple(quad) else 0.0 for quad in corners]
    return all(area > 0.0 for area in areas) or all(area < 0.0 for area in areas)


def _distinct(given: Iterable[tuple[Point, Point]]) -> list[tuple[Point, Point]]:
    """Pairs without repetitions of the last one kept."""
    pairs: list[tuple[Point, Point]] = []
    for pair in given:
        if not pairs or not _same(pair, pairs[-1]):
            pairs.append(pair)
    return pairs


def _same(pair: tuple[Point, Point], other: tuple[Point, Point]) -> bool:
    return same(pair[0], other[0]) and same(pair[1], other[1])


def _border(pairs: Sequence[tuple[Point, Point]], quads: Sequence[Sequence[Side]]) -> tuple[Side, ...] | None:
    """The parts of both borders outside all quadrilaterals but their own, the region on their left."""
    steps = list(enumerate(zip(pairs, [*pairs[1:], pairs[0]])))
    rights = [(r0, r1, i) for i, ((_, r0), (_, r1)) in steps if r0 != r1]
    lefts = [(l1, l0, i) for i, ((l0, _), (l1, _)) in reversed(steps) if l0 != l1]
    sides = rights + lefts
    cuts: list[list[Point]] = [[] for _ in sides]
    for i, (a, b, _) in enumerate(sides):
        for j in range(i + 1, len(sides)):
            c, d, _ = sides[j]
            count = len(rights) if j < len(rights) else len(lefts)
            neighbours = (i < len(rights)) == (j < len(rights)) and j - i in (1, count - 1)
            if neighbours and (folds_back(a, b, d) if b == c else folds_back(c, d, b)):
                return None
            if neighbours or not meet(a, b, c, d):
                continue
            if 0 in (orientation(a, b, c), orientation(a, b, d), orientation(c, d, a), orientation(c, d, b)):
                return None
            cuts[i].append(meeting_place(a, b, c, d))
            cuts[j].append(cuts[i][-1])
    pieces: list[Side] = []
    for (a, b, own), places in zip(sides, cuts):
        way = segment(a, b)
        points = distinct([a, *sorted(places, key=lambda p: along(way, *p)), b], False)
        for p, q in pairwise(points):
            x, y = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2
            if not any(odd_crossings(x, y, quad) for i, quad in enumerate(quads) if i != own):
                pieces.append((p, q))
    return tuple(pieces)


def _simple(corners: Sequence[Point]) -> bool:
    """Whether a triangle or quadrilateral has an inside and no two opposite sides that meet."""
    if len(corners) == 4:
        a, b, c, d = corners
        return not meet(a, b, c, d) and not meet(b, c, d, a)
    return len(corners) == 3


def _area(corners: Sequence[Point]) -> float:
    a = corners[0]
    return sum(side(segment(a, p), *q) for p, q in pairwise(corners[1:]))
