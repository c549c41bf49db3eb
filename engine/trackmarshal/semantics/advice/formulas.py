"""Formulas that hardly say what is meant: where they end, what meets them, and what does not change along a timeline."""

from __future__ import annotations

from collections.abc import Collection
from typing import TypeGuard

from trackmarshal import typed
from trackmarshal.semantics.warnings.formulas import (
    EndsEarly,
    GoesOn,
    JoinsConditions,
    MetByOthers,
    SameEverywhere,
)
from trackmarshal.syntax import ast
from trackmarshal.syntax.notation import ASKED


def ends_early(expr: ast.Binary) -> EndsEarly | None:
    """What is to be said of a connective whose left side ends with a quantifier, or with `always`, that may have been meant to go on.

    Of a quantifier before `and` and `or` it makes no difference, or next to none, how far it goes, and the formatter shows where it ends.
    """
    last: ast.Expr | None = expr.left
    while last is not None and not ast.is_parenthesised(last):
        below = _ending(last)
        word = last.quantifier if isinstance(last, ast.Quantified) else "always" if _always(last) else ""
        if word and word != "always" and expr.op not in ASKED:
            return None
        if word and below is not None and not ast.is_parenthesised(below):
            return EndsEarly(last.__dict__["span"], word, expr.op)
        last = below
    return None


def _always(expr: ast.Expr) -> bool:
    return isinstance(expr, ast.Temporal) and expr.op == "always"


def _ending(expr: ast.Expr) -> ast.Expr | None:
    """What a formula ends with, where that is a formula that may go on."""
    match expr:
        case ast.Binary() | ast.Until():
            return expr.right
        case ast.Unary() | ast.Temporal():
            return expr.operand
        case ast.Quantified():
            return expr.body
        case _:
            return None


def joins_conditions(expr: ast.Binary) -> JoinsConditions | None:
    """What is to be said of `a implies b and c implies d`, which reads as two consequences, and demands nothing of `b`."""
    left, right = expr.left, expr.right
    if _leads_on(right):
        middle, op = right.left, right.op
    elif _leads_on(left):
        while _leads_on(left.right):
            left = left.right
        middle, op = left.right, left.op
    else:
        return None
    if isinstance(middle, ast.Binary) and middle.op in ("and", "or") and not ast.is_parenthesised(middle):
        return JoinsConditions(middle.__dict__["span"], middle.op, op)
    return None


def _leads_on(expr: ast.Expr) -> TypeGuard[ast.Binary]:
    return isinstance(expr, ast.Binary) and expr.op in ASKED and not ast.is_parenthesised(expr)


def goes_on(expr: ast.Temporal) -> GoesOn | None:
    """What is to be said of `previous (a) - b <= c`, which reads as the `a` of before beside the `b` of now, and is neither.

    Where nothing else comes from the input, both come to the same.
    """
    whole = expr.operand
    if ast.is_parenthesised(whole):
        return None
    first = whole
    while not ast.is_parenthesised(first):
        if isinstance(first, ast.Binary) and first.op not in typed.CONNECTIVES:
            first = first.left
        elif isinstance(first, ast.Chained):
            first = first.operands[0]
        else:
            return None
    read, inside = (sum(isinstance(node, ast.Attribute) for node in part.walk()) for part in (whole, first))
    return GoesOn(whole.__dict__["span"], expr.op, first.__dict__["span"].text) if read > inside else None


#: What comes of one for which, or of a cycle in which, the left side of an `implies` does not hold.
_MET = {
    "exists": "one for which that does not hold is enough", "where": "all for which that does not hold are in the range",
    "whenever": "the rule applies wherever that does not hold", "except": "all for which that does not hold are left out",
    "once": "a time at which that did not hold is enough", "eventually": "a time at which that does not hold is enough",
    "within": "a cycle in which that does not hold meets the demand", "until": "a time at which that does not hold ends the wait",
    "since": "a time at which that did not hold is enough", "count": "all in which that does not hold count",
    "reset": "the count starts anew wherever that does not hold",
}  # fmt: skip


def met_by_others(
    word: str, condition: ast.Expr | None, sought: Collection[str] | None = None
) -> MetByOthers | None:
    """What is to be said of an `implies` of which one that meets it is looked for, or those that do are picked.

    sought: the names of those that are looked for; where its left side is about none of them, no other one meets it.
    """
    if word not in _MET or not isinstance(condition, ast.Binary) or condition.op != "implies":
        return None
    if sought is not None and ast.names_in(condition.left).isdisjoint(sought):
        return None
    return MetByOthers(condition.__dict__["span"], word, _MET[word])


#: What ranges over a timeline.
_OVER_TIME = (typed.Temporal, typed.Until, typed.Step, typed.Edge, typed.CountComparison)


def changes(axis: typed.TimeAxis, formula: typed.Formula) -> bool:
    """Whether a formula without temporal operators may be another one at another sample of a timeline, or in another cycle."""
    parts = list(typed.below(formula))
    if any(isinstance(part, _OVER_TIME) for part in parts):
        return False
    if isinstance(axis, typed.Range):
        return any(_is_sample(part, axis) for part in parts)
    return not isinstance(formula, typed.Boolean)


def same_everywhere(
    word: str, axis: typed.TimeAxis, *operands: typed.Formula | None
) -> SameEverywhere | None:
    """What is to be said of a temporal operator along a timeline that is about something else, such as an event: that is of the cycle, and does not change."""
    if not isinstance(axis, typed.Range) or not axis.signal.name:  # the run, or a definition by itself
        return None
    for operand in operands:
        if operand is None or isinstance(operand, typed.Boolean):
            continue
        parts = typed.below(operand)
        if not any(_is_sample(part, axis) or isinstance(part, _OVER_TIME) for part in parts):
            return SameEverywhere(operand.span, word, axis.signal.name)
    return None


def _is_sample(part: typed.Typed, axis: typed.Range) -> bool:
    return isinstance(part, typed.Variable) and part.range is axis
