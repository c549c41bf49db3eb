"""Made-up rulebooks and violations, and a plain reading of what is better, which shares nothing with the engine."""

from __future__ import annotations

import itertools
from typing import Any

from hypothesis import strategies as st

from trackmarshal.ir.spec import RulebookInfo
from trackmarshal.rulebooks.violation import Violation
from trackmarshal.source import NOWHERE

RULES = tuple("abcdef")
Relation = tuple[str, str, str]

#: Few sizes, so that candidates are often alike in a rule.
violations = st.sampled_from(
    [(0, 0.0), (1, 0.0), (1, 0.5), (1, 2.0), (1, float("inf")), (2, float("inf"))]
).map(lambda pair: Violation(*pair))
candidates = st.fixed_dictionaries(dict.fromkeys(RULES, violations))


@st.composite
def relations(draw: Any, rules: tuple[str, ...] = RULES) -> tuple[Relation, ...]:
    """Relations without a contradiction: `>` goes down between levels that are drawn, `~` and `&` stay on one."""
    level = {rule: draw(st.integers(0, 3)) for rule in rules}
    found: list[Relation] = []
    for one, other in itertools.combinations(rules, 2):
        if not draw(st.booleans()):
            continue
        if level[one] == level[other]:
            found.append((one, draw(st.sampled_from("~&")), other))
        elif level[one] < level[other]:
            found.append((one, ">", other))
        else:
            found.append((other, ">", one))
    return tuple(draw(st.permutations(found)))


def book(relations: tuple[Relation, ...], rules: tuple[str, ...] = RULES) -> RulebookInfo:
    return RulebookInfo("book", "", rules, relations, NOWHERE)


def outranks(relations: tuple[Relation, ...], upper: str, lower: str) -> bool:
    """Whether a way leads down from one to the other, and none back: tried step by step, as often as there are rules."""

    def leads(start: str, end: str) -> bool:
        reached = {start}
        for _ in RULES:
            for one, relation, other in relations:
                if one in reached:
                    reached.add(other)
                if relation != ">" and other in reached:
                    reached.add(one)
        return end in reached

    return leads(upper, lower) and not leads(lower, upper)


def together(relations: tuple[Relation, ...], rules: tuple[str, ...] = RULES) -> list[set[str]]:
    groups = [{rule} for rule in rules]
    for one, relation, other in relations:
        if relation == "&":
            joined = [group for group in groups if one in group or other in group]
            groups = [group for group in groups if group not in joined] + [set().union(*joined)]
    return groups


def plainly_better(
    relations: tuple[Relation, ...], mine: dict[str, Violation], theirs: dict[str, Violation], rules: tuple[str, ...] = RULES
) -> bool:  # fmt: skip
    """The definition, word for word. A group counts by the greatest violation of which the two have not equally many."""
    groups = together(relations, rules)

    def sign(group: set[str]) -> int:
        ours, others = [tuple(mine[r]) for r in group], [tuple(theirs[r]) for r in group]
        for value in sorted({*ours, *others}, reverse=True):
            if ours.count(value) != others.count(value):
                return 1 if ours.count(value) > others.count(value) else -1
        return 0

    signs = [sign(group) for group in groups]
    if not any(signs):
        return False
    return all(
        any(
            signs[other] < 0 and any(outranks(relations, up, low) for up in groups[other] for low in group)
            for other in range(len(groups))
        )
        for place, group in enumerate(groups)
        if signs[place] > 0
    )
