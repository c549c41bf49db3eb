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
    if item.many != (kind in ("object", "lane")):
        problem = f"there is no set of {kind}s" if item.many else f"{kind}s come in sets"
        found.append(
            BadValue(
                head,
                problem,
                None,
                f"write `set of {kind if kind == 'lane' else 'object'}`"
                + ("" if item.many else ", or `state` for a single record"),
            )
        )
    if kind == "polyline" and item.fields_:
        found.append(
            BadValue(item.fields_[0].span, "a polyline has no fields", None, "it is a list of points")
        )
    if kind == "corridor" and item.fields_:
        sides = {field.name for field in item.fields_ if field.type == "polyline"}
        for field in item.fields_:
            if field.type != "polyline" or field.name not in ("left", "right"):
                found.append(
                    BadValue(
                        field.span, f"a corridor has no field `{field.name}: {field.type}`", None, _CORRIDOR
                    )
                )
        for side in ("left", "right"):
            if side not in sides:
                found.append(
                    BadValue(head, f"the corridor `{item.name}` lacks `{side}: polyline`", None, _CORRIDOR)
                )
    sides = {field.name for field in item.fields_ if field.type == "polyline"}
    for side in ("left", "right") if kind == "lane" else ():
        if side not in sides:
            found.append(BadValue(head, f"a lane lacks `{side}: polyline`", None, _LANE))
    for field in item.fields_ if kind not in ("corridor", "polyline") else ():
        if kind == "lane" and field.type == "polyline" and field.name in ("left", "right"):
            continue
        if field.type == "polyline":
            found.append(
                BadValue(
                    field.span,
                    f"a lane has no border `{field.name}`"
                    if kind == "lane"
                    else f"a {kind} has no polylines",
                    None,
                    "it has `left` and `right`"
                    if kind == "lane"
                    else "polylines stand in a corridor, or alone",
                )
            )
        if field.increasing and kind not in ("trajectory", "series"):
            found.append(
                BadValue(
                    field.span,
                    f"a field of a {kind} has no order",
                    None,
                    "only columns of a timeline increase",
                )
            )


_CORRIDOR = "its fields are `left: polyline` and `right: polyline`"
_LANE = "write `set of lane { left: polyline, right: polyline, ... }`"
