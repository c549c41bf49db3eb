"""A Supervisor with the generated door and rules decides what the one with the numpy evaluator decides."""

from __future__ import annotations

import math
import random
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import PERIOD, cycle, mutate
from trackmarshal.backends.c.judge import SteppedDoor, SteppedJudge
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.record import read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.supervision import judge_of, rerun

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


class Pair:
    """Two Supervisors, one with C, that see the same."""

    def __init__(self, *configuration: str, record: Path | None = None, **given: Any) -> None:
        self.now = 0.0
        spec = tm.load([ROOT / "specs" / "supervisor"], [ROOT / name for name in configuration])
        limits = tm.Limits(budget=1e9)
        self.c, self.other = (
            tm.supervisor(spec, backend=b, limits=limits, clock=lambda: self.now, record=r, **given)
            for b, r in (("c", record), ("numpy", None))
        )
        assert isinstance(self.c.door, SteppedDoor)
        assert isinstance(self.c.judge, SteppedJudge)

    def step(self, given: Cycle | None, now: float) -> str:
        self.now = now
        mine, other = self.c.step(given), self.other.step(given)
        assert (mine.state, mine.safe, mine.lost, mine.number) == (
            other.state,
            other.safe,
            other.lost,
            other.number,
        )
        told = [{(name_of(f), f.signal, f.field, f.index) for f in d.faults} for d in (mine, other)]
        assert told[0] == told[1]
        key = [
            [(v.rule, v.candidate, v.verdict, v.requirements) for v in d.violations] for d in (mine, other)
        ]
        assert key[0] == key[1]
        if mine.judged and other.judged:
            for a, b in zip(mine.judged, other.judged):
                assert a.verdicts == b.verdicts
                np.testing.assert_allclose(a.margins, b.margins, rtol=1e-12, atol=1e-12)
        if mine.samples is not None and other.samples is not None:
            for name, column in mine.samples.items():
                assert column.tobytes() == other.samples[name].tobytes()
        return mine.state


@pytest.mark.parametrize("form", ["columns", "records"])
def test_the_shipped_scenario(form: str) -> None:
    recording = tm.load_recording(ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    pair = Pair("specs/tracks/northfield.spec", params=recording.params, tables=recording.tables)
    states = []
    for given in tm.cycles(recording):
        signals = given.signals
        if form == "columns":
            signals = {**signals, "objects": columns(signals["objects"]), "obstacles": NOBODY}
        states.append(pair.step(replace(given, signals=signals), given.t))
    assert states.count("drive") == 104
    assert "previous_emergency" in states


def columns(records: list[dict[str, Any]]) -> dict[str, Any]:
    """A set as columns: what generated C takes at once."""
    names = ("x", "y", "heading", "v", "length", "width", "age")
    return {
        "id": [r["id"] for r in records],
        **{n: np.array([float(r.get(n, 0.0)) for r in records]) for n in names},
    }


NOBODY = {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")}


def test_broken_cycles_have_the_same_faults() -> None:
    pair = Pair()
    rng = random.Random(11)
    for number in range(1500):
        given: Cycle | None = cycle(number, 1 + number % 4, 1 + number % 3)
        if number % 3 == 2 and given is not None:
            given = mutate(rng, given)[0]
        if number % 100 == 50:
            given = None
        pair.step(given, number * PERIOD)


def test_records_that_break_the_contract_have_the_same_faults() -> None:
    pair = Pair()
    good = {
        "id": "a",
        "x": 60.0,
        "y": 0.0,
        "heading": 0.0,
        "v": 20.0,
        "length": 4.7,
        "width": 2.0,
        "age": 0.0,
    }
    records: list[Any] = [
        [good],
        [good, good],
        [{**good, "v": math.nan}],
        [{"id": "a"}],
        [7],
        [{**good, "x": "1"}],
    ]
    states = []
    for number, objects in enumerate(records * 2):
        given = cycle(number)
        given.signals["objects"] = objects
        states.append(pair.step(given, number * PERIOD))
    assert [state == "drive" for state in states] == [True, False, False, False, False, False] * 2


def test_tracks_that_change() -> None:
    pair = Pair()
    for number in range(12):
        given = cycle(number)
        left = given.signals["track"]["left"].copy()
        if number in (4, 5):
            left[:, 1] = 0.5  # the car no longer fits
        if number in (7, 8):
            left = np.zeros((1, 2))
        given.signals["track"]["left"] = left
        assert (pair.step(given, number * PERIOD) == "drive") == (number in (0, 1, 2, 3, 6, 9, 10, 11)), (
            number
        )


def test_a_record_runs_again_the_same_with_either(tmp_path: Path) -> None:
    pair = Pair(record=tmp_path / "run.arrows")
    rng = random.Random(12)
    for number in range(60):
        given = cycle(number)
        if number % 5 == 3:
            given = mutate(rng, given)[0]
        if number == 31:
            given.driving["v"][:] = 100.0
        pair.step(given, number * PERIOD)
    assert pair.c.record_error == ""
    run = read((tmp_path / "run.arrows").read_bytes(), "run")
    assert len(run.cycles) == 60
    spec = tm.load([ROOT / "specs" / "supervisor"])
    assert [d for _, found in rerun(run, spec, judge_of(run, spec)) for d in found] == []
    with_numpy = [d for _, found in rerun(run, spec, judge_of(run, spec, "numpy")) for d in found]
    assert {d.column for d in with_numpy} <= {"violations", "margins.driving", "margins.emergency"}


def test_the_generated_rules_go_with_the_generated_door() -> None:
    pair = Pair()
    supervisor = Supervisor(tm.load([ROOT / "specs" / "supervisor"]), pair.c.judge, clock=lambda: 0.0)
    decision = supervisor.step(cycle(0))
    assert [name_of(f) for f in decision.faults] == ["judge_failed"]
