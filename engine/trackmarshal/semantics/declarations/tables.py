"""Tables: knots that ascend, rows that fit the arguments, periods that hold all knots."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from trackmarshal.ir.spec import Across, TableInfo
from trackmarshal.ir.tables import Way, in_period
from trackmarshal.semantics.declarations.ranges import finite
from trackmarshal.semantics.errors.declarations import TablePeriod, TableShape
from trackmarshal.semantics.errors.expressions import BadValue
from trackmarshal.semantics.errors.names import Duplicate
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import decimal_comma
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import in_full

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def table_info(item: ast.Table, x: Expressions, ctx: Context) -> TableInfo:
    """A declared table in SI; fails for one that cannot be read."""
    _check_shape(x, item)
    second = item.second
    ways = item.ways * 2 if len(item.ways) == 1 else item.ways
    heads, cells = [row[0] for row in item.rows], [cell for row in item.rows for cell in row[1:]]
    knots, values, columns = x.all(
        lambda: _knots(x, heads, item.unit, ways[0]),
        lambda: x.all(*(partial(finite, x, cell, item.result) for cell in cells)),
        lambda: _knots(x, second.knots, second.unit, ways[1]) if second else None,
    )
    across = None
    if second is not None and columns is not None:
        across = Across(columns[0], second.unit, columns[1])
    return TableInfo(
        f"{ctx.scope.module}.{item.name}",
        knots[0],
        tuple(values),
        (item.unit, item.result),
        item.span,
        knots[1],
        across,
    )


def _check_shape(x: Expressions, item: ast.Table) -> None:
    second = item.second
    if second is None:
        width = 1
        if len(item.ways) > 1:
            hint = f"leave `{item.ways[1].span.text}` out, or name a second argument"
            problem = "this table has one argument to be read along, not two"
            x.fail(TableShape(item.ways[1].span, None, problem, hint))
    else:
        width = len(second.knots)
        if second.name == item.argument:
            at = item.span.head
            x.fail(Duplicate(at, at, "argument", second.name))
        if not second.knots:
            hint = f"begin with `| {second.name}: ...`, and give each row as many values"
            x.fail(TableShape(second.span, None, f"there is no row of knots for `{second.name}`", hint))
        if second.label != second.name:
            problem = f"the row of knots is that of `{second.name}`, not of `{second.label}`"
            hint = f"begin it with `| {second.name}:`"
            x.fail(TableShape(second.span.word(second.label), None, problem, hint))
    for row in item.rows:
        if len(row) - 1 != width:
            at = ast.span_of(row[0]).to(ast.span_of(row[-1]))
            has, wanted = _values(len(row) - 1), _values(width)
            hint = "a table of one argument has a knot and a value in each row" if second is None else ""
            hint = decimal_comma(*map(ast.span_of, row)) or hint
            x.fail(TableShape(at, second.span if second else None, f"this row has {has}, not {wanted}", hint))


def _knots(
    x: Expressions, exprs: Sequence[ast.Expr], unit: str, written: ast.Way
) -> tuple[tuple[float, ...], Way]:
    """The knots of one argument in SI, and how the table is read along it."""
    numbers, length = x.all(
        lambda: x.all(*(partial(finite, x, expr, unit) for expr in exprs)),
        lambda: 0.0 if written.length is None else finite(x, written.length, unit),
    )
    knots = tuple(numbers)
    for before, after, above, here in zip(knots, knots[1:], exprs, exprs[1:]):
        if not before < after:
            problem = (
                f"the knots of a table ascend; {in_full(after, unit)} is not above {in_full(before, unit)}"
            )
            hint, about = "sort the rows; each knot stands once", "not above this one"
            x.fail(BadValue(ast.span_of(here), problem, ast.span_of(above), hint, about))
    way = Way(written.reading == "step", written.outside == "clamp", length)
    if written.length is not None:
        _check_period(x, way, knots, exprs, unit, ast.span_of(written.length))
    return knots, way


def _check_period(
    x: Expressions, way: Way, knots: Sequence[float], exprs: Sequence[ast.Expr], unit: str, at: Span
) -> None:
    if not way.length > 0.0:
        problem = f"a period of {in_full(way.length, unit)} has no length"
        x.fail(TablePeriod(at, None, problem, "write a length above 0"))
    if not in_period(way, knots):
        wrong = exprs[0] if knots[0] < 0.0 else exprs[-1]
        problem = f"this knot is outside the period, which goes from 0 up to {in_full(way.length, unit)}"
        hint = "write the place from 0 on at which it is in the first period"
        x.fail(TablePeriod(ast.span_of(wrong), at, problem, hint))


def _values(count: int) -> str:
    return "1 value" if count == 1 else f"{count} values"
