"""Signals: what one of a kind may hold, and that all modules agree on its contract."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir.spec import FieldType, SignalType
from trackmarshal.semantics.declarations.fields import field_type
from trackmarshal.semantics.declarations.lifetimes import lifetimes
from trackmarshal.semantics.errors.declarations import SignalConflict
from trackmarshal.semantics.errors.expressions import BadValue
from trackmarshal.semantics.errors.names import Duplicate
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.source import Span
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def check_signal(item: ast.Signal, x: Expressions, ctx: Context) -> None:
    """Declare a signal; what a module declares anew is the same as what another one says."""
    fields: list[FieldType] = []
    seen: dict[str, Span] = {}
    _check_kind(item, x.found)
    for field in item.fields_:
        if field.name in seen:
            x.found.append(Duplicate(field.span, seen[field.name], "field", field.name))
            continue
        seen[field.name] = field.span
        fields.append(field_type(x, field, ctx.scope))
    if item.kind == "corridor" and not fields:
        fields = [
            FieldType(side, "polyline", "m", False, None, None, None, item.span) for side in ("left", "right")
        ]
    signal = SignalType(item.name, item.kind, item.many, tuple(fields), item.span, *lifetimes(x, item))
    known = x.signals.setdefault(item.name, signal)
    if known != signal and ctx.scope.own[item.name].item is item:
        x.found.append(SignalConflict(item.span.head, known.span.head, item.name))


def _check_kind(item: ast.Signal, found: list[Diagnostic]) -> None:
    """What a signal of a kind may hold."""
    head, kind = item.span.head, item.kind

    def report(at: Span, problem: str, hint: str) -> None:
        found.append(BadValue(at, problem, None, hint))

    if item.many != (kind in ("object", "lane")):
        problem = f"there is no set of {kind}s" if item.many else f"{kind}s come in sets"
        hint = f"write `set of {kind if kind == 'lane' else 'object'}`"
        report(head, problem, hint if item.many else f"{hint}, or `state` for a single record")
    if kind == "polyline" and item.fields_:
        report(item.fields_[0].span, "a polyline has no fields", "it is a list of points")
    lacking = {"left", "right"} - {field.name for field in item.fields_ if field.type == "polyline"}
    for side in ("left", "right"):
        if side in lacking and kind == "corridor" and item.fields_:
            report(head, f"the corridor `{item.name}` lacks `{side}: polyline`", _CORRIDOR)
        elif side in lacking and kind == "lane":
            report(head, f"a lane lacks `{side}: polyline`", _LANE)
    for field in item.fields_ if kind != "polyline" else ():
        border = field.type == "polyline" and field.name in ("left", "right")
        if border and kind in ("corridor", "lane"):
            continue
        if kind == "corridor":
            report(field.span, f"a corridor has no field `{field.name}: {field.type}`", _CORRIDOR)
            continue
        if field.type == "polyline" and kind == "lane":
            report(field.span, f"a lane has no border `{field.name}`", "it has `left` and `right`")
        elif field.type == "polyline":
            report(field.span, f"a {kind} has no polylines", "polylines stand in a corridor, or alone")
        if field.increasing and kind not in ("trajectory", "series"):
            report(field.span, f"a field of a {kind} has no order", "only columns of a timeline increase")


_CORRIDOR = "its fields are `left: polyline` and `right: polyline`"
_LANE = "write `set of lane { left: polyline, right: polyline, ... }`"
