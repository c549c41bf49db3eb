"""Inline tests to cases: builders called, units converted, expectations in SI; everything wrong is reported."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any, NoReturn
from weakref import WeakKeyDictionary

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.margins import SCALED, margin_units, own_unit
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import UNKNOWN, Enumeration, FieldType, ParamInfo, RuleInfo, SignalType
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.node import Node
from trackmarshal.runtime.settings import check_table
from trackmarshal.semantics.causes import told_once
from trackmarshal.semantics.compile import Compiled
from trackmarshal.semantics.expressions.checking import Context
from trackmarshal.semantics.expressions.dimensions import decimal_comma, unit_hint
from trackmarshal.semantics.values import Poison
from trackmarshal.semantics.warnings.numbers import BareAngle
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import span_of
from trackmarshal.testing.builders import BUILDERS, Builder, built
from trackmarshal.testing.errors import BadExpectation, BadGiven, UnknownRuleOfTest
from trackmarshal.testing.meant import Meant, Told
from trackmarshal.testing.si import table_in_si
from trackmarshal.units import NUMBER, Dimension, digits, in_full, parse_shown, parse_unit, quantity, show

VERDICTS = ("satisfied", "violated", "undefined", "inactive", "open")
#: The units of the columns that builders make.
_COLUMNS = {
    "t": "s",
    "s": "m",
    "x": "m",
    "y": "m",
    "heading": "rad",
    "kappa": "1/m",
    "v": "m/s",
    "a": "m/s^2",
}


class PreparedTest(Node):
    """A test ready to run: the rule, the case as plain data, and what is expected in SI.

    later: of a test that goes on `after` its first cycle, the others: seconds since the first one, and all signals.
    """

    rule: RuleInfo
    title: str
    #: In SI whatever the declared units are: for an evaluator of `spec_in_si`.
    case: dict[str, Any]
    later: tuple[tuple[float, dict[str, Any]], ...]
    verdict: str
    margin: float | None
    tolerance: float
    #: Where the comparisons of a rule are in several units: the one in which the margin is expected; None for any.
    unit: str | None
    binder: str | None
    at: str | None
    #: Its text, and what that comes to.
    told: Told
    span: Span


def prepare(compiled: Compiled) -> tuple[list[PreparedTest], list[Diagnostic]]:
    """All tests that have a meaning, and what is wrong with the others."""
    prepared: list[PreparedTest] = []
    found = compiled.expressions.found
    before = len(found)
    titles: dict[tuple[str, str], Span] = {}
    for module in compiled.order:
        for item in compiled.library.modules[module].tree.items:
            if not isinstance(item, ast.Test):
                continue
            if (item.rule, item.title) in titles:
                first, hint = titles[item.rule, item.title], "say what this one shows"
                problem = "another test of this rule has the same title"
                found.append(BadGiven(item.span.head, problem, hint, first, "the first one is here"))
            titles.setdefault((item.rule, item.title), item.span.head)
            rule = compiled.spec.rule(item.rule)
            if rule is not None and rule.formula is None:
                found.append(UnknownRuleOfTest(item.span.head.word(item.rule), item.rule))
            try:
                test = _Preparation(compiled, module, found).test(item, rule)
            except Poison:
                continue
            if test is not None:
                prepared.append(test)
    reported, found[before:] = found[before:], []
    return prepared, told_once(reported, compiled.found)


class _Preparation:
    def __init__(self, compiled: Compiled, module: str, found: list[Diagnostic]) -> None:
        self._spec = compiled.spec
        self._scope = compiled.scopes[module]
        self._x = compiled.expressions
        self._lowering = Lowering(Interner())
        self._ctx = Context(self._scope, {}, 0, typed.THE_RUN, None, ())
        self._found = found
        self._kind: type[BadGiven | BadExpectation] = BadGiven
        self._meant = Meant()

    def fail(
        self, span: Span, problem: str, hint: str = "", other: Span | None = None,
        declared: tuple[tuple[str, Span, str, str], ...] = (),
    ) -> NoReturn:  # fmt: skip
        given = BadGiven(span, problem, hint, other, declared=declared)
        self._found.append(given if other or declared else self._kind(span, problem, hint))
        raise Poison

    def test(self, item: ast.Test, rule: RuleInfo | None) -> PreparedTest | None:
        """The test; None for one of a rule that has errors of its own, or no formula: what it gives is checked all the same."""
        case: dict[str, Any] = {"id": item.title, "signals": {}, "params": {}, "tables": {}, "places": {}}
        given: set[str] = set()
        later: list[tuple[float, dict[str, Any]]] = []

        def give(entry: ast.Given | ast.After) -> None:
            if isinstance(entry, ast.After):
                given.clear()
                t, before = later[-1] if later else (0.0, case["signals"])
                later.append((t + self._after(entry, rule), dict(before)))
                return
            if entry.name in given:
                self.fail(entry.span, f"`{entry.name}` is given twice", "keep one of them")
            given.add(entry.name)
            if not later:
                self._given(entry, case)
                return
            now: dict[str, Any] = {"signals": later[-1][1], "params": {}, "tables": {}, "places": {}}
            self._given(entry, now)
            if now["params"] or now["tables"] or now["places"]:
                self.fail(
                    entry.span,
                    f"`{entry.name}` stays as it is over a run",
                    "give it before the first `after`",
                )

        _, expect = self._x.all(
            lambda: self._x.each(give, item.steps),
            lambda: self._expectation(item.expect, rule),
        )
        if rule is None or rule.formula is None:
            return None
        verdict, margin, tolerance, unit, binder, at = expect
        return PreparedTest(
            rule,
            item.title,
            case,
            tuple(later),
            verdict,
            margin,
            tolerance,
            unit,
            binder,
            at,
            Told(item, self._meant, _variables(rule.formula), unit),
            item.span.head,
        )

    def _after(self, entry: ast.After, rule: RuleInfo | None) -> float:
        """How long after the cycle before the next one comes [s]."""
        from trackmarshal.backends.over_run.program import (
            remembers,
        )  # which `check` does not wait for otherwise

        if rule is not None and not remembers(rule):
            self.fail(entry.span, f"`{rule.name}` speaks of one cycle alone", "a test for each cycle")
        seconds = self._number(entry.time, "s", "the time of the next cycle")
        if not (math.isfinite(seconds) and nanoseconds(seconds) > 0):
            self.fail(span_of(entry.time), "the next cycle comes later", "write a time above 0 s")
        return seconds

    # What is given --------------------------------------------------------------------------------------------

    def _given(self, entry: ast.Given, case: dict[str, Any]) -> None:
        symbol = self._scope.find(entry.name)
        item = symbol.item if symbol is not None else None
        if symbol is None or not isinstance(
            item, (ast.Signal, ast.Event, ast.Param, ast.ParamRecord, ast.Table, ast.Place)
        ):
            if entry.name in self._scope.broken:
                raise Poison  # its declaration has an error of syntax
            self._unknown(entry)
        if entry.changes and not (isinstance(item, ast.Signal) and self._spec.signals[item.name].sequence):
            self.fail(
                entry.changes[0].span,
                "`with` changes columns of a timeline",
                f"give all of `{entry.name}` in one value",
            )
        many = isinstance(item, (ast.Signal, ast.Event))  # which have no module of their own
        self._meant.name(entry, item.name if many else symbol.qualified)
        match item:
            case ast.Signal():
                case["signals"][entry.name] = self._signal(self._spec.signals[item.name], entry)
            case ast.Event():
                if not isinstance(entry.value, ast.Boolean):
                    self.fail(span_of(entry.value), f"the event `{item.name}` is true or false")
                case["signals"][entry.name] = entry.value.value
            case ast.Param():
                info = self._spec.params.get(symbol.qualified)
                if info is None:
                    raise Poison  # its declaration was reported
                case["params"][symbol.qualified] = self._param(info, entry.value)
            case ast.ParamRecord():
                case["params"] |= self._param_record(symbol, entry.value)
            case ast.Table():
                table = self._spec.tables.get(symbol.qualified)
                if table is None:
                    raise Poison
                rows = self._x.each(lambda row: self._pair(row, table.units), self._list(entry.value))
                try:
                    check_table(table_in_si(table), rows)
                except TrackmarshalError as error:
                    self.fail(span_of(entry.value), error.message, error.help or "")
                case["tables"][symbol.qualified] = rows
            case ast.Place():
                case["places"][symbol.qualified] = self._points(entry.value)
            case _:
                raise AssertionError(f"a test gives no {type(item).__name__}")

    def _unknown(self, entry: ast.Given) -> NoReturn:
        kinds = (ast.Signal, ast.Event, ast.Param, ast.ParamRecord, ast.Table, ast.Place)
        symbols = {name: self._scope.find(name) for name in self._scope.names()}
        known = [
            name for name, symbol in symbols.items() if symbol is not None and isinstance(symbol.item, kinds)
        ]
        hint = close_matches(entry.name, known) or "only what the test's module declares or uses can be given"
        problem = f"`{entry.name}` is no signal, event, parameter, table, zone or line"
        if entry.name in symbols and symbols[entry.name] is None:
            problem, hint = (
                f"`{entry.name}` is declared in several used modules",
                "rename one, or use only one of the modules",
            )
        unknown = self._scope.unknown(entry.name, entry.span.word(entry.name), "name", "")
        if unknown.modules and entry.name not in symbols:
            self._found.append(unknown)
            raise Poison
        self.fail(entry.span.word(entry.name), problem, hint)

    def _param_record(self, symbol: typed.Symbol, value: ast.Expr) -> dict[str, float]:
        """Some fields of a record of parameters, or all; the others stay."""
        if not isinstance(value, ast.RecordValue):
            self.fail(
                span_of(value), "a record is needed here", f"write `{symbol.name} = {{ field: value }}`"
            )
        infos = {
            info.short: info
            for info in self._spec.params.values()
            if info.name.startswith(f"{symbol.qualified}.")
        }
        if not infos:
            raise Poison  # its declaration was reported
        given: dict[str, float] = {}
        for name, each in zip(value.names, value.values):
            info = infos.get(f"{symbol.name}.{name}")
            if info is None:
                fields = [short.partition(".")[2] for short in infos]
                hint = close_matches(name, fields) or f"it has {', '.join(fields)}"
                self.fail(span_of(each), f"`{symbol.name}` has no field `{name}`", hint)
            given[info.name] = self._param(info, each)
        return given

    def _param(self, info: ParamInfo, value: ast.Expr) -> float:
        number = self._number(value, info.unit, f"the parameter `{info.short}`")
        if not math.isfinite(number):
            self.fail(span_of(value), "a parameter is finite")
        if (info.lower is not None and number < info.lower) or (
            info.upper is not None and number > info.upper
        ):
            ends = (
                -math.inf if info.lower is None else info.lower,
                math.inf if info.upper is None else info.upper,
            )
            limits = ", ".join(digits(end, info.unit) for end in ends)
            problem = f"{in_full(number, info.unit)} is outside its range [{limits}]{'' if info.unit == '1' else ' ' + info.unit}"
            self.fail(span_of(value), problem, "", info.span.head)
        return number

    def _signal(self, signal: SignalType, entry: ast.Given) -> Any:
        if signal.many:
            elements = self._list(entry.value)
            with self._told_once(elements):
                return self._x.each(lambda element: self._record(signal, element), elements)
        if signal.sequence:
            columns = self._columns(signal, entry.value)
            self._x.each(lambda change: self._change(signal, columns, change), entry.changes)
            return columns
        if signal.kind == "state":
            return self._record(signal, entry.value)
        if signal.kind == "polyline":
            return self._points(entry.value)
        if isinstance(entry.value, ast.Call):
            return self._build(entry.value, "corridor")
        if not isinstance(entry.value, ast.RecordValue):
            self.fail(
                span_of(entry.value),
                "a corridor is built, or given as `{ left: [...], right: [...] }`",
                _HOW["corridor"],
            )
        return self._entries(entry.value, self._side)

    def _side(self, side: str, value: ast.Expr) -> Any:
        """One entry of a corridor."""
        if side == "closed":
            if not isinstance(value, ast.Boolean):
                self.fail(span_of(value), "`closed` is true or false")
            return value.value
        if side not in ("left", "right"):
            hint = close_matches(side, ("left", "right", "closed")) or "it has left, right and closed"
            self.fail(span_of(value), f"a corridor has no `{side}`", hint)
        return self._points(value)

    def _columns(self, signal: SignalType, value: ast.Expr) -> dict[str, Any]:
        if isinstance(value, ast.Call):
            built = self._build(value, "trajectory")
            columns: dict[str, Any] = {}
            for field in signal.fields_:
                if field.name in built:
                    unit = _COLUMNS[field.name]
                    if field.kind == UNKNOWN:
                        raise Poison
                    if (
                        field.enumeration
                        or field.kind != "number"
                        or parse_unit(field.unit)[2] != parse_unit(unit)[2]
                    ):
                        problem = f"`{value.function}` gives `{field.name}` in {unit}, which does not fit its declaration"
                        self.fail(
                            value.span,
                            problem,
                            "give the columns yourself, or declare it with this dimension",
                            field.span,
                            _declared(f"{signal.name}.{field.name}", field, unit),
                        )
                    columns[field.name] = built[field.name]
            return columns
        if not isinstance(value, ast.RecordValue):
            self.fail(
                span_of(value), "a timeline is built, or given as `{ column: [...] }`", _HOW["trajectory"]
            )

        def column(field_name: str, content: ast.Expr) -> list[Any]:
            field = self._field(signal, field_name, span_of(content))
            values = self._list(content)
            with self._told_once(values):
                return self._x.each(lambda element: self._scalar(field, element), values)

        columns = self._entries(value, column)
        lengths = {len(entries) for entries in columns.values()}
        for name, content in zip(value.names, value.values):
            comma = _decimal_comma(self._list(content))
            if comma and len(lengths) > 1:
                self.fail(
                    span_of(content),
                    f"`{name}` has {len(columns[name])} entries, others have more or fewer",
                    comma,
                )
        return columns

    @contextmanager
    def _told_once(self, values: Sequence[ast.Expr]) -> Iterator[None]:
        """What is wrong with the entries of a list in the same way is told of the first of them; where commas made more of them, it says so."""
        begin = len(self._found)
        try:
            yield
        finally:
            first: dict[str, Diagnostic] = {}
            for item in self._found[begin:]:
                first.setdefault(item.message if isinstance(item, BadGiven) else repr(item), item)
            comma = _decimal_comma(values)
            self._found[begin:] = [
                BadGiven(**{**item.__dict__, "hint": comma}) if comma and isinstance(item, BadGiven) else item
                for item in first.values()
            ]

    def _change(self, signal: SignalType, columns: dict[str, Any], change: ast.Change) -> None:
        field = self._field(signal, change.field, change.span)
        count = max((len(column) for column in columns.values()), default=0)
        default = bool(field.default) if field.kind == "bool" and field.default is not None else field.default
        column = list(columns.get(change.field, [default] * count))
        value = self._scalar(field, change.value)
        if change.index is None:
            column = [value] * count
        else:
            index = _index(change.index)
            if index is None:
                self.fail(change.span, "an index is a whole number, from 0")
            if index >= len(column):
                last = f"the last one is [{len(column) - 1}]" if column else ""
                self.fail(change.span, f"`{change.field}` has no sample {index}", last)
            column[index] = value
        columns[change.field] = column

    def _build(self, call: ast.Call, kind: str) -> dict[str, Any]:
        builder = BUILDERS.get(call.function)
        fitting = [b.name for b in BUILDERS.values() if b.builds == kind]
        if builder is None or builder.builds != kind:
            hint = close_matches(call.function, fitting) or "there are " + ", ".join(fitting)
            self.fail(call.span.word(call.function), f"`{call.function}` builds no {kind}", hint)
        arguments = self._arguments(call, builder)
        try:
            return built(builder, arguments)
        except TrackmarshalError as error:
            self.fail(call.span, f"`{builder.name}`: {error.message}", error.help or "")

    def _arguments(self, call: ast.Call, builder: Builder) -> dict[str, float]:
        comma = decimal_comma(*map(span_of, call.args))
        if comma:
            self.fail(call.span.word(call.function), f"`{call.function}` has a number in two parts", comma)

        def argument(one: tuple[int, str, ast.Expr]) -> tuple[str, float]:
            place, named, value = one
            parameter = builder.parameters.get(named)
            takes = f"`{builder.name}` takes " + ", ".join(builder.parameters)
            if not named:
                self.fail(span_of(value), "the arguments of builders are named", takes)
            if parameter is None:
                self.fail(
                    span_of(value),
                    f"`{builder.name}` has no argument `{named}`",
                    close_matches(named, builder.parameters) or takes,
                )
            if named in call.names[:place]:
                self.fail(span_of(value), f"`{named}` is given twice", "keep one of them")
            return named, self._number(value, parameter.unit, f"the argument `{named}`")

        arguments = dict(self._x.each(argument, zip(range(len(call.names)), call.names, call.args)))
        missing = [n for n, p in builder.parameters.items() if p.required and n not in arguments]
        if missing:
            shown = ", ".join(f"{n}: ... {builder.parameters[n].unit}" for n in missing)
            self.fail(
                call.span,
                f"`{builder.name}` needs {' and '.join(f'`{n}`' for n in missing)}",
                f"write `{builder.name}({shown})`",
            )
        return arguments

    def _record(self, signal: SignalType, value: ast.Expr) -> dict[str, Any]:
        if not isinstance(value, ast.RecordValue):
            self.fail(span_of(value), f"`{signal.name}` takes a record", _HOW["record"])

        def read(name: str, value: ast.Expr) -> Any:
            field = self._field(signal, name, span_of(value))
            return self._points(value) if field.kind == "polyline" else self._scalar(field, value)

        return self._entries(value, read)

    def _entries(self, record: ast.RecordValue, read: Any) -> dict[str, Any]:
        """The entries of `{ name: value }`, each read by a function of both."""

        def entry(one: tuple[int, str, ast.Expr]) -> tuple[str, Any]:
            place, field, value = one
            if field in record.names[:place]:
                self.fail(span_of(value), f"`{field}` is given twice", "keep one of them")
            return field, read(field, value)

        return dict(self._x.each(entry, zip(range(len(record.names)), record.names, record.values)))

    def _field(self, signal: SignalType, field: str, span: Span) -> FieldType:
        kind = signal.field(field)
        if kind is None:
            names = [f.name for f in signal.fields_]
            hint = close_matches(field, names) or "it has " + ", ".join(names)
            self.fail(span, f"`{signal.name}` has no field `{field}`", hint)
        return kind

    def _scalar(self, field: FieldType, value: ast.Expr) -> Any:
        if field.kind == UNKNOWN:
            raise Poison
        if field.kind == "bool":
            if not isinstance(value, ast.Boolean):
                self.fail(span_of(value), f"`{field.name}` is true or false")
            return value.value
        if field.enumeration is not None:
            return self._member(field, field.enumeration, value)
        return self._number(value, field.unit, f"`{field.name}`", field)

    def _member(self, field: FieldType, enumeration: Enumeration, value: ast.Expr) -> str | float:
        """A member by its name; `nan` is a missing one, where no member is called so."""
        if isinstance(value, ast.Name) and value.name in enumeration.members:
            return value.name
        if isinstance(value, ast.Name) and value.name == "nan":
            return math.nan
        known, hint = ", ".join(enumeration.members), ""
        if isinstance(value, ast.Name):
            hint = close_matches(value.name, enumeration.members)
        self.fail(span_of(value), f"`{field.name}` is one of {known}", hint)

    def _list(self, value: ast.Expr) -> tuple[ast.Expr, ...]:
        if not isinstance(value, ast.ListValue):
            self.fail(span_of(value), "a list is needed here", "write `[...]`")
        return value.values

    def _points(self, value: ast.Expr) -> list[list[float]]:
        rows = self._list(value)
        with self._told_once(rows):
            return self._x.each(lambda row: self._pair(row, ("m", "m")), rows)

    def _pair(self, value: ast.Expr, units: tuple[str, str]) -> list[float]:
        parts = self._list(value)
        if len(parts) != 2:
            entries = "1 entry" if len(parts) == 1 else f"{len(parts)} entries"
            hint = decimal_comma(*map(span_of, parts)) or "write `[x, y]`"
            self.fail(span_of(value), f"a pair is needed here, this has {entries}", hint)
        return self._x.each(lambda one: self._number(one[0], one[1], "this"), zip(parts, units))

    def _number(self, value: ast.Expr, unit: str, what: str, field: FieldType | None = None) -> float:
        """A constant of a unit's dimension, in SI; `nan` and `inf` are allowed here and only here."""
        special = _special(value)
        if special is not None:
            return special
        number = self._constant(value, what, parse_unit(unit)[2], unit, field)[0]
        literal = value.operand if isinstance(value, ast.Unary) else value
        if number != 0.0 and isinstance(literal, ast.Number) and not literal.unit and unit != "1":
            text = span_of(value).text
            if unit != "rad":  # of an angle, or a percentage: which other numbers look like
                self.fail(span_of(value), f"{what} is a number in {unit}", f"write the unit: `{text} {unit}`")
            self._found.append(BareAngle(span_of(value), None, f"write `{text} deg` or `{text} rad`", what))
        return number

    def _si(self, value: ast.Expr, dimension: Dimension, what: str) -> float:
        """A constant of a dimension, in SI."""
        return self._constant(value, what, dimension)[0]

    def _constant(
        self, value: ast.Expr, what: str, wanted: Dimension | None = None, declared: str = "", field: FieldType | None = None
    ) -> tuple[float, Dimension]:  # fmt: skip
        """A constant in SI with its dimension, which may be given, and with that the unit in which it is declared."""
        if isinstance(value, (ast.ListValue, ast.RecordValue)):
            self.fail(
                span_of(value),
                f"{what} is one value, not a {'list' if isinstance(value, ast.ListValue) else 'record'}",
            )
        if isinstance(value, ast.Number):  # mostly; one of another dimension is told of below
            number, dimension = self._x.literal(value)
            if wanted is None or dimension == wanted:
                self._meant.number(value, None, number)
                return number, dimension
        checked = self._x.number(value, self._ctx)
        if wanted is not None and checked.dimension != wanted:
            problem = f"{what} is {quantity(wanted)}, not {quantity(checked.dimension)}"
            bare = checked.dimension == NUMBER
            things = () if bare or field is None else _declared(field.name, field, show(checked.dimension))
            self.fail(span_of(value), problem, unit_hint(checked, wanted, declared), declared=things)
        params = self._spec.params
        plain = typed.literal(checked)
        if plain is not None:
            self._meant.number(value, None, plain)
            return plain, checked.dimension
        core = self._lowering.number(checked)
        if any(isinstance(node, ir.Param) and node.name not in params for node in ir.below(core)):
            raise Poison  # a parameter whose declaration was reported
        found = constant_value(core, lambda qualified: params[qualified].value)
        if found is None:
            self.fail(span_of(value), "this depends on an input", "a test gives constants")
        self._meant.number(value, core, found)
        return found, checked.dimension

    # What is expected -----------------------------------------------------------------------------------------

    def _expectation(self, expect: ast.Expect, rule: RuleInfo | None) -> tuple[Any, ...]:
        """Verdict, margin, tolerance, unit of the margin, variable and index."""
        self._kind = BadExpectation
        (margin, unit), (tolerance, other), at, _ = self._x.all(
            lambda: (None, None) if expect.margin is None else self._margin(expect.margin, rule),
            lambda: (0.0, None) if expect.tolerance is None else self._tolerance(expect.tolerance, rule),
            lambda: self._at(expect, rule),
            lambda: self._verdict(expect),
        )
        if margin is not None and expect.verdict == "undefined" and not math.isnan(margin):
            assert expect.margin is not None
            self.fail(span_of(expect.margin), "an undefined rule has no margin", "expect the verdict only")
        if unit is not None and other is not None and unit != other:
            assert expect.tolerance is not None
            problem = f"a margin in {unit} has no tolerance in {other}"
            self.fail(span_of(expect.tolerance), problem, f"write it in {unit}")
        return expect.verdict, margin, tolerance, unit or other, expect.binder, at

    def _verdict(self, expect: ast.Expect) -> None:
        if expect.verdict not in VERDICTS:
            hint = (
                close_matches(expect.verdict, VERDICTS)
                or f"a verdict is {', '.join(VERDICTS[:-1])} or {VERDICTS[-1]}"
            )
            self.fail(
                expect.span.word(expect.verdict),
                f"`{expect.verdict}` is no verdict that a test can expect",
                hint,
            )

    def _at(self, expect: ast.Expect, rule: RuleInfo | None) -> str | None:
        """The index, or the id of an object, at which the rule is expected to be decided."""
        if expect.at is None or expect.binder is None:
            return None
        if rule is not None and rule.formula is not None:
            variables = _variables(rule.formula)
            if expect.binder not in variables:
                hint = close_matches(expect.binder, variables) or (
                    "it has " + ", ".join(variables) if variables else "it has none"
                )
                self.fail(
                    expect.span.word(expect.binder), f"`{rule.name}` has no variable `{expect.binder}`", hint
                )
        if expect.at.startswith('"'):
            return expect.at.strip('"')
        index = _index(expect.at)
        if index is None:
            self.fail(expect.span.word(expect.at), "an index is a whole number, from 0")
        return str(index)

    def _tolerance(self, value: ast.Expr, rule: RuleInfo | None) -> tuple[float, str | None]:
        tolerance, unit = self._margin(value, rule)
        if not 0.0 <= tolerance < math.inf:
            self.fail(span_of(value), "a tolerance is finite and not negative")
        return tolerance, unit

    def _margin(self, value: ast.Expr, rule: RuleInfo | None) -> tuple[float, str | None]:
        """A margin in SI and, where the rule's comparisons are in several units, its unit; None for 0, which is 0 in any."""
        special = _special(value)
        if special is not None:
            return special, None
        if rule is None or rule.formula is None:
            return 0.0, None
        if own_unit(rule.unit):
            return self._si(value, parse_shown(rule.unit), f"the margin of `{rule.name}`"), None
        number, dimension = self._constant(value, f"the margin of `{rule.name}`")
        unit, units = show(dimension), margin_units(rule.formula)
        if dimension == NUMBER and (number == 0.0 or rule.unit == SCALED):
            return number, None
        if unit not in units:
            listed = " and ".join(sorted(units))
            problem = (
                f"no comparison of `{rule.name}` is in {unit if dimension != NUMBER else 'plain numbers'}"
            )
            self.fail(span_of(value), problem, f"its comparisons are in {listed}; 0 needs no unit")
        if rule.unit == SCALED:
            return number / dict(self._spec.scales).get(unit, 1.0), unit
        return number, unit


_HOW = {
    "trajectory": "for example `line(v: 20 m/s)`",
    "corridor": "for example `straight_track(width: 12 m)`",
    "record": "for example `{ x: 0 m, y: 0 m }`",
}


#: By formula: a rule has many tests.
_VARIABLES: WeakKeyDictionary[ir.IR, tuple[str, ...]] = WeakKeyDictionary()


def _variables(formula: ir.Formula) -> tuple[str, ...]:
    """What a formula binds, in order, each once."""
    known = _VARIABLES.get(formula)
    if known is None:
        names: dict[str, None] = {}
        for node in ir.below(formula):
            if isinstance(node, ir.Quantify):
                names.update(dict.fromkeys(node.names))
            elif isinstance(node, ir.At):
                names[node.name] = None
        known = _VARIABLES[formula] = tuple(names)
    return known


def _index(text: str) -> int | None:
    """A whole number as written, or None."""
    number = float(text)
    return int(number) if math.isfinite(number) and number == int(number) else None


def _special(value: ast.Expr) -> float | None:
    """`nan`, `inf`, `-inf`."""
    sign = 1.0
    if isinstance(value, ast.Unary) and value.op == "-":
        sign, value = -1.0, value.operand
    if isinstance(value, ast.Name) and value.name in ("nan", "inf"):
        return math.nan if value.name == "nan" else sign * math.inf
    return None


def _declared(name: str, field: FieldType, given: str) -> tuple[tuple[str, Span, str, str], ...]:
    """A field that is given in a unit of another dimension than it is declared in, as `DimensionMismatch` has it."""
    return ((name, field.span, quantity(parse_unit(field.unit)[2]), quantity(parse_shown(given))),)


def _decimal_comma(values: Sequence[ast.Expr]) -> str:
    """What to write for a list with decimal commas; empty where there are none, as in one of whole numbers that are written closely, `[0,1,2]`."""
    spans = [span_of(value) for value in values]
    closely = all(a.file.text[a.end : b.start] == "," for a, b in pairwise(spans))
    return "" if closely and all(span.text.isdecimal() for span in spans) else decimal_comma(*spans)


__all__ = ["PreparedTest", "prepare"]
