"""Dimensions that do not match: what is said, and what to write."""

from __future__ import annotations

import re
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.semantics.errors.expressions import DimensionMismatch, WrongDimension
from trackmarshal.semantics.values import number_spoken, span_of
from trackmarshal.source import Span
from trackmarshal.syntax.build import is_unit
from trackmarshal.units import NUMBER, SPEED, Dimension, name, over, parse_unit, power, quantity, show

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def same(x: Expressions, action: str, left: typed.Number, right: typed.Number) -> None:
    """Fail unless two numbers have one dimension."""
    if left.dimension == right.dimension:
        for found in x.advice.joined(left, right):
            x.advise(found)
        return
    sides = (
        ("left side", "right side")
        if action in ("compare", "add", "subtract")
        else ("first one", "second one")
    )
    hint = decimal_comma(left.span, right.span)
    hint = hint or unit_hint(right, left.dimension, left.written)
    hint = hint or unit_hint(left, right.dimension, right.written)
    hint = hint or unit_of_factor(left, right.dimension) or unit_of_factor(right, left.dimension)
    hint = hint or _factor(left.dimension, right.dimension, *sides)
    ours, theirs = quantity(left.dimension), quantity(right.dimension)
    # Where a unit is missing, it is missing there, and no declaration is to blame.
    bare = any(isinstance(side, typed.Literally) and not side.unit for side in (left, right))
    things = () if bare else (_declared(left, ours, theirs), _declared(right, theirs, ours))
    declared = tuple(thing for thing in things if thing)
    x.fail(DimensionMismatch(left.span, right.span, action, ours, theirs, hint, (), declared))


def of_dimension(
    x: Expressions, value: typed.Value, wanted: Dimension, what: str, declared: Span | None = None, unit: str = ""
) -> typed.Number:  # fmt: skip
    """A value that is a number of this dimension; fails for any other. declared: where that is said, and in which unit."""
    if isinstance(value, typed.NumberNode) and value.dimension == wanted:
        return value
    hint = unit_hint(value, wanted, unit) if isinstance(value, typed.NumberNode) else ""
    x.fail(WrongDimension(span_of(value), declared, what, quantity(wanted), number_spoken(value), hint))


def _declared(number: typed.Number, own: str, other: str) -> tuple[str, Span, str, str] | None:
    """What a number is where it is declared: a parameter, or a field of a signal."""
    if isinstance(number, typed.Parameter):
        return number.symbol.item.__dict__["name"], number.symbol.item.__dict__["span"], own, other
    if isinstance(number, typed.Field) and number.record.signal is not None:
        field = number.record.signal.field(number.name)
        return (
            None if field is None else (f"{number.record.signal.name}.{number.name}", field.span, own, other)
        )
    return None


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


def decimal_comma(*spans: Span) -> str:
    """What to write where two arguments look like one number with a decimal comma, `f(1,5 m)`; empty where none do."""
    for first, second in pairwise(spans):
        text = first.file.text
        if first.text.isdecimal() and text[first.end : second.start] == "," and second.text[:1].isdecimal():
            return f"numbers have a decimal point: `{first.text}.{second.text}`"
    return ""


_LITERAL = re.compile(r"([-−]?\s*[0-9.]+(?:[eE][+-]?[0-9]+)?)\s*(\S*)")


def unit_hint(value: typed.Number, wanted: Dimension, declared: str = "") -> str:
    """How a literal gets the dimension that is wanted; empty for what is no literal, or has no such unit.

    declared: the unit of what it meets. Of a limit for a speed in km/h, whoever writes m/s as told has one that is 3.6 times as high.
    """
    literal, unit = _LITERAL.fullmatch(value.span.text.strip()), show(wanted)
    if declared and is_unit(declared) and parse_unit(declared)[2] == wanted:
        unit = declared
    if literal is None or typed.literal(value) is None or "*" in unit or "(" in unit:
        return ""
    if wanted == NUMBER:  # of what is declared in deg or %, a bare number is another one
        other = f"write a number in {unit}, such as `{literal[1]} {unit}`"
        return f"leave the unit out: `{literal[1]}`" if unit == "1" else other
    if not literal[2]:
        return f"write the unit: `{literal[1]} {unit}`"
    if literal[2] == "%":
        return f"say of what it is a share: `{literal[1]}% * NAME`"
    if literal[2] == "km" and wanted == SPEED:
        unit = "km/h"
    return f"write a unit of {name(wanted)}, such as `{literal[1]} {unit}`"


def unit_of_factor(value: typed.Number, wanted: Dimension) -> str:
    """What to write for `pit * 1.1 km/h`, where a speed is wanted and `pit` is one; empty for what is no such product."""
    if not isinstance(value, typed.Arithmetic) or value.op not in ("*", "/"):
        return ""
    factors = ((value.right, value.left), (value.left, value.right))[: 2 if value.op == "*" else 1]
    for factor, other in factors:
        literal = _LITERAL.fullmatch(factor.span.text.strip())
        if literal and literal[2] and isinstance(factor, typed.Literally) and other.dimension == wanted:
            return f"a factor has no unit: `{literal[1]}`"
    return ""
