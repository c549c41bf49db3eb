"""Rules over the run with every cycle kept: the engine that others are held against."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from trackmarshal.backends.over_run.history import History, Past, sets_of, values_of
from trackmarshal.backends.over_run.lives import Without
from trackmarshal.backends.over_run.now import Now
from trackmarshal.backends.over_run.outcome import Outcome, Pending, is_ahead, outcome
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import leaves
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.saving import Piece, Pieces, unsaved
from trackmarshal.runtime.verdict import About, Truth


@dataclass(frozen=True, slots=True)
class Kept:
    """The cycles so far, how many were missed since the last one, and by rule the cycles about which it may still change."""

    cycles: tuple[Past, ...]
    missed: int
    pending: tuple[tuple[Pending, ...], ...]


class KeepingAll:
    """An `Engine` over histories."""

    shares = False

    def __init__(self, rules: Sequence[RuleInfo]) -> None:
        self._rules = rules
        #: Of all others, nothing is asked when a cycle is over.
        self._ahead = list(map(is_ahead, rules))
        formulas = [
            formula for rule in rules for formula in (rule.formula, rule.active) if formula is not None
        ]
        self._leaves = tuple(dict.fromkeys(leaf for formula in formulas for leaf in leaves(formula)))
        below = [part for formula in formulas for part in ir.below(formula)]
        self._lasting = dict.fromkeys(part for part in below if isinstance(part, ir.Axis) and part.forget)

    def start(self) -> Kept:
        return Kept((), 0, ((),) * len(self._rules))

    def judge(self, state: Kept, now: Now) -> list[Outcome]:
        history = History((*state.cycles, _past(state, now)))
        found = [self._outcome(rule, own, history, now) for rule, own in zip(self._rules, state.pending)]
        if any(one.pending and not ahead for one, ahead in zip(found, self._ahead)):
            raise AssertionError("a rule that does not look ahead waits for what is to come")
        return found

    def without(self, state: Kept, now: Now) -> Without:
        history = History((*state.cycles, _past(state, now)))
        return {axis.signal: (axis.capacity or 0, sorted(history.placeless(axis))) for axis in self._lasting}

    def commit(self, state: Kept, now: Now) -> Kept:
        known = self._all_of(now)
        this = Past(
            now.t, now.name, now.ids, lambda leaf, ids: known[leaf, ids], now.number, state.missed, now
        )
        cycles = (*state.cycles, this)
        history = History(cycles)
        pending = (
            self._outcome(rule, own, history, now).pending if ahead else ()
            for rule, own, ahead in zip(self._rules, state.pending, self._ahead)
        )
        return Kept(cycles, 0, tuple(pending))

    def missed(self, state: Kept, cycles: int) -> Kept:
        # What comes before the first cycle is no gap: nothing was remembered yet.
        return Kept(state.cycles, state.missed + cycles if state.cycles else 0, state.pending)

    def end(self, state: Kept) -> list[tuple[About, ...]]:
        history = History(state.cycles, ended=True)
        return [
            outcome(rule, pending[:-1], pending[-1], values_of(history)).about if pending else ()
            for rule, pending in zip(self._rules, state.pending)
        ]

    @property
    def described(self) -> str:
        raise _unsaved()

    def save(self, state: Kept) -> Iterator[Piece]:
        raise _unsaved()

    def load(self, pieces: Pieces) -> Kept:
        raise _unsaved()

    def _outcome(self, rule: RuleInfo, pending: Sequence[Pending], history: History, now: Now) -> Outcome:
        this = Pending(len(history.cycles) - 1, now.name, False)
        return outcome(rule, pending, this, values_of(history))

    def _all_of(self, now: Now) -> dict[tuple[ir.Formula, tuple[str, ...]], Truth]:
        """The values of all leaves for all elements that are there."""
        found: dict[tuple[ir.Formula, tuple[str, ...]], Truth] = {}
        for leaf in self._leaves:
            for ids in now.combinations(sets_of(leaf)):
                found[leaf, ids] = now.leaf(leaf, ids)
        return found


def _unsaved() -> TrackmarshalError:
    """It keeps whole cycles, more with each: what is saved in a step would have no bound."""
    return unsaved("the reference keeps every cycle of a run, and saves none of them")


def _past(state: Kept, now: Now) -> Past:
    return Past(now.t, now.name, now.ids, now.leaf, now.number, state.missed, now)
