"""Operators over time, along a timeline or over the run: windows, deadlines, and how often something was."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.ir.operators import TEMPORAL, UNTIL, known
from trackmarshal.semantics.advice.formulas import goes_on, met_by_others, same_everywhere
from trackmarshal.semantics.errors.expressions import BadValue
from trackmarshal.semantics.errors.names import UnknownReference
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import unit_hint
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import TIME, in_full, quantity

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def temporal(expr: ast.Temporal, x: Expressions, ctx: Context) -> typed.Formula:
    """`always p`, `once[0 s, 3 s] p`, `previous p`."""
    x.advise(goes_on(expr))
    x.advise(met_by_others(expr.op, expr.operand))
    (operand,), window = _over_time((expr.operand,), expr.window, x, ctx)
    axis = ctx.timeline
    x.advise(same_everywhere(expr.op, axis, operand))
    if expr.op in typed.STEPS:
        return typed.Step(known(expr.op, typed.STEPS), expr.weak, axis, operand, expr.span)
    return typed.Temporal(known(expr.op, TEMPORAL), axis, window, operand, expr.span)


def until(expr: ast.Until, x: Expressions, ctx: Context) -> typed.Formula:
    """`p until q`, `p since q`."""
    x.advise(met_by_others(expr.op, expr.right))
    (left, right), window = _over_time((expr.left, expr.right), expr.window, x, ctx)
    x.advise(same_everywhere(expr.op, ctx.timeline, left, right))
    return typed.Until(known(expr.op, UNTIL), ctx.timeline, window, left, right, expr.span)


def _over_time(
    operands: tuple[ast.Expr, ...], window: ast.Window | None, x: Expressions, ctx: Context
) -> tuple[list[typed.Formula], typed.Window | None]:
    """Operands and window of a temporal operator; the errors of all of them are reported."""
    bounds, *formulas = x.all(
        lambda: _window(window, x, ctx),
        *(lambda o=operand: x.formula(o, ctx) for operand in operands),
    )
    return formulas, bounds


def count(
    args: tuple[ast.Expr, ...], names: tuple[str, ...], span: Span, x: Expressions, ctx: Context
) -> typed.Count:
    """`count(p)`, with `last: 10 s` or `reset: q`."""
    given = dict(zip(names, args))
    wrong = next((arg for name, arg in zip(names, args) if name not in ("", "last", "reset")), None)
    if len(given) != len(args) or "" not in given or wrong is not None or names[0] or len(args) > 2:
        hint = "write `count(p)`, `count(p, last: 10 s)` or `count(p, reset: q)`"
        at = span if wrong is None else wrong.__dict__["span"]
        x.fail(UnknownReference(at, "`count` takes a formula, and `last` or `reset`", hint))
    x.advise(met_by_others("count", given[""]))
    x.advise(met_by_others("reset", given.get("reset")))
    counted, window, reset = x.all(
        lambda: x.formula(given[""], ctx),
        lambda: _last(given["last"], x, ctx) if "last" in given else None,
        lambda: x.formula(given["reset"], ctx) if "reset" in given else None,
    )
    x.advise(same_everywhere("count", ctx.timeline, counted, reset))
    return typed.Count(ctx.timeline, counted, window, reset, span)


def _last(limit: ast.Expr, x: Expressions, ctx: Context) -> typed.Window:
    """The window of a count: so long until now."""
    number, seconds = bound(limit, x, ctx)
    if seconds < 0.0:
        problem = f"a window starts at zero or later, not at {in_full(seconds, 's')}"
        x.fail(BadValue(ast.span_of(limit), problem))
    zero = typed.Literally(TIME, "s", "0", "s", 0.0, ast.span_of(limit))
    return typed.Window(zero, number, (0.0, seconds), ast.span_of(limit))


def deadline(limit: ast.Expr, span: Span, x: Expressions, ctx: Context) -> typed.Deadline:
    """How long after a cycle something has to happen: a literal time."""
    number, seconds = bound(limit, x, ctx)
    if seconds < 0.0:
        problem = f"a deadline is not before the cycle that it counts from, at {in_full(seconds, 's')}"
        x.fail(BadValue(ast.span_of(limit), problem))
    return typed.Deadline(number, seconds, span)


def _window(window: ast.Window | None, x: Expressions, ctx: Context) -> typed.Window | None:
    if window is None:
        return None
    (lower, low), (upper, high) = x.all(
        lambda: bound(window.lower, x, ctx), lambda: bound(window.upper, x, ctx)
    )
    if low < 0:
        past = "`once`, `historically` and `since` look back"
        hint = f"windows count away from the current sample; {past}"
        problem = f"a window starts at zero or later, not at {in_full(low, 's')}"
        x.fail(BadValue(ast.span_of(window.lower), problem, None, hint))
    if high < low:
        problem = f"a window runs from low to high, not from {in_full(low, 's')} to {in_full(high, 's')}"
        x.fail(BadValue(window.span, problem, None, "swap the bounds"))
    return typed.Window(lower, upper, (low, high), window.span)


#: No time that anybody means is longer [s]; a thousand times as long, and no evaluator could count in it.
NEVER = 1e15


def bound(limit: ast.Expr, x: Expressions, ctx: Context) -> tuple[typed.Number, float]:
    """A bound of a window: a literal time, and its value in s."""
    value = x.number(limit, ctx)
    if value.dimension != TIME:
        problem = f"the window of a temporal operator is a time, not {quantity(value.dimension)}"
        x.fail(BadValue(value.span, problem, None, unit_hint(value, TIME)))
    seconds = typed.literal(value)
    if seconds is None:
        hint = "write a number with a unit of time: how much is remembered is known before the run, and a parameter may be overridden"
        x.fail(BadValue(value.span, "the window of a temporal operator is constant", None, hint))
    if abs(seconds) > NEVER:
        problem = f"no time is as long as {in_full(seconds, 's')}"
        x.fail(BadValue(value.span, problem, None, "leave the bound out where it is none"))
    return value, seconds
