"""A rule that looks ahead, piece by piece of a run: which cycles are open, in which cycle each is decided, and in which nothing can change it any more."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from trackmarshal.backends.numpy.logic import Value
from trackmarshal.backends.numpy.whole import values
from trackmarshal.backends.numpy.whole.ahead import Looking, places_of
from trackmarshal.backends.numpy.whole.elements import Indices, Stamps, elements
from trackmarshal.backends.numpy.whole.firsts import NEVER
from trackmarshal.backends.numpy.whole.outcomes import (
    OPEN,
    OTHER,
    UNDEFINED,
    Codes,
    Outcome,
    Saying,
    at_once,
    together,
)
from trackmarshal.backends.numpy.whole.values import Bools, Floats, pairs
from trackmarshal.backends.over_run.history import parts_ahead
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import leaves
from trackmarshal.ir.spec import RuleInfo


class _Kept(NamedTuple):
    """The cycles about which a rule may still change what it says, and all after these: when, after how many that are missing, which they
    are, what is known of them, and which are open still. undecided: how many there are before the first one that has no verdict yet."""

    stamps: Stamps
    missed: Indices
    names: Indices
    values: dict[ir.Formula, Value]
    pending: Bools
    undecided: int = 0

    def part(self, begin: int, end: int | None = None) -> _Kept:
        """Some of them: nothing here is a copy."""
        own = slice(begin, end)
        known = {node: values.taken(one, own) for node, one in self.values.items()}
        return _Kept(self.stamps[own], self.missed[own], self.names[own], known, self.pending[own])

    def copy(self) -> _Kept:
        known = {node: values.applied(np.copy, one) for node, one in self.values.items()}
        return _Kept(
            self.stamps.copy(), self.missed.copy(), self.names.copy(), known, self.pending.copy(), self.undecided
        )  # fmt: skip


class _Own(NamedTuple):
    """The cycles of a piece as they are given: nothing here is a copy. first: the number of the first one."""

    stamps: Stamps
    missed: Indices
    first: int
    values: dict[ir.Formula, Value]

    @property
    def kept(self) -> _Kept:
        """These cycles, all of which are open."""
        count = len(self.stamps)
        names = np.arange(self.first, self.first + count)
        return _Kept(self.stamps, self.missed, names, self.values, np.ones(count, dtype=bool))


class _Looked(NamedTuple):
    """Cycles, and for each the place of the one in which it is decided, and of the one in which it is final."""

    kept: _Kept
    looking: Looking
    first: Indices
    final: Indices
    #: In which so much is undefined that nothing to come can make the rule hold; None: in none.
    hopeless: Bools | None

    def own(self, begin: int) -> Codes:
        """What the cycles from a place on say of themselves: that they are open, or undefined for good; OTHER of those that are decided at once."""
        codes = np.where(self.first[begin:] != self.looking.places[begin:], OPEN, OTHER)
        if self.hopeless is not None:
            codes[self.hopeless[begin:] & (codes == OPEN)] = UNDEFINED
        return codes


class _Decided(NamedTuple):
    """What is decided in a piece: about which cycles, in which one, and what; by places."""

    about: Indices
    now: Indices
    codes: Codes
    margins: Floats


class Ahead:
    """A rule that looks ahead."""

    def __init__(self, rule: RuleInfo) -> None:
        assert rule.formula is not None
        self._formula, self._active = rule.formula, rule.active
        settled = [*leaves(rule.formula, parts_ahead), *([] if rule.active is None else [rule.active])]
        self._settled = tuple(dict.fromkeys(settled))
        #: How long after a cycle its last window is closed, where one has an end.
        self._reach = max((node.upper for node in _ahead(rule.formula) if node.upper is not None), default=0)
        self._kept: _Kept | None = None

    def step(
        self, stamps: Stamps, missed: Indices, first: int, value: Callable[[ir.Formula], Value], keep: bool
    ) -> Outcome:
        """What the rule says in the next cycles, of which the first has this number. value: what formulas come to in them that are settled at once."""
        before, own = self._kept, _Own(stamps, missed, first, {node: value(node) for node in self._settled})
        # Of cycles that have their verdicts only the margins may still change, which are said when they are asked for.
        undecided = None if before is None else before.part(before.undecided)
        looked = self._looked(_joined(undecided, own.kept), False)
        begin = len(looked.first) - len(stamps)
        said = self._decided(looked, begin)
        found = together(looked.own(begin), said.now - begin, said.codes, said.margins)
        if keep:
            self._keep(before, looked)
        # Worked out again where it is asked for, which is seldom: kept until then it would be as much as all else of a run.
        return Outcome(*found, partial(self._saying, before, own))

    @property
    def oldest(self) -> int | None:
        """The number of the oldest cycle that is open."""
        return None if self._kept is None else int(self._kept.names[0])

    def end(self, count: int) -> Saying | None:
        """What the rule says of the cycles that are open after the last one. count: how many there were."""
        if self._kept is None:
            return None
        looked = self._looked(self._kept, True)
        about = np.flatnonzero(self._kept.pending)
        value = looked.looking.value(self._formula, about, looked.final[about])
        codes, margins = self._said(looked, about, value)
        turn = np.roll(np.arange(len(about)), 1)  # the last cycle is the one in which it is said
        cycle, true = np.full(len(about), count), np.ones(len(about), dtype=bool)
        return Saying(cycle, self._kept.names[about[turn]], codes[turn], margins[turn], true)

    def _saying(self, before: _Kept | None, own: _Own) -> Saying:
        """What is said in the cycles of a piece."""
        with np.errstate(all="ignore"):
            looked = self._looked(_joined(before, own.kept), False)
            begin, final = len(looked.first) - len(own.stamps), looked.final
            said = self._decided(looked, begin)
            closing = np.flatnonzero(looked.kept.pending & (final < NEVER) & (final > looked.first))
            value = looked.looking.value(self._formula, closing, final[closing])
            closed = self._said(looked, closing, value)
        themselves = looked.own(begin)
        waits = np.flatnonzero(themselves != OTHER)
        waiting, nothing = begin + waits, (themselves[waits], np.full(len(waits), np.nan))
        return _ordered(
            looked.kept.names,
            [
                (waiting, waiting, *nothing, np.zeros(len(waiting), dtype=bool)),
                (said.now, said.about, said.codes, said.margins, final[said.about] == said.now),
                (final[closing], closing, *closed, np.ones(len(closing), dtype=bool)),
            ],
        )

    def _looked(self, kept: _Kept, ended: bool) -> _Looked:
        own = elements(kept.stamps, kept.missed, None)
        looking = Looking(kept.stamps, own, kept.values.__getitem__, ended, parts_ahead)
        final, hopeless = looking.final(self._formula), looking.hopeless(self._formula)
        if self._active is None:
            return _Looked(kept, looking, looking.first(self._formula), final, hopeless)
        times = looking.times(self._formula)
        applies, may = (pair[0] for pair in pairs(kept.values[self._active]))
        # What holds, if it applies, is open until it is known whether it does; and what does not apply is that at once.
        first = np.minimum(np.minimum(np.where(applies, times.true, NEVER), times.false), final)
        places = looking.places
        return _Looked(kept, looking, np.where(may, first, places), np.where(may, final, places), hopeless)

    def _decided(self, looked: _Looked, begin: int) -> _Decided:
        """What is decided in a piece that begins at a place. What was decided before is not said again, until it is final."""
        first = looked.first
        chosen = places_of((first < NEVER) & (first >= begin) & looked.kept.pending)
        about, now = looked.looking.places[chosen], first[chosen]
        return _Decided(
            about, now, *self._said(looked, about, looked.looking.decided(self._formula, chosen, now))
        )

    def _said(self, looked: _Looked, about: Indices, value: Value) -> tuple[Codes, Floats]:
        """What a value of the formula about some cycles is to the rule."""
        active = self._active
        return at_once(value, None if active is None else values.taken(looked.kept.values[active], about))

    def _keep(self, before: _Kept | None, looked: _Looked) -> None:
        """Forget all before the oldest cycle that is open. before: what was kept; looked: what is undecided of that, and the next cycles."""
        stamps, closed = looked.kept.stamps, int(looked.kept.stamps[-1]) - self._reach
        # Windows close in order: only of these may any be open, of which the last cycle is one if it waits for the next.
        begin = min(int(np.searchsorted(stamps, closed, "right")), len(stamps) - 1)
        rest = looked.kept.part(begin)
        pending = rest.pending & (looked.final[begin:] == NEVER)
        undecided = _first_of(pending & (looked.first[begin:] == NEVER))
        rest = rest._replace(pending=pending)
        if before is not None:
            old = before.part(int(np.searchsorted(before.stamps, closed, "right")), before.undecided)
            if old.pending.any():
                old = old.part(_first_of(old.pending))
                self._kept = _joined(old, rest)._replace(undecided=len(old.stamps) + undecided)
                return
        first = _first_of(pending)
        rest = rest.part(first)._replace(undecided=undecided - first)
        self._kept = rest.copy() if len(rest.stamps) else None


def _ahead(formula: ir.Formula) -> Iterator[ir.OverRun]:
    """The operators of a formula that look ahead."""
    stack = [formula]
    while stack:
        node = stack.pop()
        stack += parts_ahead(node) or ()
        if isinstance(node, ir.OverRun) and not node.past:
            yield node


def _first_of(where: Bools) -> int:
    """The first place of some; as many as there are: none."""
    return int(np.argmax(where)) if where.any() else len(where)


def _joined(a: _Kept | None, b: _Kept) -> _Kept:
    if a is None or not len(a.stamps):
        return b
    known = {node: values.together([one, b.values[node]]) for node, one in a.values.items()}
    return _Kept(
        np.concatenate((a.stamps, b.stamps)), np.concatenate((a.missed, b.missed)), np.concatenate((a.names, b.names)),
        known, np.concatenate((a.pending, b.pending)),
    )  # fmt: skip


def _ordered(names: Indices, parts: list[tuple[Any, ...]]) -> Saying:
    """What is said in the cycles of a piece: of each about itself, then about earlier ones, in order."""
    cycle, about, codes, margins, final = (np.concatenate([part[i] for part in parts]) for i in range(5))
    order = np.lexsort((about, cycle != about, cycle))
    return Saying(names[cycle[order]], names[about[order]], codes[order], margins[order], final[order])
