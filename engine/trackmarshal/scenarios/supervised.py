"""A recording as the cycles of a Supervisor, and what it decides about them once both candidates have been evaluated."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Cycle, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.door import Door
from trackmarshal.runtime.judge import Judged
from trackmarshal.runtime.record import read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.runtime.verdict import CaseResult
from trackmarshal.scenarios.recording import Cycle as RecordedCycle
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


def recording_of(data: bytes, name: str, shown: str) -> Recording:
    """The cycles of a run's record that passed the door, as a recording; raises D161, D162, or D130 where there are none.

    A recording has one track: cycles after a change of it are left out. What is left out, the notes say.
    """
    run = read(data, shown)
    kept: list[RecordedCycle] = []
    track: dict[str, Any] = {}
    stopped = ""
    for one in run.cycles:
        cycle = one.cycle
        if type(cycle) is not Cycle or one.value("faults") != "[]":
            continue
        given = {line: _list(value) for line, value in cycle.signals.get("track", {}).items()}
        if track and given != track:
            stopped = f"the track changes at {cycle.t:g} s; what follows is left out"
            break
        track = given
        kept.append(
            RecordedCycle(
                cycle.t,
                dict(cycle.signals["ego"]),
                _records(cycle.signals.get("objects", {})),
                {DRIVING: _columns(cycle.driving), EMERGENCY: _columns(cycle.emergency)},
            )
        )
    if not kept:
        raise TrackmarshalError(
            "D130", "the record has no cycle that passed the door", file=shown, help="replay it as it is"
        )
    first = next(one.cycle for one in run.cycles if one.value("faults") == "[]")
    left_out = len(run.cycles) - len(kept)
    notes = [stopped] if stopped else []
    if left_out:
        notes.append(f"{left_out} of {len(run.cycles)} cycles of the record are left out")
    obstacles = _records(first.signals.get("obstacles", {}))
    params, tables = run.identity.get("params", {}), run.identity.get("tables", {})
    return Recording(name, shown, tuple(kept), track, params, tables, obstacles=obstacles, notes=tuple(notes))


def _list(value: Any) -> Any:
    return value.tolist() if hasattr(value, "tolist") else value


def _columns(columns: Mapping[str, Any]) -> dict[str, list[float]]:
    return {name: _list(column) for name, column in columns.items()}


def _records(columns: Mapping[str, Any]) -> list[dict[str, Any]]:
    listed = {name: _list(column) for name, column in columns.items()}
    return [dict(zip(listed, values)) for values in zip(*listed.values())]


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
