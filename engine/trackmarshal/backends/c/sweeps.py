"""Sweeps along a whole timeline: one call for all of them, which leaves out what cannot be the least margin."""

from __future__ import annotations

from trackmarshal.ir import nodes as ir


def along_timeline(node: ir.Formula, axis: ir.Axis, outside: frozenset[ir.Axis]) -> tuple[str, ...]:
    """The fields x, y and heading of an axis, where a predicate is about what is swept from each of its samples to the next.

    outside: the axes that the vehicle's length and width depend on. Empty for any other predicate.
    """
    if not isinstance(node, ir.SweptInside):
        return ()
    if axis.kind != "samples" or axis.width != 1 or axis in outside:
        return ()
    poses = (*node.start, *node.end)
    fields = tuple(pose.field for pose in poses if isinstance(pose, ir.Column) and pose.axis is axis)
    offsets = [pose.offset for pose in poses if isinstance(pose, ir.Column)]
    if len(fields) != 6 or fields[:3] != fields[3:] or offsets != [-1, -1, -1, 0, 0, 0]:
        return ()
    return fields[:3]
