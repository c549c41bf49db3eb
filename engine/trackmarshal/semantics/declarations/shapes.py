"""Shapes: the fields that each declares itself, and what is wrong with those of which nobody asks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.ir.spec import FieldType
from trackmarshal.semantics.errors.declarations import ShapeProblem
from trackmarshal.semantics.errors.names import Duplicate, Hides
from trackmarshal.semantics.expressions.shapes import SHAPES, SIGNALS, Kind, resolved
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import UNITS, parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def check_shape(x: Expressions, item: ast.Shape, symbol: typed.Symbol) -> None:
    """Report what is wrong with a shape, whether it is used or not."""
    if symbol.qualified not in x.failed:
        resolved(x, symbol, item.span.head, ())


def own_fields(
    x: Expressions, item: ast.Shape, qualified: str, read: Callable[[ast.Field], FieldType]
) -> dict[str, Kind] | None:
    """The fields that a shape declares itself; None where one of them has an error."""
    before, found = len(x.found), dict[str, Kind]()
    first: dict[str, Span] = {}
    units = x.units.setdefault(qualified, {})
    if item.name in SHAPES or item.name in SIGNALS or item.name in UNITS:
        what = "unit" if item.name in UNITS else "shape" if item.name in SHAPES else "type"
        x.found.append(Hides(item.span.head, None, "shape", item.name, what, " of the language"))
    for field in item.fields_:
        if field.name in first:
            x.found.append(Duplicate(field.span, first[field.name], "field", field.name))
            continue
        first[field.name] = field.span
        made = read(field)
        if made.kind == "polyline":
            hint = "a `corridor` or a `polyline` is a parameter of its own"
            x.found.append(
                ShapeProblem(field.span, "a shape has numbers, Booleans and members, and no lines", hint)
            )
        units[field.name] = made.unit
        found[field.name] = None if made.kind == "bool" else made.enumeration or parse_unit(made.unit)[2]
    return found if len(x.found) == before else None
