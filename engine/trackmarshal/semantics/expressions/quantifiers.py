"""Quantifiers, and numbers of many: what they range over, and what is said of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.operators import QUANTIFIERS, known
from trackmarshal.ir.spec import COURSE, SignalType
from trackmarshal.node import Node
from trackmarshal.semantics.advice.formulas import met_by_others
from trackmarshal.semantics.errors.declarations import CourseProblem
from trackmarshal.semantics.errors.expressions import BadValue, WrongKind
from trackmarshal.semantics.errors.names import Duplicate, UnknownReference
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.expressions.dimensions import same
from trackmarshal.semantics.values import Broken, Local, Poison, common, span_of, spoken
from trackmarshal.semantics.warnings.vacuity import UnusedVariable
from trackmarshal.source import Span
from trackmarshal.syntax import ast
from trackmarshal.units import NUMBER

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def quantified(expr: ast.Quantified, x: Expressions, ctx: Context) -> typed.Formula:
    """`for all o in objects where c: p`."""
    range_, variables = range_of(expr, x, ctx)
    inner = ctx.bind(variables, 1)
    check_used(x, expr.names, (expr.where, expr.by, expr.body), expr.span.head)
    x.advise(met_by_others("where", expr.where))
    if expr.by is None:  # of the nearest there is one
        x.advise(met_by_others(expr.quantifier, expr.body, expr.names))
    by, guard, body = x.all(
        lambda: x.number(expr.by, inner) if expr.by is not None else None,
        lambda: x.formula(expr.where, inner) if expr.where is not None else None,
        lambda: x.formula(expr.body, inner),
    )
    if range_ is None:
        raise Poison
    return typed.Quantified(known(expr.quantifier, QUANTIFIERS), range_, guard, by, body, expr.span)


def folded(expr: ast.Folded, x: Expressions, ctx: Context) -> typed.Number:
    """`sum(E for o in objects where c)`, `count(o in objects where c)`."""
    op = _folding(expr, x)
    range_, variables = range_of(expr, x, ctx)
    inner = ctx.bind(variables, 1)
    if expr.body is not None or expr.where is not None:
        check_used(x, expr.names, (expr.where, expr.body), expr.span.head)
    x.advise(met_by_others("where", expr.where))
    guard, body, otherwise = x.all(
        lambda: x.formula(expr.where, inner) if expr.where is not None else None,
        lambda: x.number(expr.body, inner) if expr.body is not None else None,
        lambda: x.number(expr.otherwise, ctx) if expr.otherwise is not None else None,
    )
    if range_ is None:
        raise Poison
    if op in ("min", "max") and otherwise is None and (guard is not None or not _never_empty(range_)):
        hint = f"say what it is then: `{op}(... for {expr.names[0]} in {range_.signal.name} ... else ...)`"
        x.fail(BadValue(expr.span, f"there may be nothing to take the {op} of", None, hint))
    if body is None:
        return typed.Folded(NUMBER, "", op, range_, guard, None, None, expr.span)
    if otherwise is not None:
        same(x, "choose between", body, otherwise)
    unit = body.written if otherwise is None else common(body, otherwise)
    return typed.Folded(body.dimension, unit, op, range_, guard, body, otherwise, expr.span)


#: How numbers of many are written.
_FORMS: dict[typed.Folding, str] = {
    "count": "count(o in objects where ...)", "sum": "sum(... for o in objects)",
    "min": "min(... for o in objects else ...)", "max": "max(... for o in objects else ...)",
}  # fmt: skip


def _folding(expr: ast.Folded, x: Expressions) -> typed.Folding:
    """What becomes one number of many; fails for what has another form."""
    at = expr.span.head.word(expr.function)
    if expr.function not in typed.FOLDINGS:
        asked = {"any": "exists", "some": "exists", "all": "for all", "every": "for all"}.get(expr.function)
        hint = close_matches(expr.function, typed.FOLDINGS) or f"write {', '.join(typed.FOLDINGS)}"
        hint = f"write `{asked} o in objects: (...)`" if asked else hint
        x.fail(UnknownReference(at, f"`{expr.function}` makes no number of many", hint))
    op = known(expr.function, typed.FOLDINGS)
    if (op == "count") != (expr.body is None):
        hint = f"write `{_FORMS[op]}`"
        x.fail(UnknownReference(at, f"`{op}` is written another way over many", hint))
    if op in ("count", "sum") and expr.otherwise is not None:
        problem = f"the {op} of nothing is 0, so it has no `else`"
        x.fail(UnknownReference(ast.span_of(expr.otherwise), problem, "remove the `else`"))
    return op


def _never_empty(range_: typed.Range) -> bool:
    """Whether there always is something in a range: a trajectory has two samples at least, a series one."""
    signal = range_.signal
    return signal.sequence and len(range_.names) <= (2 if signal.kind == "trajectory" else 1)


def range_of(
    bind: ast.Bind | ast.Quantified | ast.Folded, x: Expressions, ctx: Context
) -> tuple[typed.Range | None, dict[str, Local]]:
    """The range and the variables of a quantifier; where its range has an error, none and broken variables."""
    try:
        clause = isinstance(bind, ast.Bind)
        return axis(bind.domain, bind.names, bind.consecutive, bind.span.head, x, ctx, clause)
    except Poison:
        return None, dict.fromkeys(bind.names, Broken())


def axis(
    domain: ast.Expr, names: tuple[str, ...], consecutive: bool, span: Span, x: Expressions, ctx: Context, clause: bool = False
) -> tuple[typed.Range, dict[str, Local]]:  # fmt: skip
    """What a quantifier ranges over, and its variables; clause: that of a rule, where no other one of its depth has its names."""
    value = x.value(domain, ctx)
    if not isinstance(value, typed.SignalNode) or not (value.signal.sequence or value.signal.many):
        x.fail(WrongKind(ast.span_of(domain), "a timeline or a set", spoken(value)))
    signal = value.signal
    refuse_course(signal, ast.span_of(domain), "no quantifier ranges over", x)
    if len(names) > 1 and not consecutive:
        hint = "write a quantifier for each"
        if signal.sequence:
            hint = f"write `consecutive {', '.join(names)}`, or a quantifier for each"
        x.fail(UnknownReference(span, "several variables range together over consecutive samples only", hint))
    if consecutive and not signal.sequence:
        problem = f"the elements of `{signal.name}` have no order"
        x.fail(UnknownReference(span, problem, "remove `consecutive`"))
    if consecutive and len(names) < 2:
        hint = "add a variable, or remove `consecutive`"
        x.fail(UnknownReference(span, "`consecutive` binds two or more samples", hint))
    return _range(value, names, span, x, ctx, clause)


def timeline(
    value: typed.WholeSignal, name: str, span: Span, x: Expressions, ctx: Context
) -> tuple[typed.Range, dict[str, Local]]:
    """The timeline of a rule, and its variable."""
    return _range(value, (name,), span, x, ctx, True)


def _range(
    value: typed.WholeSignal, names: tuple[str, ...], span: Span, x: Expressions, ctx: Context, clause: bool
) -> tuple[typed.Range, dict[str, Local]]:
    signal = value.signal
    range_, shape = typed.Range(value, names, ctx.level, span), x.shape(signal)
    if clause:
        range_ = x.shared.range(range_)
    variables: dict[str, Local] = {}
    for offset, name in enumerate(names):
        if name in variables:
            x.fail(UnknownReference(span, f"`{name}` is bound twice", "give each its own name"))
        check_new(name, span, x, ctx)
        variables[name] = typed.Variable(shape, signal, name, range_, offset, span)
    return range_, variables


def check_new(name: str, span: Span, x: Expressions, ctx: Context) -> None:
    """Report a variable that would hide another one: it is not said which of the two is meant."""
    known = ctx.local.get(name)
    if known is not None and not isinstance(known, Broken):
        x.found.append(Duplicate(span.word(name), span_of(known).head, "variable", name))
    else:
        ctx.scope.check_bound(name, span.word(name), "variable")


def check_used(x: Expressions, names: tuple[str, ...], parts: tuple[Node | None, ...], span: Span) -> None:
    """Warn of a quantifier none of whose variables is mentioned below."""
    if all(ast.names_in(part).isdisjoint(names) for part in parts if part is not None):
        x.found.append(UnusedVariable(span, "`, `".join(names)))


def refuse_course(signal: SignalType, span: Span, what: str, x: Expressions) -> None:
    """Fail for what can be done with a timeline, and not with a course."""
    if signal.kind == COURSE:
        hint = f"write a rule `along {signal.name} as ...`: its operators range over it"
        x.fail(CourseProblem(span, f"{what} the course `{signal.name}`", hint))
