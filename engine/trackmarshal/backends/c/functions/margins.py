"""What the margin of a formula tells."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from trackmarshal.backends.c.facts import Value
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import COMPARISONS, Measure


def told_by_margin(formula: ir.Formula) -> bool:
    """Whether a formula of which all is known holds exactly where its margin is not negative."""

    def parts(node: Value) -> Iterable[Value] | None:
        match node:
            case ir.Compare():
                return () if COMPARISONS[node.op].holds_at_zero else None
            case ir.Truth() | ir.Flag() | ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return ()
            case ir.Connective() if node.op in ("and", "or"):
                return node.left, node.right
            case ir.Quantify() | ir.Guarded():
                return (node.body,)
            case _:
                return None  # of a margin that is divided by a scale, nothing may be left

    return all_of(formula, parts)


def always_finite(formula: ir.Formula) -> bool:
    """Whether the margin of what is simple is finite where all is known: with several samples at once, an infinite one is not known."""

    def parts(node: Value) -> Iterable[Value] | None:
        if isinstance(node, ir.Connective):
            return node.left, node.right
        same = isinstance(node, ir.Compare) and COMPARISONS[node.op].measure is Measure.SAMENESS
        return None if same else ()

    return all_of(formula, parts)


def all_of(value: Value, parts: Callable[[Value], Iterable[Value] | None]) -> bool:
    """Whether all of a value is as wanted: `parts` gives what else is asked of a node, None where it is not as wanted. What stands in it
    several times is asked once."""
    asked, waiting = set[Value](), [value]
    while waiting:
        node = waiting.pop()
        if node not in asked:
            asked.add(node)
            more = parts(node)
            if more is None:
                return False
            waiting += more
    return True
