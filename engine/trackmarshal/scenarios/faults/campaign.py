"""A campaign run: each fault put into the recording, the Supervisor run over it, and held against what was expected."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable, Sequence
from dataclasses import astuple, dataclass, fields, replace

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.cycle import DRIVING, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.machine import DRIVE
from trackmarshal.runtime.program import Judged, Memory, Program
from trackmarshal.scenarios.faults.around import Around
from trackmarshal.scenarios.faults.declaration import Campaign, Expected, Fault
from trackmarshal.scenarios.faults.judging import Judging
from trackmarshal.scenarios.faults.moment import Moment
from trackmarshal.scenarios.fields import check_fit, further_names
from trackmarshal.scenarios.overrides import known_params, known_tables
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.supervised import cycles, pass_gap
from trackmarshal.supervision import limits_with, rulebox
from trackmarshal.units import moment as stamp

#: Stamps are sums of steps; this is far less than a step, s.
_SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Outcome:
    """What came of a fault: which rules and faults made a cycle unsafe in which cycles, s, and what was driven then.

    by: in the first unsafe cycle; driven, since: in it as well; lost: why nothing stored was driven, and from when on.
    wrong: how that differs from what was expected; empty where it does not.
    """

    fault: Fault
    by: tuple[str, ...]
    first: float | None
    last: float | None
    driven: str
    since: float | None
    lost: str
    lost_at: float | None
    wrong: str


def fingerprint(
    campaign: Campaign, fault: Fault, source_hash: str, spec: str, limits: Limits, rules: Sequence[RuleInfo]
) -> str:
    """sha256 of all that an outcome depends on: the fault as declared, the recording, rules and values, the limits; and of the requirements of rules,
    which are no part of what these mean, whether the one that is to find it satisfies that of the fault, and whether any does."""
    held = [(field.name, value) for field, value in zip(fields(limits), astuple(limits))]
    by = "" if fault.expected is None else fault.expected.by
    finder = [rule for rule in rules if rule.name == by]
    asked = [fault.requirement in _satisfied(each) for each in (finder, rules)]
    made_of = [fault.digest, campaign.lead, source_hash, spec, held, asked]
    return hashlib.sha256(json.dumps(made_of).encode()).hexdigest()


class Bench:
    """A recording and its rules, ready for faults; with the limits of the rules' spec, unless others are given."""

    def __init__(self, recording: Recording, evaluator: Evaluator, limits: Limits | None = None) -> None:
        check_fit(recording, evaluator)
        tables, _ = known_tables(recording, evaluator.spec)
        self._box = rulebox(evaluator, known_params(recording, evaluator.spec), tables)
        self._limits = limits_with(evaluator.spec, {}, self._box.settings) if limits is None else limits
        self._evaluated = _satisfied(evaluator.rules)
        self._recording = recording
        self._cycles = list(cycles(recording, further_names(recording, evaluator)))
        self._judging = Judging(evaluator.program)

    def run(self, campaign: Campaign, fault: Fault) -> Outcome:
        """Put one fault in and see what comes of it; the run is made twice, its frames are judged twice, and both have to come out the same.

        Raises D153 for a fault that cannot be put into this recording.
        """
        said, idle = zip(*(self._decisions(campaign, fault) for _ in range(2)))
        outcome = _outcome(fault, said[0], self._evaluated)
        confirmed = self._judging.confirmed()
        if not confirmed or [_summary(d) for _, d in said[0]] != [_summary(d) for _, d in said[1]]:
            wrong = f"{outcome.wrong}; " if outcome.wrong else ""
            return replace(outcome, wrong=f"{wrong}the same cycles led to other decisions the second time")
        if len(idle[0]) == len(fault.changes) > 0:  # an undisturbed run shows nothing of faults
            return replace(outcome, wrong="it changes nothing: all cycles are as they were recorded")
        if idle[0]:  # what is found may be due to the others alone
            which = ", ".join(str(number + 1) for number in sorted(idle[0]))
            wrong = f"change {which} of {len(fault.changes)} changes nothing: all cycles are as without it"
            return replace(outcome, wrong=wrong)
        return outcome

    def _decisions(self, campaign: Campaign, fault: Fault) -> tuple[list[tuple[float, Decision]], set[int]]:
        """The decisions of a new Supervisor around the fault, each with the time that its cycle is due, s; and the numbers of changes that changed no cycle."""
        last = fault.end if fault.expected is None else max(fault.end, fault.expected.last)
        begin, end = fault.begin - campaign.lead - _SLACK, last + campaign.lead + _SLACK
        clock = _Clock()
        supervisor = self._box.supervisor(self._limits, clock.read)
        supervisor.program = judge = _Saboteur(self._judging)
        said: list[tuple[float, Decision]] = []
        touched = disturbed = False
        every = set(range(len(fault.changes)))
        idle = set(every)
        free = -math.inf  # when the Supervisor is done with the cycle before
        for cycle in self._cycles:
            if not begin <= cycle.t <= end:
                continue
            pass_gap(self._recording, supervisor, cycle.number)
            moment = Moment.of(cycle)
            if fault.begin - _SLACK <= cycle.t <= fault.end + _SLACK:
                touched = True
                try:
                    for number, each in enumerate(fault.changes):
                        before = moment.copied()
                        each(moment)
                        if moment != before:
                            idle.discard(number)
                    disturbed = disturbed or moment != Moment.of(cycle)  # of changes, one may undo another
                except (KeyError, IndexError, TypeError, ValueError, ZeroDivisionError) as error:
                    message = (
                        f"the fault `{fault.id}` changes what is not there at {stamp(cycle.t)} s ({error})"
                    )
                    raise TrackmarshalError(
                        "D153",
                        message,
                        file=campaign.source,
                        line=fault.line,
                        help="name what the recording has",
                    ) from error
            if moment.lost:
                continue
            arrival = max(moment.arrival, free)
            free = arrival + moment.delay
            clock.readings = [arrival + moment.clock, free + moment.clock]
            judge.sabotage = moment.judge
            said.append((cycle.t, supervisor.step(None if moment.silent else moment.cycle)))
        if not touched:
            message = f"the recording has no cycle in the time of the fault `{fault.id}`"
            raise TrackmarshalError(
                "D153", message, file=campaign.source, line=fault.line, help="choose a time that it has"
            )
        return said, idle if disturbed else every


def _satisfied(rules: Iterable[RuleInfo]) -> frozenset[str]:
    """The requirements that some rules satisfy."""
    return frozenset(name for rule in rules for name, _ in rule.satisfies)


class _Clock:
    """Reads what it is told to; a reading that nobody asked for in the cycle before is dropped."""

    def __init__(self) -> None:
        self.readings: list[float] = []

    def read(self) -> float:
        return self.readings.pop(0)


class _Saboteur(Around):
    """A program that fails as it is told to."""

    def __init__(self, program: Program) -> None:
        super().__init__(program)
        self.sabotage = ""

    def judge(self, memory: Memory, frame: Frame) -> Judged:
        if self.sabotage == "raises":
            raise ArithmeticError("put in on purpose")
        judged = self._program.judge(memory, frame)
        driving = judged.rated[DRIVING]
        match self.sabotage:
            case "":
                return judged
            case "short":
                driving = driving._replace(verdicts=driving.verdicts[:-1])
            case "unknown":
                driving = driving._replace(verdicts=b"\xff" + driving.verdicts[1:])
            case other:
                raise AssertionError(other)
        return judged._replace(rated={**judged.rated, DRIVING: driving})


def _outcome(fault: Fault, said: list[tuple[float, Decision]], evaluated: frozenset[str]) -> Outcome:
    """What came of a fault; `evaluated`: the requirements that rules satisfy."""
    unsafe = [(t, decision) for t, decision in said if not decision.safe]
    lost = next(((decision.lost, t) for t, decision in said if decision.lost), ("", None))
    if unsafe:
        first, decision = unsafe[0]
        since = None if decision.driven is None else decision.driven.t
        found = Outcome(
            fault, _by(decision), first, unsafe[-1][0], decision.action, since, lost[0], lost[1], ""
        )
    else:
        found = Outcome(fault, (), None, None, DRIVE, None, lost[0], lost[1], "")
    return replace(found, wrong="; ".join(_differences(fault, found, said, evaluated)))


def _by(decision: Decision) -> tuple[str, ...]:
    """The rules that are violated or undefined, and the faults, each once."""
    names = [violation.rule for violation in decision.violations] + [name_of(f) for f in decision.faults]
    return tuple(dict.fromkeys(names))


def _differences(
    fault: Fault, found: Outcome, said: list[tuple[float, Decision]], evaluated: frozenset[str]
) -> list[str]:
    """How the outcome differs from what is expected.

    A fault of something that rules evaluate is found by a rule that does so; one of the Supervisor itself, by whatever rule it is put in for.
    """
    expected = fault.expected
    if expected is None:
        return (
            []
            if found.first is None
            else [f"unsafe at {stamp(found.first)} s by {', '.join(found.by)}, not at all expected"]
        )
    if found.first is None:
        return [f"nothing was found; expected {expected.by} at {stamp(expected.first)} s"]
    wrong = []
    decision = next(decision for _, decision in said if not decision.safe)
    if expected.by not in found.by:
        wrong.append(f"found by {', '.join(found.by)}, expected {expected.by}")
    asked = [set(v.requirements) for v in decision.violations if v.rule == expected.by]
    if asked and fault.requirement in evaluated and fault.requirement not in asked[0]:
        wrong.append(f"{expected.by} satisfies {', '.join(sorted(asked[0]))}, expected {fault.requirement}")
    wrong += _stretch(expected, said)
    same = found.since is None if expected.since is None else _equal(found.since, expected.since)
    if found.driven != expected.driven or not same:
        wrong.append(
            f"driven is {_driven(found.driven, found.since)}, expected {_driven(expected.driven, expected.since)}"
        )
    if (found.lost, found.lost_at is None) != (expected.lost, expected.lost_at is None) or not (
        expected.lost_at is None or _equal(found.lost_at, expected.lost_at)
    ):
        wrong.append(
            f"the stored trajectory is {_lost(found.lost, found.lost_at)}, expected {_lost(expected.lost, expected.lost_at)}"
        )
    return wrong


def _stretch(expected: Expected, said: list[tuple[float, Decision]]) -> list[str]:
    """Exactly the cycles from first to last, both of which there are, have to be unsafe; in all others the planned trajectory is driven."""
    wrong = []
    for t, decision in said:
        inside = expected.first - _SLACK <= t <= expected.last + _SLACK
        if decision.safe == inside:
            wrong.append(f"{'safe' if decision.safe else 'unsafe'} at {stamp(t)} s")
    if len(wrong) > 3:
        wrong[3:] = [f"and {len(wrong) - 3} more cycles"]
    # Of a time at which nothing was decided, as after the end of the recording, nothing is known.
    for end in dict.fromkeys((expected.first, expected.last)):
        if not any(_equal(t, end) for t, _ in said):
            wrong.append(f"nothing was decided at {stamp(end)} s")
    return (
        [f"{', '.join(wrong)}; expected unsafe from {stamp(expected.first)} to {stamp(expected.last)} s"]
        if wrong
        else []
    )


def _equal(one: float | None, other: float) -> bool:
    return one is not None and abs(one - other) <= _SLACK


def _driven(what: str, since: float | None) -> str:
    return what if since is None else f"{what} from {stamp(since)} s"


def _lost(what: str, at: float | None) -> str:
    return "kept" if at is None else f"{what} at {stamp(at)} s"


def _summary(decision: Decision) -> tuple[object, ...]:
    """Everything of a decision that has to be the same again."""
    judged = (
        None
        if decision.judged is None
        else [(r.verdicts, list(map(repr, r.margins))) for r in decision.judged.rated.values()]
    )
    driven = None if decision.driven is None else (decision.driven.number, decision.driven.matrix.tobytes())
    return decision.state, decision.safe, decision.lost, decision.reasons, judged, driven
