"""What a rulebook prefers, for people: who is violated by how much, who beats whom, and when one candidate is better than the other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

from trackmarshal.cli.output import dump, number, table
from trackmarshal.errors import TrackmarshalError
from trackmarshal.units import moment, written

if TYPE_CHECKING:
    from trackmarshal.rulebooks.choosing import Choice
    from trackmarshal.rulebooks.comparing import Comparison, Violations
    from trackmarshal.rulebooks.order import Order
    from trackmarshal.rulebooks.violation import Violation
    from trackmarshal.runtime.verdict import RuleResult
    from trackmarshal.scenarios.replay import Replay


def violations_table(
    choice: Choice, names: Sequence[str], rules: Sequence[Mapping[str, RuleResult]]
) -> list[str]:
    """A row a rule, a column a candidate; `rules` has the result of each rule that a violation is of."""
    order = choice.order
    rows = [
        [
            f"{rule} (advisory)" if rules[0][rule].advisory else rule,
            *(_shown(of[rule], results[rule]) for of, results in zip(choice.violations, rules)),
        ]
        for rule in order.rules
    ]
    title = f": {order.title}" if order.title else ""
    return [f"rulebook {order.name}{title}", *table(rows, ["violation of", *names])]


def _shown(violation: Violation, result: RuleResult) -> str:
    """A violation in the unit in which the limit is written."""
    from trackmarshal.rulebooks.violation import KEPT, UNDEFINED

    if violation.grade == KEPT:
        return "-"
    if violation.grade == UNDEFINED:
        return "undefined"
    if math.isinf(violation.size):
        return "violated"
    return f"by {written(violation.size, result.unit, result.shown)}"


def reasons(choice: Choice, names: Sequence[str]) -> list[str]:
    """Of each that is beaten, by whom; of the others, how the chosen one stands to them."""
    from trackmarshal.rulebooks.comparing import EQUAL, WORSE

    lines, best = [], names[choice.chosen]
    for place, name in enumerate(names):
        if place == choice.chosen:
            continue
        if place in choice.best:
            said = choice.comparison(choice.chosen, place)
            if said.outcome == EQUAL:
                lines.append(f"{best} and {name} are equal")
            else:
                sides = f"{', '.join(said.for_)} for {best}, {', '.join(said.against)} for {name}"
                lines.append(f"{best} and {name} are incomparable: {sides}")
            continue
        winner = next(one for one in choice.best if choice.comparison(place, one).outcome == WORSE)
        lines.append(
            f"{names[winner]} is better than {name}: {', '.join(choice.comparison(winner, place).for_)}"
        )
    return lines


def why(choice: Choice) -> str:
    """Why the chosen one is."""
    return (
        "no other one beats it"
        if choice.alone
        else f"the first given of {len(choice.best)} that no other one beats"
    )


def violations_json(violations: Violations) -> dict[str, Any]:
    return {rule: {"grade": each.grade, "size": number(each.size)} for rule, each in violations.items()}


def comparison_json(said: Comparison) -> dict[str, Any]:
    return {"outcome": said.outcome, "for": list(said.for_), "against": list(said.against)}


def choice_json(choice: Choice, names: Sequence[str]) -> dict[str, Any]:
    """All that a choice says, by the names of candidates."""
    compared = [
        {"first": names[one], "second": names[other], **comparison_json(choice.comparison(one, other))}
        for one, other in combinations(range(len(names)), 2)
    ]
    return {
        "rulebook": choice.order.name,
        "compared": compared,
        "best": [names[place] for place in choice.best],
        "chosen": names[choice.chosen],
        "alone": choice.alone,
    }


# Runs ----------------------------------------------------------------------------------------------------------


class Runs:
    """Recordings that were replayed, compared by a rulebook: both candidates of each cycle, then runs by their driving trajectories."""

    def __init__(self, format_: str) -> None:
        self._json = format_ == "jsonl"
        self._order: Order | None = None
        self._named: list[tuple[str, str]] = []
        self._violations: list[Violations] = []
        self._rules: list[Mapping[str, RuleResult]] = []
        #: Of each run why nothing is known of it; empty where something is.
        self._unknown: list[str] = []

    def add(self, order: Order, outcome: Replay) -> None:
        """Keep the worst cycle of each rule. A cycle without a driving trajectory is one of which nothing is known."""
        from trackmarshal.rulebooks.candidates import unreliable, violations
        from trackmarshal.rulebooks.violation import UNKNOWN
        from trackmarshal.scenarios.recording import CANDIDATES

        driving = CANDIDATES[0]
        there = [cycle.results[driving] for cycle in outcome.cycles if driving in cycle.results]
        if not there:
            raise TrackmarshalError(
                "E409",
                f"the recording {outcome.recording.name} has no {driving} trajectory",
                help="leave it out",
            )
        rated = [violations(order, result) for result in there]
        worst = {
            rule: max(range(len(there)), key=lambda place, rule=rule: rated[place][rule])  # type: ignore[misc]
            for rule in order.rules
        }
        without = [cycle.t for cycle in outcome.cycles if driving not in cycle.results]
        complete = not without
        doubtful = [cycle.t for cycle in outcome.cycles if complete and unreliable(cycle.results[driving])]
        self._unknown.append(
            f"there is no {driving} trajectory at {moment(without[0])} s" if without
            else f"what they say at {moment(doubtful[0])} s cannot be relied on" if doubtful else ""
        )  # fmt: skip
        self._order = order
        self._named.append((outcome.recording.name, outcome.recording.source))
        self._violations.append(
            {rule: rated[place][rule] if complete else UNKNOWN for rule, place in worst.items()}
        )
        self._rules.append({rule: there[place].rules[rule] for rule, place in worst.items()})

    def of_candidates(self, order: Order, outcome: Replay) -> list[str]:
        """What is said of the driving trajectory beside the emergency one, stretch by stretch."""
        found = stretches(order, outcome)
        if self._json:
            compared = [{"from": first, "to": last, **comparison_json(said)} for said, (first, last) in found]
            return [
                dump({"scenario": outcome.recording.name, "rulebook": order.name, "candidates": compared})
            ]
        rows = [
            [
                f"{moment(first)} to {moment(last)}" if first != last else moment(first),
                f"{said.outcome} than" if said.outcome in ("better", "worse") else said.outcome,
                ", ".join(said.for_),
                ", ".join(said.against),
            ]
            for said, (first, last) in found
        ]  # fmt: skip
        head = ["at s", "driving is", "for driving", "for emergency"]
        return [f"rulebook {order.name}, driving beside emergency", *table(rows, head)]

    def of_all(self) -> list[str]:
        """What is said of the runs beside each other; nothing of one alone."""
        from trackmarshal.rulebooks.choosing import choose

        if self._order is None or len(self._named) < 2:
            return []
        scenarios = [name for name, _ in self._named]  # runs of one scenario are told apart by their files
        names = [source if scenarios.count(name) > 1 else name for name, source in self._named]
        choice = choose(self._order, self._violations)
        if self._json:
            runs = [
                {"scenario": name, "violations": violations_json(violations)}
                for name, violations in zip(names, self._violations)
            ]
            return [dump({"runs": runs, **choice_json(choice, names)})]
        last = f"best by its driving trajectories: {names[choice.chosen]}, {why(choice)}"
        unknown = [
            f"{name}: all rules count as undefined, since {why}"
            for name, why in zip(names, self._unknown)
            if why
        ]
        return [*violations_table(choice, names, self._rules), *unknown, *reasons(choice, names), last]


def stretches(order: Order, outcome: Replay) -> list[tuple[Comparison, tuple[float, float]]]:
    """How the driving trajectory stands beside the emergency one, with the first and the last time of cycles in a row of which the same is said."""
    from trackmarshal.rulebooks.candidates import compare
    from trackmarshal.scenarios.recording import CANDIDATES

    found: list[tuple[Comparison, tuple[float, float]]] = []
    going = False
    for cycle in outcome.cycles:
        if len(cycle.results) < len(CANDIDATES):
            going = False
            continue
        said = compare(order, *(cycle.results[name] for name in CANDIDATES))
        if going and found[-1][0] == said:
            found[-1] = (said, (found[-1][1][0], cycle.t))
        else:
            found.append((said, (cycle.t, cycle.t)))
        going = True
    return found
