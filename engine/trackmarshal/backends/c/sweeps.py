"""Sweeps along a whole timeline: one call for all of them, which leaves out what cannot be the least margin."""

from __future__ import annotations

from trackmarshal.ir import nodes as ir


def along_timeline(node: ir.Formula, axis: ir.Axis, outside: frozenset[ir.Axis]) -> tuple[str, ...]:
    """The fields x, y, heading and, for a curve, kappa of an axis, where a predicate is about what is swept from each of its samples to the next.

    outside: the axes that the vehicle's length and width depend on. Empty for any other predicate.
    """
    if not isinstance(node, ir.SweptInside):
        return ()
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
