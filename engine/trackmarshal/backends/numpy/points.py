"""Which points are projected onto a line at once: of samples and elements, however rules bind them, all."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

from trackmarshal.backends.numpy.blocks import Guarding
from trackmarshal.backends.numpy.inputs import ENDS, index
from trackmarshal.ir import nodes as ir


class Table(NamedTuple):
    """All points of a signal, by the fields that say where they are."""

    signal: str
    x: str
    y: str


Point = tuple[ir.Num, ir.Num]
#: By line what is projected onto it, with the blocks that ask for it; none where somebody else does.
Projections = dict[ir.Line, dict[Point | Table, frozenset[Guarding]]]


def projections(
    points: Mapping[ir.Projected, Point], tops: Callable[[ir.Projected], frozenset[Guarding]], rank: int
) -> tuple[Projections, dict[ir.Projected, Point | Table]]:
    """What is projected, and of each node what it is read from.

    points: of each node its own. tops: the formulas in whose blocks a node is worked out; none of one that is worked out whatever holds.
    """
    found: Projections = {}
    source: dict[ir.Projected, Point | Table] = {}
    # The first and the last sample are in a table that is projected whatever holds, which its columns say.
    for node in sorted(points, key=lambda node: isinstance(points[node][0], ir.Sample)):
        point, asking = points[node], tops(node)
        own, table = found.setdefault(node.line, {}), _table(*point, rank)
        among = table is not None and (isinstance(point[0], ir.Column) or own.get(table) == frozenset())
        one = source[node] = table if table is not None and among else point
        before = own.get(one, asking)
        own[one] = before | asking if before and asking else frozenset()
    return found, source


def _table(x: ir.Num, y: ir.Num, rank: int) -> Table | None:
    """The table that a point is a part of; None for one that is not, or not of one alone."""
    if isinstance(x, ir.Column) and isinstance(y, ir.Column):
        fits = min(x.offset, y.offset) >= 0 and index(x, rank) == index(y, rank)
        return Table(x.axis.signal, x.field, y.field) if fits and x.axis.signal == y.axis.signal else None
    if isinstance(x, ir.Sample) and isinstance(y, ir.Sample):
        fits = x.index == y.index and x.index in ENDS
        return Table(x.signal, x.field, y.field) if fits and x.signal == y.signal else None
    return None
