"""Which of many candidates no other one beats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.errors import TrackmarshalError
from trackmarshal.rulebooks.comparing import BETTER, WORSE, Comparison, Violations, compare
from trackmarshal.rulebooks.order import Order
from trackmarshal.rulebooks.violation import Violation


@dataclass(frozen=True, slots=True)
class Choice:
    """What a rulebook chooses, by the places of candidates in the order in which they were given.

    best: those that no other one beats, in order, at least one. chosen: the first of them. violations: of each candidate.
    """

    order: Order
    violations: tuple[Violations, ...]
    best: tuple[int, ...]

    @property
    def chosen(self) -> int:
        """The first that no other one beats."""
        return self.best[0]

    @property
    def alone(self) -> bool:
        """Whether there is only one that no other one beats; else the chosen one is the first given of several."""
        return len(self.best) == 1

    def comparison(self, first: int, second: int) -> Comparison:
        """What is said of one candidate beside another one, by their places; raises IndexError."""
        return compare(self.order, self.violations[first], self.violations[second])


def choose(order: Order, candidates: Sequence[Violations]) -> Choice:
    """All candidates that no other one beats. Raises TrackmarshalError E409 for no candidate."""
    if not candidates:
        raise TrackmarshalError("E409", "there is no candidate to choose", help="give at least one")
    keys = [tuple(candidate[rule] for rule in order.rules) for candidate in candidates]
    alike = dict(zip(keys, candidates))  # what is said of one is said of all that are alike
    unbeaten: dict[tuple[Violation, ...], Violations] = {}
    for key, candidate in alike.items():
        # Who beats one that is beaten beats all that this one would: to be held against those who are left is enough.
        outcomes = {other: compare(order, candidate, unbeaten[other]).outcome for other in unbeaten}
        if WORSE in outcomes.values():
            continue
        for other, outcome in outcomes.items():
            if outcome == BETTER:
                del unbeaten[other]
        unbeaten[key] = candidate
    best = tuple(place for place, key in enumerate(keys) if key in unbeaten)
    if not best:
        raise AssertionError("each of the candidates is beaten by another one")
    return Choice(order, tuple(candidates), best)
