"""How generated code reads its input: a table of each field of a signal once, and of it what columns and samples have."""

from __future__ import annotations

from trackmarshal.backends.numpy.batch import column_index
from trackmarshal.backends.numpy.writing import Writing
from trackmarshal.ir import nodes as ir

#: Numbers that are read from the input as they are.
INPUTS = (ir.Column, ir.Sample, ir.Scalar)
#: Samples of which tables have one of every case at the same place.
ENDS = {0: slice(0, 1), -1: slice(-1, None)}
#: What is read from a table of a signal.
Part = ir.Column | ir.Sample


class Inputs:
    """Expressions of what is read. rank: of arrays."""

    def __init__(self, writing: Writing, rank: int) -> None:
        self._writing = writing
        self.rank = rank

    def table(self, signal: str, field: str, read: str = "table") -> str:
        """The variable of a table; read: `flags` for one of Booleans."""
        return self._writing.once("t", (signal, field), f"b.{read}({signal!r}, {field!r})")

    def column(self, node: ir.Column, read: str = "table") -> str:
        """A field of the variable of an axis, `offset` samples on; before the start it is that of the first one."""
        table = self.table(node.axis.signal, node.field, read)
        if node.offset < 0:
            key = node.axis.signal, node.field, node.offset
            table = self._writing.once("s", key, f"before({table}, {-node.offset})")
        return self.part(table, node)

    def sample(self, node: ir.Sample) -> str:
        """A field of one sample; a table has the first one, and the last one, which is repeated up to the end."""
        if node.index in ENDS:
            return self.part(self.table(node.signal, node.field), node)
        return f"b.sample({node.signal!r}, {node.field!r}, {node.index})"

    def part(self, table: str, node: Part) -> str:
        """What a table has of a column or a sample."""
        place = index(node, self.rank)
        part = f"{table}[{self._writing.hold(place, ('index', repr(place)))}]"
        whole = isinstance(node, ir.Sample) or node.axis.width == 1
        return part if whole else f"{part}.copy()"  # of part of a table, which is in several pieces

    def mask(self, axis: ir.Axis) -> str:
        """The variable of what is there along an axis."""
        return self._writing.once("m", axis, f"b.mask({self._writing.hold(axis)})")


def index(node: Part, rank: int) -> tuple[slice | int | None, ...]:
    """Where a table has a column or a sample, shaped for broadcasting."""
    if isinstance(node, ir.Column):
        return column_index(node.axis, max(0, node.offset), rank)
    if rank == 1:  # of nothing but cases, a sample is one number of each
        return (slice(None), node.index)
    return (slice(None), ENDS[node.index], *(None,) * (rank - 2))
