"""Supervisors out of specs: the evaluators as judges of the runtime."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import BACKENDS, Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.contract import IS_EMERGENCY, PLAN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door import Door
from trackmarshal.runtime.judge import Judge, Judged
from trackmarshal.runtime.record import Difference, Record, Run, differences
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.runtime.verdict import VERDICTS, CaseResult

_CODES = {name: code for code, name in enumerate(VERDICTS)}


def supervisor(
    spec: Spec,
    rules: Sequence[str] | None = None,
    backend: str = "numpy",
    limits: Limits | None = None,
    clock: Callable[[], float] = time.monotonic,
    record: str | Path | None = None,
    params: Mapping[str, float] | None = None,
    tables: Mapping[str, Any] | None = None,
) -> Supervisor:
    """A Supervisor for a spec, or for some of its rules.

    params and tables override the spec's, in declared units; clock gives s on the clock of the cycles' stamps; record is a new file that
    keeps the run. Raises TrackmarshalError D203, D204, E401, E403, E404, E481, E482 or E483.
    """
    made = _made(EvaluatorJudge(Evaluator(spec, rules, backend), params, tables), limits or Limits(), clock)
    if record is not None:
        made.recorder = Record(record, made.door, made.judge.identity)
    return made


def _made(judge: EvaluatorJudge, limits: Limits, clock: Callable[[], float]) -> Supervisor:
    """A Supervisor around a judge; with generated C, door and rules of its own where a compiler and the spec let it."""
    spec = judge.evaluator.spec
    if judge.evaluator.backend == "c":
        from trackmarshal.backends.c.judge import SteppedDoor, SteppedJudge

        try:
            door = SteppedDoor(spec, judge.rules, limits, judge.settings)
        except (TrackmarshalError, ValueError) as error:
            print(
                f"note: the evaluator judges instead of the generated door and rules: {error}",
                file=sys.stderr,
            )
        else:
            return Supervisor(spec, SteppedJudge(judge.rules, judge.identity), limits, clock, door)
    return Supervisor(spec, judge, limits, clock)


def rerun(run: Run, spec: Spec, judge: Judge) -> Iterator[tuple[Decision, list[Difference]]]:
    """The cycles of a record again, at the recorded times: each decision, and where it is not the recorded one."""
    ticks: list[float] = []

    def clock() -> float:
        return ticks.pop(0)

    if isinstance(judge, EvaluatorJudge):
        again = _made(judge, run.limits, clock)
    else:
        again = Supervisor(spec, judge, run.limits, clock)
    for place, recorded in enumerate(run.cycles):
        ticks[:] = recorded.readings
        decision = again.step(recorded.cycle)
        yield decision, differences(place, recorded, decision)


def judge_of(run: Run, spec: Spec, backend: str | None = None) -> EvaluatorJudge:
    """A judge as the one of a record, with another backend where one is given, or the recorded judge was none of ours.

    Raises E401 and others for another spec.
    """
    identity = run.identity
    own = str(identity.get("backend"))
    evaluator = Evaluator(spec, identity.get("rules"), backend or (own if own in BACKENDS else BACKENDS[0]))
    return EvaluatorJudge(evaluator, identity.get("params"), identity.get("tables"))


class EvaluatorJudge:
    """A judge that evaluates both candidates with an Evaluator; raises E403 where the parameters break a constraint."""

    def __init__(
        self,
        evaluator: Evaluator,
        params: Mapping[str, float] | None = None,
        tables: Mapping[str, Any] | None = None,
    ) -> None:
        self.evaluator = evaluator
        self.rules: Sequence[RuleInfo] = evaluator.rules
        settings = {"params": dict(params or {}), "tables": dict(tables or {})}
        self.identity: Mapping[str, Any] = {
            "fingerprint": evaluator.spec.fingerprint,
            "backend": evaluator.backend,
            "rules": [rule.name for rule in evaluator.rules],
            **settings,
        }
        read = evaluator.read(settings)
        broken = evaluator.broken_constraints(read)
        if broken:
            raise TrackmarshalError("E403", broken[0], help="change the parameters")
        if evaluator.backend != "reference":
            _ = evaluator.program  # made now, not in the first cycle's time
        #: Parameters, tables and places as they are in force.
        self.settings = Case(params=read.params, tables=read.tables, places=read.places)
        signals = evaluator.spec.signals
        self._sets = [name for name, info in signals.items() if info.many]
        self._timelines = [name for name, info in signals.items() if info.sequence]
        self._states = [name for name, info in signals.items() if info.kind == "state" and not info.many]

    def judge(self, door: Door) -> tuple[Judged, Judged]:
        cases = [self._case(door, name, one) for name, one in zip((DRIVING, EMERGENCY), door.signals())]
        driving, emergency = self.evaluator.evaluate(cases)
        return judged(driving, self.rules), judged(emergency, self.rules)

    def _case(self, door: Door, name: str, signals: Mapping[str, Any]) -> Case:
        """A case as its reader makes one, from what passed the door."""
        case = replace(self.settings, id=name, columns={}, counts={}, names={}, scalars={}, lines={}, closed={},
                       faults=[], unusable=set())  # fmt: skip
        ids = door.ids()
        for signal, values in signals.items():
            if signal in self._sets or signal in self._timelines:
                case.columns[signal] = {field: column.tolist() for field, column in values.items()}
                block = door.block(signal if signal != PLAN else name)
                case.counts[signal] = block.count
                if signal in ids:
                    case.names[signal] = ids[signal]
            elif signal in self._states:
                case.scalars[signal] = dict(values)
            elif signal in self.evaluator.spec.events:
                case.scalars[signal] = {"": values}
        for (signal, line), border in door.lines().items():
            case.lines[signal, line] = border.tuples
        case.closed |= door.closed
        if IS_EMERGENCY in signals:
            case.scalars[IS_EMERGENCY] = {"": signals[IS_EMERGENCY]}
        return case


def judged(result: CaseResult, rules: Sequence[RuleInfo]) -> Judged:
    """A case's results as a judge returns them. A breach of the contract that only the case's reader saw leaves no verdict known."""
    outcomes = [result.rules[rule.name] for rule in rules]
    codes = bytes(_CODES["undefined" if result.faults else outcome.verdict] for outcome in outcomes)
    return Judged(codes, [outcome.margin for outcome in outcomes], lambda number: outcomes[number])
