"""Arithmetic: the dimensions of sums, products and powers, and of a choice between two numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.ir.operators import ARITHMETIC, known
from trackmarshal.semantics.advice.headings import between
from trackmarshal.semantics.errors.expressions import BadValue
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import same
from trackmarshal.semantics.values import Poison, common, product
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER, in_full, over, quantity, times
from trackmarshal.units import power as raised

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def arithmetic(expr: ast.Binary, x: Expressions, ctx: Context) -> typed.Number:
    """A sum, a difference, a product or a quotient."""
    op = known(expr.op, ARITHMETIC)
    try:
        left = x.number(expr.left, ctx)
    except Poison:
        x.number(expr.right, ctx)  # whose errors are reported as well
        raise
    right = x.number(expr.right, ctx)
    x.advise(between(op, left, right, expr.span))
    if op in ("+", "-"):
        same(x, "add" if op == "+" else "subtract", left, right)
        return typed.Arithmetic(left.dimension, common(left, right), op, left, right, expr.span)
    dimension = (times if op == "*" else over)(left.dimension, right.dimension)
    return typed.Arithmetic(dimension, product(op, left, right), op, left, right, expr.span)


def power(expr: ast.Binary, x: Expressions, ctx: Context) -> typed.Number:
    """`a^b`: of what has a dimension, a whole power alone has one, too."""
    base, exponent = x.all(lambda: x.number(expr.left, ctx), lambda: x.number(expr.right, ctx))
    if exponent.dimension != NUMBER:
        x.fail(BadValue(exponent.span, f"an exponent is a plain number, not {quantity(exponent.dimension)}"))
    constant, whole = typed.literal(exponent), typed.whole_exponent(exponent)
    if whole is not None:
        return typed.Power(raised(base.dimension, whole), "", base, exponent, expr.span)
    if base.dimension != NUMBER:
        hint = (
            "use sqrt(...) for a root" if constant == 0.5 else "divide the base by a reference quantity first"
        )
        problem = f"the exponent of {quantity(base.dimension)} must be a literal whole number from 1 to 8, or from -8 to -1"
        if constant is not None:
            problem += f", not {in_full(constant, '1')}"
        x.fail(BadValue(exponent.span, problem, base.span, hint, f"this is {quantity(base.dimension)}"))
    return typed.Power(NUMBER, "", base, exponent, expr.span)


def choice(expr: ast.IfElse, x: Expressions, ctx: Context) -> typed.Number:
    """`if p then a else b`."""
    condition, then, otherwise = x.all(
        lambda: x.formula(expr.condition, ctx),
        lambda: x.number(expr.then, ctx),
        lambda: x.number(expr.otherwise, ctx),
    )
    same(x, "choose between", then, otherwise)
    return typed.Choice(then.dimension, common(then, otherwise), condition, then, otherwise, expr.span)
