"""A closed track whose borders cross: the union of the quadrilaterals between paired points (a figure of eight)."""

from __future__ import annotations

from collections.abc import Sequence

from trackmarshal.backends.reference.geometry.points import (
    Point,
    distinct,
    meet,
    meeting_place,
    orientation,
    segment,
    side,
)
from trackmarshal.backends.reference.geometry.region import Region, odd_crossings

Side = tuple[Point, Point]


def union_of_quads(left: Sequence[Point], right: Sequence[Point]) -> Region | None:
    """The region of a closed track with paired border points; None where it is no proper union.

    Proper: as many points left as right; each quadrilateral right, next right, next left, left is simple, and all turn
    the same way round; border segments that meet, other than at a common end, cross properly.
    """
    pairs = paired(left, right)
    if pairs is None:
        return None
    corners = [
        distinct([r0, r1, l1, l0], True) for (l0, r0), (l1, r1) in zip(pairs, [*pairs[1:], pairs[0]])
    ]
    if not all(_simple(quad) for quad in corners):
        return None
    areas = [_area(quad) for quad in corners]
    if not (min(areas) > 0.0 or max(areas) < 0.0):
        return None
    quads = tuple(tuple(zip(quad, [*quad[1:], quad[0]])) for quad in corners)
    border = _border(pairs, quads)
    return None if border is None else Region(border, quads)


def paired(left: Sequence[Point], right: Sequence[Point]) -> list[tuple[Point, Point]] | None:
    """Left and right points in pairs, without repetitions of the pair before; None for unequal counts."""
    if len(left) != len(right):
        return None
    pairs: list[tuple[Point, Point]] = []
    for pair in zip(left, right):
        if not pairs or pair != pairs[-1]:
            pairs.append(pair)
    while len(pairs) > 1 and pairs[-1] == pairs[0]:
        pairs.pop()
    return pairs if len(pairs) >= 3 else None


def _border(pairs: Sequence[tuple[Point, Point]], quads: Sequence[Sequence[Side]]) -> tuple[Side, ...] | None:
    """The parts of both borders outside all quadrilaterals but their own, the region on their left."""
    count = len(pairs)
    following = [*pairs[1:], pairs[0]]
    sides = [(r0, r1) for (_, r0), (_, r1) in zip(pairs, following)]
    sides += [(l1, l0) for (l0, _), (l1, _) in zip(pairs, following)]
    cuts: list[list[tuple[float, Point]]] = [[] for _ in sides]
    for i, (a, b) in enumerate(sides):
        for j in range(i + 1, len(sides)):
            c, d = sides[j]
            if a == b or c == d or {a, b} & {c, d} or not meet(a, b, c, d):
                continue
            if 0 in (orientation(a, b, c), orientation(a, b, d), orientation(c, d, a), orientation(c, d, b)):
                return None
            x, y = meeting_place(a, b, c, d)
            for k in (i, j):
                (px, py), (qx, qy) = sides[k]
                cuts[k].append(((qx - px) * (x - px) + (qy - py) * (y - py), (x, y)))
    pieces: list[Side] = []
    for k, (a, b) in enumerate(sides):
        points = distinct([a, *(point for _, point in sorted(cuts[k])), b], False)
        for p, q in zip(points, points[1:]):
            x, y = (p[0] + q[0]) / 2, (p[1] + q[1]) / 2
            if not any(odd_crossings(x, y, quad) for i, quad in enumerate(quads) if i != k % count):
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
    return sum(side(segment(a, p), *q) for p, q in zip(corners[1:], corners[2:]))
