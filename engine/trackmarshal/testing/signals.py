"""Signals that a test gives: built or written out, as plain data in SI."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise
from typing import Any

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import UNKNOWN, Enumeration, FieldType, SignalType
from trackmarshal.semantics.expressions.dimensions import decimal_comma
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import span_of
from trackmarshal.testing.builders import BUILDERS, Builder, built
from trackmarshal.testing.constants import Constants, declaration, index_of
from trackmarshal.testing.errors import BadGiven
from trackmarshal.units import parse_unit

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


class Signals(Constants):
    """Reads the values of signals, and what these are made of."""

    def signal(self, signal: SignalType, entry: ast.Given) -> Any:
        if signal.many:
            elements = self.list_of(entry.value)
            with self._told_once(elements):
                return self.expressions.each(lambda element: self._record(signal, element), elements)
        if signal.sequence:
            columns = self._columns(signal, entry.value)
            self.expressions.each(
                lambda one: self._change(signal, columns, one[1], entry.changes[: one[0]]),
                enumerate(entry.changes),
            )
            return columns
        if signal.kind == "state":
            return self._record(signal, entry.value)
        if signal.kind == "polyline":
            return self.points(entry.value)
        if isinstance(entry.value, ast.Call):
            return self._build(entry.value, "corridor")
        if not isinstance(entry.value, ast.RecordValue):
            problem = "a corridor is built, or given as `{ left: [...], right: [...] }`"
            self.fail(span_of(entry.value), problem, "for example `straight_track(width: 12 m)`")
        return self._entries(entry.value, self._side)

    def _side(self, side: str, value: ast.Expr) -> Any:
        """One entry of a corridor."""
        if side == "closed":
            return self.truth(value, "`closed`")
        if side not in ("left", "right"):
            hint = close_matches(side, ("left", "right", "closed")) or "it has left, right and closed"
            self.fail(span_of(value), f"a corridor has no `{side}`", hint)
        return self.points(value)

    def _columns(self, signal: SignalType, value: ast.Expr) -> dict[str, Any]:
        if isinstance(value, ast.Call):
            built = self._build(value, "trajectory")
            columns: dict[str, Any] = {}
            for field in signal.fields_:
                if field.name in built:
                    unit = _COLUMNS[field.name]
                    if field.kind == UNKNOWN:
                        raise Poison
                    plain = field.kind == "number" and not field.enumeration
                    if not plain or parse_unit(field.unit)[2] != parse_unit(unit)[2]:
                        problem = f"`{value.function}` gives `{field.name}` in {unit}, which does not fit its declaration"
                        hint = "give the columns yourself, or declare it with this dimension"
                        declared = declaration(f"{signal.name}.{field.name}", field, unit)
                        self.fail(value.span, problem, hint, field.span, declared)
                    columns[field.name] = built[field.name]
            return columns
        if not isinstance(value, ast.RecordValue):
            problem = "a timeline is built, or given as `{ column: [...] }`"
            self.fail(span_of(value), problem, "for example `line(v: 20 m/s)`")

        def column(field_name: str, content: ast.Expr) -> list[Any]:
            field = self._field(signal, field_name, span_of(content))
            values = self.list_of(content)
            with self._told_once(values):
                return self.expressions.each(lambda element: self._scalar(field, element), values)

        columns = self._entries(value, column)
        lengths = {len(entries) for entries in columns.values()}
        for name, content in zip(value.names, value.values):
            comma = _decimal_comma(self.list_of(content))
            if comma and len(lengths) > 1:
                problem = f"`{name}` has {len(columns[name])} entries, others have more or fewer"
                self.fail(span_of(content), problem, comma)
        return columns

    def _change(
        self, signal: SignalType, columns: dict[str, Any], change: ast.Change, before: Sequence[ast.Change]
    ) -> None:
        field = self._field(signal, change.field, change.span)
        if any(_undoes(change, other) for other in before):
            called = change.field if change.index is None else f"{change.field}[{change.index}]"
            self.fail(change.span, f"`{called}` undoes a change that stands before it", "keep one of them")
        count = max((len(column) for column in columns.values()), default=0)
        default = bool(field.default) if field.kind == "bool" and field.default is not None else field.default
        column = list(columns.get(change.field, [default] * count))
        value = self._scalar(field, change.value)
        if change.index is None:
            column = [value] * count
        else:
            index = index_of(change.index)
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
                hint = close_matches(named, builder.parameters) or takes
                self.fail(span_of(value), f"`{builder.name}` has no argument `{named}`", hint)
            if named in call.names[:place]:
                self.fail(span_of(value), f"`{named}` is given twice", "keep one of them")
            return named, self.number(value, parameter.unit, f"the argument `{named}`")

        arguments = dict(self.expressions.each(argument, zip(range(len(call.names)), call.names, call.args)))
        missing = [n for n, p in builder.parameters.items() if p.required and n not in arguments]
        if missing:
            shown = ", ".join(f"{n}: ... {builder.parameters[n].unit}" for n in missing)
            problem = f"`{builder.name}` needs {' and '.join(f'`{n}`' for n in missing)}"
            self.fail(call.span, problem, f"write `{builder.name}({shown})`")
        return arguments

    def _record(self, signal: SignalType, value: ast.Expr) -> dict[str, Any]:
        if not isinstance(value, ast.RecordValue):
            self.fail(span_of(value), f"`{signal.name}` takes a record", "for example `{ x: 0 m, y: 0 m }`")

        def read(name: str, value: ast.Expr) -> Any:
            field = self._field(signal, name, span_of(value))
            return self.points(value) if field.kind == "polyline" else self._scalar(field, value)

        return self._entries(value, read)

    def _entries(self, record: ast.RecordValue, read: Any) -> dict[str, Any]:
        """The entries of `{ name: value }`, each read by a function of both."""

        def entry(one: tuple[int, str, ast.Expr]) -> tuple[str, Any]:
            place, field, value = one
            if field in record.names[:place]:
                self.fail(span_of(value), f"`{field}` is given twice", "keep one of them")
            return field, read(field, value)

        return dict(self.expressions.each(entry, zip(range(len(record.names)), record.names, record.values)))

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
            return self.truth(value, f"`{field.name}`")
        if field.enumeration is not None:
            return self._member(field, field.enumeration, value)
        return self.number(value, field.unit, f"`{field.name}`", field)

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

    def list_of(self, value: ast.Expr) -> tuple[ast.Expr, ...]:
        if not isinstance(value, ast.ListValue):
            self.fail(span_of(value), "a list is needed here", "write `[...]`")
        return value.values

    def points(self, value: ast.Expr) -> list[list[float]]:
        rows = self.list_of(value)
        with self._told_once(rows):
            return self.expressions.each(lambda row: self.pair(row, ("m", "m")), rows)

    def pair(self, value: ast.Expr, units: tuple[str, str]) -> list[float]:
        parts = self.list_of(value)
        if len(parts) != 2:
            entries = "1 entry" if len(parts) == 1 else f"{len(parts)} entries"
            hint = decimal_comma(*map(span_of, parts)) or "write `[x, y]`"
            self.fail(span_of(value), f"a pair is needed here, this has {entries}", hint)
        return self.expressions.each(lambda one: self.number(one[0], one[1], "this"), zip(parts, units))

    @contextmanager
    def _told_once(self, values: Sequence[ast.Expr]) -> Iterator[None]:
        """What is wrong with the entries of a list in the same way is told of the first of them; where commas made more of them, it says so."""
        begin = len(self.found)
        try:
            yield
        finally:
            first: dict[str, Diagnostic] = {}
            for item in self.found[begin:]:
                first.setdefault(item.message if isinstance(item, BadGiven) else repr(item), item)
            comma = _decimal_comma(values)
            self.found[begin:] = [
                BadGiven(**{**item.__dict__, "hint": comma}) if comma and isinstance(item, BadGiven) else item
                for item in first.values()
            ]


def _undoes(change: ast.Change, before: ast.Change) -> bool:
    """Whether nothing is left of an earlier change: of a whole column, samples may differ."""
    if change.field != before.field or change.index is None:
        return change.field == before.field
    return before.index is not None and float(change.index) == float(before.index)


def _decimal_comma(values: Sequence[ast.Expr]) -> str:
    """What to write for a list with decimal commas; empty where there are none, as in one of whole numbers that are written closely, `[0,1,2]`."""
    spans = [span_of(value) for value in values]
    closely = all(a.file.text[a.end : b.start] == "," for a, b in pairwise(spans))
    return "" if closely and all(span.text.isdecimal() for span in spans) else decimal_comma(*spans)
