"""Zones, and stretches of lines: whether a point or a station lies in one."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.semantics.errors.expressions import WrongKind
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import of_dimension
from trackmarshal.semantics.expressions.geometry import line
from trackmarshal.semantics.expressions.shapes import SHAPES, shaped
from trackmarshal.semantics.scope import spoken
from trackmarshal.semantics.values import Poison, number_spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import LENGTH

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: A line, and the stations [m] at which a stretch of it begins and ends.
Ends = tuple[typed.Line, typed.Number, typed.Number]


def in_zone(expr: ast.InZone, x: Expressions, ctx: Context) -> typed.Formula:
    """`p in zone pit`."""
    at = Span(expr.span.file, ast.span_of(expr.value).end, expr.span.end).word(expr.zone)
    found = x.look_up(expr.zone, at, "zone", set(), ctx)
    if not isinstance(found.item, ast.Place) or found.item.kind != "zone":
        x.fail(WrongKind(at, "a zone", f"the {spoken(found.item)} `{expr.zone}`"))
    point = shaped(x, x.value(expr.value, ctx), "point", ast.span_of(expr.value))
    return typed.InZone(point, typed.Zone(found, at), expr.span)


def in_stretch(expr: ast.InStretch, x: Expressions, ctx: Context) -> typed.Formula:
    """`p in stretch chicane`."""
    at = Span(expr.span.file, ast.span_of(expr.value).end, expr.span.end).word(expr.stretch)
    found = x.look_up(expr.stretch, at, "stretch", set(), ctx)
    if not isinstance(found.item, ast.Stretch):
        x.fail(WrongKind(at, "a stretch", f"the {spoken(found.item)} `{expr.stretch}`"))
    if found.qualified in x.failed:
        raise Poison  # reported with the declaration
    place = _place(expr.value, x, ctx)
    line, start, end = ends(found.item, x, ctx.elsewhere(x.scopes[found.module], at))
    return typed.InStretch(place, found, line, start, end, expr.span)


def between_stations(expr: ast.BetweenStations, x: Expressions, ctx: Context) -> typed.Formula:
    """`p in stretch(track, s.from, s.to)`."""
    place, (line, start, end) = x.all(lambda: _place(expr.value, x, ctx), lambda: ends(expr, x, ctx))
    return typed.InStretch(place, None, line, start, end, expr.span)


def ends(expr: ast.Stretch | ast.BetweenStations, x: Expressions, ctx: Context) -> Ends:
    """The line of a stretch, where it begins and where it ends."""
    on, start, end = x.all(
        lambda: line(x, x.value(expr.line, ctx), ast.span_of(expr.line)),
        *(partial(_station, one, what, x, ctx) for one, what in ((expr.start, "begins"), (expr.end, "ends"))),
    )
    return on, start, end


def _station(expr: ast.Expr, what: str, x: Expressions, ctx: Context) -> typed.Number:
    return of_dimension(x, x.number(expr, ctx), LENGTH, f"the station at which a stretch {what}")


def _place(expr: ast.Expr, x: Expressions, ctx: Context) -> typed.Record | typed.Number:
    """What is asked about: a station, or a point, which stands for its station."""
    value = x.value(expr, ctx)
    if isinstance(value, typed.NumberNode) and value.dimension == LENGTH:
        return value
    if isinstance(value, typed.RecordNode):
        return shaped(x, value, "point", ast.span_of(expr))
    wanted = f"a station, or something with {', '.join(SHAPES['point'])}"
    x.fail(WrongKind(ast.span_of(expr), wanted, number_spoken(value)))
