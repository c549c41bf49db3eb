"""A uniform grid over a border: which segments can be nearest to a shape, read off for many shapes at once."""

from __future__ import annotations

import math

import numpy as np

from trackmarshal.runtime.geometry.arrays import SLACK, Bools, Floats, Ints
from trackmarshal.runtime.geometry.border import Border

#: Segments in a tile, the unit in which a cell's list is read.
SHIFT = 3
WIDTH = 1 << SHIFT
#: The list of a cell is complete for shapes of up to this radius [m]; larger ones are searched for without the grid.
REACH = 8.0
#: Bounds on the grid, for borders that are long or far apart.
MOST_CELLS = 1_000_000
MOST_SAMPLES = 20_000


class Cells:
    """For each cell near the border, its possibly nearest segments, by distance from the cell's middle, in tiles.

    A shape around a point p that lies within a radius r of p and holds all within a radius s of it is nearest to segments no
    farther than r + max(0, |p border| - s) from p, so no farther than |p q| + r + max(0, |q border| + |p q| - s) from the
    middle q of p's cell.
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
        self.middle = np.stack([(ix + 0.5) * size, (iy + 0.5) * size]) + self.corner
        #: Where a grid cell's data is, -1 for a cell without.
        self.data = np.full(self.columns * self.rows, -1, dtype=np.intp)
        self.data[cells] = np.arange(cells.size)
        self._tiles(border)

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

    def _tiles(self, border: Border) -> None:
        spread = math.sqrt(2.0) * self.size
        rows, k, distance = border.near(self.middle[0], self.middle[1], spread + REACH)
        order = np.argsort(rows * (2.0 * distance.max() + 1.0) + distance)
        rows, k, distance = rows[order], k[order], distance[order]
        counts = np.bincount(rows, minlength=self.middle.shape[1])
        first = np.cumsum(counts) - counts
        #: The distance of the border from each cell's middle, and a little more.
        self.clearance = distance[first] + SLACK
        tiles = -(-counts // WIDTH)
        self.first_tile = np.cumsum(tiles) - tiles
        rank = np.arange(k.size) - first[rows]
        tile = self.first_tile[rows] + rank // WIDTH
        #: Segments by place in the tile and tile; a last tile is filled up with one after the last of the border.
        self.tiles = np.full((WIDTH, int(tiles.sum())), border.size)
        self.tiles[rank % WIDTH, tile] = k
        #: From which distance on a cell's i-th tile is needed.
        self.needed = np.full((int(tiles.max()), counts.size), np.inf)
        begins = rank % WIDTH == 0
        self.needed[(rank // WIDTH)[begins], rows[begins]] = distance[begins]

    def tiles_around(
        self, points: Floats, radius: Floats, inner: float | Floats = 0.0
    ) -> tuple[Ints, Ints, Bools | None]:
        """Rows and tiles that hold all segments that may be nearest to shapes of a radius around points, (2, N), or touch them.

        The shapes hold all within the `inner` radius.

        The mask names the rows that the grid cannot tell about, if any: a shape larger than `REACH`, or far from the border.
        """
        at = points - self.corner
        at *= self.density
        np.maximum(at, 0.0, out=at)
        np.minimum(at, self.last, out=at)
        column, row = at.astype(np.intp)
        data = self.data.take(column * self.rows + row)
        unknown: Bools | None = None
        if data.min() < 0 or radius.max() > REACH:
            unknown = (data < 0) | (radius > REACH)
        apart = points - self.middle.take(data, axis=1)
        apart *= apart
        apart = np.sqrt(apart[0] + apart[1])
        limit = apart + self.clearance.take(data)
        limit -= inner
        np.maximum(limit, SLACK, out=limit)
        limit += apart
        limit += radius
        counts = np.add.reduce(self.needed.take(data, axis=1) <= limit, axis=0)
        if unknown is not None:
            counts[unknown] = 0
        ends = counts.cumsum()
        rows = np.arange(data.size).repeat(counts)
        offset = self.first_tile.take(data) - ends
        offset += counts
        tiles = offset.take(rows)
        tiles += np.arange(rows.size)
        return rows, tiles, unknown
