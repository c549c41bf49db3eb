"""Formulas of numbers and of other formulas: comparisons, chains of them, ranges, and connectives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from trackmarshal import typed
from trackmarshal.ir.operators import known
from trackmarshal.semantics.advice.formulas import changes, ends_early, joins_conditions
from trackmarshal.semantics.advice.headings import laps_over, turns_over
from trackmarshal.semantics.errors.expressions import BadValue, WrongDimension, WrongKind
from trackmarshal.semantics.errors.names import UnknownName
from trackmarshal.semantics.expressions import members
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import same
from trackmarshal.semantics.values import Poison, spoken
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.syntax.notation import ASKED
from trackmarshal.units import NUMBER, TIME, quantity

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def connective(expr: ast.Binary, x: Expressions, ctx: Context) -> typed.Formula:
    """`p and q`, `p implies q`."""
    early = ends_early(expr)
    if expr.op in ASKED:
        x.advise(early)
        x.advise(joins_conditions(expr))
    before = len(x.found)
    try:
        left, right = x.all(lambda: x.formula(expr.left, ctx), lambda: x.formula(expr.right, ctx))
    except Poison:
        _ended(expr, before, x)
        raise
    if expr.op not in ASKED and early is not None and changes(ctx.timeline, right):
        x.advise(early)
    return typed.Connective(known(expr.op, typed.CONNECTIVES), left, right, expr.span)


def _ended(expr: ast.Binary, before: int, x: Expressions) -> None:
    """Names that a quantifier on the left of a connective binds are unknown on its right: that it ends there is what is to be said of them."""
    ended = {
        name: node.quantifier
        for node in expr.left.walk()
        if isinstance(node, ast.Quantified)
        for name in node.names
    }
    for at, item in enumerate(x.found[before:], before):
        if (
            isinstance(item, UnknownName)
            and item.name in ended
            and item.span.start >= ast.span_of(expr.right).start
        ):
            quantifier = f"{ended[item.name]} {item.name}"
            hint = f"`{quantifier}` ends before `{expr.op}`: put all that it is about in parentheses, `{quantifier} in ...: (...)`"
            x.found[at] = UnknownName(item.span, item.what, item.name, hint)


def comparison(expr: ast.Binary, x: Expressions, ctx: Context) -> typed.Formula:
    """Two numbers, or a count and a number that no input changes."""
    op, span = known(expr.op, typed.COMPARISONS), expr.span
    left, right = _compared(expr, x, ctx)
    if isinstance(left, typed.Count) and not isinstance(right, typed.Count):
        return typed.CountComparison(op, left, _limit(right, left.span, x), False, span)
    if isinstance(right, typed.Count) and not isinstance(left, typed.Count):
        return typed.CountComparison(op, right, _limit(left, right.span, x), True, span)
    if isinstance(left, typed.Count) or isinstance(right, typed.Count):
        x.fail(WrongKind(right.span, "a number", spoken(right)))
    _compare(x, expr.op, left, right, span)
    return typed.Comparison(op, left, right, span)


def _compared(expr: ast.Binary, x: Expressions, ctx: Context) -> list[Any]:
    """Both sides: numbers, or counts. Two members, or two formulas, are one mistake."""
    asked: list[typed.MemberNode] = []

    def left_side() -> typed.Value:
        value = x.value(expr.left, ctx)
        if isinstance(value, typed.MemberNode) and isinstance(expr.right, ast.Name):
            asked.append(value)
            hint = members.hint(value, expr.right.name, expr.op)
            x.fail(WrongKind(ast.span_of(expr.left), "a number", spoken(value), hint))
        return value

    def right_side() -> typed.Value:
        if asked:
            raise Poison  # the word is one of its members, or meant to be
        return x.value(expr.right, ctx)

    def number(value: typed.Value, side: ast.Expr) -> typed.Number | typed.Count:
        return value if isinstance(value, typed.Count) else x.numeric(value, side)

    sides: list[typed.Value] = x.all(left_side, right_side)
    left, right = sides
    if isinstance(left, typed.FormulaNode) and isinstance(right, typed.FormulaNode):
        x.fail(WrongKind(ast.span_of(expr.left), "a number", "a formula", _of_formulas(expr)))
    if isinstance(left, typed.RecordNode) and isinstance(right, typed.RecordNode):
        x.fail(WrongKind(ast.span_of(expr.left), "a number", spoken(left), _of_records(expr, left, right)))
    return x.all(lambda: number(left, expr.left), lambda: number(right, expr.right))


def _limit(number: typed.Number, count: Span, x: Expressions) -> typed.Number:
    """What a count is compared with: a plain number made of literals and parameters."""
    if number.dimension != NUMBER:
        what = "what a count is compared with"
        hint = (
            "it counts samples or cycles; how long something lasts is asked by `historically[0 s, 3 s] (...)`"
        )
        hint = hint if number.dimension == TIME else ""
        x.fail(WrongDimension(number.span, None, what, "a plain number", quantity(number.dimension), hint))
    inputs = (
        typed.Field,
        typed.Folded,
        typed.Choice,
        typed.NumberCase,
        typed.TableValue,
        typed.OnLine,
        typed.StationGap,
        typed.Kept,
    )
    if any(isinstance(node, inputs) for node in typed.below(number)):
        problem = "a count is compared with a number that no input changes"
        x.fail(BadValue(number.span, problem, None, "use literals and parameters"))
    x.advise(x.advice.counted(number, count))
    return number


def within(expr: ast.Within, x: Expressions, ctx: Context) -> typed.Formula:
    """`a in [b, c]`."""
    lower, value, upper = x.all(
        lambda: x.number(expr.lower, ctx),
        lambda: x.number(expr.value, ctx),
        lambda: x.number(expr.upper, ctx),
    )
    x.all(
        lambda: _compare(x, "<=", lower, value, expr.span),
        lambda: _compare(x, "<=", value, upper, expr.span),
    )
    return typed.Within(value, lower, upper, expr.span)


def chained(expr: ast.Chained, x: Expressions, ctx: Context) -> typed.Formula:
    """`a <= b < c`."""
    numbers = x.each(lambda operand: x.number(operand, ctx), expr.operands)
    x.all(
        *(
            lambda op=op, left=left, right=right: _compare(x, op, left, right, left.span.to(right.span))
            for op, left, right in zip(expr.ops, numbers, numbers[1:])
        )
    )
    ops = tuple([known(op, typed.COMPARISONS) for op in expr.ops])
    return typed.Chained(tuple(numbers), ops, expr.span)


def _compare(x: Expressions, op: str, left: typed.Number, right: typed.Number, span: Span) -> None:
    """Check a comparison of two numbers."""
    same(x, "compare", left, right)
    x.advise(x.advice.compared(op, left, right, span))
    x.advise(turns_over(left, right, span))
    x.advise(laps_over(left, right, span))


def _of_formulas(expr: ast.Binary) -> str:
    """What to write for two formulas between which `==` stands, or another comparison."""
    left, right = (" ".join(ast.span_of(side).text.split()) for side in (expr.left, expr.right))
    if expr.op not in ("==", "!="):
        return "compare numbers, or join formulas with `and`, `or`, `implies`, `iff`, `xor`"
    if isinstance(expr.right, ast.Boolean):
        return f"write `{left}`" if expr.right.value == (expr.op == "==") else f"write `not ({left})`"
    return f"write `({left}) {'iff' if expr.op == '==' else 'xor'} ({right})`"


#: How elements of one set are told apart.
NUMBERED = "let the data number them, in a field of the unit 1"


def _of_records(expr: ast.Binary, left: typed.Record, right: typed.Record) -> str:
    """What to write for two elements, or an element and a state, between which `!=` stands.

    Not their places: two that are in one place are what rules about two of them look for.
    """
    ours, theirs = (ast.span_of(side).text for side in (expr.left, expr.right))
    if left.signal is not None and left.signal.many and left.signal == right.signal:
        return f"{NUMBERED}: `{ours}.number {'==' if expr.op == '==' else '<'} {theirs}.number`"
    return "compare a field that tells which it is: declare one, such as `own: bool`"
