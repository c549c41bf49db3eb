"""Rules with which a Supervisor never drives: those that nothing can meet as long as nothing was driven."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from itertools import product
from typing import assert_never

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.ir.operators import ConnectiveOp
from trackmarshal.ir.overrun import over_run, recalls
from trackmarshal.ir.reads import IS_DRIVEN, IS_EMERGENCY, asks_what_was_driven
from trackmarshal.ir.spec import ParamInfo
from trackmarshal.lowering.rules import Lowered
from trackmarshal.semantics.warnings.vacuity import NeverStarts

#: What may be of a formula in a cycle; false is less than unknown, and unknown less than true.
Truths = frozenset[int]
_FALSE, _UNKNOWN, _TRUE = 0, 1, 2
_KNOWN, _ANY = frozenset((_FALSE, _TRUE)), frozenset((_FALSE, _UNKNOWN, _TRUE))


def never_starts(core: Lowered, rule: typed.Rule, params: Mapping[str, ParamInfo]) -> list[Diagnostic]:
    """What is to be said of a rule that no cycle meets behind others in which nothing was driven, whatever its inputs are.

    As long as nothing was driven, `plan` of an earlier cycle is unknown; whatever else is asked for may be true or false, and so may what is to come.
    Parameters have the values that are declared.
    """
    formula = core.formula
    if not over_run(formula) or not asks_what_was_driven(formula):
        return []
    return [] if _TRUE in _Starting(params).may_be(formula, True) else [NeverStarts(rule.condition.span)]


class _Starting:
    """What formulas may be behind cycles in which nothing was driven."""

    def __init__(self, params: Mapping[str, ParamInfo]) -> None:
        self._params = params
        #: Definitions that ask twice for what is below them double it with each level.
        self._known: dict[tuple[ir.Formula, bool], Truths] = {}

    def may_be(self, node: ir.Formula, present: bool) -> Truths:
        """What a formula may be in the present cycle, or in one before it in which nothing was driven; more than it can be, never less."""
        found = self._known.get((node, present))
        if found is None:
            found = self._known[node, present] = self._may_be(node, present)
        return found

    def _may_be(self, node: ir.Formula, present: bool) -> Truths:
        match node:
            case ir.Not():
                return frozenset(_TRUE - each for each in self.may_be(node.operand, present))
            case ir.Connective():
                return _joined(node.op, self.may_be(node.left, present), self.may_be(node.right, present))
            case ir.Flag() if node.signal == IS_DRIVEN and not node.field:
                return frozenset((_TRUE if present else _FALSE,))
            case ir.Flag() if node.signal == IS_EMERGENCY and not node.field and not present:
                return frozenset((_FALSE,))
            case _ if not over_run(node):
                return _KNOWN if present or not asks_what_was_driven(node) else frozenset((_UNKNOWN,))
            case ir.Guarded():
                spared = frozenset(_TRUE - each for each in self.may_be(node.guard, present))
                return _each(max, spared, self.may_be(node.body, present))
            case ir.OverRun():
                return self._over_run(node, present)
            case ir.Counted() if present and self._grows_past(node):
                return frozenset((_UNKNOWN, _TRUE if node.turned and node.op != "==" else _FALSE))
            case ir.Quantify() | ir.Counted() | ir.InState():
                return _ANY  # a set may be empty, a count far from its limit, a machine in a state that nothing leads out of
            case _ if recalls(node):
                return _ANY
            case _:
                raise AssertionError(f"{type(node).__name__} is put together from no formulas over the run")

    def _grows_past(self, node: ir.Counted) -> bool:
        """Whether cycles in which nothing was driven take a count beyond the number that it is compared with, as each of them is one that may count.

        How many come is not known: at least one a second.
        """
        limit = constant_value(node.limit, self._declared)
        if node.op == "!=" or len(node.operands) > 1 or limit is None or not math.isfinite(limit):
            return False
        if node.upper is not None and node.upper <= (limit + 1.0) * 1e9:
            return False
        return self.may_be(node.operands[0], False) == {_UNKNOWN}

    def _declared(self, name: str) -> float | None:
        found = self._params.get(name)
        return None if found is None else found.value

    def _over_run(self, node: ir.OverRun, present: bool) -> Truths:
        """Of the cycles of a window, the present one may be among them, and those before it are: runs are longer than windows."""
        match node.op:
            case "previous":
                return self.may_be(node.operands[0], False)
            case "historically" | "once":
                earlier, now = self.may_be(node.operands[0], False), self.may_be(node.operands[0], True)
                if not present or node.lower:
                    return earlier
                return (
                    now if node.upper == 0 else _each(min if node.op == "historically" else max, earlier, now)
                )
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
