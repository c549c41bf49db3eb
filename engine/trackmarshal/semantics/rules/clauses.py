"""What the clauses of a rule mean, one after the other: each sees what those before it bind."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING, Literal, assert_never, get_args

from trackmarshal import typed
from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir.nodes import JudgedAt
from trackmarshal.ir.operators import QUANTIFIERS, known
from trackmarshal.ir.spec import COURSE, SignalType
from trackmarshal.semantics.advice.formulas import met_by_others
from trackmarshal.semantics.declarations.courses import has_time
from trackmarshal.semantics.errors.rules import ClauseProblem, JudgedNowhere
from trackmarshal.semantics.expressions.context import Context, any_timeline
from trackmarshal.semantics.expressions.quantifiers import check_new, check_used, range_of, timeline
from trackmarshal.semantics.expressions.temporal import deadline
from trackmarshal.semantics.rules.placement import SCENE
from trackmarshal.semantics.values import Broken, Local, Poison, named, span_of
from trackmarshal.semantics.warnings.vacuity import NothingFound, UnusedVariable
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: The words for where a rule is judged.
_PLACES: tuple[JudgedAt, ...] = get_args(JudgedAt)
_KEYWORDS: tuple[Literal["require", "monitor"], ...] = ("require", "monitor")


def typed_rule(item: ast.Rule | ast.Assume, x: Expressions, ctx: Context) -> typed.Rule | None:
    """What the rule means; None where it has no condition, or an error. Errors of all clauses are reported."""
    made: list[typed.Clause] = []
    failed = False
    quantifier: typed.ForEach | None = None
    #: What one is looked for by that meets the demand.
    sought = within = ""
    #: Those that are looked for, and what a `let` says of them.
    about = set[str]()
    #: The variables of the last quantifier, and what a `let` says of them.
    latest = set[str]()
    # Of those that stand below the condition that is said; what they bind is known in it all the same.
    scene = [c for c in item.clauses if isinstance(c, SCENE)]
    clauses = [*scene, *(c for c in item.clauses if isinstance(c, ast.Require))]
    mentioned = [ast.names_in(clause) for clause in clauses]
    #: By name, how many clauses mention it.
    mentions = Counter(name for names in mentioned for name in names)
    for position, clause in enumerate(clauses):
        x.expansions = 0
        try:
            match clause:
                case ast.Along():
                    range_, names = _timeline(clause, x, ctx)
                    ctx = ctx.bind(names, 1, range_)
                    at = _judged_at(clause, range_.signal, x)
                    made.append(typed.Along(range_, at, clause.at is not None, clause.span))
                case ast.Bind():
                    over, names = range_of(clause, x, ctx)
                    failed |= over is None
                    ctx = ctx.bind(names, 1)
                    check_used(
                        x,
                        clause.names,
                        (clause.where, clause.by, *clauses[position + 1 :]),
                        clause.span.head,
                    )
                    x.advise(met_by_others("where", clause.where))
                    sought = clause.quantifier if clause.by is None else ""
                    about |= set(clause.names) if sought == "exists" else set()
                    latest = set(clause.names)
                    guard, by = _range_condition(clause, x, ctx)
                    if over is not None:
                        word = known(clause.quantifier, QUANTIFIERS)
                        quantifier = typed.ForEach(word, over, guard, by, clause.span)
                        made.append(quantifier)
                case ast.Except():
                    x.advise(met_by_others("except", clause.condition))
                    condition = x.formula(clause.condition, ctx)
                    if quantifier is not None:  # else it was reported with the clauses' places
                        _leaves_out(x, clause, quantifier, bool(latest & mentioned[position]))
                        made.append(typed.Except(quantifier, condition, clause.reason, clause.span))
                case ast.Whenever():
                    x.advise(met_by_others("whenever", clause.condition))
                    made.append(typed.Whenever(x.formula(clause.condition, ctx), clause.span))
                case ast.WithinTime():
                    within = "within"
                    made.append(deadline(clause.bound, clause.span, x, ctx))
                case ast.Let():
                    check_new(clause.name, clause.span, x, ctx)
                    about |= {clause.name} if about & mentioned[position] else set()
                    latest |= {clause.name} if latest & mentioned[position] else set()
                    if mentions[clause.name] == (clause.name in mentioned[position]):  # by no other clause
                        x.found.append(UnusedVariable(clause.span.head, clause.name))
                    value = x.value(clause.value, ctx)
                    ctx = ctx.bind({clause.name: named(clause.name, value, span_of(value))})
                    made.append(typed.Let(clause.name, value, clause.span))
                case ast.Require():
                    x.advise(met_by_others(within or sought, clause.condition, None if within else about))
                    keyword = known(clause.keyword, _KEYWORDS)
                    made.append(typed.Require(keyword, x.formula(clause.condition, ctx), clause.span))
                case _:
                    assert_never(clause)
        except (Poison, RecursionError) as error:
            failed = True
            if isinstance(error, RecursionError):
                x.too_deep(clause.__dict__["span"].head)
            # A broken name, so that the clauses below are still checked.
            if isinstance(clause, (ast.Let, ast.Along)):
                along = any_timeline(clause.span) if isinstance(clause, ast.Along) else None
                ctx = ctx.bind({clause.name: Broken()}, 0, along)
    if failed or not any(isinstance(clause, typed.Require) for clause in made):
        return None
    return typed.Rule(item.name, item.title, tuple(made), item.span)


def _leaves_out(x: Expressions, clause: ast.Except, quantifier: typed.ForEach, about_it: bool) -> None:
    """Warn of an exception that leaves out all or none of an `exists`."""
    if quantifier.quantifier == "exists" and not about_it:
        names = "`, `".join(quantifier.range.names)
        x.found.append(NothingFound(ast.span_of(clause.condition), names, quantifier.range.signal.name))


def _range_condition(
    clause: ast.Bind, x: Expressions, ctx: Context
) -> tuple[typed.Formula | None, typed.Number | None]:
    """What is in a quantifier's range, and of what the least of it is meant."""
    guard, by = x.all(
        lambda: x.formula(clause.where, ctx) if clause.where is not None else None,
        lambda: x.number(clause.by, ctx) if clause.by is not None else None,
    )
    return guard, by


def _timeline(clause: ast.Along, x: Expressions, ctx: Context) -> tuple[typed.Range, dict[str, Local]]:
    signal = x.value(clause.signal, ctx)
    if not isinstance(signal, typed.SignalNode) or not signal.signal.sequence or not has_time(signal.signal):
        hint = "a timeline is a trajectory or a series with a column `t: s increasing`"
        x.fail(ClauseProblem(clause.signal.span, f"`{clause.signal.name}` is no timeline", hint))
    return timeline(signal, clause.name, clause.span, x, ctx)


def _judged_at(clause: ast.Along, signal: SignalType, x: Expressions) -> JudgedAt:
    """At which sample of its timeline a rule is judged."""
    course = signal.kind == COURSE
    if clause.at is None:
        return "now" if course else "first"
    word = next((word for word in _PLACES if word == clause.at.name), None)
    if word is None:
        hint = close_matches(clause.at.name, _PLACES) or f"write {', '.join(_PLACES[:-1])} or {_PLACES[-1]}"
        x.fail(JudgedNowhere(clause.at.span, f"no rule is judged at `{clause.at.name}`", hint))
    if word == "now" and not course:
        hint = "judge it at the first sample, which needs no word, or declare a `course`"
        x.fail(JudgedNowhere(clause.at.span, f"no sample of `{signal.name}` is the one that is now", hint))
    if word == "first" and course:
        hint = "judge it at the sample that is now, which needs no word, or at the last one"
        x.fail(
            JudgedNowhere(clause.at.span, f"where `{signal.name}` begins is moving on with every cycle", hint)
        )
    return word
