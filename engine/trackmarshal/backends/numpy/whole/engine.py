"""Rules over the run on pieces of it: each piece at once, with what its rules remember of those before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np

from trackmarshal.backends.numpy.logic import Value, negate
from trackmarshal.backends.numpy.whole import values
from trackmarshal.backends.numpy.whole.ahead import Looking
from trackmarshal.backends.numpy.whole.elements import Elements, Indices, Stamps, elements
from trackmarshal.backends.numpy.whole.outcomes import (
    OPEN,
    UNDEFINED,
    Codes,
    Said,
    Saying,
    at_once,
    following,
    worst,
)
from trackmarshal.backends.numpy.whole.past import Operator, operator
from trackmarshal.backends.numpy.whole.values import Bools, Floats, pairs
from trackmarshal.backends.over_run.history import looks_ahead, parts_ahead, parts_of, recalls_of, sets_of
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import leaves
from trackmarshal.ir.spec import RuleInfo


class Leaves(Protocol):
    """What formulas about one cycle alone come to in the cycles of a piece."""

    def value(self, node: ir.Formula) -> Value:
        """(cycles,) of a formula."""

    def number(self, node: ir.Num) -> Any:
        """A number that no input changes: one, or (cycles,)."""


class Outcome(NamedTuple):
    """What a rule says in the cycles of a piece: codes of verdicts and margins, (cycles,); said: about which cycles, worked out when it is asked for; None: each about itself."""

    codes: Codes
    margins: Floats
    said: Said

    def blocked(self, where: Bools, first: int) -> Outcome:
        """The same, but undefined in some cycles, which say so of themselves alone. first: the number of the first cycle."""
        codes, margins = self.codes.copy(), self.margins.copy()
        codes[where], margins[where] = UNDEFINED, np.nan
        said = self.said
        return Outcome(codes, margins, None if said is None else lambda: said().blocked(where, first))


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
        self._rules: list[_AtOnce | _Ahead] = []
        for rule in rules:
            assert rule.formula is not None
            self._rules.append(_Ahead(rule) if looks_ahead(rule.formula) else _AtOnce(rule))
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
        stamps, missed = stamps[own], missed[own].copy()
        missed[0] += self._missing
        piece = _Piece(elements(stamps, missed, self._last), given, own, self._operators, keep)
        names = np.arange(self.count, self.count + len(stamps))
        found = [rule.step(stamps, missed, names, piece.value, keep) for rule in self._rules]
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
        names: Indices,
        value: Callable[[ir.Formula], Value],
        keep: bool,
    ) -> Outcome:
        assert self._rule.formula is not None
        active = None if self._rule.active is None else value(self._rule.active)
        return Outcome(*at_once(value(self._rule.formula), active), None)

    def end(self, count: int) -> None:
        return None


class _Kept(NamedTuple):
    """The cycles about which a rule may still change what it says, and all after these: when, after how many that are missing, which they
    are, what is known of them, and which are open still."""

    stamps: Stamps
    missed: Indices
    names: Indices
    values: dict[ir.Formula, Value]
    pending: Bools


class _Ahead:
    """A rule that looks ahead."""

    def __init__(self, rule: RuleInfo) -> None:
        assert rule.formula is not None
        self._formula, self._active = rule.formula, rule.active
        settled = [*leaves(rule.formula, parts_ahead), *([] if rule.active is None else [rule.active])]
        self._settled = tuple(dict.fromkeys(settled))
        self._kept: _Kept | None = None

    def step(
        self,
        stamps: Stamps,
        missed: Indices,
        names: Indices,
        value: Callable[[ir.Formula], Value],
        keep: bool,
    ) -> Outcome:
        own = _Kept(
            stamps,
            missed,
            names,
            {node: value(node) for node in self._settled},
            np.ones(len(stamps), dtype=bool),
        )
        before = 0 if self._kept is None else len(self._kept.stamps)
        whole = own if self._kept is None else _joined(self._kept, own)
        looking, first, final = self._looked(whole, False)
        # What was decided before this piece is not said again, until it is final.
        about = np.flatnonzero(whole.pending & (first < np.inf) & (first >= before))
        now = first[about].astype(np.intp)
        codes, margins = self._said(whole, looking, about, now)
        here = now == about
        of_own = np.full(len(stamps), OPEN), np.full(len(stamps), np.nan)
        of_own[0][about[here] - before], of_own[1][about[here] - before] = codes[here], margins[here]
        later = ~here
        found = worst(of_own, now[later] - before, codes[later], margins[later])

        def said() -> Saying:
            closing = np.flatnonzero(whole.pending & (final < np.inf) & (final > first))
            late = final[closing].astype(np.intp)
            mine = np.arange(before, len(whole.stamps))
            with np.errstate(all="ignore"):
                closed = self._said(whole, looking, closing, late)
            parts = [
                (mine, mine, *of_own, final[before:] == mine),
                (now[later], about[later], codes[later], margins[later], final[about[later]] == now[later]),
                (late, closing, *closed, np.ones(len(late), dtype=bool)),
            ]
            return _ordered(whole.names, parts)

        if keep:
            self._keep(whole, whole.pending & (final == np.inf))
        return Outcome(*found, said)

    @property
    def oldest(self) -> int | None:
        """The number of the oldest cycle that is open."""
        return None if self._kept is None else int(self._kept.names[0])

    def end(self, count: int) -> Saying | None:
        if self._kept is None:
            return None
        looking, _, final = self._looked(self._kept, True)
        about = np.flatnonzero(self._kept.pending)
        codes, margins = self._said(self._kept, looking, about, final[about].astype(np.intp))
        turn = np.roll(np.arange(len(about)), 1)  # the last cycle is the one in which it is said
        cycle, true = np.full(len(about), count), np.ones(len(about), dtype=bool)
        return Saying(cycle, self._kept.names[about[turn]], codes[turn], margins[turn], true)

    def _looked(self, kept: _Kept, ended: bool) -> tuple[Looking, Floats, Floats]:
        """The cycles kept, and for each in which one it is decided, and in which one final: by their places."""
        own = elements(kept.stamps, kept.missed, None)
        looking = Looking(kept.stamps, own, kept.values.__getitem__, ended, parts_ahead)
        times, final = looking.times(self._formula), looking.final(self._formula)
        places = np.arange(len(kept.stamps), dtype=np.float64)
        true, false = np.maximum(-times.true, places), np.maximum(times.false, places)
        if self._active is None:
            return looking, np.minimum(np.minimum(true, false), final), final
        applies, may = (pair[0] for pair in pairs(kept.values[self._active]))
        # What holds, if it applies, is open until it is known whether it does; and what does not apply is that at once.
        first = np.minimum(np.minimum(np.where(applies, true, np.inf), false), final)
        return looking, np.where(may, first, places), np.where(may, final, places)

    def _said(self, kept: _Kept, looking: Looking, about: Indices, now: Indices) -> tuple[Codes, Floats]:
        value = looking.value(self._formula, about, now)
        return at_once(
            value, None if self._active is None else values.taken(kept.values[self._active], about)
        )

    def _keep(self, whole: _Kept, pending: Bools) -> None:
        """Forget all before the oldest cycle that is open."""
        if not pending.any():
            self._kept = None
            return
        old = int(np.argmax(pending))
        known = {
            node: values.applied(lambda array: array[old:].copy(), one) for node, one in whole.values.items()
        }
        self._kept = _Kept(
            whole.stamps[old:].copy(),
            whole.missed[old:].copy(),
            whole.names[old:].copy(),
            known,
            pending[old:].copy(),
        )


def _joined(a: _Kept, b: _Kept) -> _Kept:
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
