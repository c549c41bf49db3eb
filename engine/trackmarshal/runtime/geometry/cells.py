"""A uniform grid over a border: which segments can be nearest to a shape, read off for many shapes at once."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from trackmarshal.runtime.geometry.arrays import SLACK, Bools, Floats, Ints
from trackmarshal.runtime.geometry.border import Border

#: Segments in a tile, the unit in which a cell's list is read.
SHIFT = 3
WIDTH = 1 << SHIFT
#: The list of a cell is complete for shapes of up to this radius [m]; larger ones are searched for without the grid.
REACH = 8.0
#: Cells across and up of a field: the lists of its cells are made together, when one of them is first read.
FIELD = 8
#: Bounds on the grid, for borders that are long or far apart.
MOST_CELLS = 1_000_000
MOST_SAMPLES = 20_000


class _Lists(NamedTuple):
    """What is made of a grid's lists; nobody writes to it again, so that threads may make lists at once: what one of them loses is made again."""

    #: By cell: whether its list is made, the distance of the border from its middle, and a little more, and where its tiles begin.
    made: Bools
    clearance: Floats
    first_tile: Ints
    #: From which distance on a cell's i-th tile is needed.
    needed: Floats
    #: Segments by place in the tile and tile; a last tile is filled up with one after the last of the border.
    tiles: Ints


class Cells:
    """For each cell near the border, its possibly nearest segments, by distance from the cell's middle, in tiles.

    A shape around a point p that lies within a radius r of p and holds all within a radius s of it is nearest to segments no
    farther than r + max(0, |p border| - s) from p, so no farther than |p q| + r + max(0, |q border| + |p q| - s) from the
    middle q of p's cell.

    A car sees little of a border at a time, and of a new one wants to know soon: lists are made field by field, as they are asked
    for. Whenever that is, they hold what may be nearest.
    """

    def __init__(self, border: Border, size: float) -> None:
        low = np.array([min(border.ax.min(), border.bx.min()), min(border.ay.min(), border.by.min())])
        high = np.array([max(border.ax.max(), border.bx.max()), max(border.ay.max(), border.by.max())])
        spans = high - low
        size = max(
            size,
            float(border.length.sum()) * 2.0 / MOST_SAMPLES,
            math.sqrt(spans[0] * spans[1] / MOST_CELLS),
            0.1,
        )
        self.size, self.density = size, 1.0 / size
        self.columns, self.rows = (spans // size).astype(int).tolist()
        self.columns += 5
        self.rows += 5
        self.corner = (low - 2.0 * size)[:, None]
        self.last = np.array([[self.columns - 1], [self.rows - 1]], dtype=np.float64)
        cells = self._near_border(border)
        ix, iy = cells // self.rows, cells % self.rows
        field = ix // FIELD * (self.rows // FIELD + 1) + iy // FIELD
        order = np.argsort(field, kind="stable")
        cells, ix, iy, field = cells[order], ix[order], iy[order], field[order]
        self.middle = np.stack([(ix + 0.5) * size, (iy + 0.5) * size]) + self.corner
        #: Where a grid cell's data is, -1 for a cell without.
        self.data = np.full(self.columns * self.rows, -1, dtype=np.intp)
        self.data[cells] = np.arange(cells.size)
        self._border = border
        #: Where the cells of a cell's field begin and end.
        self._fields = field.searchsorted(field), field.searchsorted(field, side="right")
        none = np.zeros(cells.size, dtype=np.intp)
        self._lists = _Lists(
            none.astype(np.bool_), np.empty(cells.size), none, np.empty((0, cells.size)), np.empty((WIDTH, 0), dtype=np.intp)
        )  # fmt: skip

    def _near_border(self, border: Border) -> Ints:
        """The cells with a point of the border, and their neighbours."""
        pieces = np.ceil(border.length / (0.5 * self.size)).astype(int) + 1
        k = np.repeat(np.arange(border.size), pieces)
        first = np.repeat(np.cumsum(pieces) - pieces, pieces)
        t = (np.arange(k.size) - first) / np.repeat(pieces, pieces)
        x, y = border.ax[k] + t * border.ex[k], border.ay[k] + t * border.ey[k]
        near = np.zeros((self.columns, self.rows), dtype=bool)
        near[
            ((x - self.corner[0]) // self.size).astype(int), ((y - self.corner[1]) // self.size).astype(int)
        ] = True
        near[1:-1] |= near[2:] | near[:-2]
        near[:, 1:-1] |= near[:, 2:] | near[:, :-2]
        cells: Ints = np.flatnonzero(near)
        return cells

    def _with(self, lists: _Lists, wanted: Ints) -> _Lists:
        """The same, and the lists of the fields of some cells that have none."""
        firsts = np.unique(self._fields[0].take(wanted))
        fields = zip(firsts.tolist(), self._fields[1].take(firsts).tolist())
        cells = np.concatenate([np.arange(first, end) for first, end in fields])
        x, y = self.middle.take(cells, axis=1)
        rows, k, distance = self._border.near(x, y, math.sqrt(2.0) * self.size + REACH)
        # Row by row, nearest first but for rounding, which is far below SLACK.
        order = np.argsort(rows * (2.0 * distance.max() + 1.0) + distance, kind="stable")
        rows, k, distance = rows.take(order), k.take(order), distance.take(order)
        counts = np.bincount(rows, minlength=cells.size)
        begins = np.cumsum(counts) - counts
        tiles = -(-counts // WIDTH)
        first_tile = np.cumsum(tiles) - tiles
        rank = np.arange(k.size) - begins.take(rows)
        place, tile = rank & (WIDTH - 1), rank >> SHIFT
        more = np.full((WIDTH, int(tiles.sum())), self._border.size)
        more[place, first_tile.take(rows) + tile] = k
        needed = np.full((max(len(lists.needed), int(tiles.max())), lists.made.size), np.inf)
        needed[: len(lists.needed)] = lists.needed
        heads = (place == 0).nonzero()[0]
        needed[tile.take(heads), cells.take(rows.take(heads))] = distance.take(heads)
        made, clearance, first = lists.made.copy(), lists.clearance.copy(), lists.first_tile.copy()
        made[cells], clearance[cells] = True, distance.take(begins) + SLACK
        first[cells] = first_tile + lists.tiles.shape[1]
        return _Lists(made, clearance, first, needed, np.concatenate([lists.tiles, more], axis=1))

    def tiles_around(
        self, points: Floats, radius: Floats, inner: float | Floats = 0.0, counted: Bools | None = None
    ) -> tuple[Ints, Ints, Bools | None]:
        """Rows, ascending, and tiles of segments, (WIDTH, rows), that hold all that may be nearest to shapes of a radius around points, (2, N),
        or touch them.

        The shapes hold all within the `inner` radius. Of those that are not `counted` there are none.

        The mask names the rows that the grid cannot tell about, if any: a shape larger than `REACH`, or far from the border.
        """
        at = points - self.corner
        at *= self.density
        np.maximum(at, 0.0, out=at)
        np.minimum(at, self.last, out=at)
        column, row = at.astype(np.intp)
        data = self.data.take(column * self.rows + row)
        lists = self._lists
        made = lists.made.take(data)  # where a cell has no data, of the last one
        if 0 in made.tobytes():
            lists = self._lists = self._with(lists, data[~made])
        unknown: Bools | None = None
        if data.min() < 0 or radius.max() > REACH:
            unknown = (data < 0) | (radius > REACH)
        apart = points - self.middle.take(data, axis=1)
        apart *= apart
        apart = np.sqrt(apart[0] + apart[1])
        limit = apart + lists.clearance.take(data)
        limit -= inner
        np.maximum(limit, SLACK, out=limit)
        limit += apart
        limit += radius
        counts = np.add.reduce(lists.needed.take(data, axis=1) <= limit, axis=0)
        if unknown is not None:
            counts[unknown] = 0
        if counted is not None:
            counts *= counted
        ends = counts.cumsum()
        rows = np.arange(data.size).repeat(counts)
        offset = lists.first_tile.take(data) - ends
        offset += counts
        tiles = offset.take(rows)
        tiles += np.arange(rows.size)
        return rows, lists.tiles.take(tiles, axis=1), unknown
