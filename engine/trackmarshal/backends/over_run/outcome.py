"""What a rule over the run comes to in a cycle: about this cycle, and about earlier ones that are decided only now."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from trackmarshal.ir.overrun import looks_ahead
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.kleene import TRUE
from trackmarshal.runtime.verdict import About, Truth

#: Verdicts, the worst first: what a rule says in a cycle is the worst of what it says of this one and of those decided in it.
RANK = ("violated", "undefined", "open", "satisfied", "inactive")


class Known(NamedTuple):
    """The value of a formula about one cycle, and whether nothing that is still to come can change it."""

    value: Truth
    final: bool


ALWAYS = Known(TRUE, True)


@dataclass(frozen=True, slots=True)
class Pending:
    """A cycle about which a rule may still change what it says: its place in the run, its name, and whether its verdict is decided."""

    place: int
    name: object
    decided: bool


def is_ahead(rule: RuleInfo) -> bool:
    """Whether a rule may still change what it says of a cycle when that is past."""
    return any(looks_ahead(root) for root in (rule.formula, rule.active) if root is not None)


class Outcome(NamedTuple):
    """What a rule says in a cycle. about: this cycle, then earlier ones whose verdict was decided, or whose margin became final, in it."""

    verdict: str
    margin: float
    about: tuple[About, ...]
    pending: tuple[Pending, ...]


def about(name: object, formula: Known, active: Known) -> About:
    """What a rule says about one cycle, given the values of its formula and of where it applies."""
    final = formula.final and active.final
    if not active.value.best.sat:
        return About(name, "inactive", math.inf, active.final)
    verdict, margin = formula.value.verdict, formula.value.margin
    unsure = verdict == "satisfied" and not active.value.worst.sat  # it may turn out not to apply
    if (verdict == "undefined" or unsure) and not final:
        return About(name, "open", math.nan, False)
    return About(name, verdict, margin, final)


def at_once(name: object, formula: Truth, active: Truth) -> Outcome:
    """What a rule says in a cycle that is settled in its own cycle: nothing about earlier ones, and nothing stays open."""
    said = about(name, Known(formula, True), Known(active, True))
    return Outcome(said.verdict, said.margin, (said,), ())


class Values(NamedTuple):
    """What rules come to about any cycle of a run, by its place: the values of the formula, and of where it applies; and whether anything that is
    to come can still make it surely true."""

    of: Callable[[RuleInfo, int], tuple[Known, Known]]
    may_hold: Callable[[RuleInfo, int], bool]


def outcome(rule: RuleInfo, pending: Sequence[Pending], now: Pending, values: Values) -> Outcome:
    """What a rule says in the cycle `now`, given what is pending.

    What is open makes nothing unsafe. A cycle in which so much is undefined that nothing to come can make the rule hold is that at once: it is no
    better than undefined, whatever it turns out to be, and is said again when that is decided.
    """
    said: list[About] = []
    kept: list[Pending] = []
    counted: list[About] = []
    for cycle in (*pending, now):
        found = about(cycle.name, *values.of(rule, cycle.place))
        decided = found.verdict != "open"
        if cycle is now and not decided and not values.may_hold(rule, cycle.place):
            found = About(cycle.name, "undefined", math.nan, False)
        newly = decided and not cycle.decided
        if cycle is now or newly:
            counted.append(found)
        if cycle is now:
            said.insert(0, found)
        elif newly or found.final:
            said.append(found)
        if not found.final:
            kept.append(Pending(cycle.place, cycle.name, decided))
    worst = min(
        counted, key=lambda one: (RANK.index(one.verdict), one.margin if one.margin == one.margin else 0.0)
    )
    return Outcome(worst.verdict, worst.margin, tuple(said), tuple(kept))
