"""Record shapes that definitions ask for by name, those of the language and those of specs: which fields, of which kinds."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import Enumeration, FieldType
from trackmarshal.semantics.errors.declarations import ShapeProblem
from trackmarshal.semantics.errors.expressions import WrongKind
from trackmarshal.semantics.errors.names import Duplicate, Hides
from trackmarshal.semantics.scope import Scope, spoken
from trackmarshal.semantics.values import Poison
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import is_unit
from trackmarshal.syntax.errors import UnknownUnit
from trackmarshal.syntax.foreign_units import unit_hint
from trackmarshal.units import LENGTH, NUMBER, SPEED, UNITS, Dimension, parse_unit

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions import Expressions

#: What a field is: the dimension of a number, the enumeration of a member, None for a Boolean.
Kind: TypeAlias = Dimension | Enumeration | None

_POINT: dict[str, Kind] = {"x": LENGTH, "y": LENGTH}
_POSE: dict[str, Kind] = {**_POINT, "heading": NUMBER}

#: A record fits a shape when it has these fields; other fields of it cannot be read through the shape.
SHAPES: dict[str, dict[str, Kind]] = {
    "point": _POINT,
    "pose": _POSE,
    "moving": {**_POSE, "v": SPEED},
    "body": {**_POSE, "length": LENGTH, "width": LENGTH},
    "vehicle": {**_POSE, "v": SPEED, "length": LENGTH, "width": LENGTH},
}
#: Types of parameters that take whole signals.
_SIGNALS = ("trajectory", "corridor", "polyline")


def is_shape(kind: str) -> bool:
    """Whether the type of a parameter is a shape, of the language or by the name of a declared one, and no unit or kind of signal."""
    return not is_unit(kind) and kind not in _SIGNALS


def shape_named(x: Expressions, name: str, at: Span, scope: Scope) -> typed.Shape:
    """The fields of a shape by its name; fails where there is none of that name, or something is wrong with it."""
    if name in SHAPES:
        return SHAPES[name]
    found = scope.look_up(name, at, "shape", set()) if scope.knows(name) else None
    if isinstance(found, Diagnostic):
        x.fail(found)
    if found is not None:
        return _resolved(x, found, at, ())
    if name in scope.broken or scope.incomplete:
        raise Poison
    unknown = scope.unknown(name, at, "shape", "")
    if unknown.modules:
        x.fail(unknown)
    shapes = [n for n in scope.names() if (s := scope.find(n)) is not None and isinstance(s.item, ast.Shape)]
    kinds = f"{', '.join(SHAPES)}, {', '.join(_SIGNALS)}, or the name of a `shape`"
    x.fail(
        UnknownUnit(at, "unit or shape", name, close_matches(name, shapes) or unit_hint(name, name, kinds))
    )


def _resolved(x: Expressions, symbol: typed.Symbol, at: Span, stack: tuple[str, ...]) -> typed.Shape:
    """The fields of a declared shape, those of the shape that it is made of first."""
    item, name = symbol.item, symbol.qualified
    if not isinstance(item, ast.Shape):
        x.fail(WrongKind(at, "a unit or a shape", f"the {spoken(item)} `{symbol.name}`"))
    known = x.shapes.get(name)
    if known is not None:
        return known
    if name in x.failed or name not in x.own_fields:
        raise Poison
    x.failed.add(name)  # until it is known
    base = _base(x, item, symbol, (*stack, name)) if item.base else {}
    own = x.own_fields[name]
    other = x.scopes[symbol.module].find(item.base) if item.base and item.base not in SHAPES else None
    if other is not None:
        x.units[name] = {**x.units[other.qualified], **x.units[name]}
    twice = next((field for field in item.fields_ if field.name in base), None)
    if twice is not None:
        x.fail(
            ShapeProblem(
                twice.span,
                f"`{item.base}` has a field `{twice.name}` already",
                "leave it out, or give it another name",
            )
        )
    x.failed.discard(name)
    x.shapes[name] = {**base, **own}
    return x.shapes[name]


def _base(x: Expressions, item: ast.Shape, symbol: typed.Symbol, stack: tuple[str, ...]) -> typed.Shape:
    at, scope = item.span.head.word(item.base), x.scopes[symbol.module]
    other = scope.find(item.base)
    if other is None or item.base in SHAPES:
        return shape_named(x, item.base, at, scope)
    if other.qualified in stack:
        way = " -> ".join(
            name.rpartition(".")[2] for name in (*stack[stack.index(other.qualified) :], other.qualified)
        )
        x.fail(ShapeProblem(at, f"the shape `{item.base}` is made of itself: {way}", "write its fields"))
    return _resolved(x, other, at, stack)


def check_shape(x: Expressions, item: ast.Shape, symbol: typed.Symbol) -> None:
    """Report what is wrong with a shape, whether it is used or not."""
    if symbol.qualified not in x.failed:
        _resolved(x, symbol, item.span.head, ())


def own_fields(
    x: Expressions, item: ast.Shape, qualified: str, read: Callable[[ast.Field], FieldType]
) -> dict[str, Kind] | None:
    """The fields that a shape declares itself; None where one of them has an error."""
    before, found = len(x.found), dict[str, Kind]()
    first: dict[str, Span] = {}
    units = x.units.setdefault(qualified, {})
    if item.name in SHAPES or item.name in _SIGNALS or item.name in UNITS:
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
