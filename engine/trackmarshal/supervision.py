"""Supervisors out of specs: the evaluators as judges of the runtime."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.contract import IS_EMERGENCY, PLAN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.door import Door
from trackmarshal.runtime.judge import Judge, Judged
from trackmarshal.runtime.supervisor import Recorder, Supervisor
from trackmarshal.runtime.verdict import VERDICTS, CaseResult

_CODES = {name: code for code, name in enumerate(VERDICTS)}


def supervisor(
    spec: Spec,
    rules: Sequence[str] | None = None,
    backend: str = "numpy",
    limits: Limits | None = None,
    clock: Callable[[], float] = time.monotonic,
    recorder: Callable[[Judge, Limits], Recorder] | None = None,
    params: Mapping[str, float] | None = None,
    tables: Mapping[str, Any] | None = None,
) -> Supervisor:
    """A Supervisor for a spec, or for some of its rules.

    params and tables override the spec's, in declared units; clock gives s on the clock of the cycles' stamps; recorder makes what keeps
    the run (`record_to`). Raises TrackmarshalError D203, D204, E401, E403, E404, E481 or E482.
    """
    judge = EvaluatorJudge(Evaluator(spec, rules, backend), params, tables)
    limits = Limits() if limits is None else limits
    kept = None if recorder is None else recorder(judge, limits)
    return Supervisor(spec, judge, limits, clock, kept)


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
        if evaluator.backend == "numpy":
            _ = evaluator.program  # made now, not in the first cycle's time
        self._settings = Case(params=read.params, tables=read.tables, places=read.places)
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
        case = replace(self._settings, id=name, columns={}, counts={}, names={}, scalars={}, lines={}, closed={},
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
