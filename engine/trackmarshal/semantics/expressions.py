"""Expressions: names resolved, dimensions checked, lowered to the IR. All errors of an expression are found."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any, NoReturn

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import (
    ARITHMETIC,
    COMPARISONS,
    CONNECTIVES,
    OVER_RUN,
    QUANTIFIERS,
    TEMPORAL,
    UNTIL,
    known,
)
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import SignalType
from trackmarshal.node import Node
from trackmarshal.semantics import calls
from trackmarshal.semantics.advice import Advice
from trackmarshal.semantics.constants import literal_problem
from trackmarshal.semantics.errors import (
    BadValue,
    DimensionMismatch,
    Duplicate,
    RunAxis,
    TooLarge,
    UnknownField,
    UnknownReference,
    UnusedVariable,
    WrongKind,
)
from trackmarshal.semantics.scope import Scope, Symbol, spoken
from trackmarshal.semantics.values import (
    AreaValue,
    Broken,
    FormulaValue,
    LineValue,
    NumberValue,
    Poison,
    RecordValue,
    SignalValue,
    Value,
    common,
    of_limit,
    own_unit,
    product,
    written_unit,
)  # fmt: skip
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import (
    NUMBER,
    TIME,
    Dimension,
    in_full,
    over,
    parse_unit,
    power,
    quantity,
    show,
    times,
    to_si,
)


class Context(Node):
    """Where an expression stands: the names it sees, how deep it is nested, which timeline it lives on."""

    scope: Scope
    local: dict[str, Value]
    level: int
    timeline: ir.Axis | None
    #: The call in the rule's own file, while a definition is written out.
    site: Span | None
    #: Definitions being written out, outermost first.
    stack: tuple[str, ...]

    def bind(self, names: dict[str, Value], levels: int = 0, timeline: ir.Axis | None = None) -> Context:
        """This context with more local names, and `levels` more axes in use."""
        return Context(
            self.scope,
            {**self.local, **names},
            self.level + levels,
            timeline or self.timeline,
            self.site,
            self.stack,
        )


#: What to do instead of remembering something.
STATE_HINT = "write what the rule needs from the signals of one cycle"


class Expressions:
    """Lowers expressions; `signals` maps the names of signals to their types, `found` collects diagnostics."""

    def __init__(
        self, interner: ir.Interner, signals: dict[str, SignalType], found: list[Diagnostic]
    ) -> None:
        self.make = interner.make
        self.signals = signals
        self.found = found
        self.scopes: dict[str, Scope] = {}
        #: Names of tables -> (dimension of the argument, of the result).
        self.tables: dict[str, tuple[Dimension, Dimension]] = {}
        self.params: dict[str, Dimension] = {}
        self.advice = Advice(signals)
        #: Definitions (qualified names) whose bodies have errors: nothing more is said about their uses.
        self.failed: set[str] = set()
        #: How many definitions were written out for the declaration at hand.
        self.expansions = 0

    def attempt(self, step: Callable[[], None], span: Span) -> bool:
        """Check one declaration, or one clause: whether it has a meaning; what keeps it from one was reported."""
        self.expansions = 0
        try:
            step()
        except Poison:
            return False
        except RecursionError:
            self.too_deep(span)
            return False
        return True

    def too_deep(self, span: Span) -> None:
        """Report what exhausted the stack: expressions may be deep, and definitions too, but not both."""
        self.found.append(TooLarge(span, "nested too deeply"))

    def advise(self, diagnostic: Diagnostic | None) -> None:
        """Report what was found, if anything was; fail where it is an error."""
        if diagnostic is not None and diagnostic.level == "error":
            self.fail(diagnostic)
        if diagnostic is not None:
            self.found.append(diagnostic)

    def fail(self, diagnostic: Diagnostic) -> NoReturn:
        self.found.append(diagnostic)
        raise Poison

    def all(self, *steps: Callable[[], Any]) -> list[Any]:
        """Run all steps, so that the errors of each are reported; then fail if one did."""
        values, failed = [], False
        for step in steps:
            try:
                values.append(step())
            except Poison:
                failed = True
        if failed:
            raise Poison
        return values

    def number(self, expr: ast.Expr, ctx: Context) -> NumberValue:
        value = self.value(expr, ctx)
        if not isinstance(value, NumberValue):
            hint = (
                "`if FORMULA then 1 else 0` makes a number of a formula"
                if isinstance(value, FormulaValue)
                else ""
            )
            self.fail(WrongKind(_span(expr), "a number", value.spoken, hint))
        return value

    def formula(self, expr: ast.Expr, ctx: Context) -> FormulaValue:
        value = self.value(expr, ctx)
        if not isinstance(value, FormulaValue):
            hint = "compare it with something" if isinstance(value, NumberValue) else ""
            self.fail(WrongKind(_span(expr), "a formula", value.spoken, hint))
        return value

    def value(self, expr: ast.Expr, ctx: Context) -> Value:
        span = _span(expr)
        match expr:
            case ast.Number():
                problem = literal_problem(expr.text, expr.unit or "1")
                if problem:
                    self.fail(BadValue(span, problem, None, "is an exponent or a unit wrong?"))
                value = to_si(float(expr.text), expr.unit or "1")
                bare, unit = not expr.unit and value != 0.0, own_unit(expr.unit)
                dimension = parse_unit(expr.unit or "1")[2]
                return NumberValue(self.make(ir.Const, value), dimension, span, bare, unit)
            case ast.Boolean():
                return FormulaValue(self.make(ir.Truth, expr.value), span)
            case ast.Name():
                return self._name(expr, ctx)
            case ast.Attribute():
                return self._attribute(expr, ctx)
            case ast.Call():
                return calls.call(self, expr.function, expr.args, expr.names, span, ctx)
            case ast.Infix():
                return calls.call(self, expr.predicate, (expr.left, expr.right), ("", ""), span, ctx)
            case ast.Unary():
                if expr.op == "not":
                    return FormulaValue(self.make(ir.Not, self.formula(expr.operand, ctx).node), span)
                operand = self.number(expr.operand, ctx)
                if isinstance(operand.node, ir.Const):
                    node: ir.Num = self.make(ir.Const, -operand.node.value)
                    return NumberValue(node, operand.dimension, span, operand.bare, operand.written)
                node = self.make(ir.Neg, operand.node)
                return NumberValue(node, operand.dimension, span, False, operand.written)
            case ast.Binary():
                return self._binary(expr, ctx)
            case ast.IfElse():
                return self._if_else(expr, ctx)
            case ast.Within():
                return self._chained(
                    (expr.lower, expr.value, expr.upper), ("<=", "<="), (span, span), span, ctx
                )
            case ast.Chained():
                ends = zip(expr.operands, expr.operands[1:])
                spans = tuple(_span(left).to(_span(right)) for left, right in ends)
                return self._chained(expr.operands, expr.ops, spans, span, ctx)
            case ast.InZone():
                return self._in_zone(expr, ctx)
            case ast.Temporal():
                return self._temporal(expr, ctx)
            case ast.Until():
                return self._until(expr, ctx)
            case ast.Quantified():
                return self._quantified(expr, ctx)
            case _:
                raise AssertionError(f"unknown expression {type(expr).__name__}")

    # Names ------------------------------------------------------------------------------------------------

    def _name(self, expr: ast.Name, ctx: Context) -> Value:
        if expr.name in ctx.local:
            value = ctx.local[expr.name]
            if isinstance(value, Broken):
                raise Poison  # the error is where the name was bound
            return type(value)(**{**value.__dict__, "span": expr.span})  # messages point to the use
        if expr.name == "pi" and ctx.scope.find("pi") is None:
            return NumberValue(self.make(ir.Const, math.pi), NUMBER, expr.span)
        return self._symbol(
            self.look_up(expr.name, expr.span, "name", {*ctx.local, "pi"}, ctx), expr.span, ctx
        )

    def look_up(self, name: str, span: Span, what: str, extra: set[str], ctx: Context) -> Symbol:
        """A declared name; fails with what is wrong with it."""
        found = ctx.scope.look_up(name, span, what, extra)
        if isinstance(found, Symbol):
            return found
        if isinstance(found, Diagnostic):
            self.fail(found)
        raise Poison  # reported with the declaration

    def _symbol(self, symbol: Symbol, span: Span, ctx: Context) -> Value:
        item = symbol.item
        match item:
            case ast.Signal():
                signal = self.signals[item.name]
                if signal.kind == "state":
                    return self.record(
                        signal,
                        f"the state `{signal.name}`",
                        span,
                        lambda f: self.make(ir.Scalar, signal.name, f),
                    )
                if signal.kind == "polyline":
                    return LineValue(self.make(ir.Line, "signal", signal.name, ""), span)
                return SignalValue(signal, span)
            case ast.Event():
                return FormulaValue(self.make(ir.Flag, item.name, None, None, 0, ctx.site or span), span)
            case ast.Param():
                if symbol.qualified not in self.params:
                    raise Poison  # its declaration was reported
                param = self.make(ir.Param, symbol.qualified)
                return NumberValue(
                    param, self.params[symbol.qualified], span, written=written_unit((item.value,), item.unit)
                )
            case ast.Place():
                if item.kind == "zone":
                    return AreaValue(self.make(ir.Area, "zone", symbol.qualified), span)
                return LineValue(self.make(ir.Line, "place", symbol.qualified, ""), span)
            case ast.Define() if not item.parameters:
                return calls.expand(self, symbol, item, [], span, ctx)
            case ast.Define() | ast.Table():
                self.fail(
                    WrongKind(span, "a value", f"the function `{item.name}`", f"call it: `{item.name}(...)`")
                )
            case ast.State():
                self.fail(RunAxis(span, f"state `{item.name}`", STATE_HINT))
            case ast.Reference() | ast.Rulebook():
                self.fail(WrongKind(span, "a value", f"the name of a {type(item).__name__.lower()}"))
            case _:
                raise AssertionError(f"unknown symbol {type(item).__name__}")

    def record(
        self, signal: SignalType, what: str, span: Span, number: Callable[[str], ir.Num],
        axis: ir.Axis | None = None, offset: int = 0, previous: Callable[[str], ir.Num] | None = None,
    ) -> RecordValue:  # fmt: skip
        """A record of a signal; `number` makes the node that reads one of its fields."""

        def reader(make: Callable[[str], ir.Num]) -> Callable[[str, Span], ir.Num | ir.Formula]:
            def read(name: str, at: Span) -> ir.Num | ir.Formula:
                field = signal.field(name)
                if field is not None and field.kind == "bool":
                    return self.make(ir.Flag, signal.name, name, axis, offset, at)
                return make(name)

            return read

        shape = {
            f.name: None if f.kind == "bool" else parse_unit(f.unit)[2]
            for f in signal.fields_
            if f.kind != "polyline"
        }
        return RecordValue(what, signal, shape, reader(number), reader(previous) if previous else None, span)

    def _attribute(self, expr: ast.Attribute, ctx: Context) -> Value:
        value = self.value(expr.value, ctx)
        span = expr.span
        if isinstance(value, RecordValue):
            if expr.name not in value.shape:
                hint = close_matches(expr.name, value.shape)
                if not hint and value.signal is not None and value.signal.field(expr.name) is not None:
                    hint = "the definition asks for a shape without it"
                elif not hint:
                    hint = "only what a signal's declaration lists can be read"
                self.fail(UnknownField(span, value.what, expr.name, ", ".join(value.shape), hint))
            node = value.read(expr.name, ctx.site or span)
            dimension = value.shape[expr.name]
            if isinstance(node, ir.Formula):
                return FormulaValue(node, span)
            assert dimension is not None
            field = None if value.signal is None else value.signal.field(expr.name)
            return NumberValue(node, dimension, span, written="" if field is None else own_unit(field.unit))
        if isinstance(value, SignalValue):
            signal = value.signal
            if signal.sequence and expr.name in ("first", "last"):
                index = 0 if expr.name == "first" else -1
                what = f"the {expr.name} sample of `{signal.name}`"
                return self.record(signal, what, span, lambda f: self.make(ir.Sample, signal.name, f, index))
            field = signal.field(expr.name)
            if field is not None and field.kind == "polyline" and not signal.many:
                return LineValue(self.make(ir.Line, "signal", signal.name, expr.name), span)
            known = (
                ["first", "last"]
                if signal.sequence
                else [f.name for f in signal.fields_ if f.kind == "polyline"]
            )
            hint, shown = close_matches(expr.name, known), ", ".join(known)
            if signal.sequence or signal.many:
                parts = f"{'samples' if signal.sequence else 'elements'} with {', '.join(f.name for f in signal.fields_)}"
                shown = f"{shown}, and {parts}" if shown else parts
            if signal.field(expr.name) is not None:
                hint = f"bind a variable first: `for all x in {signal.name}`"
            self.fail(UnknownField(span, value.spoken, expr.name, shown or "nothing to read", hint))
        self.fail(WrongKind(_span(expr.value), "a record", value.spoken))

    # Arithmetic and logic -----------------------------------------------------------------------------------

    def _binary(self, expr: ast.Binary, ctx: Context) -> Value:
        op, span = expr.op, expr.span
        if op in CONNECTIVES:
            a, b = self.all(lambda: self.formula(expr.left, ctx), lambda: self.formula(expr.right, ctx))
            return FormulaValue(self.make(ir.Connective, known(op, CONNECTIVES), a.node, b.node), span)
        if op == "^":
            return self._power(expr, ctx)
        left, right = self.all(lambda: self.number(expr.left, ctx), lambda: self.number(expr.right, ctx))
        if op in ("*", "/"):
            dimension = (
                times(left.dimension, right.dimension) if op == "*" else over(left.dimension, right.dimension)
            )
            bare = left.bare and right.bare
            arith = self.make(ir.Arith, known(op, ARITHMETIC), left.node, right.node)
            return NumberValue(arith, dimension, span, bare, product(op, left, right))
        if op in COMPARISONS:
            return self._compare(op, left, right, span, ctx)
        self.same("add" if op == "+" else "subtract", left, right)
        bare = left.bare and right.bare
        return NumberValue(
            self.make(ir.Arith, known(op, ARITHMETIC), left.node, right.node),
            left.dimension,
            span,
            bare,
            common(left, right),
        )

    def _chained(
        self,
        operands: tuple[ast.Expr, ...],
        ops: tuple[str, ...],
        spans: tuple[Span, ...],
        span: Span,
        ctx: Context,
    ) -> FormulaValue:
        """Neighbours compared, and all of it joined by `and`; every operand stands for one number, however often it is compared."""
        numbers = self.all(*(lambda o=operand: self.number(o, ctx) for operand in operands))
        compared = self.all(
            *(
                lambda op=op, left=left, right=right, at=at: self._compare(op, left, right, at, ctx)
                for op, left, right, at in zip(ops, numbers, numbers[1:], spans)
            )
        )
        node = compared[0].node
        for other in compared[1:]:
            node = self.make(ir.Connective, "and", node, other.node)
        return FormulaValue(node, span)

    def _compare(
        self, op: str, left: NumberValue, right: NumberValue, span: Span, ctx: Context
    ) -> FormulaValue:
        self.same("compare", left, right)
        self.advise(self.advice.compared(op, left, right, span))
        unit, shown = show(left.dimension), of_limit(left, right)
        node = self.make(
            ir.Compare, known(op, COMPARISONS), left.node, right.node, unit, ctx.site or span, shown
        )
        return FormulaValue(node, span)

    def same(self, action: str, left: NumberValue, right: NumberValue) -> None:
        """Fail unless two numbers have one dimension."""
        if left.dimension == right.dimension:
            self.advise(self.advice.joined(left, right))
            return
        sides = (
            ("left side", "right side")
            if action in ("compare", "add", "subtract")
            else ("first one", "second one")
        )
        hint = calls.decimal_comma(left.span, right.span)
        hint = hint or calls.unit_hint(right, left.dimension) or calls.unit_hint(left, right.dimension)
        hint = hint or _factor(left.dimension, right.dimension, *sides)
        self.fail(
            DimensionMismatch(
                left.span, right.span, action, quantity(left.dimension), quantity(right.dimension), hint
            )
        )

    def _power(self, expr: ast.Binary, ctx: Context) -> Value:
        base, exponent = self.all(lambda: self.number(expr.left, ctx), lambda: self.number(expr.right, ctx))
        if exponent.dimension != NUMBER:
            self.fail(
                BadValue(exponent.span, f"an exponent is a plain number, not {quantity(exponent.dimension)}")
            )
        constant = exponent.node.value if isinstance(exponent.node, ir.Const) else None
        if constant is not None and constant == int(constant) and 1 <= abs(constant) <= 8:
            node = base.node
            for _ in range(
                int(abs(constant)) - 1
            ):  # defined as repeated multiplication, not as a library's pow
                node = self.make(ir.Arith, "*", node, base.node)
            if constant < 0:
                node = self.make(ir.Arith, "/", self.make(ir.Const, 1.0), node)
            return NumberValue(node, power(base.dimension, Fraction(int(constant))), expr.span)
        if base.dimension != NUMBER:
            hint = (
                "use sqrt(...) for a root"
                if constant == 0.5
                else "divide the base by a reference quantity first"
            )
            problem = f"the exponent of {quantity(base.dimension)} must be a literal whole number from 1 to 8, or from -8 to -1"
            if constant is not None:
                problem += f", not {in_full(constant, '1')}"
            self.fail(
                BadValue(exponent.span, problem, base.span, hint, f"this is {quantity(base.dimension)}")
            )
        return NumberValue(self.make(ir.Func, "pow", (base.node, exponent.node)), NUMBER, expr.span)

    def _if_else(self, expr: ast.IfElse, ctx: Context) -> Value:
        condition, then, otherwise = self.all(
            lambda: self.formula(expr.condition, ctx),
            lambda: self.number(expr.then, ctx),
            lambda: self.number(expr.otherwise, ctx),
        )
        self.same("choose between", then, otherwise)
        node = self.make(ir.Choose, condition.node, then.node, otherwise.node)
        return NumberValue(node, then.dimension, expr.span, written=common(then, otherwise))

    def _in_zone(self, expr: ast.InZone, ctx: Context) -> Value:
        at = Span(expr.span.file, _span(expr.value).end, expr.span.end).word(expr.zone)
        found = self.look_up(expr.zone, at, "zone", set(), ctx)
        if not isinstance(found.item, ast.Place) or found.item.kind != "zone":
            self.fail(WrongKind(at, "a zone", f"the {spoken(found.item)} `{expr.zone}`"))
        area = self.make(ir.Area, "zone", found.qualified)
        x, y = calls.fields(self, self.value(expr.value, ctx), "point", _span(expr.value), ctx)
        return FormulaValue(self.make(ir.InArea, x, y, area, ctx.site or expr.span), expr.span)

    # Time and quantifiers -----------------------------------------------------------------------------------

    def _temporal(self, expr: ast.Temporal, ctx: Context) -> Value:
        (operand,), (lower, upper) = self._over_time((expr.operand,), expr.window, ctx)
        axis = ctx.timeline
        if axis is None:
            return self.over_run(expr.op, (operand,), lower, upper, expr.weak, expr.span, ctx)
        if expr.op in ("next", "previous"):
            shift = self.make(ir.Shift, axis, operand, 1 if expr.op == "next" else -1, expr.weak)
            return FormulaValue(shift, expr.span)
        op = known(expr.op, TEMPORAL)
        return FormulaValue(self.make(ir.Temporal, op, axis, operand, lower, upper), expr.span)

    def _over_time(
        self, operands: tuple[ast.Expr, ...], window: ast.Window | None, ctx: Context
    ) -> tuple[list[ir.Formula], tuple[float | None, float | None]]:
        """Operands and window of a temporal operator; the errors of all of them are reported."""
        bounds, *formulas = self.all(
            lambda: self._window(window, ctx), *(lambda o=operand: self.formula(o, ctx).node for operand in operands)
        )  # fmt: skip
        return formulas, bounds

    def _until(self, expr: ast.Until, ctx: Context) -> Value:
        (left, right), (lower, upper) = self._over_time((expr.left, expr.right), expr.window, ctx)
        axis = ctx.timeline
        if axis is None:
            return self.over_run(expr.op, (left, right), lower, upper, False, expr.span, ctx)
        op = known(expr.op, UNTIL)
        return FormulaValue(self.make(ir.Until, op, axis, left, right, lower, upper), expr.span)

    def over_run(
        self, op: str, operands: tuple[ir.Formula, ...], lower: float | None, upper: float | None, weak: bool, span: Span, ctx: Context
    ) -> FormulaValue:  # fmt: skip
        """A temporal operator of a rule without a timeline: cycle by cycle over the run. Times of the run are whole nanoseconds."""
        low, high = (None if bound is None else nanoseconds(bound) for bound in (lower, upper))
        node = self.make(ir.OverRun, known(op, OVER_RUN), operands, low, high, weak, ctx.site or span)
        return FormulaValue(node, span)

    def _window(self, window: ast.Window | None, ctx: Context) -> tuple[float | None, float | None]:
        if window is None:
            return None, None
        low, high = self.all(lambda: self._bound(window.lower, ctx), lambda: self._bound(window.upper, ctx))
        if low < 0:
            past = "`once`, `historically` and `since` look back"
            hint = f"windows count away from the current sample; {past}"
            problem = f"a window starts at zero or later, not at {in_full(low, 's')}"
            self.fail(BadValue(_span(window.lower), problem, None, hint))
        if high < low:
            problem = f"a window runs from low to high, not from {in_full(low, 's')} to {in_full(high, 's')}"
            self.fail(BadValue(window.span, problem, None, "swap the bounds"))
        return low, high

    def deadline(self, limit: ast.Expr, ctx: Context) -> float:
        """How long after a cycle something has to happen, in s: a literal time."""
        value = self._bound(limit, ctx)
        if value < 0.0:
            problem = f"a deadline is not before the cycle that it counts from, at {in_full(value, 's')}"
            self.fail(BadValue(_span(limit), problem))
        return value

    def _bound(self, bound: ast.Expr, ctx: Context) -> float:
        """A bound of a window: a literal time, in s."""
        value = self.number(bound, ctx)
        if value.dimension != TIME:
            problem = f"the window of a temporal operator is a time, not {quantity(value.dimension)}"
            self.fail(BadValue(value.span, problem, None, calls.unit_hint(value, TIME)))
        if not isinstance(value.node, ir.Const):
            self.fail(
                BadValue(
                    value.span,
                    "the window of a temporal operator is constant",
                    None,
                    "write a number with a unit of time",
                )
            )
        return value.node.value

    def axis(
        self, domain: ast.Expr, names: tuple[str, ...], consecutive: bool, span: Span, ctx: Context
    ) -> tuple[ir.Axis, dict[str, Value]]:
        """The axis of a quantifier and its variables."""
        value = self.value(domain, ctx)
        if not isinstance(value, SignalValue) or not (value.signal.sequence or value.signal.many):
            self.fail(WrongKind(_span(domain), "a timeline or a set", value.spoken))
        signal = value.signal
        if len(names) > 1 and not consecutive:
            hint = f"write `consecutive {', '.join(names)}`, or a quantifier for each"
            self.fail(
                UnknownReference(span, "several variables range together over consecutive samples only", hint)
            )
        if consecutive and not signal.sequence:
            self.fail(
                UnknownReference(
                    span, f"the elements of `{signal.name}` have no order", "remove `consecutive`"
                )
            )
        if consecutive and len(names) < 2:
            self.fail(
                UnknownReference(
                    span, "`consecutive` binds two or more samples", "add a variable, or remove `consecutive`"
                )
            )
        axis = self.make(
            ir.Axis, signal.name, "samples" if signal.sequence else "elements", len(names), ctx.level
        )
        variables: dict[str, Value] = {}
        for offset, name in enumerate(names):
            if name in variables:
                self.fail(UnknownReference(span, f"`{name}` is bound twice", "give each its own name"))
            self.check_new(name, span, ctx)
            variables[name] = self._variable(signal, axis, offset, name, span)
        return axis, variables

    def check_new(self, name: str, span: Span, ctx: Context) -> None:
        """Report a variable that would hide another one: it is not said which of the two is meant."""
        known = ctx.local.get(name)
        if known is not None and not isinstance(known, Broken):
            self.found.append(Duplicate(span.word(name), known.__dict__["span"].head, "variable", name))
        else:
            ctx.scope.check_bound(name, span.word(name), "variable")

    def _variable(self, signal: SignalType, axis: ir.Axis, offset: int, name: str, span: Span) -> RecordValue:
        what = f"`{name}` ({'a sample' if signal.sequence else 'an element'} of `{signal.name}`)"

        def number(field: str) -> ir.Num:
            return self.make(ir.Column, axis, field, offset)

        def previous(field: str) -> ir.Num:
            return self.make(ir.Column, axis, field, offset - 1)

        return self.record(signal, what, span, number, axis, offset, previous if signal.sequence else None)

    def _quantified(self, expr: ast.Quantified, ctx: Context) -> Value:
        axis, variables = self.range_of(expr, ctx)
        inner = ctx.bind(variables, 1)
        self.check_used(expr.names, (expr.where, expr.body), expr.span.head)
        guard, body = self.all(
            lambda: self.formula(expr.where, inner).node if expr.where is not None else None,
            lambda: self.formula(expr.body, inner).node,
        )
        if axis is None:
            raise Poison
        return FormulaValue(
            self.make(ir.Quantify, known(expr.quantifier, QUANTIFIERS), axis, guard, body, expr.names),
            expr.span,
        )

    def range_of(
        self, bind: ast.Bind | ast.Quantified, ctx: Context
    ) -> tuple[ir.Axis | None, dict[str, Value]]:
        """The axis and the variables of a quantifier; where its range has an error, no axis and broken variables."""
        try:
            return self.axis(bind.domain, bind.names, bind.consecutive, bind.span.head, ctx)
        except Poison:
            return None, dict.fromkeys(bind.names, Broken())

    def check_used(self, names: tuple[str, ...], parts: tuple[Node | None, ...], span: Span) -> None:
        """Warn of a quantifier none of whose variables is mentioned below."""
        used = {
            node.name
            for part in parts
            if part is not None
            for node in part.walk()
            if isinstance(node, ast.Name)
        }
        if used.isdisjoint(names):
            self.found.append(UnusedVariable(span, "`, `".join(names)))


def _span(expr: ast.Expr) -> Span:
    span: Span = expr.__dict__["span"]
    return span


def _factor(left: Dimension, right: Dimension, a: str, b: str) -> str:
    """What would make two dimensions one; `a` and `b` are what messages call the two."""
    if power(right, Fraction(2)) == left:
        return f"square the {b}, or take the square root of the {a}"
    if power(left, Fraction(2)) == right:
        return f"square the {a}, or take the square root of the {b}"
    factor = over(right, left)
    unit, inverse = show(factor), show(over(NUMBER, factor))
    if unit.startswith("1/"):
        return f"divide the {a} by a quantity in {inverse}, or multiply the {b} by it"
    return f"multiply the {a} by a quantity in {unit}, or divide the {b} by it"
