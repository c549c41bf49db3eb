"""Which of many candidates no other one beats."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from trackmarshal.errors import TrackmarshalError
from trackmarshal.rulebooks.comparing import BETTER, WORSE, Comparison, Violations, compare
from trackmarshal.rulebooks.order import Order


@dataclass(frozen=True, slots=True)
class Choice:
    """What a rulebook chooses, by the places of candidates in the order in which they were given.

    best: those that no other one beats, in order, at least one. chosen: the first of them. violations: of each candidate. compared: by pair of places,
    the lower one first, what is said of the first beside the second.
    """

    order: Order
    violations: tuple[Violations, ...]
    compared: dict[tuple[int, int], Comparison]
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
        """What is said of one candidate beside another one; raises KeyError for places that are none, or the same."""
        if first < second:
            return self.compared[first, second]
        return self.compared[second, first].turned


def choose(order: Order, candidates: Sequence[Violations]) -> Choice:
    """All candidates that no other one beats. Raises TrackmarshalError E409 for no candidate."""
    if not candidates:
        raise TrackmarshalError("E409", "there is no candidate to choose", help="give at least one")
    places = range(len(candidates))
    compared = {
        (one, other): compare(order, candidates[one], candidates[other])
        for one in places
        for other in places[one + 1 :]
    }
    beaten = {
        other if comparison.outcome == BETTER else one
        for (one, other), comparison in compared.items()
        if comparison.outcome in (BETTER, WORSE)
    }
    best = tuple(place for place in places if place not in beaten)
    if not best:
        raise AssertionError("each of the candidates is beaten by another one")
    return Choice(order, tuple(candidates), compared, best)
