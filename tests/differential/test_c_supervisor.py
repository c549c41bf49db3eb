"""A Supervisor in generated C decides what the one in Python decides, cycle by cycle."""

from __future__ import annotations

import os
import random
import re
import shutil
import subprocess
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support import tape
from support.cycles import PERIOD, cycle, not_finite
from support.length import amount, shared_out
from support.pairs import Abreast, Pair, Readings, agree, declared, generated, lines_once, spec_with
from support.sanitized import FLAGS as SANITIZED
from support.sanitized import unit
from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal import scenarios
from trackmarshal.backends.c.build import EXACT, compiler
from trackmarshal.backends.c.step import Stepper
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.cli.replay import Known, evaluator_for
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import FAULTS, name_of
from trackmarshal.runtime.record.reading import read
from trackmarshal.runtime.supervisor import Supervisor
from trackmarshal.scenarios.faults.campaign import Bench
from trackmarshal.scenarios.faults.declaration import Fault, load
from trackmarshal.scenarios.overrides import known_tables
from trackmarshal.scenarios.recording import Recording
from trackmarshal.supervision import Rulebox, box_of, rerun, rulebox

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

FOLDER = REPOSITORY / "specs" / "scenarios"
RECORDINGS = sorted(path.name for path in FOLDER.glob("*.tmrec.jsonl*"))
NORTHFIELD = REPOSITORY / "specs" / "tracks" / "northfield.spec"
#: TRACKMARSHAL_RUNS=10000 has so many generated runs of 50 cycles.
RUNS = int(os.environ.get("TRACKMARSHAL_RUNS", "4"))
PARTS = amount(2, 8)


@cache
def evaluator() -> Evaluator:
    return Evaluator(spec_with())


_known = Known()


@cache
def boxed(name: str) -> tuple[Recording, Rulebox]:
    recording = scenarios.load(FOLDER / name)
    found = evaluator_for(recording, SUPERVISOR, [], REPOSITORY, None, "numpy", known=_known)
    tables, _ = known_tables(recording, found.spec)
    return recording, rulebox(found, recording.params, tables)


@pytest.mark.verifies("S-1-B-1")
@pytest.mark.parametrize(("name", "limits"), shared_out(product(RECORDINGS, ("driven", "open_loop")), 12))
def test_shipped_scenarios(name: str, limits: str) -> None:
    recording, box = boxed(name)
    free = replace(Limits.open_loop(), samples=64, elements=32, border=2048)
    pair = Pair(box.evaluator, box.settings, free if limits == "open_loop" else Limits())
    cycles = [declared(given, box.evaluator.spec) for given in tm.cycles(recording)]
    said = [pair.step(given, given.t + 0.01, given.t + 0.02) for given in cycles]
    assert sum(decision.judged is not None for decision in said) > 10


# The campaign of injected faults ---------------------------------------------------------------------------------

CAMPAIGN = load(FOLDER / "faults.yaml", "specs/scenarios/faults.yaml")
PUT_IN = [fault for fault in CAMPAIGN.faults if not fault.open]


class Beside(Supervisor):
    """The Supervisor in Python with one in C beside it, until its judge is made to fail: in C, nothing can be put in its place."""

    def __init__(self, made: Supervisor, box: Rulebox) -> None:
        self.__dict__ = made.__dict__
        self._own, self._read_by_c = made._clock, Readings()
        self._c: CSupervisor | None = CSupervisor(
            box.evaluator.spec, box.evaluator.rules, made.limits, self._read_by_c.read, box.settings
        )
        self.compared = 0
        self._clock = self._note
        self._seen: list[float] = []

    def _note(self) -> float:
        reading = self._own()
        self._seen.append(reading)
        return reading

    def step(self, cycle: Any) -> Decision:
        self._seen.clear()
        decision = super().step(cycle)
        if getattr(self.program, "sabotage", ""):
            self._c = None
        if self._c is not None:
            self._read_by_c.waiting = list(self._seen)
            agree(self._c.step(cycle), decision)
            self.compared += 1
        return decision


@cache
def bench() -> tuple[Bench, list[Beside]]:
    recording = scenarios.load(FOLDER / CAMPAIGN.recording)
    found = evaluator_for(recording, SUPERVISOR, [], REPOSITORY, None, "numpy", FOLDER)
    made = Bench(recording, found)
    box, beside = made._box, []

    class Box(Rulebox):
        def supervisor(self, *given: Any) -> Supervisor:
            beside.append(Beside(box.supervisor(*given), box))
            return beside[-1]

    made._box = Box(box.evaluator, box.settings, box.identity)
    made._cycles = [declared(given, found.spec) for given in made._cycles]
    return made, beside


@pytest.mark.verifies("S-1-B-1")
@pytest.mark.parametrize("fault", shared_out(PUT_IN, 5), ids=lambda fault: fault.id)
def test_injected_faults(fault: Fault) -> None:
    made, beside = bench()
    beside.clear()
    made._decisions(CAMPAIGN, fault)
    assert beside[0].compared > 1


# Generated runs --------------------------------------------------------------------------------------------------


@pytest.mark.verifies("S-1-B-1")
@pytest.mark.parametrize("part", range(PARTS))
def test_generated_runs(part: int) -> None:
    """Faults of every kind that a cycle can have; TRACKMARSHAL_RUNS=N makes N runs of 50 cycles.

    One run in ten, and the first ones, go on by themselves, as in operation; the others many abreast, which numpy judges together.
    """
    seen, states = Counter[str](), Counter[str]()

    def note(decision: Decision) -> None:
        seen.update(name_of(fault) for fault in decision.faults)
        seen.update([decision.lost] if decision.lost else [])
        states[decision.state] += 1

    seeds = range(part, RUNS, PARTS)
    for seed in (alone := {*seeds[:2], *seeds[::10]}):
        pair = Pair(evaluator())
        for given, readings in generated(seed):
            try:
                note(pair.step(given, *readings))
            except AssertionError as error:
                raise AssertionError(f"run {seed}, {given!r:.300}") from error
    with lines_once():
        others = [seed for seed in seeds if seed not in alone]
        for group in (others[start : start + 25] for start in range(0, len(others), 25)):
            abreast = Abreast(evaluator(), len(group))
            for number, steps in enumerate(zip(*map(generated, group))):
                try:
                    decisions = abreast.step(steps)
                except AssertionError as error:
                    raise AssertionError(f"step {number} of one of the runs {group}") from error
                for decision in decisions:
                    note(decision)
    # What Python's code raises, or what was put into C, is the business of tests of its own; the shipped signals have no enumeration.
    wanted = set(FAULTS) - {"judge_failed", "incomplete", "not_configured", "internal", "no_member"}
    if RUNS >= 200 * PARTS:
        assert set(seen) >= wanted, wanted - set(seen)
    assert len(seen) > 10
    assert min(states[name] for name in ("drive", "previous_emergency", "no_safe_trajectory")) > 0


def test_more_reasons_than_there_is_room_for() -> None:
    pair = Pair(evaluator())
    given = cycle(0, 4, 3)
    for table in (given.driving, given.emergency, given.signals["objects"], given.signals["obstacles"]):
        for name in set(table) - {"id"}:
            table[name] = np.full(len(table[name]), np.nan)
    given.signals["objects"] |= {f"misspelt_{n}": 1.0 for n in range(60)}
    decision = pair.step(given, 0.0, 0.01)
    assert decision.more
    assert len(decision.faults) == 64
    assert not pair.step(cycle(1), 0.1, 0.11).more


# The shell -------------------------------------------------------------------------------------------------------


@pytest.mark.verifies("S-1-B-4")
def test_what_never_came_back_from_c_drives_nothing() -> None:
    pair = Pair(evaluator())
    pair.step(cycle(0), 0.0, 0.01)
    made = pair.c.stepper
    assert isinstance(made, Stepper)
    run, made._run = made._run, lambda *_: None
    pair.clocks[0].waiting = [0.1, 0.11]
    decision = pair.c.step(cycle(1))
    assert (decision.safe, decision.driven, decision.fallback, decision.state) == (
        False,
        None,
        None,
        "no_safe_trajectory",
    )
    assert [name_of(f) for f in decision.faults] == ["incomplete"]
    made._run = run
    pair.clocks[0].waiting = [0.2, 0.21]
    assert pair.c.step(cycle(2)).driven is None  # what C has stored is not known here
    pair.clocks[0].waiting = [0.3, 0.31]
    assert pair.c.step(cycle(3)).safe


@pytest.mark.verifies("S-1-B-4")
def test_a_step_never_raises(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = Pair(evaluator())
    pair.step(cycle(0), 0.0, 0.01)
    calls = []

    def failing(*_: Any) -> Any:
        calls.append(1)
        raise MemoryError

    monkeypatch.setattr(pair.c._reader, "read", failing)
    pair.clocks[0].waiting = [0.1]
    decision = pair.c.step(cycle(1))
    assert calls
    assert [name_of(f) for f in decision.faults] == ["internal"]
    assert decision.state == "previous_emergency"


def test_parameters_and_tables_are_put_in_and_checked() -> None:
    spec = spec_with()
    slow = tm.supervisor(spec, backend="c", params={"v_max": 10.0}, clock=lambda: 0.01)
    decision = slow.step(cycle(0))
    assert "speed_limit" in {violation.rule for violation in decision.violations}
    assert decision.violations[0].witness is not None
    with pytest.raises(TrackmarshalError) as caught:
        tm.supervisor(spec, backend="c", params={"b_rear": 9.0, "b_front": 3.0})
    assert caught.value.code == "E403"


@pytest.mark.verifies("S-1-B-1")
def test_a_record_runs_again_the_same_with_either(tmp_path: Path) -> None:
    now = [0.0]
    spec = spec_with()
    made = tm.supervisor(spec, backend="c", clock=lambda: now[0], record=tmp_path / "run.arrows")
    assert isinstance(made, CSupervisor)
    rng = random.Random(12)
    for number in range(60):
        given = cycle(number)
        if number % 5 == 3:
            given = not_finite(rng, given)[0]
        if number == 31:
            given.driving["v"][:] = 100.0
        now[0] = number * PERIOD
        made.step(given)
    made.close()
    assert made.record_error == ""
    run = read((tmp_path / "run.arrows").read_bytes(), "run")
    assert len(run.cycles) == 60
    assert [d for _, found in rerun(run, box_of(run, spec)) for d in found] == []
    with_numpy = [d for _, found in rerun(run, box_of(run, spec, "numpy")) for d in found]
    assert {d.column for d in with_numpy} <= {"violations", "margins.driving", "margins.emergency"}


# In a process of its own -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("compiled_by", ["gcc", "clang"])
def test_under_sanitizers_and_to_the_bit(
    compiled_by: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same runs in a program of their own, under the address and undefined-behaviour sanitizers: the same decisions, bit by bit.

    Limits and parameters are those that tm_init puts in. Every column has memory of its own, and not one byte more. The rules are those of the
    shipped scenarios, whose program the emitted example is, too.
    """
    if shutil.which(compiled_by) is None:
        pytest.skip(f"{compiled_by} is not installed")
    monkeypatch.setattr("trackmarshal.backends.c.supervisor.Stepper", tape.Taped)
    runs: list[tape.Taped] = []
    of_scenarios = Evaluator(tm.load([SUPERVISOR], [NORTHFIELD], REPOSITORY))
    for seed in range(1000, 1000 + max(2, min(200, RUNS // 4))):
        pair = Pair(of_scenarios)
        for given, readings in generated(seed):
            pair.step(given, *readings)
        assert isinstance(pair.c.stepper, tape.Taped)
        runs.append(pair.c.stepper)
    source = runs[0].source
    for name, size in runs[0].sizes.items():
        assert re.search(rf"^#define {name} {size}u$", source.header, re.MULTILINE), (
            "a capacity of the object's own"
        )
    files = tape.files(source)
    made = unit({name: files[name] for name in ("supervisor.c", "supervisor.h")}, "supervisor.c", compiled_by)
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    command = [compiled_by, *EXACT, *SANITIZED, "player.c", str(made), "-o", "player", "-lm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    for place, taped in enumerate(runs):
        (tmp_path / "tape").write_bytes(taped.tape)
        ran = subprocess.run(
            ["./player", "tape", "said"], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        assert (ran.returncode, ran.stderr[:3000]) == (0, ""), place
        assert (tmp_path / "said").read_bytes() == bytes(taped.said), place
