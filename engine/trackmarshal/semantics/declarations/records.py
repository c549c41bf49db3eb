"""Records of parameters: each field of a shape is a parameter of its own, `limits.response`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.spec import Enumeration
from trackmarshal.semantics.errors.declarations import RecordProblem
from trackmarshal.semantics.expressions.shapes import SHAPES, shape_named
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import show

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions
    from trackmarshal.semantics.scope import Scope


def record_params(x: Expressions, item: ast.ParamRecord, scope: Scope, params: list[ast.Param]) -> None:
    """Declare a record, and add a parameter for each of its fields, in the unit that the shape declares; fails where they do not fit."""
    at = item.span.head.word(item.shape)
    shape = shape_named(x, item.shape, at, scope)
    units = _units(x, item.shape, shape, scope)
    problems: list[RecordProblem] = []
    plain = [name for name, kind in shape.items() if kind is None or isinstance(kind, Enumeration)]
    if plain:
        problem = f"`{plain[0]}` of `{item.shape}` is no number"
        problems.append(RecordProblem(at, problem, "parameters are numbers: take a shape of numbers alone"))
    first: dict[str, Span] = {}
    made = []
    for entry in item.entries:
        if entry.name in first:
            problem = f"`{entry.name}` stands twice in `{item.name}`"
            problems.append(RecordProblem(entry.span, problem, "remove one", first[entry.name]))
        elif entry.name not in shape:
            hint = close_matches(entry.name, shape) or f"its fields are {', '.join(shape)}"
            problems.append(RecordProblem(entry.span, f"`{item.shape}` has no field `{entry.name}`", hint))
        elif entry.name not in plain:
            name = f"{item.name}.{entry.name}"
            made.append(
                ast.Param(name, units[entry.name], entry.value, entry.range, entry.source, entry.span)
            )
        first.setdefault(entry.name, entry.span)
    missing = [name for name in shape if name not in first]
    if missing:
        listed = ", ".join(f"`{name}`" for name in missing)
        hint = f"add `{missing[0]}: ...`: there are no values that nobody wrote"
        problems.append(RecordProblem(item.span.head, f"`{item.name}` does not say what {listed} is", hint))
    if problems:
        x.found += problems[1:]
        x.fail(problems[0])
    x.records.setdefault(f"{scope.module}.{item.name}", shape)
    params += made


def check_field(x: Expressions, item: ast.Param, scope: Scope) -> None:
    """Report `param limits.response` where the record `limits` can be seen: a field has one value, and another one in a configuration."""
    record, dot, _ = item.name.partition(".")
    symbol = scope.find(record) if dot else None
    if symbol is not None:
        declared: Span = symbol.item.__dict__["span"]
        hint = f"write it where `{record}` is declared, or move it to a configuration that does not use this module"
        problem, about = f"`{item.name}` has a value already", "it is declared here"
        x.found.append(RecordProblem(item.span.head, problem, hint, declared.head, about))


def _units(x: Expressions, name: str, shape: typed.Shape, scope: Scope) -> dict[str, str]:
    """The unit of each number of a shape: as it is declared, and of those of the language SI units, and rad."""
    symbol = None if name in SHAPES else scope.find(name)
    declared = {} if symbol is None else x.units[symbol.qualified]
    return {
        field: declared.get(field) or ("rad" if field == "heading" else show(kind))
        for field, kind in shape.items()
        if kind is not None and not isinstance(kind, Enumeration)
    }
