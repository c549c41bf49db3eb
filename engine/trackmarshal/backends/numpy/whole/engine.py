"""Rules over the run on pieces of it: each piece at once, with what its rules remember of those before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

import numpy as np

from trackmarshal.backends.numpy.logic import Value, negate
from trackmarshal.backends.numpy.whole import values
from trackmarshal.backends.numpy.whole.elements import Elements, Indices, Stamps, elements
from trackmarshal.backends.numpy.whole.opening import Ahead
from trackmarshal.backends.numpy.whole.outcomes import Outcome, Saying, at_once, following
from trackmarshal.backends.numpy.whole.past import Operator, operator
from trackmarshal.backends.numpy.whole.values import Bools
from trackmarshal.backends.over_run.history import parts_of, recalls_of, sets_of
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import looks_ahead
from trackmarshal.ir.spec import RuleInfo


class Leaves(Protocol):
    """What formulas about one cycle alone come to in the cycles of a piece."""

    def value(self, node: ir.Formula) -> Value:
        """(cycles,) of a formula."""

    def number(self, node: ir.Num) -> Any:
        """A number that no input changes: one, or (cycles,)."""


def why_by_cycle(rule: RuleInfo) -> str:
    """Why a rule over the run goes cycle by cycle; "": it does not."""
    if rule.course is not None:
        return "it lives along a course"
    for formula in (rule.formula, rule.active):
        if formula is None:
            continue
        for node in _over_run(formula):
            if isinstance(node, ir.InState) or recalls_of(node):
                return "it asks a state machine"
            if sets_of(node) or isinstance(node, ir.Quantify):
                return "it has a history for each element of a set"
            if isinstance(node, (ir.OverRun, ir.Counted)) and any(map(looks_ahead, node.operands)):
                return "it looks ahead from other cycles than the present one"
    if rule.active is not None and looks_ahead(rule.active):
        return "where it applies depends on what is to come"
    return ""


def _over_run(formula: ir.Formula) -> list[ir.Formula]:
    """All that a formula is put together from, but for its leaves."""
    found: dict[ir.Formula, None] = {}
    stack = [formula]
    while stack:
        node = stack.pop()
        below = parts_of(node)
        if node not in found and below is not None:
            found[node] = None
            stack += below
    return list(found)


class Engine:
    """What some rules over the run, none of which goes cycle by cycle, say in pieces of it, in order."""

    def __init__(self, rules: Sequence[RuleInfo]) -> None:
        self._operators: dict[ir.Formula, Operator] = {}
        self._rules: list[_AtOnce | Ahead] = []
        for rule in rules:
            assert rule.formula is not None
            self._rules.append(Ahead(rule) if looks_ahead(rule.formula) else _AtOnce(rule))
            for formula in (rule.formula, rule.active):
                for node in () if formula is None else _over_run(formula):
                    if isinstance(node, (ir.OverRun, ir.Counted)) and not looks_ahead(node):
                        self._operators.setdefault(node, operator(node))
        #: The last stamp that is remembered, and how many cycles are missing since; how many there were in all.
        self._last: int | None = None
        self._missing = 0
        self.count = 0

    def step(self, stamps: Stamps, missed: Indices, doubt: Bools, given: Leaves) -> list[Outcome]:
        """What each rule says in the cycles of a piece. stamps: (cycles,) [ns], ascending; missed: (cycles,) how many cycles are missing before
        each; doubt: (cycles,) which of them are judged, and then as good as missing."""
        found = []
        with np.errstate(all="ignore"):  # differences of what is undefined
            for begin, end in _segments(doubt):
                found.append(self._segment(slice(begin, end), stamps, missed, given, not doubt[begin]))
        if len(found) == 1:
            return found[0]
        return [_following(parts) for parts in zip(*found)]

    def _segment(
        self, own: slice, stamps: Stamps, missed: Indices, given: Leaves, keep: bool
    ) -> list[Outcome]:
        """The same of cycles that are all remembered, or of one that is not."""
        stamps, missed = stamps[own], missed[own]
        if self._missing:
            missed = missed.copy()
            missed[0] += self._missing
        piece = _Piece(elements(stamps, missed, self._last), given, own, self._operators, keep)
        found = [rule.step(stamps, missed, self.count, piece.value, keep) for rule in self._rules]
        for node in self._operators:
            piece.value(node)
        self.count += len(stamps)
        if keep:
            self._last, self._missing = int(stamps[-1]), 0
        else:
            self._missing = int(missed[0]) + 1
        return found

    def missed(self, count: int) -> None:
        """Cycles that were refused, or did not come."""
        self._missing += count

    @property
    def oldest(self) -> int:
        """The number of the oldest cycle of which something may still be said."""
        return min((rule.oldest for rule in self._rules if rule.oldest is not None), default=self.count)

    def end(self) -> list[Saying | None]:
        """What each rule says of the cycles that were open, after the last one."""
        with np.errstate(all="ignore"):
            return [rule.end(self.count) for rule in self._rules]


def _segments(doubt: Bools) -> list[tuple[int, int]]:
    """The cycles of a piece: those in a row that are beyond doubt, and each that is not."""
    cuts = np.flatnonzero(doubt | np.concatenate(([True], doubt[:-1])))
    return list(zip(cuts.tolist(), [*cuts[1:].tolist(), len(doubt)]))


def _following(parts: Sequence[Outcome]) -> Outcome:
    """What a rule says in cycles that follow one another."""
    return Outcome(
        np.concatenate([part.codes for part in parts]),
        np.concatenate([part.margins for part in parts]),
        following([part.said for part in parts]),
    )


class _Piece:
    """Formulas that look back, in some cycles of a piece."""

    def __init__(
        self, elements: Elements, given: Leaves, own: slice, operators: dict[ir.Formula, Operator], keep: bool
    ) -> None:
        self._elements, self._given, self._own, self._operators, self._keep = (
            elements,
            given,
            own,
            operators,
            keep,
        )
        self._known: dict[ir.Formula, Value] = {}

    def value(self, node: ir.Formula) -> Value:
        """(cycles,): each is asked once, as operators remember what they are asked."""
        known = self._known.get(node)
        if known is None:
            known = self._known[node] = self._value(node)
        return known

    def _value(self, node: ir.Formula) -> Value:
        if parts_of(node) is None:
            return values.taken(self._given.value(node), self._own)
        match node:
            case ir.OverRun() | ir.Counted():
                operands = [self._elements.spread(self.value(operand)) for operand in node.operands]
                limit = self._limit(node.limit) if isinstance(node, ir.Counted) else None
                found = self._operators[node].step(self._elements, operands, limit, self._keep)
                return values.applied(self._elements.of_cycles, found)
            case ir.Not():
                return negate(self.value(node.operand))
            case ir.Connective():
                return values.connected(node.op, self.value(node.left), self.value(node.right))
            case ir.Guarded():
                return values.guarded(self.value(node.guard), self.value(node.body))
            case _:
                raise AssertionError(f"{type(node).__name__} goes cycle by cycle")

    def _limit(self, node: ir.Num) -> Any:
        """A number for each element; of gaps any."""
        number = np.asarray(self._given.number(node), dtype=np.float64)
        if number.ndim == 0:
            return number
        number = number[self._own]
        if self._elements.cycles is None:
            return number
        made = np.zeros(len(self._elements))
        made[self._elements.cycles] = number
        return made


class _AtOnce:
    """A rule that is decided in its own cycle."""

    oldest: int | None = None

    def __init__(self, rule: RuleInfo) -> None:
        self._rule = rule

    def step(
        self,
        stamps: Stamps,
        missed: Indices,
        first: int,
        value: Callable[[ir.Formula], Value],
        keep: bool,
    ) -> Outcome:
        assert self._rule.formula is not None
        active = None if self._rule.active is None else value(self._rule.active)
        return Outcome(*at_once(value(self._rule.formula), active), None)

    def end(self, count: int) -> None:
        return None
