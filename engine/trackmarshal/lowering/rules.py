"""The clauses of a rule to one formula."""

from __future__ import annotations

from collections.abc import Mapping
from typing import assert_never

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.overrun import nanoseconds
from trackmarshal.ir.spec import Called
from trackmarshal.lowering.expressions import Lowering
from trackmarshal.node import Node


class Level(Node):
    """A clause that the condition stands under: its axis, and its guard, both where it has them; and what is left out of its range."""

    clause: typed.Along | typed.Whenever | typed.ForEach
    axis: ir.Axis | None
    guard: ir.Formula | None
    #: Of all for which the guard holds, the clause is about the one of which this is least.
    by: ir.Num | None = None
    excepted: tuple[tuple[typed.Except, ir.Formula], ...] = ()

    def range(self, lowering: Lowering) -> ir.Formula | None:
        """What holds of those that it is about, but for `by`; None: it is about all."""
        allowed = self.guard
        for _, condition in self.excepted:
            other = lowering.make(ir.Not, condition)
            allowed = other if allowed is None else lowering.make(ir.Connective, "and", allowed, other)
        return allowed


class Lowered(Node):
    """A rule's formula; `active` holds where the rule applies at all (None: always); `along` is its timeline.

    levels, demand: what the formula is made of, the timeline first, then as written.
    """

    formula: ir.Formula
    active: ir.Formula | None
    along: ir.Axis | None
    levels: tuple[Level, ...]
    demand: ir.Formula
    #: What the rule calls the values in it.
    names: tuple[Called, ...] = ()


def lower_rule(rule: typed.Rule, interner: Interner, scales: Mapping[str, float] | None = None) -> Lowered:
    """The core of a rule; scales: by SI unit, what its margins are divided by before they are compared."""
    lowering = Lowering(interner, scales)
    levels, body = clauses(rule, lowering)
    # The timeline is the outermost axis, whether `whenever`, which knows nothing of it, stands before it or after it.
    levels.sort(key=lambda level: not isinstance(level.clause, typed.Along))
    formula, active, along = _nested(levels, body, lowering)
    return Lowered(formula, active, along, tuple(levels), body, tuple(lowering.names.values()))


def levels_of(rule: typed.Rule) -> list[Level]:
    """The clauses that a rule's condition stands under, as written, each with its core: for whoever tells where the rule applies."""
    return clauses(rule, Lowering(Interner()))[0]


def clauses(rule: typed.Rule, lowering: Lowering) -> tuple[list[Level], ir.Formula]:
    """The same, and what is required below them; the core of any number in the rule can be asked of the lowering afterwards."""
    levels: list[Level] = []
    body: ir.Formula | None = None
    deadline: typed.Deadline | None = None
    for clause in rule.clauses:
        match clause:
            case typed.Let():
                lowering.bind(clause.value, None)
                lowering.named(clause.value, clause.name)
            case typed.Along():
                levels.append(Level(clause, lowering.things.axis(clause.range), None))
            case typed.Whenever():
                levels.append(Level(clause, None, lowering.formula(clause.condition)))
            case typed.ForEach():
                guard = None if clause.where is None else lowering.formula(clause.where)
                by = None if clause.by is None else lowering.number(clause.by)
                levels.append(Level(clause, lowering.things.axis(clause.range), guard, by))
            case typed.Except():
                place, level = next((i, one) for i, one in enumerate(levels) if one.clause is clause.of)
                excepted = (*level.excepted, (clause, lowering.formula(clause.condition)))
                levels[place] = Level(level.clause, level.axis, level.guard, level.by, excepted)
            case typed.Deadline():
                deadline = clause
            case typed.Require():
                body = lowering.formula(clause.condition)
                if deadline is not None:
                    window = (0, nanoseconds(deadline.seconds))
                    body = lowering.make(ir.OverRun, "eventually", (body,), *window, False, deadline.span)
            case _:
                assert_never(clause)
    assert body is not None
    return levels, body


def _nested(
    levels: list[Level], body: ir.Formula, lowering: Lowering
) -> tuple[ir.Formula, ir.Formula | None, ir.Axis | None]:
    """Formula, where it applies, and timeline."""
    make = lowering.make
    active: ir.Formula | None = None
    along: ir.Axis | None = None
    for level in reversed(levels):
        clause, axis, guard = level.clause, level.axis, level.range(lowering)
        match clause:
            case typed.ForEach():
                assert axis is not None
                names = clause.range.names
                if level.by is not None:  # what is excepted is not the nearest
                    guard = lowering.nearest(clause.range, guard, level.by, clause.span)
                body = make(ir.Quantify, clause.quantifier, axis, guard, body, names)
                # An empty `for all` demands nothing; an empty `exists` has not found what it demands, and an
                # element whose own demand is empty is found: whatever lies below an `exists`, it is never idle.
                if clause.quantifier == "for all":
                    inner = active or make(ir.Truth, True)
                    active = make(ir.Quantify, "exists", axis, guard, inner, names)
                else:
                    active = None
            case typed.Whenever():
                assert guard is not None
                body = make(ir.Guarded, guard, body)
                active = guard if active is None else make(ir.Connective, "and", guard, active)
            case typed.Along():
                assert axis is not None
                name = clause.range.names[0]
                body, along = make(ir.At, axis, name, body, clause.place), axis
                active = None if active is None else make(ir.At, axis, name, active, clause.place)
            case _:
                assert_never(clause)
    return body, active, along
