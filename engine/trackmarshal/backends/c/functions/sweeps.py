"""Sweeps along a whole timeline: one call for all of them, which leaves out what cannot be the least margin."""

from __future__ import annotations

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.geometry import shape
from trackmarshal.backends.c.functions.writer import Writer
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme


def sweeps(writer: Writer, node: ir.Quantify, at: c.Scope) -> c.Expr | None:
    """The least margin of sweeps all along a timeline, in one call; None for anything else."""
    body = node.body
    if (
        not writer.known
        or node.guard is not None
        or node.extreme is not Extreme.LEAST
        or not isinstance(body, ir.SweptInside)
    ):
        return None
    free = writer.facts.free(body.length) | writer.facts.free(body.width)
    fields = _along_timeline(body, node.axis, free)
    if not fields or writer.usage.readers[body] != 1:
        return None
    columns = [writer.field(node.axis.signal, name) for name in fields]
    if len(columns) == 3:
        columns.append(c.Name("NULL"))  # straight
    size = [writer.number(each, at) for each in (body.length, body.width)]
    return writer.call(
        "tm_timeline_inside", *shape(writer, body.area), *columns, writer.count(node.axis), *size
    )


def _along_timeline(node: ir.SweptInside, axis: ir.Axis, outside: frozenset[ir.Axis]) -> tuple[str, ...]:
    """The fields x, y, heading and, for a curve, kappa of an axis, where it is about what is swept from each of its samples to the next, else none.

    outside: the axes that the vehicle's length and width depend on.
    """
    if axis.kind != "samples" or axis.width != 1 or axis in outside:
        return ()
    start, end = (*node.start, *node.bend[:1]), (*node.end, *node.bend[1:])
    numbers = (*start, *end)
    fields = tuple(
        number.field for number in numbers if isinstance(number, ir.Column) and number.axis is axis
    )
    offsets = [number.offset for number in numbers if isinstance(number, ir.Column)]
    each = len(start)
    if len(fields) != 2 * each or fields[:each] != fields[each:] or offsets != [-1] * each + [0] * each:
        return ()
    return fields[:each]
