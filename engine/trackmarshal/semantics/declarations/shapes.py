"""Shapes: the fields that each declares itself, and what is wrong with those of which nobody asks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.semantics.declarations.fields import field_type
from trackmarshal.semantics.errors.declarations import ShapeProblem
from trackmarshal.semantics.errors.names import Duplicate, Hides
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.shapes import SHAPES, SIGNALS, Kind, resolved
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import UNITS, parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def check_shape(item: ast.Shape, x: Expressions, ctx: Context) -> None:
    """Report what is wrong with a shape, whether it is used or not."""
    symbol = typed.Symbol(item, ctx.scope.module, f"{ctx.scope.module}.{item.name}")
    if symbol.qualified not in x.failed:
        resolved(x, symbol, item.span.head, ())


def own_fields(item: ast.Shape, x: Expressions, ctx: Context) -> None:
    """Declare the fields that a shape has of its own; none where one of them has an error."""
    qualified = f"{ctx.scope.module}.{item.name}"
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
        made = field_type(x, field, ctx.scope)
        if made.kind == "polyline":
            hint = "a `corridor` or a `polyline` is a parameter of its own"
            x.found.append(
                ShapeProblem(field.span, "a shape has numbers, Booleans and members, and no lines", hint)
            )
        units[field.name] = made.unit
        found[field.name] = None if made.kind == "bool" else made.enumeration or parse_unit(made.unit)[2]
    if len(x.found) == before:
        x.own_fields.setdefault(qualified, found)
