"""Fields of signals and shapes: numbers in a unit, Booleans, members of enumerations and polylines, with their ranges and defaults."""

from __future__ import annotations

from contextlib import suppress
from typing import TYPE_CHECKING, TypeGuard

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.ir.spec import UNKNOWN, FieldType
from trackmarshal.semantics.declarations.enums import declared
from trackmarshal.semantics.declarations.ranges import finite, inside, limits, outside
from trackmarshal.semantics.errors.expressions import BadValue, WrongKind
from trackmarshal.semantics.expressions.members import unknown
from trackmarshal.semantics.scope import Scope, spoken
from trackmarshal.semantics.values import Poison
from trackmarshal.syntax import ast
from trackmarshal.syntax.build import is_unit
from trackmarshal.syntax.errors import UnknownUnit
from trackmarshal.syntax.foreign_units import unit_hint
from trackmarshal.units import in_full

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def field_type(x: Expressions, field: ast.Field, scope: Scope) -> FieldType:
    """The contract of a field; where a part of it has an error, the field is there all the same."""
    if field.type == "polyline":
        if field.range or field.default or field.increasing:
            x.found.append(BadValue(field.span, "a polyline has no range, order or default"))
        return FieldType(field.name, field.type, "1", False, None, None, None, field.span)
    if field.type == "bool":
        if field.range or field.increasing:
            x.found.append(BadValue(field.span, "a bool has no range or order"))
        return FieldType(field.name, field.type, "1", False, None, None, _truth(x, field), field.span)
    if not is_unit(field.type):
        return _member(x, field, scope)
    unit = field.type
    lower, upper, default = None, None, None
    with suppress(Poison):
        lower, upper = limits(x, field.range, unit)
    if field.default is not None:
        at = ast.span_of(field.default)
        with suppress(Poison):
            if isinstance(field.default, ast.Boolean) or _is_word(field.default):
                x.fail(BadValue(at, f"the default of `{field.name}` is a number in {unit}"))
            default = finite(x, field.default, unit)
            if not inside(default, lower, upper):
                problem = f"the default of `{field.name}`, {in_full(default, unit)}, is {outside(lower, upper, unit)}"
                x.found.append(BadValue(at, problem, field.range.span if field.range else None))
    return FieldType(field.name, "number", unit, field.increasing, lower, upper, default, field.span)


def _truth(x: Expressions, field: ast.Field) -> float | None:
    """The default of a Boolean."""
    if field.default is None or isinstance(field.default, ast.Boolean):
        return None if field.default is None else float(field.default.value)
    x.found.append(BadValue(ast.span_of(field.default), f"the default of `{field.name}` is true or false"))
    return None


def _member(x: Expressions, field: ast.Field, scope: Scope) -> FieldType:
    """A field that is a member of an enumeration, by the place of the member."""
    at = field.span.word(field.type)
    symbol = scope.find(field.type)
    known = scope.look_up(field.type, at, "enumeration", set()) if scope.knows(field.type) else None
    if symbol is None or not isinstance(symbol.item, ast.Enum):
        if isinstance(known, Diagnostic):
            x.found.append(known)
        elif symbol is not None:
            found = f"the {spoken(symbol.item)} `{field.type}`"
            x.found.append(WrongKind(at, "a unit or an enumeration", found))
        elif field.type not in scope.broken and not scope.incomplete:
            x.found.append(UnknownUnit(at, "unit or enumeration", field.type, _type_hint(field.type, scope)))
        return FieldType(field.name, UNKNOWN, "1", False, None, None, None, field.span)
    made = declared(symbol.item, symbol.module)
    if field.range or field.increasing:
        x.found.append(BadValue(field.span, "a member of an enumeration has no range or order"))
    default = None
    if _is_word(field.default) and field.default.name in made.members:
        default = float(made.members.index(field.default.name))
    elif _is_word(field.default):
        x.found.append(unknown(made, field.default.name, field.default.span))
    elif field.default is not None:
        problem = f"the default of `{field.name}` is a member of `{field.type}`"
        hint = f"its members are {', '.join(made.members)}"
        x.found.append(BadValue(ast.span_of(field.default), problem, None, hint))
    return FieldType(field.name, "number", "1", False, None, None, default, field.span, made)


def _type_hint(name: str, scope: Scope) -> str:
    """What may have been meant by the type of a field: an enumeration, or a unit."""
    known = scope.names_of(ast.Enum)
    return close_matches(name, known) or unit_hint(name, name, "polyline, bool, or the name of an `enum`")


def _is_word(expr: ast.Expr | None) -> TypeGuard[ast.Name]:
    """Whether a default is a word, and not the name of a number."""
    return isinstance(expr, ast.Name) and expr.name != "inf"
