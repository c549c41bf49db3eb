"""How generated C names what is kept of one of the last cycles: the entry of a table, and the elements that were there."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.layout import Layout
from trackmarshal.backends.c.over_run.future import Table
from trackmarshal.ir import nodes as ir

_FUTURE, _SLOT = c.Name("future"), c.Name("slot")
#: The places of the elements that a formula is about, by its axes.
Binds = Mapping[ir.Axis, c.Expr]


def entry(table: Table, binds: Binds) -> c.Expr:
    """What a table has about the cycle of the slot."""
    found: c.Expr = c.Element(c.Member(_FUTURE, table.c_name, True), _SLOT)
    for axis in table.axes:
        found = c.Element(found, binds[axis])
    return found


def for_those_there(plan: Layout, axis: ir.Axis, index: c.Name, body: list[c.Statement]) -> c.Statement:
    """A loop over the elements of a set that were there in that cycle."""
    there = c.Element(c.Member(_FUTURE, f"{plan.input(axis.signal).c_name}_there", True), _SLOT)
    below = c.Binary("<", index, c.Name("TM_MAX_ELEMENTS"))
    return c.For(index.name, below, c.Unary("++", index), (c.If(c.Element(there, index), tuple(body)),))
