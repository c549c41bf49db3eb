"""Values while they are checked: what messages call them, and the units in which they are written."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import lru_cache
from typing import TypeAlias, assert_never

from trackmarshal import typed
from trackmarshal.ir.spec import Enumeration
from trackmarshal.node import Node
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, name, quantity, to_si


class Poison(Exception):
    """An error was reported; what depends on the expression is not checked further."""


class Broken(Node):
    """What a name stands for whose own declaration has an error: nothing is said about its uses."""


#: What a local name stands for.
Local: TypeAlias = (
    typed.Variable | typed.NamedNumber | typed.Count | typed.NamedFormula | typed.NamedSignal | typed.NamedRecord | typed.NamedLine
    | typed.NamedMember | typed.NamedArea | typed.NamedRegion | Broken
)  # fmt: skip


def named(called: str, value: typed.Value, span: Span) -> Local:
    """What a `let` makes of a value: the same by a name."""
    match value:
        case typed.NumberNode():
            return typed.NamedNumber(value.dimension, value.written, called, value, "", span)
        case typed.FormulaNode():
            return typed.NamedFormula(called, value, span)
        case typed.Count():
            return value
        case typed.RecordNode():
            return typed.NamedRecord(value.shape, value.signal, called, value, "", span)
        case typed.SignalNode():
            return typed.NamedSignal(value.signal, called, value, span)
        case typed.MemberNode():
            return typed.NamedMember(value.enumeration, called, value, span)
        case typed.LineNode():
            return typed.NamedLine(called, value, span)
        case typed.AreaNode():
            return typed.NamedArea(called, value, span)
        case typed.RegionNode():
            return typed.NamedRegion(called, value, span)
        case _:
            assert_never(value)


def span_of(node: typed.Typed | Broken) -> Span:
    """Where a node is written."""
    span: Span = node.__dict__["span"]
    return span


def spoken(value: typed.Value) -> str:
    """What messages call a value."""
    match value:
        case typed.NumberNode():
            return name(value.dimension)
        case typed.FormulaNode():
            return "a formula"
        case typed.Count():
            return "a count of cycles"
        case typed.RecordNode():
            return record_spoken(value)
        case typed.SignalNode():
            signal = value.signal
            return f"the {'set' if signal.many else signal.kind} `{signal.name}`"
        case typed.MemberNode():
            return member_spoken(value.enumeration)
        case typed.LineNode():
            return "a line"
        case typed.AreaNode():
            return "an area"
        case typed.RegionNode():
            return "a footprint"
        case _:
            assert_never(value)


def member_spoken(enumeration: Enumeration, beside: Enumeration | None = None) -> str:
    """What messages call a member; with the enumeration's module beside one of another module that has the same name."""
    name = enumeration.name.rpartition(".")[2]
    alike = beside is not None and beside.name != enumeration.name and beside.name.rpartition(".")[2] == name
    return f"a member of `{enumeration.name if alike else name}`"


def number_spoken(value: typed.Value) -> str:
    """The same, of a number with the unit of its dimension, for where one of another dimension is asked for."""
    return quantity(value.dimension) if isinstance(value, typed.NumberNode) else spoken(value)


def record_spoken(record: typed.Record) -> str:
    """What messages call a record: the thing itself, whatever its name is here."""
    match record:
        case typed.State():
            return f"the state `{record.signal.name}`"
        case typed.ParameterRecord():
            return f"the record of parameters `{record.symbol.name}`"
        case typed.Sample():
            return f"the {'first' if record.index == 0 else 'last'} sample of `{record.signal.name}`"
        case typed.Variable():
            part = "a sample" if record.signal.sequence else "an element"
            return f"`{record.name}` ({part} of `{record.signal.name}`)"
        case typed.NamedRecord():
            return (
                f"`{record.name}`, a {record.kind}" if record.value is None else record_spoken(record.value)
            )
        case _:
            assert_never(record)


def behind(number: typed.Number) -> typed.Number:
    """A number without the names that it goes by."""
    while True:
        if isinstance(number, typed.NamedNumber) and number.value is not None:
            number = number.value
        elif isinstance(number, typed.CalledNumber):
            number = number.body
        else:
            return number


def record_behind(record: typed.Record) -> typed.Record:
    """A record without the names that it goes by; a name itself where nothing is given for it yet."""
    while isinstance(record, typed.NamedRecord) and record.value is not None:
        record = record.value
    return record


def sample_of(record: typed.Record) -> typed.Variable | None:
    """The sample of a timeline that a record is, whatever its name is here; None for any other record."""
    found = record_behind(record)
    return found if isinstance(found, typed.Variable) and found.signal.sequence else None


def same_record(one: typed.Record, other: typed.Record) -> bool:
    """Whether two records are one thing; of parameters that nothing is given for, any two may be."""
    return _identity(one) == _identity(other)


def _identity(record: typed.Record) -> tuple[object, ...]:
    match record:
        case typed.State():
            return (record.signal.name,)
        case typed.ParameterRecord():
            return (record.symbol.qualified,)
        case typed.Sample():
            return record.signal.name, record.index
        case typed.Variable():
            over = record.range
            return record.signal.name, len(over.names), over.depth, record.offset
        case typed.NamedRecord():
            return () if record.value is None else _identity(record.value)
        case _:
            assert_never(record)


def on_open_line(line: typed.Line | typed.Area) -> bool:
    """Whether a line is known to be open, before there is data: a `line` of a spec, the path of a trajectory, or a line of a lane."""
    match line:
        case typed.PlacedLine() | typed.Path() | typed.LaneSide() | typed.Lane():
            return True
        case typed.CalledLine():
            return on_open_line(line.line)
        case typed.Centre():
            return on_open_line(line.of)
        case typed.NamedLine() | typed.NamedArea():
            return line.value is not None and on_open_line(line.value)
        case typed.SignalLine() | typed.Border() | typed.Corridor() | typed.Zone():
            return False
        case _:
            assert_never(line)


@lru_cache(maxsize=4096)
def in_si(text: str, unit: str) -> tuple[float, str]:
    """Digits in a unit in SI, and why they have no value that a double can hold; empty where they have one."""
    value = to_si(float(text), unit)
    if not math.isfinite(value):
        return value, "this number is too large for a double (about 1.8e308 in SI units)"
    if value == 0.0 and any(digit in "123456789" for digit in text.lower().partition("e")[0]):
        return value, "this number is too small for a double: it would become 0"
    return value, ""


def common(*values: typed.Number) -> str:
    """The unit in which several numbers are written; "" where they disagree."""
    units = {value.written for value in values} - {""}
    return units.pop() if len(units) == 1 else ""


def product(op: str, left: typed.Number, right: typed.Number) -> str:
    """The unit in which a product or a quotient is written: that of the quantity which a plain factor scales."""
    if right.dimension == NUMBER and (left.dimension != NUMBER or not right.written):
        return left.written
    if op == "*" and left.dimension == NUMBER and (right.dimension != NUMBER or not left.written):
        return right.written
    return ""


def own_unit(unit: str | None) -> str:
    """A unit as written; "" for a plain number."""
    return "" if unit in (None, "1") else str(unit)


def written_unit(values: Iterable[ast.Expr], declared: str) -> str:
    """The unit in which the values of a declaration are written, where all are numbers in one unit, else the declared one."""
    units = set()
    for value in values:
        literal = value.operand if isinstance(value, ast.Unary) else value
        units.add(own_unit(literal.unit) if isinstance(literal, ast.Number) else "")
    unit = units.pop() if len(units) == 1 else ""
    return unit or own_unit(declared)


def circle(stack: tuple[str, ...], name: str) -> str:
    """The way from a declaration back to itself; stack: what stands around its use, outermost first."""
    return " -> ".join(each.rpartition(".")[2] for each in (*stack[stack.index(name) :], name))
