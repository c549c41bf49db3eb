"""Which of two candidates is better, and which rules say so."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from trackmarshal.rulebooks.order import Order
from trackmarshal.rulebooks.violation import Violation

BETTER, WORSE, EQUAL, INCOMPARABLE = "better", "worse", "equal", "incomparable"
#: Violations by rule.
Violations = Mapping[str, Violation]


@dataclass(frozen=True, slots=True)
class Comparison:
    """What a rulebook says of one candidate beside another one.

    outcome: the first one is `better`, `worse`, `equal`, or they are `incomparable`. for_, against: the rules that decided, of those in which they
    differ the ones that no other such rule outranks: where the first one is better, and where it is worse. Rules that count as one are told as `a & b`.
    """

    outcome: str
    for_: tuple[str, ...]
    against: tuple[str, ...]

    @property
    def turned(self) -> Comparison:
        """The same of the second one beside the first."""
        return Comparison(_TURNED[self.outcome], self.against, self.for_)


_TURNED = {BETTER: WORSE, WORSE: BETTER, EQUAL: EQUAL, INCOMPARABLE: INCOMPARABLE}


def compare(order: Order, first: Violations, second: Violations) -> Comparison:
    """Compare two candidates, each with a violation of every rule of the rulebook.

    One is better where every rule in which it is worse is outranked by one in which it is better, and they are not equal everywhere.
    """
    mine = [taken_together(order, first, group) for group in order.groups]
    theirs = [taken_together(order, second, group) for group in order.groups]
    better = frozenset(place for place in range(len(mine)) if mine[place] < theirs[place])
    worse = frozenset(place for place in range(len(mine)) if mine[place] > theirs[place])
    if not better and not worse:
        outcome = EQUAL
    elif _made_up(order, worse, better):
        outcome = BETTER
    elif _made_up(order, better, worse):
        outcome = WORSE
    else:
        outcome = INCOMPARABLE
    return Comparison(outcome, _decided(order, better, worse), _decided(order, worse, better))


def taken_together(order: Order, violations: Violations, group: tuple[str, ...]) -> tuple[Violation, ...]:
    """The violation of rules that count as one, by their scales: the worst of them, then the next worst, and so on."""
    scaled = (
        Violation(violations[rule].grade, violations[rule].size / order.scale(rule, group)) for rule in group
    )
    return tuple(sorted(scaled, reverse=True))


def _made_up(order: Order, losses: frozenset[int], gains: frozenset[int]) -> bool:
    """Whether each loss is outranked by a gain."""
    return all(order.above[loss] & gains for loss in losses)


def _decided(order: Order, places: frozenset[int], others: frozenset[int]) -> tuple[str, ...]:
    """Of the groups in which candidates differ, those of one side that no other one outranks."""
    return tuple(
        " & ".join(order.groups[place])
        for place in sorted(places)
        if order.above[place].isdisjoint(places | others)
    )
