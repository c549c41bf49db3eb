"""A closed track whose borders cross: the outline of the quadrilaterals between paired points (a figure of eight)."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from trackmarshal.runtime.geometry.arrays import SAME, Bools, Floats, distinct
from trackmarshal.runtime.geometry.border import Border
from trackmarshal.runtime.geometry.crossings import fold, meeting_place, meetings, turn, turns


def union_of_quads(left: Floats, right: Floats) -> list[Floats] | None:
    """The outline of a closed track with paired border points, in rings with the track on their left.

    None where it is no proper union. Proper: as many points left as right; each quadrilateral right, next right, next left,
    left is simple, and all turn the same way round; border segments that meet, other than neighbours, cross properly;
    none folds back.
    """
    pairs = distinct(np.concatenate([left, right], axis=1), True) if len(left) == len(right) else left[:0]
    if len(pairs) < 3:
        return None
    left, right = pairs[:, :2], pairs[:, 2:]
    next_left, next_right = np.roll(left, -1, axis=0), np.roll(right, -1, axis=0)
    quads = np.stack([right, next_right, next_left, left])
    areas = _areas(quads)
    if areas.max() < 0.0:
        return union_of_quads(right, left)
    if areas.min() <= 0.0 or not _simple(quads).all():
        return None
    forward, backward = (right != next_right).any(axis=1), (left != next_left).any(axis=1)
    tiny = (np.abs(next_right - right) <= SAME).all(axis=1) & forward
    tiny |= (np.abs(next_left - left) <= SAME).all(axis=1) & backward
    if tiny.any() or min(forward.sum(), backward.sum()) < 3:
        return None
    border = Border([right[forward], next_left[backward][::-1]], closed=True)
    owner = np.concatenate([np.flatnonzero(forward), np.flatnonzero(backward)[::-1]])
    found = list(meetings(border))
    if not found or fold(border) is not None:
        return None
    i, j = (np.concatenate(part) for part in zip(*found))
    if any((turn(border, a, b, end) == 0).any() for a, b in ((i, j), (j, i)) for end in (0, 1)):
        return None
    cuts: dict[int, list[tuple[float, int]]] = {}
    places = np.array([meeting_place(border, int(a), int(b)) for a, b in zip(i, j)]).reshape(-1, 2)
    for number, (a, b) in enumerate(zip(i.tolist(), j.tolist())):
        for k in (a, b):
            dx, dy = places[number] - (border.ax[k], border.ay[k])
            cuts.setdefault(k, []).append((float(border.ex[k] * dx + border.ey[k] * dy), number))
    points = np.concatenate([np.stack([border.ax, border.ay], axis=1), places])
    #: By the cut at which it begins: a run's points and its last cut.
    kept: dict[int, tuple[list[int], int]] = {}
    rings: list[Floats] = []
    for first, last in ((0, int(forward.sum())), (int(forward.sum()), border.size)):
        # The way round: numbers of points, those of cuts after those of the border.
        way = [
            (k, p)
            for k in range(first, last)
            for p in (k, *(border.size + cut for _, cut in sorted(cuts.get(k, []))))
        ]
        begin = next((at for at, (_, p) in enumerate(way) if p >= border.size), None)
        if begin is None:
            if not _covered((points[first] + points[first + 1]) / 2, quads, owner[first]):
                rings.append(points[first:last])
            continue
        way = [*way[begin:], *way[: begin + 1]]
        ends = [at for at, (_, p) in enumerate(way) if p >= border.size]
        for at, end in pairwise(ends):
            run = [p for _, p in way[at : end + 1]]
            middle = next(
                ((points[p] + points[q]) / 2 for p, q in pairwise(run) if (points[p] != points[q]).any()),
                None,
            )
            if middle is not None and not _covered(middle, quads, owner[way[at][0]]):
                kept[run[0]] = run[:-1], run[-1]
    while kept:
        start = cut = next(iter(kept))
        ring: list[int] = []
        while cut in kept:
            run, cut = kept.pop(cut)
            ring += run
        if cut != start:
            return None
        rings.append(distinct(points[ring], True))
    return rings


def opposite(left: Floats, right: Floats, closed: bool) -> bool:
    """Whether points of two borders that have equally many lie opposite each other.

    They do where each quadrilateral from a pair to the next is simple, and all turn the same way round. Raises ValueError for what
    is not finite.
    """
    pairs = np.concatenate([left, right], axis=1)
    pairs = distinct(np.concatenate([pairs, pairs[:1]]) if closed else pairs, False)
    quads = _merged(np.stack([pairs[:-1, 2:], pairs[1:, 2:], pairs[1:, :2], pairs[:-1, :2]]))
    areas = _areas(quads)
    return bool(((areas > 0.0).all() or (areas < 0.0).all()) and _simple(quads).all())


def _merged(quads: Floats) -> Floats:
    """Quadrilaterals in which a corner that repeats the last one kept stands in its place, and what repeats the first at the end in that of the
    first: a step of one border that is none leaves a triangle."""
    for k in (1, 2, 3):
        again = (np.abs(quads[k] - quads[k - 1]) <= SAME).all(axis=1)
        quads[k, again] = quads[k - 1, again]
    last = np.ones(quads.shape[1], dtype=np.bool_)
    for k in (3, 2, 1):
        last &= (np.abs(quads[k] - quads[0]) <= SAME).all(axis=1)
        quads[k, last] = quads[0, last]
    return quads


def _covered(point: Floats, quads: Floats, own: int) -> bool:
    """Whether a point lies in any quadrilateral but its own."""
    inside = np.zeros(quads.shape[1], dtype=bool)
    for a, b in zip(quads, np.roll(quads, -1, axis=0)):
        upward = (a[:, 1] < b[:, 1])[:, None]
        low, high = np.where(upward, a, b), np.where(upward, b, a)
        across = (low[:, 1] <= point[1]) & (point[1] < high[:, 1])
        ex, ey = (high - low).T
        inside ^= across & (ex * (point[1] - low[:, 1]) - ey * (point[0] - low[:, 0]) > 0.0)
    inside[own] = False
    return bool(inside.any())


def _areas(quads: Floats) -> Floats:
    """Twice the signed areas of quadrilaterals (4, n, 2)."""
    b, c, d = quads[1:] - quads[0]
    areas: Floats = (b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]) + (c[:, 0] * d[:, 1] - c[:, 1] * d[:, 0])
    return areas


def _simple(quads: Floats) -> Bools:
    """Whether quadrilaterals with an area have no opposite sides that meet; a side may be a point."""
    fine = np.ones(quads.shape[1], dtype=bool)
    for a, b, c, d in (quads, np.roll(quads, -1, axis=0)):
        proper = (a != b).any(axis=1) & (b != c).any(axis=1) & (c != d).any(axis=1) & (d != a).any(axis=1)
        boxes = (np.minimum(a, b) <= np.maximum(c, d)).all(axis=1) & (
            np.minimum(c, d) <= np.maximum(a, b)
        ).all(axis=1)
        which = np.flatnonzero(proper & boxes)
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = (corner[which].T for corner in (a, b, c, d))
        apart = turns(ax, ay, bx, by, cx, cy) * turns(ax, ay, bx, by, dx, dy) > 0
        apart |= turns(cx, cy, dx, dy, ax, ay) * turns(cx, cy, dx, dy, bx, by) > 0
        fine[which] &= apart
    return fine
