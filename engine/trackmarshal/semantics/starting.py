"""Rules with which a Supervisor never drives: those that nothing can meet as long as nothing was driven."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import product
from typing import assert_never

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import ConnectiveOp
from trackmarshal.ir.overrun import over_run, recalls
from trackmarshal.ir.reads import IS_DRIVEN, IS_EMERGENCY, asks_what_was_driven
from trackmarshal.lowering.rules import Lowered
from trackmarshal.semantics.errors import NeverStarts

#: What may be of a formula in a cycle; false is less than unknown, and unknown less than true.
Truths = frozenset[int]
_FALSE, _UNKNOWN, _TRUE = 0, 1, 2
_KNOWN, _ANY = frozenset((_FALSE, _TRUE)), frozenset((_FALSE, _UNKNOWN, _TRUE))


def never_starts(core: Lowered, rule: typed.Rule) -> list[Diagnostic]:
    """What is to be said of a rule that no cycle meets behind others in which nothing was driven, whatever its inputs are.

    As long as nothing was driven, `plan` of an earlier cycle is unknown; whatever else is asked for may be true or false, and so may what is to come.
    """
    formula = core.formula
    if not over_run(formula) or not asks_what_was_driven(formula):
        return []
    return [] if _TRUE in _may_be(formula, True) else [NeverStarts(rule.condition.span)]


@lru_cache(maxsize=4096)  # definitions that ask twice for what is below them double it with each level
def _may_be(node: ir.Formula, present: bool) -> Truths:
    """What a formula may be in the present cycle, or in one before it in which nothing was driven; more than it can be, never less."""
    match node:
        case ir.Not():
            return frozenset(_TRUE - each for each in _may_be(node.operand, present))
        case ir.Connective():
            return _joined(node.op, _may_be(node.left, present), _may_be(node.right, present))
        case ir.Flag() if node.signal == IS_DRIVEN and not node.field:
            return frozenset((_TRUE if present else _FALSE,))
        case ir.Flag() if node.signal == IS_EMERGENCY and not node.field and not present:
            return frozenset((_FALSE,))
        case _ if not over_run(node):
            return _KNOWN if present or not asks_what_was_driven(node) else frozenset((_UNKNOWN,))
        case ir.Guarded():
            spared = frozenset(_TRUE - each for each in _may_be(node.guard, present))
            return _each(max, spared, _may_be(node.body, present))
        case ir.OverRun():
            return _over_run(node, present)
        case ir.Counted() if present and _grows_past(node):
            return frozenset((_UNKNOWN, _TRUE if node.turned and node.op != "==" else _FALSE))
        case ir.Quantify() | ir.Counted() | ir.InState():
            return _ANY  # a set may be empty, a count far from its limit, a machine in a state that nothing leads out of
        case _ if recalls(node):
            return _ANY
        case _:
            raise AssertionError(f"{type(node).__name__} is put together from no formulas over the run")


def _grows_past(node: ir.Counted) -> bool:
    """Whether cycles in which nothing was driven take a count beyond the number that it is compared with, as each of them is one that may count.

    How many come is not known: at least one a second.
    """
    if node.op == "!=" or len(node.operands) > 1 or not isinstance(node.limit, ir.Const):
        return False
    if node.upper is not None and node.upper <= (node.limit.value + 1.0) * 1e9:
        return False
    return _may_be(node.operands[0], False) == {_UNKNOWN}


def _over_run(node: ir.OverRun, present: bool) -> Truths:
    """Of the cycles of a window, the present one may be among them, and those before it are: runs are longer than windows."""
    match node.op:
        case "previous":
            return _may_be(node.operands[0], False)
        case "historically" | "once":
            earlier, now = _may_be(node.operands[0], False), _may_be(node.operands[0], True)
            if not present or node.lower:
                return earlier
            return now if node.upper == 0 else _each(min if node.op == "historically" else max, earlier, now)
        case "since" | "always" | "eventually" | "until" | "next":
            return _ANY
        case _:
            assert_never(node.op)


def _joined(op: ConnectiveOp, left: Truths, right: Truths) -> Truths:
    match op:
        case "and":
            return _each(min, left, right)
        case "or":
            return _each(max, left, right)
        case "iff" | "xor":
            same = _TRUE if op == "iff" else _FALSE
            pairs = list(product(left, right))
            return frozenset(
                _UNKNOWN if _UNKNOWN in pair else same if pair[0] == pair[1] else _TRUE - same
                for pair in pairs
            )
        case _:
            assert_never(op)


def _each(of_both: Callable[[int, int], int], left: Truths, right: Truths) -> Truths:
    return frozenset(of_both(one, other) for one, other in product(left, right))
