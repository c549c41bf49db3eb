"""What names stand for, and what is read of what they stand for by a point: fields, samples, borders."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.spec import UNKNOWN, Enumeration
from trackmarshal.semantics.errors.expressions import WrongKind
from trackmarshal.semantics.errors.names import UnknownField
from trackmarshal.semantics.expressions import machines
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.definitions import expand
from trackmarshal.semantics.expressions.formulas import NUMBERED
from trackmarshal.semantics.expressions.geometry import is_lane
from trackmarshal.semantics.expressions.quantifiers import refuse_course
from trackmarshal.semantics.values import (
    Broken,
    Poison,
    own_unit,
    record_behind,
    record_spoken,
    spoken,
    written_unit,
)
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, Dimension

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def name(expr: ast.Name, x: Expressions, ctx: Context) -> typed.Value:
    """A variable, or what was declared by that name."""
    if expr.name in ctx.local:
        value = ctx.local[expr.name]
        if isinstance(value, Broken):
            raise Poison  # the error is where the name was bound
        return value.at(expr.span)  # messages point to the use
    if expr.name == "pi" and ctx.scope.find("pi") is None:
        return typed.Pi(NUMBER, "", expr.span)
    return _symbol(x.look_up(expr.name, expr.span, "name", {*ctx.local, "pi"}, ctx), expr.span, x, ctx)


def _symbol(symbol: typed.Symbol, span: Span, x: Expressions, ctx: Context) -> typed.Value:
    item = symbol.item
    match item:
        case ast.Signal():
            signal = x.signals[item.name]
            if signal.kind == "state":
                return typed.State(x.shape(signal), signal, span)
            if signal.kind == "polyline":
                return typed.SignalLine(signal, span)
            return typed.Signal(signal, span)
        case ast.Course():
            if item.name not in x.courses:
                raise Poison  # its declaration was reported
            return typed.Signal(x.courses[item.name].signal, span)
        case ast.Event():
            return typed.Event(symbol, span)
        case ast.Param():
            if symbol.qualified not in x.params:
                raise Poison  # its declaration was reported
            unit = written_unit((item.value,), item.unit)
            return typed.Parameter(x.params[symbol.qualified], unit, symbol, None, span)
        case ast.ParamRecord():
            shape = x.records.get(symbol.qualified)
            if shape is None:
                raise Poison  # its declaration was reported
            return typed.ParameterRecord(shape, None, symbol, span)
        case ast.Place():
            if item.kind == "zone":
                return typed.Zone(symbol, span)
            return typed.PlacedLine(symbol, span)
        case ast.Stretch():
            hint = f"ask what lies in it: `p in stretch {item.name}`"
            x.fail(WrongKind(span, "a value", f"the stretch `{item.name}`", hint))
        case ast.Define() if not item.parameters:
            return expand(x, symbol, item, [], False, span, ctx)
        case ast.Define() | ast.Table():
            x.fail(WrongKind(span, "a value", f"the function `{item.name}`", f"call it: `{item.name}(...)`"))
        case ast.State():
            hint = f"ask for it: `{item.name} is {item.start.name}`"
            x.fail(WrongKind(span, "a value", f"the state `{item.name}`", hint))
        case ast.Enum():
            hint = f"ask a field of this type for its member: `... is {item.members[0].name}`"
            x.fail(WrongKind(span, "a value", f"the enumeration `{item.name}`", hint))
        case ast.Shape():
            hint = "a parameter of a definition has it: `predicate p(o: " + item.name + ") = ...`"
            x.fail(WrongKind(span, "a value", f"the shape `{item.name}`", hint))
        case ast.Reference() | ast.Rulebook():
            x.fail(WrongKind(span, "a value", f"the name of a {type(item).__name__.lower()}"))
        case _:
            raise AssertionError(f"unknown symbol {type(item).__name__}")


def attribute(expr: ast.Attribute, x: Expressions, ctx: Context) -> typed.Value:
    """`ego.v`, `plan.first`, `track.left`, `limits.response`, `role(o).entry`."""
    if machines.names_machine(expr.value, ctx):
        return machines.kept(expr, x, ctx)
    value = x.value(expr.value, ctx)
    span = expr.span
    if isinstance(value, typed.RecordNode):
        if expr.name in ("left", "right") and is_lane(value):
            return typed.LaneSide(value, expr.name, span)
        if expr.name not in value.shape:
            known = [*(("left", "right") if is_lane(value) else ()), *value.shape]
            hint = close_matches(expr.name, known)
            if not hint and value.signal is not None and value.signal.field(expr.name) is not None:
                hint = "the definition asks for a shape without it"
            elif not hint and expr.name == "id":
                hint = f"an id is no field: {NUMBERED}"
            elif not hint:
                hint = "only what a signal's declaration lists can be read"
            x.fail(UnknownField(span, record_spoken(value), expr.name, ", ".join(known), hint))
        dimension = value.shape[expr.name]
        if dimension is None:
            return typed.BooleanField(value, expr.name, span)
        if isinstance(dimension, Enumeration):
            return typed.MemberField(dimension, value, expr.name, span)
        record = record_behind(value)
        if isinstance(record, typed.ParameterRecord):
            return _parameter(record.symbol, value, expr.name, dimension, span, x)
        field = None if value.signal is None else value.signal.field(expr.name)
        if field is not None and field.kind == UNKNOWN:
            raise Poison
        return typed.Field(dimension, "" if field is None else own_unit(field.unit), value, expr.name, span)
    if isinstance(value, typed.SignalNode):
        signal = value.signal
        refuse_course(signal, span, "nothing is read of", x)
        if signal.sequence and expr.name == "first":
            return typed.Sample(x.shape(signal), signal, value, 0, span)
        if signal.sequence and expr.name == "last":
            return typed.Sample(x.shape(signal), signal, value, -1, span)
        field = signal.field(expr.name)
        if field is not None and field.kind == "polyline" and not signal.many:
            return typed.Border(value, expr.name, span)
        fitting = (
            ["first", "last"] if signal.sequence else [f.name for f in signal.fields_ if f.kind == "polyline"]
        )
        hint, shown = close_matches(expr.name, fitting), ", ".join(fitting)
        if signal.sequence or signal.many:
            parts = f"{'samples' if signal.sequence else 'elements'} with {', '.join(f.name for f in signal.fields_)}"
            shown = f"{shown}, and {parts}" if shown else parts
        if signal.field(expr.name) is not None:
            hint = f"bind a variable first: `for all x in {signal.name}`"
        x.fail(UnknownField(span, spoken(value), expr.name, shown or "nothing to read", hint))
    digits = ast.span_of(expr.value).text
    hint = f"a number with a point has digits after it: `{digits}.0`" if digits.isdigit() else ""
    x.fail(WrongKind(ast.span_of(expr.value), "a record", spoken(value), hint))


def _parameter(
    record: typed.Symbol, read: typed.Record, name: str, dimension: Dimension, span: Span, x: Expressions
) -> typed.Parameter:
    """`limits.response`: the parameter that a field of a record of parameters is."""
    assert isinstance(record.item, ast.ParamRecord)
    symbol = typed.Symbol(record.item, record.module, f"{record.qualified}.{name}")
    entry = next((entry for entry in record.item.entries if entry.name == name), None)
    if entry is None or symbol.qualified not in x.params:
        raise Poison  # its declaration was reported
    unit = written_unit((entry.value,), x.advice.units.get(symbol.qualified, "1"))
    return typed.Parameter(dimension, unit, symbol, read, span)
