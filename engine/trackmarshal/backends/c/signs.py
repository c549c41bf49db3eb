"""Formulas of which only whether they hold is asked, as of a guard: a point off the box of a region is outside, and that is all."""

from __future__ import annotations

from collections.abc import Iterable
from typing import assert_never

from trackmarshal.ir import nodes as ir


def margins_read(roots: Iterable[ir.Formula]) -> set[ir.Formula]:
    """The formulas whose margin counts for that of one of the roots."""
    found: set[ir.Formula] = set()
    stack = list(roots)
    while stack:
        node = stack.pop()
        if node in found:
            continue
        found.add(node)
        match node:
            case ir.Truth() | ir.Flag() | ir.Compare() | ir.SweptInside() | ir.SweptClear() | ir.InArea():
                pass
            case ir.Quantify() | ir.Guarded():
                stack.append(node.body)  # a guard chooses
            case ir.Connective() | ir.Until():
                stack += [node.left, node.right]
            case ir.Not() | ir.Scaled() | ir.Temporal() | ir.Shift() | ir.First():
                stack.append(node.operand)
            case ir.OverRun():
                stack += node.operands
            case ir.Counted() | ir.InState():
                pass  # it is asked whether they hold
            case _:
                assert_never(node)
    return found
