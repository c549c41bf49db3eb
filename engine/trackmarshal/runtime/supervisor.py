"""The Supervisor: door, judge, watchdog, state machine. docs/supervisor.md is its specification.

Every part says which step its answer is of. A cycle is safe only if all of them have answered for this very step: a part that did not
run, or that answers for another cycle, is `incomplete`.
"""

# implements S-1-B-4: a part that did not answer for this very step makes the cycle unsafe; so does a late verdict

from __future__ import annotations

import math
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from itertools import chain

from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.contract import Contract, of_cycles
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.decision import Decision, Violation
from trackmarshal.runtime.door.door import Admission, Door, stamp_of
from trackmarshal.runtime.driven import MOST_LOST, in_doubt
from trackmarshal.runtime.faults import Fault, fault
from trackmarshal.runtime.frame import NO_SETTINGS, Frame, Settings
from trackmarshal.runtime.machine import DRIVE, NO_SAFE_TRAJECTORY, PREVIOUS_EMERGENCY, Held, advance
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.program import KNOWN_CODES, NOTHING, Judged, Memory, Program, Rated, advisory
from trackmarshal.runtime.reasons import (
    Found,
    advisories,
    incomplete,
    internal,
    listed,
    named_rules,
    overlapping,
    shown,
    violations,
)
from trackmarshal.runtime.recorder import Recorder, gone, went_on
from trackmarshal.runtime.saving import (
    NOT_SAVED,
    Piece,
    Saving,
    checked,
    count,
    damaged,
    kept_by,
    meaning,
    opened,
    restored,
    save,
    spelt,
    unspelt,
    whole,
)
from trackmarshal.runtime.stored import held_of, held_pieces


@dataclass(slots=True)
class Opened:
    """A step that has begun: which one it is, what the door says, and the clock's readings as they came. recorded: whether it was handed to the recorder."""

    about: int
    cycle: object
    now: float
    readings: list[float]
    faults: list[Fault]
    admission: Admission | None = None
    recorded: bool = False


@dataclass(slots=True)
class _Closing:
    """What is known of a step when the state machine is asked: verdicts, and what went wrong after the door."""

    judged: Judged | None = None
    finished: float = math.nan
    late: list[Fault] = field(default_factory=list)
    violations: tuple[Violation, ...] = ()


@dataclass(frozen=True, slots=True)
class Timely:
    """The watchdog's answer for one step: the fault of a verdict that came late, or None."""

    about: int
    late: Fault | None


def watch(about: int, now: float, finished: float, limits: Limits) -> Timely:
    """Whether the verdict came in time; one that did at a time that nobody knows did not."""
    # implements S-1-B-2: what is decided late is driven by nobody
    if finished - now <= limits.budget:
        return Timely(about, None)
    message = f"{finished - now:g} s, the budget is {limits.budget:g} s"
    return Timely(about, fault("overrun", "cycle", "", None, message))


class OfOneRun(ABC):
    """What is in the middle of a run: nobody copies or pickles it, since two of them would share, or lack, a part of what it remembers."""

    def __reduce_ex__(self, protocol: object) -> str:
        raise TypeError(
            "a Supervisor is not copied: another one of the same rules and values goes on from where it is with `restore(it.save())`"
        )

    @abstractmethod
    def saving(self) -> Saving:
        """All that the next steps depend on, as it is now, to be saved piece by piece. Raises TrackmarshalError E486 for what cannot be saved."""

    def save(self) -> list[str]:
        """All that the next steps depend on, as lines of JSON (docs/supervisor.md). Raises TrackmarshalError E486 as `saving`."""
        return whole(self.saving())


class Supervisor(OfOneRun):
    """Decides in every cycle what is driven. One instance serves one run, from one thread.

    program judges by the rules of spec, with the values of settings; clock gives s on the clock that stamps are from; contract is that of its
    cycles (`of_cycles`), where it is known already. Raises TrackmarshalError E482 for a spec whose
    signals cannot be supervised.
    """

    def __init__(
        self,
        spec: Spec,
        program: Program,
        limits: Limits | None = None,
        clock: Callable[[], float] = time.monotonic,
        settings: Settings = NO_SETTINGS,
        contract: Contract | None = None,
    ) -> None:
        self.limits = Limits.of(spec) if limits is None else limits
        self.program = program
        self.held = Held()
        self.memory: Memory = program.start()
        #: The input contract of its cycles.
        self.contract = of_cycles(spec, program.rules) if contract is None else contract
        self.door = Door(self.contract, self.limits, settings)
        self._settings = settings
        #: Keeps the run, where there is one.
        self.recorder: Recorder | None = None
        #: Why the record is not complete; empty where it is.
        self.record_error = ""
        self._clock = clock
        #: Whether a step is being taken, and what is held while somebody looks: by the handler of a signal as well, which interrupts just that.
        self._taken, self._looked_at = False, threading.RLock()
        self._last = -math.inf
        self._steps = 0
        #: Number and step of the cycle that rules remember last, None before the first, and how many cycles since then were missing by
        #: their numbers alone.
        self._since: tuple[int, int, int] | None = None
        self._rules = named_rules(program.rules)
        self._advisory = advisory(program.rules)

    def step(self, cycle: Cycle | None) -> Decision:
        """What is driven; None says that a cycle was due and did not come. Never raises an Exception."""
        own = False
        try:
            # Nothing is called between what is noted here, and behind `finally`: a signal is seen where something is.
            with self._looked_at:
                if not self._taken:
                    self._taken = own = True
            if not own:
                return overlapping()
            steps, last = self._steps, self.door.last
            try:
                opened = self.open(cycle)
            except BaseException:
                # What was not read is no cycle: the next one is compared, and counted on, from the one before.
                self._steps, self.door.last = steps, last
                raise
            memory = self.memory
            try:
                return self.go_on(opened)
            except BaseException:
                # What was read counts as the last cycle, and rules that remember know nothing of it: a gap.
                if self.memory is memory:
                    self.memory = self._gap(_Closing())
                if self.recorder is not None and not opened.recorded:
                    self.record_error = gone(self.recorder) or self.record_error
                raise
        finally:
            if own:
                self._taken = False

    def go_on(self, opened: Opened) -> Decision:
        """The rest of a step, after its door. Never raises an Exception."""
        judged: Judged | None = None
        failed: list[Fault] = []
        if not opened.faults and opened.admission is not None:
            try:
                judged = self.program.judge(self.memory, opened.admission.frame)
            except Exception as error:
                failed.append(fault("judge_failed", "judge", "", None, shown(error)))
        return self.close_step(opened, judged, failed)

    def open(self, cycle: Cycle | None) -> Opened:
        """Begin a step: the clock, and the door. Never raises an Exception."""
        self._steps += 1
        opened = Opened(self._steps, cycle, math.nan, [math.nan, math.nan], [])
        opened.now = self._read(opened.readings, 0, opened.faults)
        try:
            if cycle is None:
                opened.faults.append(fault("missing_cycle", "cycle"))
            elif not isinstance(cycle, Cycle):
                opened.faults.append(fault("wrong_type", "cycle", "", None, "not a Cycle"))
            else:
                admission = self.door.admit(opened.about, cycle, opened.now)
                if type(admission) is Admission and admission.about == opened.about:
                    opened.admission = admission
                    opened.faults += admission.faults
                    if not opened.faults:
                        self._lost(admission)
                else:
                    opened.faults.append(incomplete("door"))
        except Exception as error:
            opened.faults.append(internal(error))
        return opened

    def _lost(self, admission: Admission) -> None:
        """Cycles that were lost on the way are missing, too: their numbers say so, and no step knew of them."""
        if self._since is not None and admission.number is not None:
            number, step, told = self._since
            lost = min(admission.number - number, MOST_LOST) - (self._steps - step) - told
            if lost > 0:
                self.memory = self.program.missed(self.memory, lost)
                self._since = number, step, told + lost

    def close_step(self, opened: Opened, judged: Judged | None, failed: list[Fault]) -> Decision:
        """End a step that was opened last, with what the program said of its frame, or why it said nothing."""
        closing = _Closing(late=failed)
        plans: tuple[Plan, Plan] | None = None
        admission = opened.admission
        try:
            if not opened.faults and admission is not None:
                self._rate(opened, admission, judged, closing)
                if closing.judged is None and not closing.late:
                    closing.late.append(incomplete("judge"))
                if not closing.late and not closing.violations and _safe(closing):
                    plans = _plans(admission)
        except Exception as error:
            plans = None
            closing.late.append(internal(error))
        held = self.held
        decision = self._decide(opened, closing, plans)
        try:
            self.memory = self._remembered(opened, decision)
        except Exception as error:
            # As if the cycle had never been safe: what it would have stored is not driven either.
            self.held, closing.late = held, [*closing.late, internal(error)]
            decision = self._decide(opened, closing, None)
            self.memory = self._gap(closing)
        if self.recorder is not None:
            opened.recorded = True
            try:
                frame = None if admission is None else admission.frame
                self.recorder.append(opened.cycle, frame, decision, (opened.readings[0], opened.readings[1]))
            except Exception as error:
                self.record_error = f"{type(error).__name__}: {error}"
        return decision

    def _remembered(self, opened: Opened, decision: Decision) -> Memory:
        """What rules remember of the step: the cycle as it was decided, or a gap where the door refused it, or it did not come."""
        accepted = not opened.faults and opened.admission is not None
        memory = (
            self.program.commit(self.memory, opened.admission.frame, decision)  # type: ignore[union-attr]
            if accepted
            else self.program.missed(self.memory)
        )
        if not isinstance(memory, Memory):
            raise TypeError("what rules remember was not kept")
        if accepted and decision.number is not None and not in_doubt(opened.admission.frame, decision):  # type: ignore[union-attr]
            self._since = decision.number, opened.about, 0
        return memory

    def _gap(self, closing: _Closing) -> Memory:
        """What they remember of a step in which remembering failed: that there is a gap. Where even that fails, no rule that remembers
        can be judged any more."""
        try:
            return self.program.missed(self.memory)
        except Exception as error:
            closing.late.append(internal(error))
            return NOTHING

    def saving(self) -> Saving:
        """All that the next steps depend on, as it is now, to be saved piece by piece. Raises TrackmarshalError E486 for rules whose memory
        cannot be saved."""
        door = self.door.last
        since = (None, None, None) if self._since is None else self._since
        own: Piece = ["supervisor", self._steps, spelt(self._last), door[0], _or_none(door[1]), *since]
        kept = save(self.program, self.memory)
        return Saving(*self._of, chain([own], held_pieces(self.held), kept))

    def restore(self, lines: Sequence[str], shown: str = "") -> None:
        """Go on from where another Supervisor was when it was saved. Raises TrackmarshalError D163 for what is damaged, D164 for what is of
        other rules, values or another evaluator; then it is as it was."""
        pieces = opened(lines, *self._of, shown)
        try:
            steps, last, number, stamp, *since = pieces.next("supervisor", 7)
            held = held_of(pieces)
            memory = restored(self.program, pieces)
            pieces.end()
            known = (
                count(steps),
                unspelt(last),
                None if number is None else checked(number, int),
                None if stamp is None else unspelt(stamp),
            )
            reckoned = (
                None if since == [None] * 3 else (checked(since[0], int), count(since[1]), count(since[2]))
            )
        except NOT_SAVED as error:
            raise damaged(str(error), shown) from error
        self._steps, self._last, self.door.last = known[0], known[1], known[2:]
        self.held, self.memory, self._since = held, memory, reckoned
        if self.recorder is not None:
            self.record_error = went_on(self.recorder, lines) or self.record_error

    @cached_property
    def _of(self) -> tuple[str, str]:
        """Who can restore it, and the hash of all that it rests on."""
        kind, words = kept_by(self.program)
        rules = [rule.name for rule in self.program.rules]
        limits = {name: spelt(value) for name, value in asdict(self.limits).items()}
        return kind, meaning(self.program.spec, rules, words, self._settings, ["supervisor", limits])

    def close(self) -> None:
        """End the record, where there is one."""
        if self.recorder is not None:
            self.recorder.close()

    def _read(self, readings: list[float], which: int, faults: list[Fault]) -> float:
        """The clock; NaN with a fault where it is wrong."""
        try:
            value = float(self._clock())
        except Exception:
            value = math.nan
        readings[which] = value
        if not (math.isfinite(value) and value >= self._last):
            faults.append(fault("bad_clock", "clock", "", None, f"{value!r} after {self._last!r}"))
            return math.nan
        self._last = value
        return value

    def _rate(self, opened: Opened, admission: Admission, judged: Judged | None, closing: _Closing) -> None:
        """Verdicts, if they are whole and of this frame, and whether they came in time."""
        if not closing.late:
            if self._whole(admission.frame, judged):
                closing.judged = judged
            else:
                closing.late.append(incomplete("judge", "not one known verdict a rule, of this cycle"))
        closing.finished = self._read(opened.readings, 1, closing.late)
        timely = watch(opened.about, opened.now, closing.finished, self.limits)
        if type(timely) is not Timely or timely.about != opened.about:
            closing.late.append(incomplete("watchdog"))
        elif timely.late is not None:
            closing.late.append(timely.late)
        if closing.judged is not None:
            safe = all(rated.safe for rated in closing.judged.rated.values())
            found = violations(opened.about, self._rules, closing.judged)
            if (
                type(found) is Found
                and found.about == opened.about
                and type(found.violations) is tuple
                and safe == (not found.violations)
            ):
                closing.violations = found.violations
            else:
                closing.late.append(incomplete("violations"))

    def _whole(self, frame: Frame, judged: Judged | None) -> bool:
        return (
            type(judged) is Judged
            and judged.about is frame
            and judged.rated.keys() == {DRIVING, EMERGENCY}
            and all(self._complete(rated) for rated in judged.rated.values())
        )

    def _complete(self, rated: Rated) -> bool:
        count = len(self._rules)
        return (
            type(rated) is Rated
            and rated.advisory == self._advisory
            and type(rated.verdicts) is bytes
            and len(rated.verdicts) == count == len(rated.margins) > 0
            and not rated.verdicts.translate(None, KNOWN_CODES)
        )

    def _decide(self, opened: Opened, closing: _Closing, plans: tuple[Plan, Plan] | None) -> Decision:
        """The state machine, and its outcome with all reasons. Should it fail, nothing is driven."""
        admission, now = opened.admission, opened.now
        try:
            pose = None if admission is None else admission.pose
            emergency = None if plans is None else plans[1]
            held, lost = advance(self.held, opened.about, emergency, now, pose, self.limits)
            if held.about != opened.about:
                raise RuntimeError("it did not run")
            self.held = held
        except Exception as error:
            closing.late.append(incomplete("machine", shown(error)))
            self.held, lost, plans = Held(NO_SAFE_TRAJECTORY, about=opened.about), "none_stored", None
        state = self.held.state
        driven = self.held.stored if state == PREVIOUS_EMERGENCY else None
        if state == DRIVE and plans is not None:
            driven = plans[0]
        number, t = called(opened)
        faults, found, more = listed(opened.faults, closing.violations, closing.late)
        return Decision(
            number, t, now, opened.readings[1], state, plans is not None, driven, self.held.stored, now + self.limits.longest_gap,
            lost, faults, found, more, closing.judged, advisories(self._rules, closing.judged),
        )  # fmt: skip


def called(opened: Opened) -> tuple[int | None, float]:
    """Number and stamp of a cycle as far as they are numbers."""
    if opened.admission is not None:
        number, t = opened.admission.number, opened.admission.t
        return number, math.nan if t is None else t
    try:
        stamp = stamp_of(opened.cycle)  # type: ignore[arg-type]
    except Exception:  # what was handed in has a say in how it is read
        return None, math.nan
    return stamp.number, math.nan if stamp.t is None else stamp.t


def _or_none(value: float | None) -> float | str | None:
    return None if value is None else spelt(value)


def _safe(closing: _Closing) -> bool:
    """Whether there are verdicts, all of them safe. (The list of violations says why not; it is not what is relied on.)"""
    judged = closing.judged
    return (
        judged is not None and closing.violations == () and all(rated.safe for rated in judged.rated.values())
    )


def _plans(admission: Admission) -> tuple[Plan, Plan]:
    """Both candidates of a cycle without a fault, for good."""
    assert admission.number is not None
    assert admission.t is not None
    driving, emergency = (
        Plan(name, admission.number, admission.t, admission.frame.candidates[name])
        for name in (DRIVING, EMERGENCY)
    )
    return driving, emergency
