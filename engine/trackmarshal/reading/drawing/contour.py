"""Regions of a plane by what is said at its points: borders found on a grid, by bisection along its lines, and again between those.

The plane goes from 0 to 1 both ways. Whoever is asked is asked about many points at once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Codes = NDArray[np.uint8]
#: Says something of each of n points.
Says = Callable[[Floats, Floats], Codes]
Point = tuple[float, float]
#: A line of the grid by its direction (0: along x), and where it begins.
Edge = tuple[int, int, int]
#: How often a piece of a line is halved, and how far a corner may be from the line that leaves it out.
_HALVED, _STRAIGHT = 34, 6e-5
#: Into how many parts a line of the grid is cut to see what it hides.
_PARTS = 4
#: How often every piece of a border is halved to find it between two lines of the grid.
_BETWEEN = 2


class Border(NamedTuple):
    """A closed line around where one thing is said, with that on its left. beyond: by corner, what is said on the other side; None on the plane's own edge."""

    corners: list[Point]
    beyond: list[int | None]


class Grid:
    """What is said at the corners of columns by rows cells."""

    def __init__(self, says: Says, columns: int, rows: int) -> None:
        self._says = says
        self.columns, self.rows = columns, rows
        self.x, self.y = np.linspace(0.0, 1.0, columns + 1), np.linspace(0.0, 1.0, rows + 1)
        x, y = np.meshgrid(self.x, self.y)
        self.codes = says(x.ravel(), y.ravel()).reshape(rows + 1, columns + 1)

    def borders(self, code: int) -> list[Border]:
        """Around all of which one thing is said."""
        # A ring of nothing around the plane closes what runs into its edge.
        inside = np.pad(self.codes == code, 1)
        if not inside.any():
            return []
        crossings = self._crossings(inside, code)
        following = self._following(inside, code)
        found = []
        while following:
            start, at = next(iter(following.items()))
            loop = [start]
            del following[start]
            while at != start:
                loop.append(at)
                at = following.pop(at)
            corners = [crossings[edge] for edge in loop]
            found.append(
                self._between(Border([(x, y) for x, y, _ in corners], [over for _, _, over in corners]), code)
            )
        return [_straightened(one) for one in found]

    def hides(self) -> bool:
        """Whether something between two corners of a cell is unlike both, which are alike: what is thinner than a cell is not seen on the grid."""
        shares = (np.arange(_PARTS - 1) + 1.0) / _PARTS
        across = self.x[:-1, None] + shares * (self.x[1:, None] - self.x[:-1, None])
        up = self.y[:-1, None] + shares * (self.y[1:, None] - self.y[:-1, None])
        for way, (first, second) in enumerate(((self.codes[:, :-1], self.codes[:, 1:]), (self.codes[:-1], self.codes[1:]))):  # fmt: skip
            if way == 0:
                x, y = np.broadcast_arrays(across[None], self.y[:, None, None])
            else:
                x, y = np.broadcast_arrays(self.x[None, :, None], up[:, None, :])
            said = self._says(x.ravel(), y.ravel()).reshape(x.shape)
            alike = (first == second)[..., None]
            if (alike & (said != first[..., None])).any():
                return True
        return False

    def widest(self, code: int) -> Point | None:
        """A place that lies well inside where one thing is said, as far from all else as there is; None where it is said nowhere."""
        left = np.pad(self.codes == code, 1)
        if not left.any():
            return None
        while True:
            inner = left.copy()
            inner[1:-1, 1:-1] &= left[1:-1, :-2] & left[1:-1, 2:]
            if self.rows > 1:  # of one row, all is the same upwards
                inner[1:-1, 1:-1] &= left[:-2, 1:-1] & left[2:, 1:-1]
            if not inner.any():
                break
            left = inner
        rows, columns = np.nonzero(left)
        near = np.argmin((rows - rows.mean()) ** 2 + (columns - columns.mean()) ** 2)
        return float(self.x[columns[near] - 1]), float(self.y[rows[near] - 1])

    def _crossings(self, inside: NDArray[np.bool_], code: int) -> dict[Edge, tuple[float, float, int | None]]:
        """By line of the padded grid whose ends differ: where one thing ends to be said on it, and what is said beyond."""
        x, y = np.pad(self.x, 1, mode="edge"), np.pad(self.y, 1, mode="edge")
        found: dict[Edge, tuple[float, float, int | None]] = {}
        edges: list[Edge] = []
        ends: list[tuple[Point, Point, int]] = []
        rows, columns = inside.shape
        for way, (right, up) in enumerate(((1, 0), (0, 1))):
            unlike = inside[: rows - up, : columns - right] != inside[up:, right:]
            for j, i in zip(*(one.tolist() for one in np.nonzero(unlike))):
                here, there = (j, i), (j + up, i + right)
                within, without = (here, there) if inside[here] else (there, here)
                place = (float(x[within[1]]), float(y[within[0]]))
                if not (1 <= without[0] <= rows - 2 and 1 <= without[1] <= columns - 2):
                    found[way, j, i] = (*place, None)
                    continue
                edges.append((way, j, i))
                ends.append((place, (float(x[without[1]]), float(y[without[0]])), int(self.codes[without[0] - 1, without[1] - 1])))  # fmt: skip
        if edges:
            begin, end = np.array([one[0] for one in ends]), np.array([one[1] for one in ends])
            placed, beyond = self._halved(begin, end, code)
            for edge, (px, py), over in zip(edges, placed.tolist(), beyond.tolist()):
                found[edge] = (px, py, over)
        return found

    def _halved(self, begin: Floats, end: Floats, code: int) -> tuple[Floats, Codes]:
        """(n, 2): the last places at which it is said between ends at which it is and is not; and (n,) what is said right beyond."""
        begin, end = begin.copy(), end.copy()
        beyond = self._says(end[:, 0], end[:, 1])
        for _ in range(_HALVED):
            middle = (begin + end) / 2.0
            said = self._says(middle[:, 0], middle[:, 1])
            same = said == code
            begin[same], end[~same] = middle[same], middle[~same]
            beyond = np.where(same, beyond, said)
        return begin, beyond

    def _following(self, inside: NDArray[np.bool_], code: int) -> dict[Edge, Edge]:
        """By line of the grid that a border crosses, the one that it crosses next."""
        found: dict[Edge, Edge] = {}
        quarters = inside[:-1, :-1], inside[:-1, 1:], inside[1:, 1:], inside[1:, :-1]
        mixed = (quarters[0] | quarters[1] | quarters[2] | quarters[3]) & ~(quarters[0] & quarters[1] & quarters[2] & quarters[3])  # fmt: skip
        for j, i in zip(*(one.tolist() for one in np.nonzero(mixed))):
            corners = [bool(one[j, i]) for one in quarters]
            edges: list[Edge] = [(0, j, i), (1, j, i + 1), (0, j + 1, i), (1, j, i)]
            leaving = [k for k in range(4) if corners[k] and not corners[(k + 1) % 4]]
            entering = [k for k in range(4) if not corners[k] and corners[(k + 1) % 4]]
            if len(leaving) == 1:
                found[edges[leaving[0]]] = edges[entering[0]]
                continue
            joined = self._middle(j, i) == code  # two corners across: whether they hang together
            for k in leaving:
                found[edges[k]] = edges[(k + 1) % 4 if joined else (k + 3) % 4]
        return found

    def _middle(self, j: int, i: int) -> int:
        """What is said in the middle of a cell of the padded grid."""
        if not (1 <= j <= self.rows and 1 <= i <= self.columns):
            return -1
        x, y = (self.x[i - 1] + self.x[i]) / 2.0, (self.y[j - 1] + self.y[j]) / 2.0
        return int(self._says(np.array([x]), np.array([y]))[0])

    def _between(self, border: Border, code: int) -> Border:
        """The border with corners between those on lines of the grid, each as far aside as it is."""
        for level in range(_BETWEEN):
            reach = 0.5**level / max(self.columns, self.rows)
            corners, beyond = np.array(border.corners), border.beyond
            following = np.roll(corners, -1, axis=0)
            own = [a is not None and b is not None for a, b in zip(beyond, [*beyond[1:], beyond[0]])]
            way = following - corners
            length = np.hypot(way[:, 0], way[:, 1])
            chosen = np.flatnonzero(np.array(own) & (length > 0.0))
            if not chosen.size:
                return border
            middle = (corners[chosen] + following[chosen]) / 2.0
            right = np.stack([way[chosen, 1], -way[chosen, 0]], axis=1) / length[chosen, None]
            here = self._says(middle[:, 0], middle[:, 1]) == code
            away = np.clip(middle + np.where(here[:, None], right, -right) * reach, 0.0, 1.0)
            there = self._says(away[:, 0], away[:, 1]) == code
            found = here != there
            begin, end = (
                np.where(here[:, None], middle, away)[found],
                np.where(here[:, None], away, middle)[found],
            )
            if not len(begin):
                return border
            placed, over = self._halved(begin, end, code)
            new = {
                int(k): (tuple(p), int(o)) for k, p, o in zip(chosen[found], placed.tolist(), over.tolist())
            }
            made, sides = list[Point](), list[int | None]()
            for k, (corner, side) in enumerate(zip(border.corners, beyond)):
                made.append(corner)
                sides.append(side)
                if k in new:
                    made.append(new[k][0])
                    sides.append(new[k][1])
            border = Border(made, sides)
        return border


def _straightened(border: Border) -> Border:
    """The border without corners that lie on the line between others."""
    points, count = np.array(border.corners), len(border.corners)
    kept = {0, count // 2}
    waiting = [(0, count // 2), (count // 2, count)]
    while waiting:
        first, last = waiting.pop()
        if last - first < 2:
            continue
        a, b = points[first], points[last % count]
        between = points[first + 1 : last]
        way = b - a
        length = float(np.hypot(*way))
        aside = between - a
        away = np.abs(aside[:, 0] * way[1] - aside[:, 1] * way[0]) / length if length > 0.0 else np.hypot(aside[:, 0], aside[:, 1])  # fmt: skip
        # What is said beyond changes at a corner, too.
        sides = border.beyond[first : last + 1]
        turn = next((k for k in range(1, len(sides) - 1) if sides[k] != sides[k - 1]), None)
        worst = int(np.argmax(away))
        if away[worst] > _STRAIGHT:
            kept.add(first + 1 + worst)
            waiting += [(first, first + 1 + worst), (first + 1 + worst, last)]
        elif turn is not None:
            kept |= {first + turn, first + turn - 1}
            waiting += [(first, max(first + turn - 1, first + 1)), (first + turn, last)]
    chosen = sorted(kept)
    return Border([border.corners[k] for k in chosen], [border.beyond[k] for k in chosen])


def lines(border: Border, beyond: int) -> list[list[Point]]:
    """The pieces of a border on whose other side one thing is said."""
    count = len(border.corners)
    starts = [k for k in range(count) if border.beyond[k] != beyond]
    if not starts:
        return [[*border.corners, border.corners[0]]]
    found: list[list[Point]] = [[]]
    for step in range(1, count + 1):
        k = (starts[0] + step) % count
        if border.beyond[k] == beyond:
            found[-1].append(border.corners[k])
        elif found[-1]:
            found.append([])
    return [one for one in found if len(one) > 1]
