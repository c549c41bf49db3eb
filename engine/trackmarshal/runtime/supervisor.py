"""The Supervisor: door, judge, watchdog, state machine. docs/supervisor.md is its specification."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Protocol

from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.case import Fault
from trackmarshal.runtime.columns import number
from trackmarshal.runtime.contract import contract_of
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.decision import Decision, Violation
from trackmarshal.runtime.door import Door, Pose
from trackmarshal.runtime.faults import fault
from trackmarshal.runtime.judge import KNOWN_CODES, SAFE_CODES, Judge, Judged
from trackmarshal.runtime.machine import DRIVE, NO_SAFE_TRAJECTORY, PREVIOUS_EMERGENCY, Memory, advance
from trackmarshal.runtime.plan import Plan
from trackmarshal.runtime.verdict import VERDICTS, Witness


class Recorder(Protocol):
    """Keeps every cycle with its decision; where it fails, the decision stands."""

    def append(self, cycle: object, decision: Decision, readings: tuple[float, float]) -> None: ...

    def close(self) -> None: ...


class Supervisor:
    """Decides in every cycle what is driven. One instance serves one run, from one thread.

    judge evaluates the rules of spec; clock gives s on the clock that stamps are from; door, where given, takes the place of the
    one in Python. Raises TrackmarshalError E482 for a spec whose signals cannot be supervised.
    """

    def __init__(
        self,
        spec: Spec,
        judge: Judge,
        limits: Limits | None = None,
        clock: Callable[[], float] = time.monotonic,
        door: Door | None = None,
    ) -> None:
        self.limits = Limits() if limits is None else limits
        self.judge = judge
        self.memory = Memory()
        self.door = Door(contract_of(spec, judge.rules), self.limits) if door is None else door
        #: Keeps the run, where there is one.
        self.recorder: Recorder | None = None
        #: Why the record is not complete; empty where it is.
        self.record_error = ""
        self._clock = clock
        self._last = -math.inf
        self._rules = [
            (rule.name, tuple(dict.fromkeys(name for name, _ in rule.satisfies)), rule.unit)
            for rule in judge.rules
        ]

    def step(self, cycle: Cycle | None) -> Decision:
        """What is driven; None says that a cycle was due and did not come. Never raises an Exception."""
        faults: list[Fault] = []
        readings = [math.nan, math.nan]
        pose: Pose | None = None
        judged: tuple[Judged, Judged] | None = None
        plans: tuple[Plan, Plan] | None = None
        violations: tuple[Violation, ...] = ()
        now = self._read(readings, 0, faults)
        try:
            if cycle is None:
                faults.append(fault("missing_cycle", "cycle"))
            elif type(cycle) is not Cycle:
                faults.append(fault("wrong_type", "cycle", "", None, "not a Cycle"))
            else:
                found, pose = self.door.check(cycle, now)
                faults += found
                if not faults:
                    judged = self._judged(faults)
                    finished = self._read(readings, 1, faults)
                    if not finished - now <= self.limits.budget:
                        late = f"{finished - now:g} s, the budget is {self.limits.budget:g} s"
                        faults.append(fault("overrun", "cycle", "", None, late))
                if judged is not None:
                    violations = self._violations(judged)
                    if not faults and not violations:
                        plans = self.door.plans(cycle)
        except Exception as error:
            plans, pose = None, None
            faults.append(_internal(error))
        decision = self._decide(cycle, plans, now, readings[1], pose, faults, violations, judged)
        if self.recorder is not None:
            try:
                self.recorder.append(cycle, decision, (readings[0], readings[1]))
            except Exception as error:
                self.record_error = f"{type(error).__name__}: {error}"
        return decision

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
        if not self._last <= value < math.inf:
            faults.append(fault("bad_clock", "clock", "", None, f"{value!r} after {self._last!r}"))
            return math.nan
        self._last = value
        return value

    def _judged(self, faults: list[Fault]) -> tuple[Judged, Judged] | None:
        """The judge's verdicts, if they are whole."""
        try:
            driving, emergency = self.judge.judge(self.door)
        except Exception as error:
            faults.append(fault("judge_failed", "judge", "", None, _shown(error)))
            return None
        for candidate, judged in ((DRIVING, driving), (EMERGENCY, emergency)):
            if type(judged) is not Judged or not self._whole(judged):
                faults.append(fault("incomplete", "judge", candidate, None, "not one known verdict a rule"))
                return None
        return driving, emergency

    def _whole(self, judged: Judged) -> bool:
        count = len(self._rules)
        verdicts = judged.verdicts
        return (
            type(verdicts) is bytes
            and len(verdicts) == count == len(judged.margins)
            and not verdicts.translate(None, KNOWN_CODES)
        )

    def _violations(self, judged: tuple[Judged, Judged]) -> tuple[Violation, ...]:
        """The rules that make a candidate unsafe."""
        if not any(one.verdicts.translate(None, SAFE_CODES) for one in judged):
            return ()
        return tuple(
            self._violation(place, candidate, one)
            for candidate, one in zip((DRIVING, EMERGENCY), judged)
            for place, code in enumerate(one.verdicts)
            if code not in SAFE_CODES
        )

    def _violation(self, place: int, candidate: str, judged: Judged) -> Violation:
        name, requirements, unit = self._rules[place]
        witness: Witness | None = None
        reason = ""
        if judged.result is not None:
            result = judged.result(place)
            witness, unit, reason = result.witness, result.unit, result.reason
        verdict = VERDICTS[judged.verdicts[place]]
        margin = float(judged.margins[place])
        return Violation(name, requirements, candidate, verdict, margin, unit, witness, reason)

    def _decide(
        self, cycle: object, plans: tuple[Plan, Plan] | None, now: float, finished: float, pose: Pose | None, faults: list[Fault],
        violations: tuple[Violation, ...], judged: tuple[Judged, Judged] | None,
    ) -> Decision:  # fmt: skip
        """The state machine, and its outcome with all reasons. Should it fail, nothing is driven."""
        try:
            self.memory, lost = advance(
                self.memory, None if plans is None else plans[1], now, pose, self.limits
            )
        except Exception as error:
            faults.append(_internal(error))
            self.memory, lost, plans = Memory(NO_SAFE_TRAJECTORY), "none_stored", None
        state = self.memory.state
        driven = self.memory.stored if state == PREVIOUS_EMERGENCY else None
        if state == DRIVE and plans is not None:
            driven = plans[0]
        try:
            called, t = _called(cycle)
        except Exception:  # what was handed in has a say in how it is read
            called, t = None, math.nan
        return Decision(
            called, t, now, finished, state, plans is not None, driven, self.memory.stored, now + self.limits.longest_gap, lost,
            tuple(faults), violations, judged,
        )  # fmt: skip


def _called(cycle: object) -> tuple[int | None, float]:
    """Number and stamp of a cycle as far as they are numbers."""
    if type(cycle) is not Cycle:
        return None, math.nan
    called = cycle.number if type(cycle.number) is int and abs(cycle.number) < 2**63 else None
    t = number(cycle.t)
    return called, math.nan if t is None else t


def _internal(error: Exception) -> Fault:
    return fault("internal", "supervisor", "", None, _shown(error))


def _shown(error: Exception) -> str:
    """An error in one line; its own text may fail."""
    try:
        return f"{type(error).__name__}: {error}"[:200]
    except Exception:
        return type(error).__name__
