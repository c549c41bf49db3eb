"""Expressions: names resolved, dimensions checked; syntax tree to typed tree. All errors of an expression are found."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any, NoReturn, TypeVar

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir.spec import CourseInfo, Enumeration, SignalType
from trackmarshal.semantics.advice.bounds import Bounds
from trackmarshal.semantics.advice.units import Advice
from trackmarshal.semantics.errors.expressions import BadValue, TooLarge, WrongKind
from trackmarshal.semantics.expressions import (
    arithmetic,
    calls,
    formulas,
    machines,
    members,
    names,
    places,
    quantifiers,
    temporal,
)
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.sharing import Shared
from trackmarshal.semantics.scope import Scope
from trackmarshal.semantics.values import Poison, in_si, own_unit, spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import Dimension, parse_unit

T = TypeVar("T")


def _run(step: Callable[[], Any]) -> Any:
    return step()


class Expressions:
    """Makes typed nodes of expressions; `signals` maps the names of signals to their types, `found` collects diagnostics."""

    def __init__(self, signals: dict[str, SignalType], found: list[Diagnostic]) -> None:
        self.signals = signals
        self.found = found
        self.scopes: dict[str, Scope] = {}
        #: By qualified name the fields of declared shapes: those that they declare themselves, and all.
        self.own_fields: dict[str, dict[str, Dimension | Enumeration | None]] = {}
        self.shapes: dict[str, typed.Shape] = {}
        #: By qualified name the units in which shapes declare their numbers.
        self.units: dict[str, dict[str, str]] = {}
        #: By qualified name the shapes of records of parameters.
        self.records: dict[str, typed.Shape] = {}
        #: SI unit -> the scale of margins in it, where that is declared.
        self.scales: dict[str, float] = {}
        self.params: dict[str, Dimension] = {}
        #: What numbers can come to; the compiler adds what it knows of parameters.
        self.bounds = Bounds(signals, {}, {})
        #: By name.
        self.courses: dict[str, CourseInfo] = {}
        self.advice = Advice()
        self._shapes: dict[str, typed.Shape] = {}
        #: Definitions (qualified names) whose bodies have errors: nothing more is said about their uses.
        self.failed: set[str] = set()
        #: States (qualified names) that something asks for.
        self.asked: set[str] = set()
        #: How many definitions were written out for the declaration at hand.
        self.expansions = 0
        #: How many of them are around the innermost one of the definition that is being written out.
        self.deepest = 0
        self.shared = Shared()

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
        self.found.append(
            TooLarge(span, "nested too deeply", "let fewer names, of `let` or `define`, build on each other")
        )

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
        return self.each(_run, steps)

    def each(self, step: Callable[[T], Any], given: Iterable[T]) -> list[Any]:
        """The same of one step for each that is given."""
        values, failed = [], False
        for one in given:
            try:
                values.append(step(one))
            except Poison:
                failed = True
        if failed:
            raise Poison
        return values

    def literal(self, expr: ast.Number, bare: str = "1") -> tuple[float, Dimension]:
        """What digits are in SI, and of which dimension: in their own unit, else in the unit `bare`."""
        unit = expr.unit or bare
        value, problem = in_si(expr.text, unit)
        if problem:
            self.fail(BadValue(ast.span_of(expr), problem, None, "is an exponent or a unit wrong?"))
        return value, parse_unit(unit)[2]

    def number(self, expr: ast.Expr, ctx: Context) -> typed.Number:
        return self.numeric(self.value(expr, ctx), expr)

    def numeric(self, value: typed.Value, expr: ast.Expr) -> typed.Number:
        """A value that is a number; fails with what to write for any other."""
        if isinstance(value, typed.NumberNode):
            return value
        hint = ""
        if isinstance(value, typed.FormulaNode):
            hint = "`if FORMULA then 1 else 0` makes a number of a formula"
        elif isinstance(value, typed.Count):
            hint = "compare it with a number: `count(...) <= 3`"
        elif isinstance(value, typed.MemberNode):
            hint = members.hint(value)
        self.fail(WrongKind(ast.span_of(expr), "a number", spoken(value), hint))

    def formula(self, expr: ast.Expr, ctx: Context) -> typed.Formula:
        value = self.value(expr, ctx)
        if not isinstance(value, typed.FormulaNode):
            hint = "compare it with something" if isinstance(value, (typed.NumberNode, typed.Count)) else ""
            if isinstance(value, typed.MemberNode):
                hint = members.hint(value)
            if isinstance(value, typed.SignalNode):
                quantifiers.refuse_course(value.signal, ast.span_of(expr), "no formula is made of", self)
            if isinstance(value, typed.SignalNode) and (value.signal.many or value.signal.sequence):
                each = f"o in {ast.span_of(expr).text}"
                hint = (
                    f"ask about what is in it: `exists {each}: (...)`, or how many there are, `count({each})`"
                )
            self.fail(WrongKind(ast.span_of(expr), "a formula", spoken(value), hint))
        return value

    def value(self, expr: ast.Expr, ctx: Context) -> typed.Value:
        span = ast.span_of(expr)
        match expr:  # the most frequent ones first
            case ast.Name():
                return names.name(expr, self, ctx)
            case ast.Attribute():
                return names.attribute(expr, self, ctx)
            case ast.Binary() if expr.op in typed.COMPARISONS:
                return formulas.comparison(expr, self, ctx)
            case ast.Binary() if expr.op in typed.CONNECTIVES:
                return formulas.connective(expr, self, ctx)
            case ast.Binary():
                of = arithmetic.power if expr.op == "^" else arithmetic.arithmetic
                return of(expr, self, ctx)
            case ast.Number():
                value, dimension = self.literal(expr)
                return typed.Literally(dimension, own_unit(expr.unit), expr.text, expr.unit, value, span)
            case ast.Boolean():
                return typed.Boolean(expr.value, span)
            case ast.Call() if expr.function == machines.TIME_IN:
                return machines.time_in(expr, self, ctx)
            case ast.Call():
                return calls.call(self, expr.function, expr.args, expr.names, False, span, ctx)
            case ast.Infix() if expr.predicate == machines.IS:
                return members.asked(expr, self, ctx)
            case ast.Case():
                return members.case(expr, self, ctx)
            case ast.Infix():
                return calls.call(self, expr.predicate, (expr.left, expr.right), ("", ""), True, span, ctx)
            case ast.Unary():
                if expr.op == "not":
                    return typed.Not(self.formula(expr.operand, ctx), span)
                operand = self.number(expr.operand, ctx)
                return typed.Negative(operand.dimension, operand.written, operand, span)
            case ast.IfElse():
                return arithmetic.choice(expr, self, ctx)
            case ast.Within():
                return formulas.within(expr, self, ctx)
            case ast.Chained():
                return formulas.chained(expr, self, ctx)
            case ast.InZone():
                return places.in_zone(expr, self, ctx)
            case ast.InStretch():
                return places.in_stretch(expr, self, ctx)
            case ast.BetweenStations():
                return places.between_stations(expr, self, ctx)
            case ast.Temporal():
                return temporal.temporal(expr, self, ctx)
            case ast.Until():
                return temporal.until(expr, self, ctx)
            case ast.Quantified():
                return quantifiers.quantified(expr, self, ctx)
            case ast.Folded():
                return quantifiers.folded(expr, self, ctx)
            case _:
                raise AssertionError(f"unknown expression {type(expr).__name__}")

    def look_up(self, name: str, span: Span, what: str, extra: set[str], ctx: Context) -> typed.Symbol:
        """A declared name; fails with what is wrong with it."""
        found = ctx.scope.look_up(name, span, what, extra)
        if isinstance(found, typed.Symbol):
            return found
        if isinstance(found, Diagnostic):
            self.fail(found)
        raise Poison  # reported with the declaration

    def shape(self, signal: SignalType) -> typed.Shape:
        """What can be read of a record of a signal."""
        shape = self._shapes.get(signal.name)
        if shape is None:
            shape = self._shapes[signal.name] = {
                f.name: None if f.kind == "bool" else f.enumeration or parse_unit(f.unit)[2]
                for f in signal.fields_
                if f.kind != "polyline"
            }
        return shape
