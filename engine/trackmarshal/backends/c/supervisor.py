"""The Supervisor in C behind Python's surface: what callers hand in becomes a frame, one call decides, and a Decision comes out."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict
from functools import cached_property
from typing import Any

from trackmarshal.backends.c.calling.quick import Quick, Slowly
from trackmarshal.backends.c.gather import Gathered, fastest
from trackmarshal.backends.c.over_run.explaining import Explaining
from trackmarshal.backends.c.rated import BothRated
from trackmarshal.backends.c.said import Reason, Said, Stepping
from trackmarshal.backends.c.saving import loaded, pieces, words
from trackmarshal.backends.c.source import Source, generated
from trackmarshal.backends.c.step import Stepper
from trackmarshal.backends.c.words import Wording
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.decision import Decision, Violation
from trackmarshal.runtime.door.door import Stamp, stamp_of
from trackmarshal.runtime.door.reading import CycleReader
from trackmarshal.runtime.faults import NAMES, Fault, fault
from trackmarshal.runtime.frame import NO_SETTINGS, Columns, Frame, Settings
from trackmarshal.runtime.machine import NO_SAFE_TRAJECTORY, STATES
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.program import Judged, advisory
from trackmarshal.runtime.reasons import advisories, incomplete, internal, named_rules, overlapping
from trackmarshal.runtime.recorder import Recorder, gone, went_on
from trackmarshal.runtime.saving import NOT_SAVED, Saving, damaged, meaning, opened, spelt, unsaved
from trackmarshal.runtime.supervisor import OfOneRun
from trackmarshal.runtime.verdict import VERDICTS

#: Nothing stands in C's `driven`, the driving trajectory, the stored one.
_NOTHING, _THIS, _STORED = range(3)


class CSupervisor(OfOneRun):
    """Decides in every cycle what is driven, as `runtime.supervisor.Supervisor` does, by generated C.

    clock gives s on the clock that stamps are from. Raises TrackmarshalError E470 to E473 for what generated C cannot do, E482 for a
    spec that cannot be supervised with.
    """

    def __init__(
        self, spec: Spec, rules: list[RuleInfo], limits: Limits | None = None, clock: Callable[[], float] = time.monotonic,
        settings: Settings = NO_SETTINGS, stepping: Callable[[Source], Stepping] | None = None,
    ) -> None:  # fmt: skip
        """stepping: makes what takes the steps, for those that are taken elsewhere; by default they are taken here."""
        if settings.places:
            raise TrackmarshalError(
                "E473", "a generated Supervisor has the places of its spec", help="put them into the spec"
            )
        self.limits = Limits.of(spec) if limits is None else limits
        self.spec = spec
        self.contract = of_cycles(spec, rules)
        source = generated(spec, rules, doored=True)
        self.rules = source.plan.rules
        self.stepper: Stepping = (
            Stepper(source, asdict(self.limits), clock, settings.params, settings.tables)
            if stepping is None
            else stepping(source)
        )
        #: How many steps C has taken, and how many it had when a step was handed to the recorder.
        self._counted = self.stepper.serial
        self._recorded = 0
        self._recorder: Recorder | None = None
        #: Why the record is not complete; empty where it is.
        self.record_error = ""
        self._settings = settings
        order = self.stepper.words
        self._shared, self._lines, self._closed, self._events = (
            order.columns[2:],
            order.lines,
            order.closed,
            order.events,
        )
        self._lanes = order.lanes
        #: Lines, whether they are closed, and events of a frame, and the same in the order of words.
        self._others: tuple[Any, ...] = (None, None, None, (), (), ())
        self._reader = CycleReader(self.contract, settings, lambda readers: fastest(readers, self.limits))
        self._words = Wording(self.contract, self.limits)
        self._named = named_rules(self.rules)
        self._advisory = advisory(self.rules)
        self._clock = clock
        self._explaining = Explaining(spec, self.rules)
        #: The cycle that C was asked about last by Python; and what was stored when steps were stopped, with what C has stored of them, if it had
        #: decided by then: nobody has seen whether it had.
        self._asked: tuple[Stamp, Frame | None] = (Stamp(None, None, ()), None)
        self._unseen: tuple[Plan | None, tuple[Plan, ...]] = (None, ())
        #: What takes most steps; None where that cannot be had.
        self._quick = self._quickest()

    def step(self, cycle: Cycle | None) -> Decision:
        """What is driven; None says that a cycle was due and did not come. Never raises an Exception."""
        quick = self._quick
        before = self._counted[0]
        try:
            decision = quick.step(cycle)
            if decision is None:
                decision = self._at_length(cycle)
                quick.release()
        except BaseException:
            left = quick.stopped(self.stepper.taken)
            stamp, frame = self._asked
            if isinstance(left.made, Frame):
                stamp, frame = Stamp(left.number, left.t, ()), left.made
            if frame is not None and stamp.number is not None and stamp.t is not None:
                earlier = self._unseen[1] if self._unseen[0] is quick.stored else ()
                self._unseen = quick.stored, (*earlier, Plan(EMERGENCY, stamp.number, stamp.t, frame))
            if (taken := self._counted[0]) > before:
                if self.contract.over_run:
                    self._gap()
                if self._recorder is not None and self._recorded != taken:
                    self.record_error = gone(self._recorder) or self.record_error
            raise
        return decision or overlapping()

    @property
    def recorder(self) -> Recorder | None:
        """Keeps the run, where there is one."""
        return self._recorder

    @recorder.setter
    def recorder(self, given: Recorder | None) -> None:
        self._recorder = given
        self._quick.recorded = given is not None

    def _at_length(self, cycle: Cycle | None) -> Decision:
        """A step that is not taken, or not all of it."""
        left = self._quick.left()
        if isinstance(left.made, Decision):
            assert left.made.judged is not None
            return self._kept(cycle, left.made.judged.about, left.made, left.made.now)
        now = self._read() if left.now is None else left.now
        frame: Frame | None = left.made
        stamp = Stamp(None, None, ())
        found: list[Fault] = []
        self._words.last = self._quick.last
        if frame is not None:
            stamp, said = Stamp(left.number, left.t, ()), self._here.last()
            self._asked = stamp, frame
        else:
            try:
                if isinstance(cycle, Cycle):
                    stamp = stamp_of(cycle)
                    frame, structure = self._reader.read(cycle)
                    found = [*stamp.faults, *structure]
                elif cycle is not None:
                    found.append(fault("wrong_type", "cycle", "", None, "not a Cycle"))
            except Exception as error:  # what was handed in has a say in how it is read
                frame, found = None, [internal(error)]
            self._asked = stamp, frame
            # Not before: a step that is stopped while its cycle is read is none to C, which counts on from the one before.
            self._quick.steps += 1
            try:
                said = self._call(frame, stamp, now, found)
            except Exception as error:
                frame, found = None, [internal(error)]
                try:
                    said = self._call(None, stamp, now, found)
                except Exception:  # nobody can be asked, as in a fork
                    said = self.stepper.nothing()
            self._expect(frame)
        try:
            decision = self._decision(said, frame, stamp, now, found)
        except Exception as error:
            decision = self._nothing(said, stamp, internal(error))
        self._words.read(said)
        self._quick.last = self._words.last
        return self._kept(cycle, frame, decision, now)

    def _gap(self) -> None:
        """Of the cycle of a step that was stopped behind its reading nobody has been told what was decided: that one did not come is what rules over the
        run are told after it. Of one that was not judged they have been told so."""
        stepper, quick = self.stepper, self._quick
        quick.disarm()
        if not isinstance(stepper, Stepper) or quick.step(None) is not None:  # another thread takes a step
            return
        try:
            quick.left()
            said = stepper.last()
            if said.judged:
                stepper.none_came(said.finished if said.finished >= said.now else said.now)
                quick.steps = stepper.taken
        finally:
            quick.release()

    def _read(self) -> float:
        try:
            return float(self._clock())
        except Exception:
            return math.nan

    def _kept(self, cycle: Cycle | None, frame: Frame | None, decision: Decision, now: float) -> Decision:
        """The decision, in the record where there is one."""
        if self._recorder is not None:
            self._recorded = self._counted[0]
            try:
                self._recorder.append(cycle, frame, decision, (now, decision.finished))
            except Exception as error:
                self.record_error = f"{type(error).__name__}: {error}"
        return decision

    def saving(self) -> Saving:
        """All that the next steps depend on, as it is now, to be saved piece by piece. Raises TrackmarshalError E486 where steps are taken
        elsewhere, or memory is too large to be copied in one."""
        of = self._of  # first: it says whether what is copied is small enough
        return Saving(
            "c", of, pieces(self._quick.steps, self._quick.last, self._quick.stored, self._here.save())
        )

    def restore(self, lines: Sequence[str], shown: str = "") -> None:
        """Go on from where another Supervisor of the same program was. Raises TrackmarshalError D163 for what is damaged, D164 for what is of
        another program, E486 where steps are taken elsewhere; then it is as it was."""
        given = opened(lines, "c", self._of, shown)
        try:
            steps, last, stored, data, numbers, following = loaded(given)
            given.end()
            self._quick.disarm()
            self._here.load(data, numbers, following)
        except NOT_SAVED as error:
            raise damaged(str(error), shown) from error
        self._quick.steps, self._quick.stored, self._quick.last = steps, stored, last
        if self._recorder is not None:
            self.record_error = went_on(self._recorder, lines) or self.record_error

    @property
    def _here(self) -> Stepper:
        if not isinstance(self.stepper, Stepper):
            raise unsaved("a Supervisor in another process saves nothing")
        return self.stepper

    @cached_property
    def _of(self) -> str:
        """The hash of all that what is saved rests on."""
        here = self._here
        limits = {name: spelt(value) for name, value in asdict(self.limits).items()}
        names = [rule.name for rule in self.rules]
        said = words(here.program, here.lasting, here.sizes)
        return meaning(self.spec, names, said, self._settings, ["supervisor", limits])

    def close(self) -> None:
        """End the record, where there is one."""
        if self._recorder is not None:
            self._recorder.close()

    def _quickest(self) -> Slowly:
        """What takes most steps in one call, where that can be had: of a Supervisor whose steps are taken here, and cycles are read by C."""
        stepper, reader = self.stepper, self._reader.at_once
        if isinstance(stepper, Stepper) and stepper.takes_arenas and isinstance(reader, Gathered):
            with suppress(TrackmarshalError, OSError):
                return Quick(reader, stepper, BothRated, self._explaining, self._advisory)
        return Slowly()

    def _expect(self, frame: Frame | None) -> None:
        """After a cycle of which Python saw all: that the next one is like it, where that is known."""
        arena, reader = None if frame is None else frame.arena, self._reader.at_once
        if frame is None or arena is None or not arena.shape.whole or reader.remembered is None:
            self._quick.disarm()
        else:
            assert isinstance(reader, Gathered)
            self._quick.arm(arena, frame, reader.known, reader.remembered)

    # Parts ------------------------------------------------------------------------------------------------------

    def _call(self, frame: Frame | None, stamp: Stamp, now: float, found: list[Fault]) -> Said:
        given = [(NAMES[f.code], f.signal, f.field, f.index) for f in found] if found else ()
        if frame is None:
            return self.stepper.none_came(now, given)
        columns: list[Columns] = []
        if frame.arena is None or not self.stepper.takes_arenas:
            shared = frame.columns
            columns = [*frame.candidates.values(), *[shared[name] for name in self._shared]]
        known = self._others  # most frames have the same ones
        if frame.lines is not known[0] or frame.closed is not known[1] or frame.events is not known[2]:
            lines = tuple([frame.lines[place] for place in self._lines])
            closed = tuple([frame.closed.get(name, False) for name in self._closed])
            events = tuple([frame.events[name] for name in self._events])
            known = self._others = (frame.lines, frame.closed, frame.events, lines, closed, events)
        lanes = [frame.lanes[name] for name in self._lanes] if self._lanes else ()
        return self.stepper.step(
            stamp.number, stamp.t, now, columns, known[3], known[4], known[5], given, frame.arena, lanes
        )

    def _decision(
        self, said: Said, frame: Frame | None, stamp: Stamp, now: float, found: list[Fault]
    ) -> Decision:
        state, driven, t = STATES[said.state], None, math.nan if stamp.t is None else stamp.t
        judged = None
        if said.judged and frame is not None:
            judged = self._judged(frame)
        faults: tuple[Fault, ...] = ()
        violations: tuple[Violation, ...] = ()
        if said.reason_count:
            reasons = self.stepper.reasons(said)
            faults = self._words.faults(reasons, found, frame, stamp, now, said)
            if judged is not None:
                violations = tuple(self._violation(one, judged) for one in reasons if one.rule is not None)
        if faults and frame is not None:
            frame.faults = [f for f in faults if f.signal not in ("clock", "supervisor")]
        if said.safe and frame is not None and stamp.number is not None:
            self._quick.stored = Plan(EMERGENCY, stamp.number, t, frame)
            driven = Plan(DRIVING, stamp.number, t, frame)
        elif not said.stored:
            self._quick.stored = None
        else:
            if not self._agrees(said):
                unseen = (one for one in self._unseen[1] if self._is_stored(one, said))
                self._quick.stored = next(unseen, self._quick.stored)
            if said.driven == _STORED:
                driven = self._quick.stored
        driven_too = (driven is not None) == (said.driven != _NOTHING)
        if said.serial != self._quick.steps or not driven_too or not self._agrees(said):
            return self._nothing(said, stamp, *(faults or found), incomplete("step"))
        return Decision(
            stamp.number, t, said.now, said.finished, state, bool(said.safe), driven, self._quick.stored, said.valid_until,
            self.stepper.lost(said), faults, violations, bool(said.more), judged, advisories(self._named, judged) if self._advisory else (),
        )  # fmt: skip

    def _nothing(self, said: Said, stamp: Stamp, *faults: Fault) -> Decision:
        """C did not decide this cycle, or of another trajectory than is known here: nothing is driven."""
        self._quick.stored, self._unseen = None, (None, ())
        self._quick.steps = said.serial
        t = math.nan if stamp.t is None else stamp.t
        return Decision(
            stamp.number, t, said.now, said.finished, NO_SAFE_TRAJECTORY, False, None, None, said.valid_until, "none_stored", faults, (),
            False, None,
        )  # fmt: skip

    def _agrees(self, said: Said) -> bool:
        """Whether the trajectory that C has stored is the one that is known here."""
        stored = self._quick.stored
        return not said.stored if stored is None else self._is_stored(stored, said)

    @staticmethod
    def _is_stored(plan: Plan, said: Said) -> bool:
        """Whether a trajectory is the one that C has stored."""
        return bool(said.stored) and (plan.number, plan.t) == (said.stored_number, said.stored_t)

    def _judged(self, frame: Frame) -> Judged:
        stepper = self.stepper
        copied = stepper.margins.tobytes() + stepper.verdicts.tobytes()
        return Judged(frame, BothRated(self._explaining, self._advisory, frame, copied))

    def _violation(self, reason: Reason, judged: Judged) -> Violation:
        assert reason.rule is not None
        candidate, place = (DRIVING, EMERGENCY)[reason.candidate], reason.rule
        one, (name, requirements, unit, _) = judged.rated[candidate], self._named[reason.rule]
        margin = float(one.margins[place])
        return Violation(
            name,
            requirements,
            candidate,
            VERDICTS[one.verdicts[place]],
            margin,
            unit,
            lambda: one.explain(place, False),
        )
