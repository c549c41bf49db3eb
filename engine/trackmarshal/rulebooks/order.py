"""The pre-order of a rulebook, ready for comparisons."""

from __future__ import annotations

from dataclasses import dataclass

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.ranking import above
from trackmarshal.ir.spec import RulebookInfo, Spec


@dataclass(frozen=True, slots=True)
class Order:
    """Rules in groups, each of which counts as one; most are a single rule.

    rules: all of them, in the order in which they are named first. groups: the rules of each, in that order. above: by group, those that strictly
    outrank it. Groups of equal rank do not outrank each other; each outranks what any of them does.
    """

    name: str
    title: str
    rules: tuple[str, ...]
    groups: tuple[tuple[str, ...], ...]
    above: tuple[frozenset[int], ...]


def rulebook(spec: Spec, name: str) -> Order:
    """The rulebook of a spec by its name. Raises TrackmarshalError E408 where there is none, or more than one."""
    found = [book for book in spec.rulebooks if book.name == name]
    if len(found) > 1:
        places = " and ".join(str(book.span) for book in found)
        raise TrackmarshalError(
            "E408", f"more than one rulebook is called `{name}`: {places}", help="rename one of them"
        )
    if not found:
        known = [book.name for book in spec.rulebooks]
        help_ = close_matches(str(name), known) or f"the spec has {', '.join(known) or 'none'}"
        raise TrackmarshalError("E408", f"the spec has no rulebook `{name!s:.40}`", help=help_)
    return order(found[0])


def order(book: RulebookInfo) -> Order:
    """The order of a compiled rulebook."""
    groups = _groups(book)
    ranks = above(book.rules, book.relations)
    number = {rule: place for place, group in enumerate(groups) for rule in group}
    outranked = tuple(frozenset(number[rule] for rule in ranks[group[0]]) for group in groups)
    for place, theirs in enumerate(outranked):
        if place in theirs:
            raise AssertionError(f"a rule of the rulebook {book.name} outranks itself")
    return Order(book.name, book.title, book.rules, groups, outranked)


def _groups(book: RulebookInfo) -> tuple[tuple[str, ...], ...]:
    """Rules that count as one: those that `&` joins, directly or over others."""
    joined = {rule: [rule] for rule in book.rules}
    for upper, relation, lower in book.relations:
        if relation == "&" and joined[upper] is not joined[lower]:
            joined[upper].extend(joined[lower])
            for rule in joined[lower]:
                joined[rule] = joined[upper]
    place = {rule: number for number, rule in enumerate(book.rules)}
    found = {id(group): tuple(sorted(group, key=place.__getitem__)) for group in joined.values()}
    return tuple(found.values())
