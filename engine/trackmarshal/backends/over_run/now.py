"""The present cycle as rules over the run see it: when it is, which elements there are, and what the leaves come to."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import product
from typing import TYPE_CHECKING

from trackmarshal.backends.results import CaseValues
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.ir.overrun import sets, stamped
from trackmarshal.ir.reads import reads, reads_itself
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.kleene import UNDEFINED
from trackmarshal.runtime.verdict import Truth

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

#: Asked of every leaf in every cycle, for each element.
_reads = lru_cache(maxsize=4096)(reads_itself)
_sets = lru_cache(maxsize=4096)(sets)


@lru_cache(maxsize=4096)
def _signals(node: ir.Formula | ir.Machine) -> frozenset[str]:
    return frozenset(signal for signal, _ in reads(node))


@dataclass(slots=True)
class Now:
    """One cycle. t: its stamp [ns]; name: what it is called; ids: which elements of each set are there, by signal."""

    t: int
    name: object
    ids: Mapping[str, tuple[str, ...]]
    frame: Frame
    values: CaseValues
    #: The same cycle as another candidate's rules see it, and the signals that are not the same there; of the others, what is found out once holds for both.
    like: Now | None = None
    differs: frozenset[str] = frozenset()
    _known: dict[tuple[ir.Formula, tuple[str, ...]], Truth] = field(default_factory=dict)
    #: By what state machines keep: what a reference has found out of a cycle, it knows for all elements.
    _references: dict[tuple[tuple[ir.Kept, str], ...], Reference] = field(default_factory=dict)

    def combinations(self, axes: tuple[ir.Axis, ...]) -> list[tuple[str, ...]]:
        """What variables of some sets can stand for: one of nothing where there are none."""
        if len(axes) == 1:  # mostly
            return [(name,) for name in self.ids[axes[0].signal]]
        return list(product(*(self.ids[axis.signal] for axis in axes)))

    def leaf(self, node: ir.Formula, ids: tuple[str, ...]) -> Truth:
        """The value of a formula about this cycle alone, for elements of the sets that its variables are of."""
        key = node, ids
        known = self._known.get(key)
        if known is None:
            like = self.like
            known = like.leaf(node, ids) if like is not None and self.shares(node) else self._leaf(node, ids)
            self._known[key] = known
        return known

    def shares(self, node: ir.Formula | ir.Machine) -> bool:
        """Whether what something comes to after the same past is the same for `like`."""
        return self.like is not None and self.differs.isdisjoint(_signals(node))

    def measured(self, node: ir.Num, ids: tuple[str, ...]) -> float:
        """A number of this cycle, for elements of the sets that its variables are of; NaN where it has none."""
        if self.frame.unusable(_reads(node)) is not None:
            return math.nan
        return self.reference({}).number(node, self.env(node, ids))

    def recalled(self, node: ir.Formula, ids: tuple[str, ...], kept: Mapping[ir.Kept, float]) -> Truth:
        """The value of a formula about this cycle, and about numbers that state machines keep."""
        if self.frame.unusable(_reads(node)) is not None:
            return UNDEFINED
        return self.values.recalled(node, self.env(node, ids), kept)

    def reference(self, kept: Mapping[ir.Kept, float]) -> Reference:
        """The values of this cycle's nodes, given the numbers that state machines keep."""
        from trackmarshal.backends.reference.evaluator import Reference

        key = tuple((one, value.hex()) for one, value in kept.items())  # NaN is no key
        known = self._references.get(key)
        if known is None:
            known = self._references[key] = Reference(self.values.spec, self.frame, kept)
        return known

    def env(self, node: ir.Formula | ir.Num, ids: tuple[str, ...]) -> dict[int, int]:
        """What the variables of a node stand for, as places in this cycle."""
        axes = _sets(node)
        if len(axes) == 1:  # mostly
            (axis,) = axes
            return {axis.level: self.ids[axis.signal].index(ids[0])}
        return {axis.level: self.ids[axis.signal].index(name) for axis, name in zip(axes, ids)}

    def number(self, node: ir.Num) -> float:
        """A number that no input changes."""
        own, given = self.values.spec.params, self.frame.settings.params
        found = constant_value(node, lambda name: given.get(name, own[name].value))
        assert found is not None, "an input changes it"
        return found

    def _leaf(self, node: ir.Formula, ids: tuple[str, ...]) -> Truth:
        if self.frame.faults and self.frame.unusable(_reads(node)) is not None:
            return UNDEFINED
        return self.values.truth(node, self.env(node, ids) if ids else {})


def happening(frame: Frame, values: CaseValues, like: Now | None = None) -> Now:
    """A frame with a stamp, as it happens; like: what may be the same cycle."""
    assert frame.t is not None, "a cycle of a run has a stamp"
    ids = {name: columns.ids for name, columns in frame.columns.items()}
    differs = None if like is None else differing(frame, like.frame)
    if differs is None:
        return Now(stamped(frame.t), frame.number, ids, frame, values)
    return Now(stamped(frame.t), frame.number, ids, frame, values, like, differs)


def differing(frame: Frame, other: Frame) -> frozenset[str] | None:
    """The signals by which two frames differ, or that have faults; None where they may be frames of two cycles."""
    same = (
        frame.t == other.t and frame.number == other.number and frame.settings is other.settings and frame.lines is other.lines
        and frame.closed is other.closed and frame.lanes is other.lanes
        and frame.orders is other.orders and frame.straight == other.straight
    )  # fmt: skip
    if not same:
        return None
    columns, events = frame.columns, frame.events
    return frozenset(
        [name for name, one in columns.items() if other.columns.get(name) is not one]
        + [name for name in other.columns if name not in columns]
        + [name for name, code in events.items() if other.events.get(name) != code]
        + [name for name in other.events if name not in events]
        + [fault.signal for each in (frame, other) for fault in each.faults]
    )
