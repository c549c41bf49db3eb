"""Zones and lines that are ones, and stretches of lines that lead ahead."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

from trackmarshal import outlines
from trackmarshal.ir.spec import PlaceInfo, track_of
from trackmarshal.semantics.declarations.parameters import Parameters
from trackmarshal.semantics.declarations.ranges import finite
from trackmarshal.semantics.errors.declarations import BackwardStretch, BadPlace
from trackmarshal.semantics.errors.expressions import BadValue
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.places import ends
from trackmarshal.semantics.values import on_open_line
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import in_full

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def place_info(item: ast.Place, x: Expressions, ctx: Context) -> PlaceInfo:
    """A declared zone or line; fails for one that is none."""
    numbers = x.all(*(partial(finite, x, number, "m") for point in item.points for number in point))
    points = tuple(zip(numbers[::2], numbers[1::2]))
    least = 3 if item.kind == "zone" else 2
    if len(set(points)) < least:
        problem = f"a {item.kind} has at least {least} different points, not {len(set(points))}"
        x.fail(BadValue(item.span.head, problem))
    wrong = outlines.problem(item.kind, points)
    if wrong is not None:
        other = None if wrong.other is None else _point(item, wrong.other)
        text = f"the {item.kind} `{item.name}` {wrong.text}"
        x.fail(BadPlace(_point(item, wrong.at), other, text, wrong.hint))
    module = ctx.scope.module
    return PlaceInfo(f"{module}.{item.name}", item.kind, points, item.span, track_of(module))


def _point(item: ast.Place, index: int) -> Span:
    """Where a point of a zone or a line stands."""
    x, y = item.points[index]
    return ast.span_of(x).to(ast.span_of(y))


def check_stretch(item: ast.Stretch, x: Expressions, ctx: Context, parameters: Parameters) -> None:
    """Fail for a stretch that ends before it begins; on a line that may be closed, none does."""
    line, *numbers = ends(item, x, ctx)
    (start, _), (end, _) = x.all(*(partial(parameters.constant, number, ctx) for number in numbers))
    if on_open_line(line) and end < start:
        x.fail(BackwardStretch(numbers[1].span, line.span, in_full(start, "m"), in_full(end, "m")))
