"""Rules that say nothing: conditions that never hold, demands that nothing can break or nothing can meet, and tables that have no value."""

from __future__ import annotations

import math
from collections.abc import Iterator

from trackmarshal import typed
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import short_name
from trackmarshal.lowering.rules import Lowered
from trackmarshal.semantics.advice.bounds import FAILS, HOLDS, Bounds, Facts, TooMuchError
from trackmarshal.semantics.warnings.vacuity import AlwaysHolds, NeverHolds, NoValue
from trackmarshal.source import Span
from trackmarshal.units import in_full


def vacuous(core: Lowered, rule: typed.Rule, bounds: Bounds) -> list[Diagnostic]:
    """The first clause of a rule because of which it says nothing, outermost first; of a rule that says something, where a table has nothing to say."""
    bounds.begin(core.formula)
    try:
        found = _vacuous(core, rule, bounds)
    except (TooMuchError, RecursionError):  # a warning that is not given harms nobody
        return []
    return list(_outside(core, rule, bounds)) if found is None else [found]


def _outside(core: Lowered, rule: typed.Rule, bounds: Bounds) -> Iterator[Diagnostic]:
    """Of tables that have no value outside of their knots, those that inputs may be outside of by their declared ranges."""
    for (name, place), (low, high) in bounds.read_at.items():
        table = bounds.tables.get(name)  # None where it has errors of its own
        if table is None:
            continue
        knots, unit, way = table.knots, table.units[0], table.way
        if place and table.across is not None:
            knots, unit, way = table.across.knots, table.across.unit, table.across.way
        if way.clamped or way.length:
            continue
        first, last = knots[0], math.inf if way.steps else knots[-1]
        beyond = low if -math.inf < low < first else high if last < high < math.inf else None
        if beyond is not None:
            side, end = ("below", first) if beyond < first else ("above", last)
            yield NoValue(
                _asking(core, rule, name), short_name(table), side, in_full(end, unit), in_full(beyond, unit)
            )


def _asking(core: Lowered, rule: typed.Rule, table: str) -> Span:
    """Where a rule reads a table: its demand, or else the first of its conditions that does."""
    places = [(rule.condition.span, core.demand)]
    for level in core.levels:
        if level.guard is not None:
            places.append((_where(level.clause), level.guard))
        places += [(excepted.condition.span, condition) for excepted, condition in level.excepted]
    return next(
        (
            span
            for span, formula in places
            if any(
                isinstance(node, ir.Lookup | ir.GridLookup) and node.table == table
                for node in ir.below(formula)
            )
        ),
        rule.condition.span,
    )


def never_taken(guard: ir.Formula, span: Span, bounds: Bounds) -> Diagnostic | None:
    """What is to be said of the guard of a transition that is never taken."""
    bounds.begin()
    try:
        if bounds.truths(guard, bounds.nothing) & HOLDS:
            return None
        part = bounds.impossible(guard, bounds.nothing)
    except (TooMuchError, RecursionError):
        return None
    # It is so whatever rule asks for the state, and no rule can allow it.
    return _never(
        span, "this guard", "the transition is never taken", part, otherwise="leave the transition out"
    )


def _vacuous(core: Lowered, rule: typed.Rule, bounds: Bounds) -> Diagnostic | None:
    facts: Facts | None = bounds.nothing
    sought = False
    for level in core.levels:
        assert facts is not None
        clause = level.clause
        if isinstance(clause, typed.ForEach):
            sought = sought or clause.quantifier == "exists"
        if level.guard is not None:
            bounds.note(level.guard, facts)
            met = bounds.assume(level.guard, True, facts)
            if met is None:
                return _never(
                    _where(clause), "this condition", _without(clause), bounds.impossible(level.guard, facts)
                )
            facts = met
        for excepted, condition in level.excepted:
            if not bounds.truths(condition, facts) & HOLDS:
                part = bounds.impossible(condition, facts)
                return _never(excepted.condition.span, "this exception", "nothing is left out", part)
            facts = bounds.assume(condition, False, facts)
            if facts is None:
                return AlwaysHolds(excepted.condition.span, "this exception", _without(clause))
    assert facts is not None
    if isinstance(rule.condition, typed.Boolean):  # as it says itself
        return None
    known = bounds.truths(core.demand, facts)
    if not known & HOLDS:
        part = bounds.impossible(core.demand, facts)
        return _never(rule.condition.span, "this demand", "nothing can meet it", part)
    if not known & FAILS and not sought:
        return AlwaysHolds(rule.condition.span, "this demand", "nothing can violate it")
    return None


def _never(span: Span, what: str, consequence: str, part: Span | None, **more: str) -> NeverHolds:
    """What never holds, and the part of it because of which: not where that is all of it."""
    return NeverHolds(
        span, what, consequence, None if part is None or part.text == span.text else part, **more
    )


def _where(clause: typed.Along | typed.Whenever | typed.ForEach) -> Span:
    """Where the condition of a clause stands."""
    if isinstance(clause, typed.Whenever):
        return clause.condition.span
    if isinstance(clause, typed.ForEach) and clause.where is not None:
        return clause.where.span
    return clause.span


def _without(clause: typed.Along | typed.Whenever | typed.ForEach) -> str:
    """What follows where a clause leaves nothing."""
    if isinstance(clause, typed.ForEach) and clause.quantifier == "exists":
        return "nothing is ever found"
    return "the rule never applies" if isinstance(clause, typed.Whenever) else "the range is always empty"
