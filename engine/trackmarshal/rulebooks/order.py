"""The pre-order of a rulebook, ready for comparisons."""

from __future__ import annotations

from dataclasses import dataclass

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError, wrong_type
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
    #: By rule of `rules`, what its violations are divided by where it counts as one with rules of another scale; empty: by nothing.
    scales: tuple[float, ...] = ()

    def scale(self, rule: str, group: tuple[str, ...]) -> float:
        """What the violation of a rule is divided by beside those of its group: 1 where all have one scale, as nothing would change."""
        scales = {each: scale for each, scale in zip(self.rules, self.scales) if each in group}
        return scales[rule] if len(set(scales.values())) > 1 else 1.0


def rulebook(spec: Spec, name: str) -> Order:
    """The rulebook of a spec by its name. Raises TrackmarshalError E408 where there is none, or more than one."""
    if not isinstance(spec, Spec):
        raise wrong_type("a spec is what `load` and `loads` return", spec)
    if not isinstance(name, str):
        raise wrong_type("the name of a rulebook is a text", name)
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
    return order(found[0], spec)


def order(book: RulebookInfo, spec: Spec | None = None) -> Order:
    """The order of a compiled rulebook; spec: which declares scales of margins."""
    groups = _groups(book)
    ranks = above(book.rules, book.relations)
    number = {rule: place for place, group in enumerate(groups) for rule in group}
    outranked = tuple(frozenset(number[rule] for rule in ranks[group[0]]) for group in groups)
    for place, theirs in enumerate(outranked):
        if place in theirs:
            raise AssertionError(f"a rule of the rulebook {book.name} outranks itself")
    known = {} if spec is None or not spec.scales else {rule.name: spec.scale(rule) for rule in spec.rules}
    scales = tuple(known[rule] for rule in book.rules) if known else ()
    return Order(book.name, book.title, book.rules, groups, outranked, scales)


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
