"""Rulebooks of any shape: `better` is an order, refining keeps what is better, and a choice is never empty and never beaten."""

from __future__ import annotations

import itertools
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from support.rulebooks import RULES, Relation, book, candidates, plainly_better, relations, violations
from trackmarshal.rulebooks.choosing import choose
from trackmarshal.rulebooks.comparing import compare
from trackmarshal.rulebooks.order import order
from trackmarshal.rulebooks.violation import Violation, worst

Candidate = dict[str, Violation]


@st.composite
def refinements(draw: Any) -> tuple[tuple[Relation, ...], tuple[Relation, ...], tuple[str, ...]]:
    """A rulebook over some rules, and one that refines it: more relations of the same levels, and rules below all of it."""
    everything = draw(relations())
    size = draw(st.integers(1, len(RULES)))
    old, new = RULES[:size], RULES[size:]
    inside = tuple(step for step in everything if step[0] in old and step[2] in old)
    kept = draw(st.sets(st.sampled_from(inside))) if inside else set()
    base = tuple(step for step in inside if step in kept)
    among_new = tuple(step for step in everything if step[0] in new and step[2] in new)
    below = tuple((upper, ">", lower) for upper in old for lower in new)
    return base, (*inside, *below, *among_new), old


@given(relations(), candidates, candidates)
def test_the_outcome_is_that_of_the_definition(
    steps: tuple[Relation, ...], one: Candidate, other: Candidate
) -> None:
    said = compare(order(book(steps)), one, other)
    better, worse = plainly_better(steps, one, other), plainly_better(steps, other, one)
    assert not (better and worse)
    assert (said.outcome == "better") == better
    assert (said.outcome == "worse") == worse
    assert compare(order(book(steps)), other, one) == said.turned
    assert (said.outcome == "equal") == (not said.for_ and not said.against)
    assert (said.outcome == "incomparable") == bool(said.for_ and said.against)
    assert (said.outcome == "better") == bool(said.for_ and not said.against)


@given(relations(), st.lists(candidates, min_size=3, max_size=3))
def test_better_is_transitive(steps: tuple[Relation, ...], three: list[Candidate]) -> None:
    ranks = order(book(steps))
    for a, b, c in itertools.permutations(three):
        first, second = compare(ranks, a, b).outcome, compare(ranks, b, c).outcome
        if {first, second} <= {"better", "equal"}:
            expected = "equal" if first == second == "equal" else "better"
            assert compare(ranks, a, c).outcome == expected


@given(refinements(), candidates, candidates)
def test_refining_keeps_what_is_better(
    made: tuple[tuple[Relation, ...], tuple[Relation, ...], tuple[str, ...]], one: Candidate, other: Candidate
) -> None:
    base, finer, old = made
    if compare(order(book(base, old)), one, other).outcome == "better":
        assert compare(order(book(finer)), one, other).outcome == "better"


@given(relations(), st.integers(1, len(RULES)), candidates, candidates)
def test_extending_keeps_what_is_better_where_new_rules_are_alike(
    steps: tuple[Relation, ...], size: int, one: Candidate, other: Candidate
) -> None:
    old = RULES[:size]
    base = tuple(step for step in steps if step[0] in old and step[2] in old)
    alike = {**other, **{rule: one[rule] for rule in RULES[size:]}}
    if compare(order(book(base, old)), one, alike).outcome == "better":
        assert compare(order(book(steps)), one, alike).outcome == "better"


@given(relations(), st.lists(candidates, min_size=1, max_size=6))
def test_a_choice_is_never_empty_and_never_beaten(steps: tuple[Relation, ...], many: list[Candidate]) -> None:
    made = choose(order(book(steps)), many)
    assert made.chosen == made.best[0]
    assert list(made.best) == [
        place for place, mine in enumerate(many) if not any(plainly_better(steps, theirs, mine) for theirs in many)
    ]  # fmt: skip


@given(relations(), st.lists(candidates, min_size=1, max_size=6), st.randoms(use_true_random=False))
def test_the_order_of_candidates_breaks_ties_alone(
    steps: tuple[Relation, ...], many: list[Candidate], random: Any
) -> None:
    places = list(range(len(many)))
    random.shuffle(places)
    straight = choose(order(book(steps)), many)
    shuffled = choose(order(book(steps)), [many[place] for place in places])
    assert sorted(places[place] for place in shuffled.best) == list(straight.best)
    assert places[shuffled.chosen] in straight.best


@given(relations(), candidates, st.sampled_from(RULES), violations)
def test_more_violation_never_makes_better(
    steps: tuple[Relation, ...], one: Candidate, rule: str, other: Violation
) -> None:
    changed = {**one, rule: other}
    expected = "equal" if other == one[rule] else "better" if other < one[rule] else "worse"
    assert compare(order(book(steps)), changed, one).outcome == expected


@given(st.lists(violations, min_size=1), st.lists(violations, min_size=1))
def test_over_a_run_the_worst_counts(first: list[Violation], second: list[Violation]) -> None:
    whole = worst([*first, *second])
    assert whole == max(worst(first), worst(second))
    assert whole.grade == max(one.grade for one in (*first, *second))
    assert whole.size == max(one.size for one in (*first, *second))
