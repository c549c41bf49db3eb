"""What a rule over the run comes to in a cycle: about this cycle, and about earlier ones that are decided only now."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

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


def outcome(
    rule: RuleInfo, pending: Sequence[Pending], now: Pending, value: Callable[[RuleInfo, int], tuple[Known, Known]]
) -> Outcome:  # fmt: skip
    """What a rule says in the cycle `now`, given what is pending, and its values about any place of the run."""
    said: list[About] = []
    kept: list[Pending] = []
    counted: list[About] = []
    for cycle in (*pending, now):
        found = about(cycle.name, *value(rule, cycle.place))
        decided = found.verdict != "open"
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
