"""A recording as the cycles of a Supervisor, and what it decides about them once both candidates have been evaluated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door import Door
from trackmarshal.runtime.judge import Judged
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.runtime.verdict import CaseResult
from trackmarshal.scenarios.recording import Recording
from trackmarshal.supervision import judged


def cycles(recording: Recording) -> Iterator[Cycle]:
    """The cycles of a recording, counted from 0. Columns and records are the recording's own."""
    import numpy as np

    track = {
        name: np.array(line, dtype=np.float64) if isinstance(line, list) and line else line
        for name, line in recording.track.items()
    }
    for number, cycle in enumerate(recording.cycles):
        signals = {
            "ego": cycle.ego,
            "objects": cycle.objects,
            "obstacles": recording.obstacles,
            "track": track,
        }
        yield Cycle(number, cycle.t, cycle.candidates.get(DRIVING), cycle.candidates.get(EMERGENCY), signals)


def decisions(
    recording: Recording, evaluator: Evaluator, results: Sequence[Mapping[str, CaseResult]]
) -> Iterator[Decision]:
    """What the Supervisor decides with these results, one mapping a cycle.

    The car of a recording did not follow the decisions, so where it is says nothing about them (`Limits.open_loop`).
    """
    judge = _Known(evaluator)
    clock = _Clock()
    supervisor = Supervisor(evaluator.spec, judge, Limits.open_loop(), clock.read)
    for cycle, found in zip(cycles(recording), results):
        clock.now, judge.results = cycle.t, found
        yield supervisor.step(cycle)


class _Clock:
    now = 0.0

    def read(self) -> float:
        return self.now


class _Known:
    """A judge whose verdicts are there already."""

    def __init__(self, evaluator: Evaluator) -> None:
        self.rules = evaluator.rules
        self.identity: Mapping[str, Any] = {}
        self.results: Mapping[str, CaseResult] = {}

    def judge(self, door: Door) -> tuple[Judged, Judged]:
        return judged(self.results[DRIVING], self.rules), judged(self.results[EMERGENCY], self.rules)
