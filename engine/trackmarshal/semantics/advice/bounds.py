"""What numbers and formulas can come to within the input contract: intervals of doubles, and what is known where something holds.

All of it errs on one side: what is said to be impossible is so for every input that keeps the contract and all values that parameters and
tables may be given; much that is impossible is not seen. Whether something is undefined is not asked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import reduce
from operator import add
from typing import TypeAlias, assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import FieldType, ParamInfo, SignalType, TableInfo
from trackmarshal.semantics.advice.intervals import (
    ANY,
    EQUAL,
    EVERY,
    GREATER,
    HOLD,
    LESS,
    NOT_NEGATIVE,
    Interval,
    arithmetic,
    between,
    function,
    lie,
    square,
)
from trackmarshal.source import Span

#: What a formula can come to; bits of a set of these.
HOLDS, FAILS = 1, 2
#: Nodes that are looked at for one rule at most: written out, a rule can be far more than it is.
MOST = 20_000
_FlagAt: TypeAlias = tuple[str, str | None, ir.Axis | None, int]
_MachineAt: TypeAlias = tuple[str, ir.Axis | None]


class TooMuchError(Exception):
    """A rule is too large to be looked at."""


class Facts:
    """What is known of numbers, flags and state machines of one cycle; of a machine, the states that are left."""

    def __init__(
        self,
        numbers: Mapping[ir.Num, Interval] | None = None,
        orders: Mapping[tuple[ir.Num, ir.Num], int] | None = None,
        flags: Mapping[_FlagAt, bool] | None = None,
        states: Mapping[_MachineAt, frozenset[str]] | None = None,
    ) -> None:
        self.numbers, self.orders, self.flags = dict(numbers or {}), dict(orders or {}), dict(flags or {})
        self.states = dict(states or {})
        #: Intervals that were worked out with them.
        self.seen: dict[ir.Num, Interval] = {}

    def without(self, axis: ir.Axis) -> Facts:
        """What is known still where an axis has another value."""

        def about(node: ir.Num) -> bool:
            return axis in ir.below(node)

        return Facts(
            {n: i for n, i in self.numbers.items() if not about(n)},
            {pair: m for pair, m in self.orders.items() if not any(map(about, pair))},
            {flag: v for flag, v in self.flags.items() if flag[2] is not axis},
            {machine: left for machine, left in self.states.items() if machine[1] is not axis},
        )


class Bounds:
    """Looks at formulas with the signals, parameters and tables of a spec. Raises TooMuchError for those that are too large; `begin` first."""

    def __init__(
        self, signals: Mapping[str, SignalType], params: Mapping[str, ParamInfo], tables: Mapping[str, TableInfo]
    ) -> None:  # fmt: skip
        self._signals, self.params = signals, params
        self.tables = tables
        #: By table, and by which of its arguments, where the inputs lie at which the rule reads it.
        self.read_at: dict[tuple[str, int], Interval] = {}
        #: Whether note is taken of that: where something is assumed, it was asked before what it can come to.
        self._noting = False
        self._fields: dict[tuple[str, str], FieldType | None] = {}
        self._left = MOST
        #: Of another cycle, or another sample, nothing is known.
        self.nothing = Facts()

    def begin(self, noted: ir.Formula | None = None) -> None:
        """Begin to look at another rule; noted: the formula of one in which note is to be taken of tables."""
        self._left = MOST
        self._noting = bool(self.tables) and noted is not None and _looks_up(noted)
        self.read_at = {}
        if self._noting:  # what was worked out for another rule took no note for this one
            self.nothing = Facts()

    def _count(self) -> None:
        self._left -= 1
        if self._left < 0:
            raise TooMuchError

    # Formulas -----------------------------------------------------------------------------------------------------

    def truths(self, formula: ir.Formula, facts: Facts) -> int:
        """What it can come to where these facts are so."""
        self._count()
        match formula:
            case ir.Truth():
                return HOLDS if formula.value else FAILS
            case ir.Flag():
                value = facts.flags.get(_flag(formula))
                return HOLDS | FAILS if value is None else HOLDS if value else FAILS
            case ir.Compare():
                order, hold = self._order(formula.left, formula.right, facts), HOLD[formula.op]
                return (HOLDS if order & hold else 0) | (FAILS if order & ~hold else 0)
            case ir.Scaled() | ir.At():
                return self.truths(formula.operand, facts)
            case ir.Not():
                return _denied(self.truths(formula.operand, facts))
            case ir.Connective():
                return self._joined(formula, facts)
            case ir.Quantify():
                inner: Facts | None = facts.without(formula.axis)
                if formula.guard is not None:
                    assert inner is not None
                    self.note(formula.guard, inner)
                    inner = self.assume(formula.guard, True, inner)
                empty = HOLDS if formula.quantifier == "for all" else FAILS
                body = 0 if inner is None else self.truths(formula.body, inner)
                return empty | (body & _denied(empty))
            case ir.Guarded():
                self.note(formula.guard, facts)
                under = self.assume(formula.guard, True, facts)
                return HOLDS if under is None else HOLDS | self.truths(formula.body, under)
            case ir.Temporal():
                of_all = formula.op in ("always", "historically")
                return self._at_times(formula.operand, of_all, not formula.lower, facts)
            case ir.Until():
                return FAILS | self.truths(formula.right, self.nothing) & HOLDS
            case ir.Shift():
                return self.truths(formula.operand, self.nothing) | (HOLDS if formula.weak else FAILS)
            case ir.OverRun():
                return self._over_run(formula, facts)
            case ir.Tallied():
                return self._counted(formula, formula.counted)
            case ir.Counted():
                return self._counted(formula, formula.operands[0])
            case ir.InState():
                left = _left(formula, facts)
                return (HOLDS if formula.state in left else 0) | (FAILS if left - {formula.state} else 0)
            case ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return HOLDS | FAILS
            case _:
                assert_never(formula)

    def assume(self, formula: ir.Formula, value: bool, facts: Facts) -> Facts | None:
        """What is known where a formula holds, or does not, besides; None: it cannot be so."""
        noting, self._noting = self._noting, False
        try:
            return self._assumed(formula, value, facts)
        finally:
            self._noting = noting

    def _assumed(self, formula: ir.Formula, value: bool, facts: Facts) -> Facts | None:
        self._count()
        match formula:
            case ir.Scaled() | ir.At():
                return self._assumed(formula.operand, value, facts)
            case ir.Not():
                return self._assumed(formula.operand, not value, facts)
            case ir.Flag():
                if not self.truths(formula, facts) & (HOLDS if value else FAILS):
                    return None
                return Facts(
                    facts.numbers, facts.orders, {**facts.flags, _flag(formula): value}, facts.states
                )
            case ir.InState():
                it, left = frozenset((formula.state,)), _left(formula, facts)
                left = left & it if value else left - it
                if not left:
                    return None
                return Facts(
                    facts.numbers, facts.orders, facts.flags, {**facts.states, _machine(formula): left}
                )
            case ir.Compare():
                hold = HOLD[formula.op]
                return self._ordered(formula.left, formula.right, hold if value else EVERY & ~hold, facts)
            case ir.Connective() if formula.op in ("and", "or"):
                if value == (formula.op == "and"):  # both are so
                    first = self._assumed(formula.left, value, facts)
                    return None if first is None else self._assumed(formula.right, value, first)
                one, other = (self._assumed(side, value, facts) for side in (formula.left, formula.right))
                return other if one is None else one if other is None else facts
            case _:
                return facts if self.truths(formula, facts) & (HOLDS if value else FAILS) else None

    def impossible(self, formula: ir.Formula, facts: Facts) -> Span | None:
        """Of a formula that cannot hold with these facts the first part that cannot hold with what stands before it, where that has a place."""
        while isinstance(formula, ir.Connective) and formula.op == "and":
            first = self.assume(formula.left, True, facts)
            if first is None:
                formula = formula.left
            else:
                formula, facts = formula.right, first
        if isinstance(formula, ir.Not):
            formula = formula.operand
        return formula.span if isinstance(formula, (ir.Compare, ir.Flag, ir.InState)) else None

    def _joined(self, formula: ir.Connective, facts: Facts) -> int:
        first, second = formula.left, formula.right
        # Either side may decide alone, whatever the other one has no value for.
        if self._noting and _looks_up(first) and not _looks_up(second):
            first, second = second, first
        left = self.truths(first, facts)
        if formula.op in ("iff", "xor"):
            right = self.truths(second, facts)
            same = (left & right) != 0
            other = (left & _denied(right)) != 0
            found = (HOLDS if same else 0) | (FAILS if other else 0)
            return found if formula.op == "iff" else _denied(found)
        # What the left side alone decides, and what takes both.
        alone, both = (FAILS, HOLDS) if formula.op == "and" else (HOLDS, FAILS)
        if not left & both:
            return alone
        if not left & alone:
            return self.truths(second, facts)
        under = self.assume(first, both == HOLDS, facts)
        return alone | (0 if under is None else self.truths(second, under) & both)

    def _at_times(self, operand: ir.Formula, of_all: bool, with_now: bool, facts: Facts) -> int:
        """Of a formula at all times of a window, or at one of them; a window that does not begin now may be empty."""
        found = self.truths(operand, self.nothing)
        now = self.truths(operand, facts) if with_now else HOLDS | FAILS
        return (found & FAILS) | (now & HOLDS) if of_all else (found & HOLDS) | (now & FAILS)

    def _over_run(self, formula: ir.OverRun, facts: Facts) -> int:
        match formula.op:
            case "always" | "historically" | "eventually" | "once":
                of_all = formula.op in ("always", "historically")
                return self._at_times(formula.operands[0], of_all, not formula.lower, facts)
            case "until" | "since":
                return FAILS | self.truths(formula.operands[1], self.nothing) & HOLDS
            case "next" | "previous":
                return self.truths(formula.operands[0], self.nothing) | (HOLDS if formula.weak else FAILS)
            case _:
                assert_never(formula.op)

    def _counted(self, formula: ir.Tallied | ir.Counted, counted: ir.Formula) -> int:
        # The stamps of two cycles differ.
        most = 1.0 if isinstance(formula, ir.Counted) and formula.upper == 0 else math.inf
        count = (0.0, most if self.truths(counted, self.nothing) & HOLDS else 0.0)
        limit = self._interval(formula.limit, self.nothing)
        order = lie(limit, count) if formula.turned else lie(count, limit)
        hold = HOLD[formula.op]
        return (HOLDS if order & hold else 0) | (FAILS if order & ~hold else 0)

    # Two numbers --------------------------------------------------------------------------------------------------

    def _order(self, left: ir.Num, right: ir.Num, facts: Facts) -> int:
        """How the left one can lie to the right one."""
        if left is right:
            return EQUAL
        found = facts.orders.get((left, right), EVERY) & self._declared(left, right)
        return found & lie(self._interval(left, facts), self._interval(right, facts))

    def _declared(self, left: ir.Num, right: ir.Num) -> int:
        """How samples of a column lie that is declared increasing."""
        match left, right:
            case (ir.Column(), ir.Column()) if left.axis is right.axis and left.field == right.field:
                field = self._field(left.axis.signal, left.field)
                if field is not None and field.increasing and min(left.offset, right.offset) >= 0:
                    return LESS if left.offset < right.offset else GREATER
        return EVERY

    def _ordered(self, left: ir.Num, right: ir.Num, allowed: int, facts: Facts) -> Facts | None:
        order = self._order(left, right, facts) & allowed
        if not order:
            return None
        if left is right:
            return facts
        (low, high), (least, most) = self._interval(left, facts), self._interval(right, facts)
        if not order & GREATER:
            high = min(high, most if order & EQUAL else math.nextafter(most, -math.inf))
            least = max(least, low if order & EQUAL else math.nextafter(low, math.inf))
        if not order & LESS:
            low = max(low, least if order & EQUAL else math.nextafter(least, math.inf))
            most = min(most, high if order & EQUAL else math.nextafter(high, -math.inf))
        if low > high or least > most:
            return None
        turned = order & EQUAL | (GREATER if order & LESS else 0) | (LESS if order & GREATER else 0)
        return Facts(
            {**facts.numbers, left: (low, high), right: (least, most)},
            {**facts.orders, (left, right): order, (right, left): turned},
            facts.flags,
            facts.states,
        )

    # Numbers ------------------------------------------------------------------------------------------------------

    def _interval(self, node: ir.Num, facts: Facts) -> Interval:
        found = facts.seen.get(node)
        if found is None:
            self._count()
            low, high = self._unbounded(node, facts)
            least, most = facts.numbers.get(node, ANY)
            found = facts.seen[node] = max(low, least), min(high, most)
        return found

    def _unbounded(self, node: ir.Num, facts: Facts) -> Interval:
        """But for what is known of the number itself."""
        match node:
            case ir.Const():
                return ANY if _no_number(node) else (node.value, node.value)
            case ir.Param():
                info = self.params.get(node.name)
                return ANY if info is None else between(info.lower, info.upper)
            case ir.Column():
                return self._range(node.axis.signal, node.field)
            case ir.Sample() | ir.Scalar():
                return self._range(node.signal, node.field)
            case ir.Arith():
                return self._arithmetic(node, facts)
            case ir.Neg():
                low, high = self._interval(node.operand, facts)
                return -high, -low
            case ir.Func():
                return function(node.name, [self._interval(arg, facts) for arg in node.args])
            case ir.Choose():
                sides = []
                self.note(node.condition, facts)
                for value, side in ((True, node.then), (False, node.otherwise)):
                    under = self.assume(node.condition, value, facts)
                    if under is not None and not _no_number(side):
                        sides.append(self._interval(side, under))
                return (min(low for low, _ in sides), max(high for _, high in sides)) if sides else ANY
            case ir.Fold():
                return self._fold(node, facts)
            case ir.Distance() | ir.Ordinal():
                return NOT_NEGATIVE
            case ir.Kept():
                return ANY if node.name else NOT_NEGATIVE
            case ir.OnLane():
                return NOT_NEGATIVE if node.what == "distance" else ANY
            case ir.Lookup():
                self._reads(node.table, (node.argument,), facts)
                return ANY  # another one may be given
            case ir.GridLookup():
                self._reads(node.table, (node.first, node.second), facts)
                return ANY
            case ir.Station() | ir.Offset() | ir.Direction() | ir.StationGap() | ir.StretchRoom():
                return ANY
            case _:
                assert_never(node)

    def note(self, condition: ir.Formula, facts: Facts) -> None:
        """Take note of where a condition reads tables, before it is assumed."""
        if self._noting and _looks_up(condition):
            self.truths(condition, facts)

    def _reads(self, table: str, arguments: tuple[ir.Num, ...], facts: Facts) -> None:
        """Take note of where a table is read: of an input alone, since what is computed need not come to all that its interval has."""
        for place, argument in enumerate(arguments if self._noting else ()):
            if isinstance(argument, (ir.Column, ir.Sample, ir.Scalar)):
                low, high = self._interval(argument, facts)
                least, most = self.read_at.get((table, place), (low, high))
                self.read_at[table, place] = min(low, least), max(high, most)

    def _arithmetic(self, node: ir.Arith, facts: Facts) -> Interval:
        left, right = self._interval(node.left, facts), self._interval(node.right, facts)
        if node.left is node.right and node.op == "*":
            return square(left)
        low, high = arithmetic(node.op, left, right)
        if node.op == "-":  # the sign of a difference is that of the comparison
            order = self._order(node.left, node.right, facts)
            low = low if order & LESS else max(low, 0.0)
            high = high if order & GREATER else min(high, 0.0 if order & EQUAL else -math.ulp(0.0))
        return low, high

    def _fold(self, node: ir.Fold, facts: Facts) -> Interval:
        inner: Facts | None = facts.without(node.axis)
        if node.guard is not None:
            assert inner is not None
            self.note(node.guard, inner)
            inner = self.assume(node.guard, True, inner)
        if node.op == "nearest":
            return -1.0, math.inf
        none = (0.0, 0.0) if node.op == "sum" else None
        if node.otherwise is not None:
            none = self._interval(node.otherwise, facts)
        if inner is None:  # there is none, ever
            return none or ANY
        low, high = self._interval(node.body, inner)
        if node.op == "sum":
            return min(0.0, self._sum(node.axis, low)), max(0.0, self._sum(node.axis, high))
        return (low, high) if none is None else (min(low, none[0]), max(high, none[1]))

    def _sum(self, axis: ir.Axis, each: float) -> float:
        """The sum of as many of a number as an axis has at most, added up as evaluators do: no sum of lesser ones is rounded to more."""
        known = self._signals.get(axis.signal)
        if known is None or known.capacity is None:
            return math.copysign(math.inf, each) if each else 0.0
        return reduce(add, [each] * known.capacity, 0.0)

    def _range(self, signal: str, name: str) -> Interval:
        field = self._field(signal, name)
        if field is None:  # of a course, or of a definition that nothing is given for
            return ANY
        if field.enumeration is not None:
            return 0.0, float(len(field.enumeration.members) - 1)
        return between(field.lower, field.upper)

    def _field(self, signal: str, name: str) -> FieldType | None:
        if (signal, name) not in self._fields:
            known = self._signals.get(signal)
            self._fields[signal, name] = None if known is None else known.field(name)
        return self._fields[signal, name]


def _looks_up(formula: ir.Formula) -> bool:
    return any(isinstance(node, ir.Lookup | ir.GridLookup) for node in ir.below(formula))


def _flag(node: ir.Flag) -> _FlagAt:
    return node.signal, node.field, node.axis, node.offset


def _machine(node: ir.InState) -> _MachineAt:
    return node.machine.name, node.machine.axis


def _left(node: ir.InState, facts: Facts) -> frozenset[str]:
    """The states in which a machine may be."""
    return facts.states.get(_machine(node), frozenset(node.machine.states))


def _no_number(node: ir.Num) -> bool:
    """Whether it is NaN, as a `case` has no value for what is no member."""
    return isinstance(node, ir.Const) and math.isnan(node.value)


def _denied(truths: int) -> int:
    return (FAILS if truths & HOLDS else 0) | (HOLDS if truths & FAILS else 0)
