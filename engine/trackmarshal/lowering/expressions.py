"""Numbers and formulas of the typed tree to the core, which knows few operators: the others are rewritten by their definitions.

A rewriting keeps verdicts, margins to the bit, and what decided. `iff` and `xor` are no minimum or maximum of what they join, so they stay.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, assert_never

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.operators import FUNCTIONS, ComparisonOp
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import Called
from trackmarshal.lowering.things import Things, nothing_given
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import show

#: What the core calls numbers of a point and a lane's line.
_OF_LANE: dict[typed.LineFunction, ir.LaneWhat] = {
    "station": "station", "offset": "offset", "direction": "direction", "distance_to": "distance",
}  # fmt: skip
#: Numbers that no input changes, and what they are made of.
_FIXED = (ir.Const, ir.Param, ir.Arith, ir.Neg, ir.Func)


class Lowering:
    """Makes core nodes of typed ones. `site` is the call in a rule's own file, inside a definition: there, messages point to it."""

    def __init__(self, interner: Interner, scales: Mapping[str, float] | None = None) -> None:
        """scales: by SI unit, what margins are divided by before they are compared; None: by nothing."""
        self.make = interner.make
        self._scales = scales or {}
        self.things = Things(interner)
        #: What names stand for: each is lowered once, where it gets its name.
        self._numbers: dict[typed.Number, ir.Num] = {}
        self._formulas: dict[typed.Formula, ir.Formula] = {}
        #: What the rule calls values, for whoever shows them; of a value with names of its own, the outermost.
        self.names: dict[ir.IR, Called] = {}

    def bind(self, value: typed.Value, site: Span | None) -> None:
        """Lower what a name stands for; whatever is no number or formula is looked at where it is used."""
        if isinstance(value, typed.NumberNode):
            self._numbers[value] = self.number(value, site)
        elif isinstance(value, typed.FormulaNode):
            self._formulas[value] = self.formula(value, site)

    def named(self, value: typed.Value, name: str) -> None:
        """Note what a `let` calls a number or a formula that is bound."""
        if isinstance(value, typed.NumberNode):
            self._call(self._numbers[value], name, unit=show(value.dimension))
        elif isinstance(value, typed.FormulaNode):
            self._call(self._formulas[value], name)

    def _call(
        self, node: ir.Num | ir.Formula, name: str, own: bool = True, unit: str = "1", text: str = ""
    ) -> None:
        if own or node not in self.names:
            self.names[node] = Called(node, name, own, unit, text or name)

    def number(self, node: typed.Number, site: Span | None = None) -> ir.Num:
        """The core of a number."""
        make = self.make
        match node:
            case typed.NamedNumber():
                if node.value is None:
                    raise nothing_given(node.name)
                return self._numbers[node.value]
            case typed.Field():
                return self.things.column(node.record, node.name)
            case typed.Literally():
                return make(ir.Const, node.value)
            case typed.Arithmetic():
                return make(ir.Arith, node.op, self.number(node.left, site), self.number(node.right, site))
            case typed.CalledNumber():
                inner = self._enter(node, site)
                value = self.number(node.body, inner)
                text = node.span.in_line
                self._call(value, node.symbol.name, unit=show(node.dimension), text=text)
                return value
            case typed.Parameter():
                return make(ir.Param, node.symbol.qualified)
            case typed.Function():
                return self._function(node, site)
            case typed.Power():
                return self._power(node, site)
            case typed.Choice():
                condition = self.formula(node.condition, site)
                return make(
                    ir.Choose, condition, self.number(node.then, site), self.number(node.otherwise, site)
                )
            case typed.NumberCase():
                return self._number_case(node, site)
            case typed.Folded():
                return self._folded(node, site)
            case typed.Negative():
                operand = self.number(node.operand, site)
                if isinstance(operand, ir.Const):
                    return make(ir.Const, -operand.value)
                return make(ir.Neg, operand)
            case typed.TableValue():
                placed = [self.number(argument, site) for argument in node.arguments]
                if len(placed) == 2:
                    return make(ir.GridLookup, node.symbol.qualified, *placed)
                return make(ir.Lookup, node.symbol.qualified, *placed)
            case typed.OnLine():
                return self._on_line(node)
            case typed.StationGap():
                start, end = self.number(node.start, site), self.number(node.end, site)
                lane = self.things.lane(node.line)
                if lane is not None:
                    return self._on_lane("gap", lane, start, end)
                return make(ir.StationGap, self.things.line(node.line), start, end)
            case typed.Kept():
                return make(ir.Kept, self._machine(node.machine), node.name)
            case typed.Pi():
                return make(ir.Const, math.pi)
            case _:
                assert_never(node)

    def formula(self, node: typed.Formula, site: Span | None = None) -> ir.Formula:
        """The core of a formula."""
        make = self.make
        match node:
            case typed.Comparison():
                left, right = self.number(node.left, site), self.number(node.right, site)
                return self._compare(node.op, (node.left, left), (node.right, right), site or node.span)
            case typed.Connective():
                left_, right_ = self.formula(node.left, site), self.formula(node.right, site)
                if node.op == "implies":
                    return make(ir.Connective, "or", make(ir.Not, left_), right_)
                return make(ir.Connective, node.op, left_, right_)
            case typed.CountComparison():
                return self._counted(node, site)
            case typed.InState():
                return make(ir.InState, self._machine(node.machine), node.state, site or node.span)
            case typed.CalledFormula():
                inner = self._enter(node, site)
                holds = self.formula(node.body, inner)
                self._call(holds, node.symbol.name)
                return holds
            case typed.NamedFormula():
                return self._formulas[node.value]
            case typed.Not():
                return make(ir.Not, self.formula(node.operand, site))
            case typed.IsMember():
                return self._is(
                    self.things.member(node.left), self.things.member(node.right), site or node.span
                )
            case typed.FormulaCase():
                return self._formula_case(node, site)
            case typed.Chained():
                return self._chained(node, site)
            case typed.Within():
                numbers = [(part, self.number(part, site)) for part in (node.value, node.lower, node.upper)]
                value, lower, upper = numbers
                at = site or node.span
                return self._and(
                    [self._compare("<=", lower, value, at), self._compare("<=", value, upper, at)]
                )
            case typed.Quantified():
                axis = self.things.axis(node.range)
                guard = None if node.where is None else self.formula(node.where, site)
                if node.by is not None:
                    guard = self.nearest(node.range, guard, self.number(node.by, site), site or node.span)
                body = self.formula(node.body, site)
                return make(ir.Quantify, node.quantifier, axis, guard, body, node.range.names)
            case typed.BooleanField():
                return self.things.flag(node.record, node.name, site or node.span)
            case typed.Event():
                return make(ir.Flag, node.symbol.name, None, None, 0, site or node.span)
            case typed.Boolean():
                return make(ir.Truth, node.value)
            case typed.InStretch():
                return self._scaled(self._in_stretch(node, site), "m")
            case typed.Meets():
                met = self._swept_on_lane("meets", node, site)
                assert met is not None
                return self._scaled(met, "m")
            case typed.Inside() | typed.ClearOf() | typed.InZone():
                return self._geometry(node, site)
            case typed.Temporal() | typed.Until() | typed.Step() | typed.Edge():
                return self._timed(node, site)
            case _:
                assert_never(node)

    def _enter(self, call: typed.CalledNumber | typed.CalledFormula, site: Span | None) -> Span:
        """Name the arguments of a call, as the caller means them; where messages about its body point."""
        for argument in call.arguments:
            self.bind(argument, site)
        item = call.symbol.item
        assert isinstance(item, ast.Define)
        for parameter, argument in zip(item.parameters, call.arguments):
            if isinstance(argument, typed.NumberNode):
                self._call(self._numbers[argument], parameter.name, False, show(argument.dimension))
        return site or call.span

    # Numbers ----------------------------------------------------------------------------------------------------

    def _function(self, node: typed.Function, site: Span | None) -> ir.Num:
        numbers = tuple([self.number(argument, site) for argument in node.arguments])
        if not FUNCTIONS[node.name].more:
            return self.make(ir.Func, node.name, numbers)
        first, *others = numbers
        for other in others:
            first = self.make(ir.Func, node.name, (first, other))
        return first

    def _power(self, node: typed.Power, site: Span | None) -> ir.Num:
        base, whole = self.number(node.base, site), typed.whole_exponent(node.exponent)
        if whole is None:
            return self.make(ir.Func, "pow", (base, self.number(node.exponent, site)))
        product = base
        for _ in range(abs(whole) - 1):  # defined as repeated multiplication, not as a library's pow
            product = self.make(ir.Arith, "*", product, base)
        return product if whole > 0 else self.make(ir.Arith, "/", self.make(ir.Const, 1.0), product)

    def _on_line(self, node: typed.OnLine) -> ir.Num:
        x, y = self.things.point(node.point)
        lane = self.things.lane(node.line)
        if lane is not None:
            return self._on_lane(_OF_LANE[node.function], lane, x, y)
        line = self.things.line(node.line)
        match node.function:
            case "station":
                return self.make(ir.Station, line, x, y)
            case "offset":
                return self.make(ir.Offset, line, x, y)
            case "direction":
                return self.make(ir.Direction, line, x, y)
            case "distance_to":
                return self.make(ir.Distance, line, x, y)
            case _:
                assert_never(node.function)

    def _folded(self, node: typed.Folded, site: Span | None) -> ir.Num:
        """A count is a sum of ones."""
        axis, names = self.things.axis(node.range), node.range.names
        guard = None if node.where is None else self.formula(node.where, site)
        body = self.make(ir.Const, 1.0) if node.body is None else self.number(node.body, site)
        otherwise = None if node.otherwise is None else self.number(node.otherwise, site)
        match node.op:
            case "count" | "sum":
                return self.make(ir.Fold, "sum", axis, guard, body, None, names)
            case "min":
                return self.make(ir.Fold, "least", axis, guard, body, otherwise, names)
            case "max":
                return self.make(ir.Fold, "greatest", axis, guard, body, otherwise, names)
            case _:
                assert_never(node.op)

    def nearest(self, range_: typed.Range, guard: ir.Formula | None, by: ir.Num, span: Span) -> ir.Formula:
        """Whether a variable is the one in its range of which a number is least: what is surely out of range is not, whatever is unknown."""
        axis = self.things.axis(range_)
        first = self.make(ir.Fold, "nearest", axis, guard, by, None, range_.names)
        is_first: ir.Formula = self.make(
            ir.Compare, "==", self.make(ir.Ordinal, axis), first, "1", span, "", False
        )
        return is_first if guard is None else self.make(ir.Connective, "and", guard, is_first)

    # Formulas -----------------------------------------------------------------------------------------------------

    def _scaled(self, formula: ir.Formula, unit: str) -> ir.Formula:
        scale = self._scales.get(unit, 1.0)
        return formula if scale == 1.0 else self.make(ir.Scaled, formula, scale)

    def _compare(
        self,
        op: typed.Comparing,
        left: tuple[typed.Number, ir.Num],
        right: tuple[typed.Number, ir.Num],
        span: Span,
    ) -> ir.Formula:
        """A comparison: `a > b` is `b < a`, whose margin is the same difference a - b; `turned`, for who shows its sides."""
        (written, a), (_, b) = left, right
        unit, shown = show(written.dimension), _of_limit(left, right)
        match op:
            case "<" | "<=" | "==" | "!=":
                made = self.make(ir.Compare, op, a, b, unit, span, shown, False)
            case ">":
                made = self.make(ir.Compare, "<", b, a, unit, span, shown, True)
            case ">=":
                made = self.make(ir.Compare, "<=", b, a, unit, span, shown, True)
            case _:
                assert_never(op)
        return self._scaled(made, unit)

    def _is(self, left: ir.Num, right: ir.Num, at: Span) -> ir.Formula:
        return self.make(ir.Compare, "is", left, right, "1", at, "", False)

    def _among(self, subject: typed.AnyMember, members: tuple[str, ...], at: Span) -> ir.Formula:
        """Whether a member is one of several."""
        place, all_of_them = self.things.member(subject), subject.enumeration.members
        first, *others = [
            self._is(place, self.make(ir.Const, float(all_of_them.index(name))), at) for name in members
        ]
        for other in others:
            first = self.make(ir.Connective, "or", first, other)
        return first

    def _number_case(self, node: typed.NumberCase, site: Span | None) -> ir.Num:
        """`if` of the first branch, else of the next one; no number (NaN) of what is undefined, or the place of no member."""
        value: ir.Num = self.make(ir.Const, math.nan)
        for branch in reversed(node.branches):
            condition = self._among(node.subject, branch.members, site or node.subject.span)
            value = self.make(ir.Choose, condition, self.number(branch.value, site), value)
        return value

    def _formula_case(self, node: typed.FormulaCase, site: Span | None) -> ir.Formula:
        """One of the branches: it is this member, whose margin is infinite, and its formula holds."""
        first, *others = [
            self.make(
                ir.Connective, "and",
                self._among(node.subject, branch.members, site or node.subject.span), self.formula(branch.value, site),
            )
            for branch in node.branches
        ]  # fmt: skip
        for other in others:
            first = self.make(ir.Connective, "or", first, other)
        return first

    def _chained(self, node: typed.Chained, site: Span | None) -> ir.Formula:
        """Neighbours compared, and all of it joined by `and`; every operand is one number, however often it is compared."""
        numbers = [(operand, self.number(operand, site)) for operand in node.operands]
        return self._and(
            [
                self._compare(op, left, right, site or left[0].span.to(right[0].span))
                for op, left, right in zip(node.ops, numbers, numbers[1:])
            ]
        )

    def _and(self, formulas: list[ir.Formula]) -> ir.Formula:
        first, *others = formulas
        for other in others:
            first = self.make(ir.Connective, "and", first, other)
        return first

    def _in_stretch(self, node: typed.InStretch, site: Span | None) -> ir.Formula:
        """How far inside it is, is not below zero."""
        start, end = self.number(node.start, site), self.number(node.end, site)
        lane, station = self.things.lane(node.line), None
        if isinstance(node.place, typed.NumberNode):
            station = self.number(node.place, site)
        if lane is not None:
            if not isinstance(node.place, typed.NumberNode):
                station = self._on_lane("station", lane, *self.things.point(node.place))
            assert station is not None
            return self._not_negative(self._on_lane("room", lane, station, start, end), site or node.span)
        line = self.things.line(node.line)
        if not isinstance(node.place, typed.NumberNode):
            station = self.make(ir.Station, line, *self.things.point(node.place))
        assert station is not None
        name = "" if node.symbol is None else node.symbol.qualified
        room = self.make(ir.StretchRoom, line, name, station, start, end)
        return self._not_negative(room, site or node.span)

    def _not_negative(self, room: ir.Num, at: Span) -> ir.Formula:
        """A signed distance [m] that is a formula's margin, as that of geometric predicates is."""
        return self.make(ir.Compare, "<=", self.make(ir.Const, 0.0), room, "m", at, "", False)

    def _on_lane(self, what: ir.LaneWhat, lane: tuple[ir.LaneSide, str, ir.Num], *ends: ir.Num) -> ir.Num:
        side, signal, place = lane
        return self.make(ir.OnLane, what, signal, side, place, ends)

    def _swept_on_lane(
        self, what: ir.LaneWhat, node: typed.Inside | typed.Meets, site: Span | None
    ) -> ir.Formula | None:
        """How what is swept lies to a lane; None where the area is no lane."""
        lane = self.things.lane(node.area)
        if lane is None:
            return None
        swept = self.things.region(node.region, lambda part: self.number(part, site))
        ends = (*swept.start, *swept.end, swept.length, swept.width, *swept.bend)
        return self._not_negative(self._on_lane(what, lane, *ends), site or node.span)

    def _geometry(
        self, node: typed.Inside | typed.ClearOf | typed.InZone, site: Span | None
    ) -> ir.Formula:  # fmt: skip
        return self._scaled(self._predicate(node, site), "m")

    def _predicate(
        self, node: typed.Inside | typed.ClearOf | typed.InZone, site: Span | None
    ) -> ir.Formula:  # fmt: skip
        at, number = site or node.span, lambda part: self.number(part, site)
        match node:
            case typed.InZone():
                return self.make(ir.InArea, *self.things.point(node.point), self.things.area(node.zone), at)
            case typed.Inside():
                on_lane = self._swept_on_lane("inside", node, site)
                if on_lane is not None:
                    return on_lane
                swept = self.things.region(node.region, number)
                return self.make(
                    ir.SweptInside,
                    start=swept.start, end=swept.end, length=swept.length, width=swept.width, bend=swept.bend,
                    area=self.things.area(node.area), span=at,
                )  # fmt: skip
            case typed.ClearOf():
                swept, box = self.things.region(node.region, number), self.things.region(node.other, number)
                return self.make(
                    ir.SweptClear,
                    start=swept.start, end=swept.end, length=swept.length, width=swept.width,
                    box=box.start, box_length=box.length, box_width=box.width, bend=swept.bend, span=at,
                )  # fmt: skip
            case _:
                assert_never(node)

    def _timed(
        self, node: typed.Temporal | typed.Until | typed.Step | typed.Edge, site: Span | None
    ) -> ir.Formula:  # fmt: skip
        if isinstance(node.axis, typed.TheRun):
            return self._over_run(node, site or node.span, site)
        make, axis = self.make, self.things.axis(node.axis)
        match node:
            case typed.Temporal():
                operand = self.formula(node.operand, site)
                return make(ir.Temporal, node.op, axis, operand, *_bounds(node.window))
            case typed.Until():
                left, right = self.formula(node.left, site), self.formula(node.right, site)
                return make(ir.Until, node.op, axis, left, right, *_bounds(node.window))
            case typed.Step():
                step: Literal[1, -1] = 1 if node.op == "next" else -1
                return make(ir.Shift, axis, self.formula(node.operand, site), step, node.weak)
            case typed.Edge():
                # Before the first sample, what rises counts as false and what falls as true: there, only now counts.
                now = self.formula(node.operand, site)
                denied = make(ir.Not, now)
                before, now = (denied, now) if node.op == "rising" else (now, denied)
                return make(ir.Connective, "and", make(ir.Shift, axis, before, -1, True), now)
            case _:
                assert_never(node)

    def _counted(self, node: typed.CountComparison, site: Span | None) -> ir.Formula:
        """A count against a number: `count > 3` is `3 < count`."""
        count = node.count
        counted = self.formula(count.counted, site)
        reset = None if count.reset is None else self.formula(count.reset, site)
        limit, at = self.number(node.limit, site), site or node.span
        op, turned = _COUNTED[node.op]
        turned = turned != node.turned
        if not isinstance(count.axis, typed.TheRun):
            axis, (_, bound) = self.things.axis(count.axis), _bounds(count.window)
            return self.make(ir.Tallied, axis, op, counted, reset, bound, limit, turned, at)
        operands = (counted,) if reset is None else (counted, reset)
        _, upper = _in_nanoseconds(count.window)
        return self.make(ir.Counted, op, operands, upper, limit, turned, at)

    def _machine(self, node: typed.Machine) -> ir.Machine:
        """A state machine: one node wherever it is asked for, so that it is remembered once."""
        item = node.symbol.item
        assert isinstance(item, ast.State)
        return self.make(
            ir.Machine,
            name=node.symbol.qualified,
            axis=None if node.element is None else self.things.element(node.element),
            states=tuple([state.name for state in item.states]),
            start=item.start.name,
            targets=tuple([one.target for one in node.transitions]),
            sources=tuple([one.sources for one in node.transitions]),
            guards=tuple([self.formula(one.guard) for one in node.transitions]),
            kept=tuple(
                [(place, keep.name) for place, one in enumerate(node.transitions) for keep in one.kept]
            ),
            numbers=tuple([self.number(keep.value) for one in node.transitions for keep in one.kept]),
            bridges=nanoseconds(node.bridges),
        )

    def _over_run(
        self, node: typed.Temporal | typed.Until | typed.Step | typed.Edge, at: Span, site: Span | None
    ) -> ir.Formula:
        """The same of the run, whose times are whole nanoseconds."""
        make = self.make
        match node:
            case typed.Temporal():
                low, high = _in_nanoseconds(node.window)
                return make(ir.OverRun, node.op, (self.formula(node.operand, site),), low, high, False, at)
            case typed.Until():
                low, high = _in_nanoseconds(node.window)
                sides = self.formula(node.left, site), self.formula(node.right, site)
                return make(ir.OverRun, node.op, sides, low, high, False, at)
            case typed.Step():
                return make(
                    ir.OverRun, node.op, (self.formula(node.operand, site),), None, None, node.weak, at
                )
            case typed.Edge():
                now = self.formula(node.operand, site)
                denied = make(ir.Not, now)
                before, now = (denied, now) if node.op == "rising" else (now, denied)
                return make(
                    ir.Connective, "and", make(ir.OverRun, "previous", (before,), None, None, True, at), now
                )
            case _:
                assert_never(node)


#: What a comparison with a count is in the core, and whether its sides change places.
_COUNTED: dict[typed.Comparing, tuple[ComparisonOp, bool]] = {
    "<": ("<", False), "<=": ("<=", False), "==": ("==", False), "!=": ("!=", False), ">": ("<", True), ">=": ("<=", True),
}  # fmt: skip


def _in_nanoseconds(window: typed.Window | None) -> tuple[int | None, int | None]:
    if window is None:
        return None, None
    low, high = window.seconds
    return nanoseconds(low), nanoseconds(high)


def _bounds(window: typed.Window | None) -> tuple[float | None, float | None]:
    return (None, None) if window is None else window.seconds


def _of_limit(left: tuple[typed.Number, ir.Num], right: tuple[typed.Number, ir.Num]) -> str:
    """The unit in which a comparison's limit is written: that of the side which depends on no input, else of the right one."""
    for number, core in (right, left):
        if all(isinstance(node, _FIXED) for node in ir.walked(core)):
            return number.written
    return right[0].written or left[0].written
