"""Inline tests to cases: builders called, units converted, expectations in SI; everything wrong is reported."""

from __future__ import annotations

import math
from typing import Any

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import FieldType, RuleInfo, SignalType
from trackmarshal.node import Node
from trackmarshal.semantics.compile import Compiled
from trackmarshal.semantics.constants import constant_value
from trackmarshal.semantics.expressions import Context
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.testing.builders import BUILDERS, Builder
from trackmarshal.testing.errors import BadExpectation, BadGiven, UnknownRuleOfTest
from trackmarshal.units import LENGTH, NUMBER, Dimension, from_si, name, parse_unit, show

VERDICTS = ("satisfied", "violated", "undefined", "inactive")


class PreparedTest(Node):
    """A test ready to run: the rule, the case as plain data, and what is expected in SI."""

    rule: RuleInfo
    title: str
    case: dict[str, Any]
    verdict: str
    margin: float | None
    tolerance: float
    binder: str | None
    at: str | None
    span: Span

    @property
    def boundary(self) -> bool:
        """Whether the test stands exactly on the boundary of its rule: it expects a margin of zero."""
        return self.margin == 0.0


def prepare(compiled: Compiled) -> tuple[list[PreparedTest], list[Diagnostic]]:
    """All tests that have a meaning, and what is wrong with the others."""
    prepared: list[PreparedTest] = []
    found: list[Diagnostic] = []
    titles: dict[tuple[str, str], Span] = {}
    for module in compiled.order:
        for item in compiled.library.modules[module].tree.items:
            if not isinstance(item, ast.Test):
                continue
            rule = compiled.spec.rule(item.rule)
            if rule is None:
                continue  # the compiler reported the name, or the rule's own errors
            if rule.formula is None:
                found.append(UnknownRuleOfTest(_head(item.span), item.rule))
                continue
            if (item.rule, item.title) in titles:
                found.append(
                    BadGiven(
                        _head(item.span),
                        "another test of this rule has the same title",
                        "say what this one shows",
                    )
                )
            titles[item.rule, item.title] = item.span
            try:
                prepared.append(_Preparation(compiled, module, found).test(item, rule))
            except Poison:
                continue
    return prepared, found


class _Preparation:
    def __init__(self, compiled: Compiled, module: str, found: list[Diagnostic]) -> None:
        self._spec = compiled.spec
        self._scope = compiled.scopes[module]
        self._x = compiled.expressions
        self._ctx = Context(self._scope, {}, 0, None, None, ())
        self._found = found

    def fail(self, span: Span, problem: str, hint: str = "") -> None:
        self._found.append(BadGiven(span, problem, hint))
        raise Poison

    def test(self, item: ast.Test, rule: RuleInfo) -> PreparedTest:
        case: dict[str, Any] = {"id": item.title, "signals": {}, "params": {}, "tables": {}, "places": {}}
        failed = False
        given: set[str] = set()
        for entry in item.givens:
            try:
                if entry.name in given:
                    self.fail(entry.span, f"`{entry.name}` is given twice")
                given.add(entry.name)
                self._given(entry, case)
            except Poison:
                failed = True
        expect = self._expectation(item.expect, rule, item)
        if failed:
            raise Poison
        return PreparedTest(rule, item.title, case, *expect, _head(item.span))

    # What is given --------------------------------------------------------------------------------------------

    def _given(self, entry: ast.Given, case: dict[str, Any]) -> None:
        symbol = self._scope.find(entry.name)
        item = symbol.item if symbol is not None else None
        if symbol is None or not isinstance(item, (ast.Signal, ast.Event, ast.Param, ast.Table, ast.Place)):
            known = [
                n
                for n in self._scope.names()
                if isinstance(getattr(self._scope.find(n), "item", None), (ast.Signal, ast.Event, ast.Param))
            ]
            self.fail(
                entry.span,
                f"`{entry.name}` is no signal, event, parameter, table or place",
                close_matches(entry.name, known),
            )
            return
        if entry.changes and not (isinstance(item, ast.Signal) and self._spec.signals[item.name].sequence):
            self.fail(entry.changes[0].span, "`with` changes columns of a timeline")
        match item:
            case ast.Signal():
                case["signals"][entry.name] = self._signal(self._spec.signals[item.name], entry)
            case ast.Event():
                if not isinstance(entry.value, ast.Boolean):
                    self.fail(entry.span, "an event is true or false")
                else:
                    case["signals"][entry.name] = entry.value.value
            case ast.Param():
                info = self._spec.params[symbol.qualified]
                case["params"][symbol.qualified] = self._number(entry.value, info.unit)
            case ast.Table():
                units = self._spec.tables[symbol.qualified].units
                case["tables"][symbol.qualified] = [self._pair(row, units) for row in self._list(entry.value)]
            case ast.Place():
                case["places"][symbol.qualified] = [
                    self._pair(row, ("m", "m")) for row in self._list(entry.value)
                ]

    def _signal(self, signal: SignalType, entry: ast.Given) -> Any:
        if signal.many:
            return [self._record(signal, element) for element in self._list(entry.value)]
        if signal.sequence:
            columns = self._columns(signal, entry.value)
            for change in entry.changes:
                self._change(signal, columns, change)
            return columns
        if signal.kind == "state":
            return self._record(signal, entry.value)
        if signal.kind == "polyline":
            return [self._pair(row, ("m", "m")) for row in self._list(entry.value)]
        if isinstance(entry.value, ast.Call):
            return self._build(entry.value, "corridor")
        if not isinstance(entry.value, ast.RecordValue):
            self.fail(entry.span, "a corridor is built, or given as { left: [...], right: [...] }")
        assert isinstance(entry.value, ast.RecordValue)
        result: dict[str, Any] = {}
        for field, value in zip(entry.value.names, entry.value.values):
            if field == "closed" and isinstance(value, ast.Boolean):
                result[field] = value.value
            else:
                result[field] = [self._pair(row, ("m", "m")) for row in self._list(value)]
        return result

    def _columns(self, signal: SignalType, value: ast.Expr) -> dict[str, Any]:
        if isinstance(value, ast.Call):
            built = self._build(value, "trajectory")
            columns: dict[str, Any] = {}
            for field in signal.fields_:
                if field.name in built:
                    columns[field.name] = [from_si(number, field.unit) for number in built[field.name]]
            return columns
        if not isinstance(value, ast.RecordValue):
            self.fail(
                _span(value),
                "a timeline is built, or given as { column: [...] }",
                "for example `line(v: 20 m/s)`",
            )
        assert isinstance(value, ast.RecordValue)
        given = {}
        for column, content in zip(value.names, value.values):
            field = self._field(signal, column, _span(content))
            given[column] = [self._scalar(field, element) for element in self._list(content)]
        return given

    def _change(self, signal: SignalType, columns: dict[str, Any], change: ast.Change) -> None:
        field = self._field(signal, change.field, change.span)
        count = max((len(column) for column in columns.values()), default=0)
        column = list(
            columns.get(
                change.field, [None if field.default is None else from_si(field.default, field.unit)] * count
            )
        )
        value = self._scalar(field, change.value)
        if change.index is None:
            column = [value] * count
        else:
            index = int(float(change.index))
            if index != float(change.index) or index >= count:
                self.fail(change.span, f"there is no sample {change.index}: the trajectory has {count}")
            column[index] = value
        columns[change.field] = column

    def _build(self, call: ast.Call, kind: str) -> dict[str, Any]:
        builder = BUILDERS.get(call.function)
        fitting = [b.name for b in BUILDERS.values() if b.builds == kind]
        if builder is None or builder.builds != kind:
            hint = close_matches(call.function, fitting) or "there are " + ", ".join(fitting)
            self.fail(call.span, f"`{call.function}` builds no {kind}", hint)
        assert builder is not None
        arguments = self._arguments(call, builder)
        try:
            return builder.build(**arguments)
        except Exception as error:
            self.fail(
                call.span,
                f"{builder.name}: {getattr(error, 'message', error)}",
                getattr(error, "help", None) or "",
            )
            raise AssertionError from error

    def _arguments(self, call: ast.Call, builder: Builder) -> dict[str, float]:
        arguments: dict[str, float] = {}
        for argument, value in zip(call.names, call.args):
            parameter = builder.parameters.get(argument)
            if parameter is None:
                hint = close_matches(argument, builder.parameters) or "it takes " + ", ".join(
                    builder.parameters
                )
                self.fail(
                    _span(value),
                    f"`{builder.name}` has no argument `{argument}`"
                    if argument
                    else "arguments of builders are named",
                    hint,
                )
            assert parameter is not None
            arguments[argument] = self._number(value, parameter.unit)
        missing = [n for n, p in builder.parameters.items() if p.required and n not in arguments]
        if missing:
            self.fail(call.span, f"`{builder.name}` needs {', '.join(missing)}")
        return arguments

    def _record(self, signal: SignalType, value: ast.Expr) -> dict[str, Any]:
        if not isinstance(value, ast.RecordValue):
            self.fail(_span(value), f"`{signal.name}` takes a record", "for example `{ x: 0 m, y: 0 m }`")
        assert isinstance(value, ast.RecordValue)
        return {
            n: self._scalar(self._field(signal, n, _span(v)), v) for n, v in zip(value.names, value.values)
        }

    def _field(self, signal: SignalType, field: str, span: Span) -> FieldType:
        kind = signal.field(field)
        if kind is None:
            names = [f.name for f in signal.fields_]
            self.fail(
                span,
                f"`{signal.name}` has no field `{field}`",
                close_matches(field, names) or "it has " + ", ".join(names),
            )
        assert kind is not None
        return kind

    def _scalar(self, field: FieldType, value: ast.Expr) -> Any:
        if field.kind == "bool":
            if not isinstance(value, ast.Boolean):
                self.fail(_span(value), f"`{field.name}` is true or false")
            return value.value if isinstance(value, ast.Boolean) else None
        return self._number(value, field.unit)

    def _list(self, value: ast.Expr) -> tuple[ast.Expr, ...]:
        if not isinstance(value, ast.ListValue):
            self.fail(_span(value), "a list is needed here", "write [ ... ]")
        assert isinstance(value, ast.ListValue)
        return value.values

    def _pair(self, value: ast.Expr, units: tuple[str, str]) -> list[float]:
        parts = self._list(value)
        if len(parts) != 2:
            self.fail(_span(value), "a pair is needed here", "write [x, y]")
        return [self._number(part, unit) for part, unit in zip(parts, units)]

    def _number(self, value: ast.Expr, unit: str) -> float:
        """A constant in the unit that the data comes in; `nan` and `inf` are allowed here and only here."""
        special = _special(value)
        if special is not None:
            return special
        number = self._si(value, parse_unit(unit)[2], f"a value in {unit}")
        return from_si(number, unit)

    def _si(self, value: ast.Expr, dimension: Dimension, what: str) -> float:
        try:
            checked = self._x.number(value, self._ctx)
        except Poison:
            self._move()
            raise
        if checked.dimension != dimension:
            hint = (
                f"write `{_span(value).text.strip()} {show(dimension)}`"
                if checked.dimension == NUMBER
                else ""
            )
            self.fail(_span(value), f"{what} is needed, this is {checked.spoken}", hint)
        params = self._spec.params
        number = constant_value(checked.node, lambda q: params[q].value if q in params else None)
        if number is None:
            self.fail(_span(value), "a test gives constants")
        assert number is not None
        return number

    def _move(self) -> None:
        """Take over what the expression checker reported."""
        self._found.append(self._x.found.pop())

    # What is expected -----------------------------------------------------------------------------------------

    def _expectation(
        self, expect: ast.Expect, rule: RuleInfo, item: ast.Test
    ) -> tuple[str, float | None, float, str | None, str | None]:  # fmt: skip
        if expect.verdict not in VERDICTS:
            self._wrong(
                expect.span,
                f"`{expect.verdict}` is no verdict",
                close_matches(expect.verdict, VERDICTS) or ", ".join(VERDICTS),
            )
        margin, tolerance = None, 0.0
        if expect.margin is not None:
            margin = self._margin(expect.margin, rule)
            tolerance = 0.0 if expect.tolerance is None else self._margin(expect.tolerance, rule)
        at = expect.at.strip('"') if expect.at is not None else None
        if (
            at is not None
            and expect.at is not None
            and not expect.at.startswith('"')
            and float(at) != int(float(at))
        ):
            self._wrong(expect.span, "an index is a whole number")
        return expect.verdict, margin, tolerance, expect.binder, at

    def _margin(self, value: ast.Expr, rule: RuleInfo) -> float:
        special = _special(value)
        if special is not None:
            return special
        if rule.unit == "mixed":
            self._wrong(
                _span(value), f"the margins of `{rule.name}` have several dimensions; expect the verdict only"
            )
        dimension = LENGTH if rule.unit == "m" else _dimension(rule.unit)
        return self._si(value, dimension, f"{name(dimension)} (the margin of `{rule.name}`)")

    def _wrong(self, span: Span, problem: str, hint: str = "") -> None:
        self._found.append(BadExpectation(span, problem, hint))
        raise Poison


def _dimension(unit: str) -> Dimension:
    return parse_unit(unit.replace("^(", "^").replace(")", ""))[2]


def _special(value: ast.Expr) -> float | None:
    """`nan`, `inf`, `-inf`."""
    sign = 1.0
    if isinstance(value, ast.Unary) and value.op == "-":
        sign, value = -1.0, value.operand
    if isinstance(value, ast.Name) and value.name in ("nan", "inf"):
        return math.nan if value.name == "nan" else sign * math.inf
    return None


def _span(expr: ast.Expr) -> Span:
    span: Span = expr.__dict__["span"]
    return span


def _head(span: Span) -> Span:
    stop = span.file.text.find("\n", span.start)
    return Span(span.file, span.start, min(span.end, stop if stop >= 0 else span.end))


__all__ = ["PreparedTest", "prepare"]
