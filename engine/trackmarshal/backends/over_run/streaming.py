"""Rules over the run in memory that does not grow: what looks back in cells, what looks ahead as far as it still can change."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import chain

from trackmarshal.backends.over_run.cells import Cells, Present, cells_of
from trackmarshal.backends.over_run.history import (
    Earlier,
    History,
    Past,
    parts_ahead,
    sets_of,
    values_of,
)
from trackmarshal.backends.over_run.lives import Without
from trackmarshal.backends.over_run.now import Now
from trackmarshal.backends.over_run.outcome import Outcome, Pending, at_once, is_ahead, outcome
from trackmarshal.backends.over_run.saving import (
    Cycles,
    LookedUp,
    Made,
    described,
    loaded_cells,
    loaded_cycles,
    saved_cells,
    saved_cycles,
)
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import back, leaves, looks_ahead
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.kleene import TRUE
from trackmarshal.runtime.saving import Piece, Pieces
from trackmarshal.runtime.verdict import About, Truth


@dataclass(slots=True)
class _Kept:
    """What is remembered. taken: whether a later state has taken it over."""

    cells: Cells
    #: The cycles that may still matter to what looks ahead, and how many came before them.
    cycles: list[Past]
    dropped: int
    missed: int
    pending: list[tuple[Pending, ...]]
    #: What operators without a bound, over what looks ahead, make of the cycles that are dropped.
    earlier: Earlier
    taken: bool = False


class Streaming:
    """An `Engine` that keeps what it needs. A state can be used once: whatever follows it takes its memory over."""

    shares = True

    def __init__(self, rules: Sequence[RuleInfo]) -> None:
        self._rules = rules
        by_rule = self._by_rule = [
            [formula for formula in (rule.formula, rule.active) if formula is not None] for rule in rules
        ]
        self._nodes = cells_of(formula for formulas in by_rule for formula in formulas)
        self._ahead = list(map(is_ahead, rules))
        #: Where no rule may, nothing is open after its own cycle, and no cycle is kept.
        self._looks_ahead = any(self._ahead)
        of_ahead = [formula for formulas, ahead in zip(by_rule, self._ahead) if ahead for formula in formulas]
        self._leaves = tuple(
            dict.fromkeys(leaf for formula in of_ahead for leaf in leaves(formula, parts_ahead))
        )
        asking = cells_of(of_ahead, looks_ahead)
        self._asking = [node for node in asking if not isinstance(node, ir.Machine)]
        #: Numbers that what looks ahead asks of cycles that are past.
        self._limits = tuple(dict.fromkeys(node.limit for node in asking if isinstance(node, ir.Counted)))
        self._unbounded: list[ir.OverRun] = [
            node
            for node in asking
            if isinstance(node, ir.OverRun) and node.past and node.op != "previous" and node.upper is None
        ]
        #: Whether anything looks back at what looks ahead.
        self._looks_back = any(isinstance(node, ir.Remembered) and node.past for node in asking)
        #: How far back from the oldest open cycle anything is looked at: nanoseconds, and cycles.
        reaches = [back(formula) for formula in of_ahead]
        self._back = (
            max((reach for reach, _ in reaches), default=0),
            max((steps for _, steps in reaches), default=0),
        )

        #: The two candidates that were judged last, each after what was remembered.
        self._judged: tuple[tuple[_Kept, Present], ...] = ()

    def start(self) -> _Kept:
        return _Kept(Cells(self._nodes), [], 0, 0, [() for _ in self._rules], {})

    def judge(self, state: _Kept, now: Now) -> list[Outcome]:
        present = self._at(self._fresh(state), now)
        self._judged = *self._judged[-1:], (state, present)
        if not self._looks_ahead:
            found = present.outcomes = self._all_at_once(present)
            return found
        return self._outcomes(state, [*state.cycles, self._past(state, now, present)], present)

    def without(self, state: _Kept, now: Now) -> Without:
        if not state.cells.lasting:
            return {}
        present = self._fresh(state).cells.at(now)
        return {name: (one.capacity, sorted(here.without)) for name, (one, here) in present.lives.items()}

    def commit(self, state: _Kept, now: Now) -> _Kept:
        present = self._present(self._fresh(state), now)
        if not self._looks_ahead:
            state.cells.remember(now, present)
            state.taken = True
            return _Kept(state.cells, [], state.dropped, 0, state.pending, state.earlier)
        known = {
            (leaf, ids): present.leaf(leaf, ids)
            for leaf in self._leaves
            for ids in now.combinations(sets_of(leaf))
        }
        cycles = [*state.cycles, self._to_keep(state, now, known)] if self._leaves else []
        history = History(cycles, False, parts_ahead, state.earlier)
        pending = [
            self._open(rule, state, each, Pending(len(cycles) - 1, now.name, False), history).pending
            if open_
            else ()
            for rule, open_, each in zip(self._rules, self._ahead, state.pending)
        ]
        state.cells.remember(now, present)
        state.taken = True
        old = self._too_old(cycles, state.dropped, pending, history)
        earlier = history.folded(self._unbounded, old)
        return _Kept(state.cells, cycles[old:], state.dropped + old, 0, pending, earlier)

    def _present(self, state: _Kept, now: Now) -> Present:
        """A cycle after what is remembered; one that was judged has its values already."""
        found = [present for kept, present in self._judged if kept is state and present.now is now]
        present = found[0] if found else self._at(state, now)
        self._judged = ()
        return present

    def _at(self, state: _Kept, now: Now) -> Present:
        """A cycle after what is remembered, with what was found out about one that is like it."""
        present = state.cells.at(now)
        like = [one for kept, one in self._judged if kept is state and one.now is now.like]
        present.like = like[0] if like else None
        return present

    def missed(self, state: _Kept, cycles: int) -> _Kept:
        self._fresh(state).taken = True
        state.cells.missed(cycles)
        missed = state.missed + cycles if state.cycles else 0
        return _Kept(state.cells, state.cycles, state.dropped, missed, state.pending, state.earlier)

    def end(self, state: _Kept) -> list[tuple[About, ...]]:
        values = values_of(History(self._fresh(state).cycles, True, parts_ahead, state.earlier))
        placed = [tuple(_placed(one, -state.dropped) for one in pending) for pending in state.pending]
        return [
            outcome(rule, pending[:-1], pending[-1], values).about if pending else ()
            for rule, pending in zip(self._rules, placed)
        ]

    def _outcomes(self, state: _Kept, cycles: list[Past], present: Present) -> list[Outcome]:
        history = History(cycles, False, parts_ahead, state.earlier)
        now = Pending(len(cycles) - 1, present.now.name, False)
        return [
            self._open(rule, state, pending, now, history) if open_ else self._at_once(rule, present)
            for rule, open_, pending in zip(self._rules, self._ahead, state.pending)
        ]

    def _all_at_once(self, present: Present) -> list[Outcome]:
        """What rules say that look back alone; of one that cannot tell two candidates apart, what it said of the other one."""
        like = present.like
        if like is None or not like.outcomes:
            return [self._at_once(rule, present) for rule in self._rules]
        shares = present.now.shares
        return [
            said if all(map(shares, formulas)) else self._at_once(rule, present)
            for rule, formulas, said in zip(self._rules, self._by_rule, like.outcomes)
        ]

    @staticmethod
    def _at_once(rule: RuleInfo, present: Present) -> Outcome:
        """What a rule says that looks back alone: it is settled in its own cycle."""
        assert rule.formula is not None
        active = TRUE if rule.active is None else present.leaf(rule.active, ())
        return at_once(present.now.name, present.leaf(rule.formula, ()), active)

    def _open(
        self, rule: RuleInfo, state: _Kept, pending: Sequence[Pending], now: Pending, history: History
    ) -> Outcome:
        """What a rule says in a cycle that looks ahead: of the cycles that are open, too."""
        placed = [_placed(one, -state.dropped) for one in pending]
        one = outcome(rule, placed, now, values_of(history))
        return Outcome(
            one.verdict, one.margin, one.about, tuple(_placed(p, state.dropped) for p in one.pending)
        )

    @cached_property
    def described(self) -> str:
        """In words, what a state is made of: equal words, equal meanings."""
        return described(self._nodes, self._made)

    def save(self, state: _Kept) -> Iterator[Piece]:
        """A state as pieces, which are made later of what is taken now. Raises TrackmarshalError E486 for a cycle's name that JSON does not have."""
        self._fresh(state)
        cycles = Cycles(state.cycles, state.dropped, state.missed, state.pending, state.earlier)
        return chain(saved_cells(state.cells, self._nodes), saved_cycles(cycles, self._made))

    def load(self, pieces: Pieces) -> _Kept:
        """The state that was saved; raises ValueError, KeyError, TypeError or IndexError for what is none."""
        cells = loaded_cells(pieces, self._nodes)
        cycles, dropped, missed, pending, earlier = loaded_cycles(pieces, self._made)
        return _Kept(cells, list(cycles), dropped, missed, list(pending), earlier)

    @property
    def _made(self) -> Made:
        return Made(self._leaves, self._limits, tuple(self._unbounded), len(self._rules))

    def _to_keep(
        self, state: _Kept, now: Now, known: dict[tuple[ir.Formula, tuple[str, ...]], Truth]
    ) -> Past:
        """A cycle as it is kept: with all that is asked of it later, and without the cycle itself."""
        numbers = {node: now.number(node) for node in self._limits}
        return Past(now.t, now.name, now.ids, LookedUp(known), numbers.__getitem__, state.missed)

    def _past(self, state: _Kept, now: Now, present: Present) -> Past:
        return Past(now.t, now.name, now.ids, present.leaf, now.number, state.missed)

    def _settled(self, history: History, place: int) -> bool:
        """Whether nothing can change any more of what rules come to about a cycle, whether they apply or not."""
        values = values_of(history)
        ahead = (rule for rule, open_ in zip(self._rules, self._ahead) if open_)
        return all(known.final for rule in ahead for known in values.of(rule, place)) and all(
            history.value(node, place, ids).final
            for node in self._asking
            for ids in history.combinations(node, place)
        )

    def _fresh(self, state: _Kept) -> _Kept:
        if state.taken:
            raise RuntimeError("the memory of an earlier cycle was taken over by a later one")
        return state

    def _settled_before(self, cycles: list[Past], dropped: int) -> int:
        """Before which cycle all was settled when cycles were dropped: as many are kept before it as are looked back at from it."""
        reach, steps = self._back
        if not dropped:
            return 0
        later = range(steps + 2, len(cycles))
        return next((place for place in later if cycles[place - 1].t - reach > cycles[0].t), len(cycles))

    def _too_old(
        self, cycles: list[Past], dropped: int, pending: list[tuple[Pending, ...]], history: History
    ) -> int:
        """How many cycles nothing that is open, or is to come, looks at any more."""
        reach, steps = self._back
        oldest = min((one.place - dropped for each in pending for one in each), default=len(cycles))
        if self._looks_back:
            # What operators say about a cycle of which rules say nothing more may still change, and is asked for about later cycles.
            places = range(self._settled_before(cycles, dropped), min(oldest, len(cycles)))
            oldest = next((place for place in places if not self._settled(history, place)), oldest)
        # What is asked about the cycle before the oldest one is kept of operators without a bound.
        first = max(0, oldest - 1)
        limit = cycles[min(first, len(cycles) - 1)].t - reach if cycles else 0
        while first > 0 and cycles[first - 1].t >= limit:
            first -= 1
        # One more, so that a gap before the first is seen, and as many as steps go back.
        return max(0, first - steps - 1)


def _placed(pending: Pending, by: int) -> Pending:
    return Pending(pending.place + by, pending.name, pending.decided)
