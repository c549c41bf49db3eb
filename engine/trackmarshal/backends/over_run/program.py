"""Programs whose rules remember: each cycle's leaves from an evaluator, what they come to over the run from an engine with a memory."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import chain, islice
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from trackmarshal.backends.over_run.lives import Without, no_place
from trackmarshal.backends.over_run.now import Now, differing, happening
from trackmarshal.backends.over_run.outcome import Outcome
from trackmarshal.backends.results import Outcomes, Stateless, identity
from trackmarshal.ir.margins import undecided
from trackmarshal.ir.overrun import leaves
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import FOLLOWED, IS_DRIVEN, IS_EMERGENCY, PLAN
from trackmarshal.runtime.course import Courses, Lived
from trackmarshal.runtime.cycle import DRIVING
from trackmarshal.runtime.driven import as_driven, drives_on, driving, in_doubt
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Judged, Memory, Rated, advisory
from trackmarshal.runtime.saving import Piece, Pieces
from trackmarshal.runtime.verdict import VERDICTS, About, RuleResult

if TYPE_CHECKING:
    from trackmarshal.runtime.decision import Decision
    from trackmarshal.runtime.plan import Plan


#: Verdicts' places in VERDICTS.
_CODES = {name: code for code, name in enumerate(VERDICTS)}
#: What depends on the candidate that is rated, or driven.
_OF_CANDIDATES = frozenset((PLAN, FOLLOWED, IS_EMERGENCY, IS_DRIVEN))


#: Cycles ahead for which it is guessed that they drive what is driven now: an emergency trajectory is driven for several, and to evaluate some at
#: once takes hardly longer than one.
_GUESSED = 7


class Engine(Protocol):
    """What rules over the run come to, cycle by cycle. A state is a value: a step gives another one, and leaves it as it is.

    shares: what is found out of a cycle for one candidate is taken for another one, of signals that are the same.
    """

    shares: bool

    def start(self) -> Any:
        """Before the first cycle."""

    def judge(self, state: Any, now: Now) -> Sequence[Outcome]:
        """What each rule says in a cycle."""

    def commit(self, state: Any, now: Now) -> Any:
        """After a cycle, with the leaves as they are of what was decided to be driven."""

    def missed(self, state: Any, cycles: int) -> Any:
        """After so many cycles that were refused, or did not come."""

    def end(self, state: Any) -> Sequence[tuple[About, ...]]:
        """What each rule says of the cycles that were left open, after the last one."""

    def without(self, state: Any, now: Now) -> Without:
        """The elements of a cycle for which there is no place in a state."""

    @property
    def described(self) -> str:
        """In words, what a state is made of. Raises TrackmarshalError E486 where states are not saved."""

    def save(self, state: Any) -> Iterator[Piece]:
        """A state as plain data, taken now; raises TrackmarshalError E486."""

    def load(self, pieces: Pieces) -> Any:
        """The state again; raises ValueError, KeyError, TypeError or IndexError for what was not saved by an engine so described."""


@dataclass(frozen=True, slots=True)
class Remembered(Memory):
    """What an engine remembers, and what courses hold."""

    state: Any
    courses: tuple[Lived, ...]


class _Seen(NamedTuple):
    """A frame as rules see it that rate a candidate, with what an evaluator of leaves says of it."""

    candidate: str
    frame: Frame
    outcomes: Outcomes


class _Guess(NamedTuple):
    """A frame to come as it is if a plan is driven at a stamp, with what an evaluator of leaves says of it."""

    frame: Frame
    plan: Plan
    t: float
    driven: Frame
    outcomes: Outcomes


class Remembering:
    """A program of rules some of which are over the run. Raises AssertionError for frames without a stamp."""

    def __init__(
        self, spec: Spec, rules: Sequence[RuleInfo], program: Callable[..., Stateless],
        engine: Callable[[Sequence[RuleInfo]], Engine],
    ) -> None:  # fmt: skip
        self.spec = spec
        self.rules: Sequence[RuleInfo] = [rule for rule in rules if rule.formula is not None]
        self._over = [rule for rule in self.rules if rule.over_run]
        self._advisory = advisory(self.rules)
        self._courses = Courses(self.rules)
        formulas = [
            formula for rule in self._over for formula in (rule.formula, rule.active) if formula is not None
        ]
        found = tuple(dict.fromkeys(leaf for formula in formulas for leaf in leaves(formula)))
        self.inner = program(spec, [rule for rule in self.rules if not rule.over_run], found)
        self._all_leaves = found
        self._of_leaves = partial(program, spec, [])
        self._engine = engine(self._over)
        #: Of each rule its place among those over the run, or among the others.
        self._places = _places(self.rules)
        #: Frames that were evaluated ahead, by their identity.
        self._ready: dict[int, tuple[Frame, list[_Seen]]] = {}
        #: What was guessed of frames that were evaluated ahead, by their identity.
        self._guessed: dict[int, _Guess] = {}
        #: The frame that was judged last, and the cycle as it is if its driving candidate is driven, or if it is a case.
        self._last: tuple[Frame, Now] | None = None

    @cached_property
    def identity(self) -> Mapping[str, Any]:
        return identity(self.spec, self.inner.identity["backend"], self.rules)

    def start(self) -> Memory:
        return Remembered(self._engine.start(), self._courses.start())

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        assert isinstance(memory, Remembered)
        known = self._ready.pop(id(frame), None)
        self._last = None
        if known is not None and known[0] is frame:
            seen = known[1]
        else:
            (seen,) = self._seen(
                [[(n, self._courses.joined(memory.courses, one)) for n, one in frame.seen()]]
            )
        rated = {}
        first: Now | None = None
        for name, one, outcomes in seen:
            now = happening(one, outcomes.values(), first if self._engine.shares else None)
            first = first or now
            rated[name] = self._rated(memory.state, now, outcomes)
            if name == DRIVING or not frame.candidates:
                self._last = frame, now
        return Judged(frame, rated)

    def ahead(self, frames: Sequence[Frame]) -> None:
        """Evaluate together what does not depend on what is remembered of other cycles; whoever judges one of these frames next, or remembers one that
        is a case, finds it there."""
        self._ready, self._guessed = {}, {}
        if not self._courses.infos:
            found = self._seen([frame.seen() for frame in frames])
            self._ready = {id(frame): (frame, seen) for frame, seen in zip(frames, found)}

    def _seen(self, each: Sequence[Sequence[tuple[str, Frame]]]) -> list[list[_Seen]]:
        """Of frames by candidate what the evaluator of leaves says of each."""
        outcomes = iter(self.inner.outcomes([one for seen in each for _, one in seen]))
        return [[_Seen(name, one, next(outcomes)) for name, one in seen] for seen in each]

    def judge_all(self, frames: Sequence[Frame]) -> list[Judged]:
        """Each frame as the first and only cycle of a run, at whatever time it has: windows hold this cycle alone."""
        stamped = (replace(frame, t=0.0) if frame.t is None else frame for frame in frames)
        return [self.judge(self.start(), frame) for frame in stamped]

    def commit(self, memory: Memory, frame: Frame, decision: Decision | None) -> Memory:
        assert isinstance(memory, Remembered)
        if in_doubt(frame, decision):
            return self.missed(memory)
        is_case = decision is None and not frame.candidates
        as_judged = is_case or drives_on(frame, decision)
        if as_judged and self._last is not None and self._last[0] is frame:
            now = self._last[1]  # what is driven was judged as it is
        elif is_case and (ready := self._ready.pop(id(frame), None)) is not None and ready[0] is frame:
            ((_, one, outcomes),) = ready[1]  # not judged, and evaluated all the same
            now = happening(one, outcomes.values())
        else:
            driven = self._courses.joined(memory.courses, as_driven(frame, decision))
            now = self._driven(frame, driven, decision)
        self._last = None
        return Remembered(
            self._engine.commit(memory.state, now), self._courses.commit(memory.courses, now.frame)
        )

    def _driven(self, frame: Frame, driven: Frame, decision: Decision | None) -> Now:
        """A frame as it was driven, instead of how it was judged: no rule has a verdict of that, and but for the plan it is the same."""
        if self._engine.shares and self._last is not None and self._last[0] is frame:
            like = self._last[1]
            differs = differing(driven, like.frame)
            if differs is not None and differs <= _OF_CANDIDATES:
                driven, outcome = self._changed(frame, driven, decision)
                return happening(driven, outcome.values(), like)
        (outcome,) = self._leaves.outcomes([driven])
        return happening(driven, outcome.values())

    def _changed(self, frame: Frame, driven: Frame, decision: Decision | None) -> tuple[Frame, Outcomes]:
        """The leaves that the plan changes, in a frame as it was driven; with those to come in which it may be driven on."""
        plan = None if decision is None else decision.driven
        guess = self._guessed.pop(id(frame), None)
        if guess is not None and guess.frame is frame and decision is not None:
            if guess.plan is plan and guess.t == decision.t:
                return guess.driven, guess.outcomes
        coming: list[tuple[Frame, Plan, float, Frame]] = []
        if plan is not None:
            for one, _ in islice(self._ready.values(), _GUESSED):
                if one.t is not None and not one.faults:
                    coming.append((one, plan, one.t, driving(one, plan, one.t)))
        own, *others = self._changing.outcomes([driven, *(one[3] for one in coming)])
        self._guessed = {id(one[0]): _Guess(*one, found) for one, found in zip(coming, others)}
        return driven, own

    @cached_property
    def _leaves(self) -> Stateless:
        """The leaves alone."""
        return self._of_leaves(self._all_leaves)

    @cached_property
    def _changing(self) -> Stateless:
        """The leaves that are not the same for all candidates."""
        return self._of_leaves(
            [leaf for leaf in self._all_leaves if any(signal in _OF_CANDIDATES for signal, _ in reads(leaf))]
        )

    def missed(self, memory: Memory, cycles: int = 1) -> Memory:
        assert isinstance(memory, Remembered)
        return Remembered(
            self._engine.missed(memory.state, cycles), self._courses.missed(memory.courses, cycles)
        )

    def end(self, memory: Memory) -> dict[str, tuple[About, ...]]:
        assert isinstance(memory, Remembered)
        return {rule.name: found for rule, found in zip(self._over, self._engine.end(memory.state)) if found}

    def kept(self) -> tuple[str, str]:
        """Who can restore what is remembered, and in words what that is made of. Raises TrackmarshalError E486 for an engine that saves none."""
        described = "\n\n".join(filter(None, (self._engine.described, self._courses.described)))
        return str(self.identity["backend"]), described

    def save(self, memory: Memory) -> Iterator[Piece]:
        """What is remembered, taken now, as pieces that are made later. Raises TrackmarshalError E486."""
        assert isinstance(memory, Remembered)
        return chain(self._engine.save(memory.state), self._courses.save(memory.courses))

    def restored(self, pieces: Pieces) -> Memory:
        """What was remembered; raises ValueError, KeyError, TypeError or IndexError for what was not saved by such a program."""
        return Remembered(self._engine.load(pieces), self._courses.load(pieces))

    def _rated(self, state: Any, now: Now, inner: Outcomes) -> Rated:
        plain, frame = inner.rated, now.frame
        found = self._engine.judge(state, now)
        if frame.faults:
            found = [
                _blocked(frame) if frame.unusable(rule.reads) is not None else outcome
                for rule, outcome in zip(self._over, found)
            ]
        without = self._engine.without(state, now)
        codes, known = plain.verdicts, plain.margins
        verdicts = bytes(
            [_CODES[found[place].verdict] if over else codes[place] for over, place in self._places]
        )
        margins = [found[place].margin if over else float(known[place]) for over, place in self._places]

        def explain(number: int, series: bool = False) -> RuleResult:
            over, place = self._places[number]
            return (
                explained(
                    self._over[place],
                    frame,
                    found[place].verdict,
                    found[place].margin,
                    found[place].about,
                    without,
                )
                if over
                else plain.explain(place, series)
            )

        return Rated(verdicts, margins, explain, self._advisory)


def _places(rules: Sequence[RuleInfo]) -> list[tuple[bool, int]]:
    counts = {True: 0, False: 0}
    places = []
    for rule in rules:
        places.append((rule.over_run, counts[rule.over_run]))
        counts[rule.over_run] += 1
    return places


def _blocked(frame: Frame) -> Outcome:
    return Outcome("undefined", math.nan, (About(frame.number, "undefined", math.nan, True),), ())


def explained(
    rule: RuleInfo,
    frame: Frame,
    verdict: str,
    margin: float,
    about: tuple[About, ...],
    without: Without = MappingProxyType({}),
) -> RuleResult:
    """The result of a rule over the run, given what it says of a frame, and about which cycles; `without`: the elements that found no place."""
    blocked = frame.unusable(rule.reads)
    if blocked is not None:
        verdict, margin, reason = "undefined", math.nan, str(blocked)
    else:
        reason = "nothing in its range" if verdict == "inactive" else ""
        if verdict == "undefined":
            reason = no_place(rule, without)
    return RuleResult(
        rule.name, verdict, margin, undecided(rule.unit), None, reason, None, "", about, rule.advisory
    )
