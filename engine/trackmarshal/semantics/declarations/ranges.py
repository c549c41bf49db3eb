"""Numbers that declarations give, in SI: literals that may be bare, finite ones, and the ranges that they lie in."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from trackmarshal.semantics.errors.expressions import BadValue, WrongDimension
from trackmarshal.syntax import ast
from trackmarshal.units import digits, in_full, parse_unit, quantity

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def limits(x: Expressions, written: ast.Range | None, unit: str) -> tuple[float | None, float | None]:
    """A range in SI; bounds without a unit are in the declared one."""
    if written is None:
        return None, None
    lower, upper = x.all(lambda: _literal(x, written.lower, unit), lambda: _literal(x, written.upper, unit))
    if not lower <= upper:
        problem = f"a range runs from low to high, not from {in_full(lower, unit)} to {in_full(upper, unit)}"
        x.fail(BadValue(written.span, problem, None, "swap the bounds"))
    return lower, upper


def finite(x: Expressions, expr: ast.Expr, unit: str) -> float:
    """A literal in SI that is not infinite: ranges have open ends, values don't."""
    value = _literal(x, expr, unit)
    if not math.isfinite(value):
        problem = f"this value is {in_full(value, '1')}, which is not finite"
        x.fail(BadValue(ast.span_of(expr), problem, None, "only ranges may be open: `in [0, inf]`"))
    return value


def _literal(x: Expressions, expr: ast.Expr, unit: str) -> float:
    """A literal in SI: a bare number is in `unit`, another one must have its dimension."""
    if isinstance(expr, ast.Unary):
        return -_literal(x, expr.operand, unit)
    if isinstance(expr, ast.Name):
        return math.inf
    if not isinstance(expr, ast.Number):
        raise AssertionError(f"a bound is a literal, not {type(expr).__name__}")
    if expr.unit and parse_unit(expr.unit)[2] != parse_unit(unit)[2]:
        wanted, found = quantity(parse_unit(unit)[2]), quantity(parse_unit(expr.unit)[2])
        hint = f"write it in {unit}" + (", or leave the unit out" if unit != "1" else "")
        x.fail(WrongDimension(expr.span, None, "this value", wanted, found, hint))
    return x.literal(expr, unit)[0]


def inside(value: float, lower: float | None, upper: float | None) -> bool:
    """Whether a value is in a range; NaN is in none."""
    return (lower is None or value >= lower) and (upper is None or value <= upper) and not math.isnan(value)


def outside(lower: float | None, upper: float | None, unit: str) -> str:
    """What is said of a value that is outside a range in SI."""
    low = digits(-math.inf if lower is None else lower, unit)
    high = digits(math.inf if upper is None else upper, unit)
    return f"outside its range [{low}, {high}]" + ("" if unit == "1" else f" {unit}")
