"""Record shapes that definitions ask for by name, those of the language and those of specs: which fields, of which kinds."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import Enumeration
from trackmarshal.semantics.errors.declarations import ShapeProblem
from trackmarshal.semantics.errors.expressions import WrongKind
from trackmarshal.semantics.scope import Scope, spoken
from trackmarshal.semantics.values import Poison, circle, member_spoken
from trackmarshal.semantics.values import spoken as value_spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import is_unit
from trackmarshal.syntax.errors import UnknownUnit
from trackmarshal.syntax.foreign_units import unit_hint
from trackmarshal.units import LENGTH, NUMBER, SPEED, Dimension, quantity, show

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

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
SIGNALS = ("trajectory", "corridor", "polyline")


def is_shape(kind: str) -> bool:
    """Whether the type of a parameter is a shape, of the language or by the name of a declared one, and no unit or kind of signal."""
    return not is_unit(kind) and kind not in SIGNALS


def shape_named(x: Expressions, name: str, at: Span, scope: Scope) -> typed.Shape:
    """The fields of a shape by its name; fails where there is none of that name, or something is wrong with it."""
    if name in SHAPES:
        return SHAPES[name]
    found = scope.look_up(name, at, "shape", set()) if scope.knows(name) else None
    if isinstance(found, Diagnostic):
        x.fail(found)
    if found is not None:
        return resolved(x, found, at, ())
    if name in scope.broken or scope.incomplete:
        raise Poison
    unknown = scope.unknown(name, at, "shape", "")
    if unknown.modules:
        x.fail(unknown)
    shapes = scope.names_of(ast.Shape)
    kinds = f"{', '.join(SHAPES)}, {', '.join(SIGNALS)}, or the name of a `shape`"
    x.fail(
        UnknownUnit(at, "unit or shape", name, close_matches(name, shapes) or unit_hint(name, name, kinds))
    )


def resolved(x: Expressions, symbol: typed.Symbol, at: Span, stack: tuple[str, ...]) -> typed.Shape:
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
        problem = f"`{item.base}` has a field `{twice.name}` already"
        x.fail(ShapeProblem(twice.span, problem, "leave it out, or give it another name"))
    x.failed.discard(name)
    x.shapes[name] = {**base, **own}
    return x.shapes[name]


def _base(x: Expressions, item: ast.Shape, symbol: typed.Symbol, stack: tuple[str, ...]) -> typed.Shape:
    at, scope = item.span.head.word(item.base), x.scopes[symbol.module]
    other = scope.find(item.base)
    if other is None or item.base in SHAPES:
        return shape_named(x, item.base, at, scope)
    if other.qualified in stack:
        way = circle(stack, other.qualified)
        x.fail(ShapeProblem(at, f"the shape `{item.base}` is made of itself: {way}", "write its fields"))
    return resolved(x, other, at, stack)


def shaped(x: Expressions, value: typed.Value, shape: str, span: Span) -> typed.Record:
    """A value that is a record with the fields that a shape names."""
    hint = lacking(value, SHAPES[shape]) if isinstance(value, typed.RecordNode) else one_of(value)
    if not isinstance(value, typed.RecordNode) or hint:
        x.fail(WrongKind(span, f"something with {', '.join(SHAPES[shape])}", value_spoken(value), hint))
    return value


def one_of(value: typed.Value) -> str:
    """How one of a whole set, or a sample of a timeline, is named; empty for what is neither."""
    if not isinstance(value, typed.SignalNode) or not (value.signal.many or value.signal.sequence):
        return ""
    each = "o" if value.signal.many else "p"
    return (
        f"this is all of them: bind each by `for all {each} in {value.signal.name}`, and write `{each}` here"
    )


def lacking(value: typed.Record, shape: typed.Shape) -> str:
    """Why a record does not fit a shape; empty when it does."""
    for field, kind in shape.items():
        if field not in value.shape:
            similar = close_matches(field, [name for name in value.shape if name not in shape])
            unit = "rad" if field == "heading" else _declared_as(kind)
            return f"it has no `{field}`" + (f"; {similar}" if similar else f": declare `{field}: {unit}`")
        own = value.shape[field]
        if own != kind:
            return f"its `{field}` is {_kind_spoken(own, kind)}, not {_kind_spoken(kind, own)}"
    return ""


def _declared_as(kind: Kind) -> str:
    """How a field of a kind is declared."""
    if isinstance(kind, Enumeration):
        return kind.name.rpartition(".")[2]
    return "bool" if kind is None else show(kind)


def _kind_spoken(kind: Kind, beside: Kind) -> str:
    if isinstance(kind, Enumeration):
        return member_spoken(kind, beside if isinstance(beside, Enumeration) else None)
    return "a Boolean" if kind is None else quantity(kind)
