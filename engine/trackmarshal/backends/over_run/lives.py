"""Which elements of a set are known again after an absence: how many are remembered, and what is not known of those that were too many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import sets
from trackmarshal.ir.spec import RuleInfo

#: By signal its capacity, and the elements for which there is no place.
Without = Mapping[str, tuple[int, Sequence[str]]]
#: Cycles of which it is not known how many they were.
ANY_CYCLES = 1 << 60


class Seen(NamedTuple):
    """An element that is remembered: the stamp of the last cycle in which it was there [ns], and how many came, or were missed, since.

    sure: whether it is known that there was nothing before its life began.
    """

    t: int
    since: int
    sure: bool


@dataclass(frozen=True, slots=True)
class Arrivals:
    """A cycle's elements. over: those of whose earlier life nothing is remembered any more; without: those for which there is no place."""

    over: frozenset[str]
    without: frozenset[str]


@dataclass(frozen=True, slots=True)
class Lives:
    """What is known of one set. lost: the last stamp at which an element found no place, and the cycles since; None: there was none."""

    forget: int
    capacity: int
    seen: Mapping[str, Seen] = field(default_factory=dict)
    lost: tuple[int, int] | None = None

    def arrivals(self, t: int, ids: Sequence[str], missed: int) -> tuple[Lives, Arrivals]:
        """The lives after a cycle with the stamp t, before which so many were missed; and what happens in it.

        Places are given in the order of the input. One that begins may have been there already where another one, or itself, found
        no place in the cycle before, or as long ago as it may have been absent.
        """
        there = set(ids)
        kept = {name: one for name, one in self.seen.items() if self._lasts(one, name in there, t)}
        over = frozenset(self.seen.keys() - kept.keys())
        lost = self.lost
        sure = lost is None or (lost[1] > 0 and t - lost[0] > self.forget)
        without = set[str]()
        found = dict(kept)
        for name in ids:
            if name in kept:
                found[name] = Seen(t, 0, kept[name].sure)
            elif len(found) < self.capacity:
                found[name] = Seen(t, 0, sure)
            else:
                without.add(name)
        for name in kept.keys() - there:
            found[name] = kept[name]._replace(since=kept[name].since + 1 + missed)
        after = (t, 0) if without else None if lost is None or sure else (lost[0], lost[1] + 1)
        return Lives(self.forget, self.capacity, found, after), Arrivals(over, frozenset(without))

    def _lasts(self, one: Seen, there: bool, t: int) -> bool:
        """Whether a life goes on, or may: one that was there in the cycle before is not absent, however long ago that was."""
        if there:
            return one.since == 0 or t - one.t <= self.forget
        return t - one.t < self.forget


def no_place(rule: RuleInfo, without: Without) -> str:
    """Why a rule over the run says nothing where elements of which it remembers something found no place; empty where all of them did."""
    for signal, (capacity, names) in without.items():
        if names and signal in _remembered(rule):
            told = ", ".join(f"`{name}`" for name in names[:3]) + (", ..." if len(names) > 3 else "")
            return f"no place for {told} among the {capacity} elements of `{signal}` that are remembered"
    return ""


def _remembered(rule: RuleInfo) -> set[str]:
    """The sets of which a rule remembers something of each element, known again after an absence: it may read others, too."""
    below = (node for root in rule.roots for node in ir.below(root))
    past = (
        node
        for node in below
        if isinstance(node, ir.Machine) or (isinstance(node, ir.Remembered) and node.past)
    )
    return {axis.signal for node in past for axis in sets(node) if axis.forget}
