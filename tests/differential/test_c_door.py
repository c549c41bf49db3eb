"""The door in generated C: what it admits and refuses against a plain reading of the contract, and what a step then says."""

from __future__ import annotations

import contextlib
import copy
import ctypes
import math
import os
import random
import shutil
import struct
import subprocess
from collections import Counter
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support import door_fuzz
from support.cycles import PERIOD
from support.cycles import cycle as straight
from support.ring_cycles import Cycle, breaches, cycle, mutate, ring
from support.sanitized import FLAGS as SANITIZED
from support.si_cycles import Driver, program
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.source import Source
from trackmarshal.backends.c.step import Stepper
from trackmarshal.backends.c.supervisor import CSupervisor
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import FieldType, SignalType, Spec
from trackmarshal.runtime.contract import KINDS, Kind
from trackmarshal.runtime.contract.conditions import Condition
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.runtime.verdict import VERDICTS

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

#: TRACKMARSHAL_CYCLES=N mutates N cycles.
CYCLES = int(os.environ.get("TRACKMARSHAL_CYCLES", "400"))
FUZZ = int(os.environ.get("TRACKMARSHAL_FUZZ", "800"))
TRACK = {"left": np.array(ring(94.0)), "right": np.array(ring(106.0)), "closed": True}


@cache
def spec() -> Spec:
    return shipped()


@cache
def source() -> Source:
    return program(spec())


class Step:
    """A Supervisor in C that reads each cycle's own clock."""

    def __init__(self, **limits: Any) -> None:
        self._now = 0.0
        rules = [rule for rule in spec().rules if rule.formula is not None]
        self.made = CSupervisor(spec(), rules, Limits(**limits), lambda: self._now)

    def __call__(self, given: Cycle) -> Decision:
        self._now = given.now
        signals = {"track": TRACK, **given.signals}
        return self.made.step(tm.Cycle(given.number, given.t, given.driving, given.emergency, signals))


def places(decision: Decision) -> set[tuple[str, str, str, int | None]]:
    return {(name_of(f), f.signal, f.field, f.index) for f in decision.faults}


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def records(columns: dict[str, Any]) -> list[dict[str, float]]:
    count = len(next(iter(columns.values())))
    return [{name: float(column[i]) for name, column in columns.items()} for i in range(count)]


@pytest.mark.parametrize("count", [2, 7, 8, 9, 15, 16, 17, 25])
def test_the_first_breach_of_a_column_is_named_wherever_it_is(count: int) -> None:
    """Entries are looked at in blocks: neither where one begins, nor how many are left over, hides any."""
    run, number = Step(), 0
    for place in range(count):
        for value, fault in ((math.nan, "not_finite"), (-math.inf, "not_finite"), (1.5, "out_of_range"), (-1.5, "out_of_range")):  # fmt: skip
            for more in {place, (place + count) // 2, count - 1}:
                number += 1
                given = cycle(random.Random(count), number, 0.1 * number)
                given.driving = {name: column[:count].copy() for name, column in given.driving.items()}
                given.driving["kappa"][[place, more]] = value
                said = {one for one in places(run(given)) if one[1:3] == ("driving", "kappa")}
                assert said == {(fault, "driving", "kappa", place)}, (place, value, more)


@pytest.mark.verifies("S-1-B-1", "S-1-B-5")
def test_a_step_says_of_both_candidates_what_the_reference_says() -> None:
    evaluator = Evaluator(spec(), None, "reference")
    run, seen = Step(), Counter[str]()
    for seed in range(6):
        given = cycle(random.Random(seed), seed, 0.1 * seed)
        if seed % 2:
            given.driving["a"] = given.driving["a"] + 30.0  # too much
            given.emergency["y"] = given.emergency["y"] + np.linspace(0.0, 20.0, 50)  # off the track
        judged = run(given).judged
        assert judged is not None
        for side, columns in (("driving", given.driving), ("emergency", given.emergency)):
            raw = {
                "plan": {name: column.tolist() for name, column in columns.items()}, "ego": given.signals["ego"],
                "objects": records(given.signals["objects"]), "obstacles": records(given.signals["obstacles"]),
                "track": {"left": ring(94.0), "right": ring(106.0), "closed": True}, "emergency": side == "emergency",
            }  # fmt: skip
            expected = next(iter(evaluator.evaluate([evaluator.read({"signals": raw})]))).rules
            rated = judged.rated[side]
            for rule, code, margin in zip(source().rules, rated.verdicts, rated.margins):
                wanted = expected[rule.rule.name]
                assert (VERDICTS[code], bits(margin)) == (wanted.verdict, bits(wanted.margin)), rule.rule.name
                seen[wanted.verdict] += 1
    assert min(seen[name] for name in ("satisfied", "violated", "inactive")) >= 3


@pytest.mark.verifies("S-1-B-1", "S-1-B-9")
def test_mutated_cycles_are_refused_for_what_is_wrong_with_them() -> None:
    """No breach passes, nothing else is refused, and every reason is one that there is."""
    run, last, refused = Step(oldest=0.1), None, Counter[str]()
    for seed in range(CYCLES):
        r = random.Random(seed)
        number = 0 if last is None else last.number + 1
        given = cycle(r, number, 0.0 if last is None else last.t + 0.1)
        if seed % 4:
            mutate(r, given)
        if not math.isfinite(given.t) or given.now < (-math.inf if last is None else last.now):
            given.now = 0.0 if last is None else last.now  # clocks that are wrong are another matter
        expected = breaches(spec(), given, last)
        decision = run(given)
        found = places(decision)
        assert (decision.judged is None) == bool(expected) == bool(found), (seed, found, expected)
        assert found <= expected, (seed, found - expected)
        refused.update(name for name, *_ in found)
        refused["admitted"] += not found
        if last is not None and given.now > last.now:
            last.now = given.now
        if (
            math.isfinite(given.t)
            and (last is None or given.t > last.t + 1e-3)
            and given.t - given.now <= 0.01
        ):
            last = copy.copy(given)
    assert refused["admitted"] > CYCLES / 10
    assert set(refused) >= {"missing", "not_finite", "out_of_range", "not_increasing", "over_capacity", "wrong_length", "too_short",
                            "starts_elsewhere", "not_at_rest", "wrong_type", "late", "skipped", "stale", "early"}  # fmt: skip


@pytest.mark.parametrize(
    ("left", "right", "expected"),
    [
        ([(0.0, 0.0)], ring(106.0), ("bad_border", "track", "left", None)),
        (ring(94.0), [(0.0, 0.0), (math.nan, 1.0)], ("not_finite", "track", "right", 1)),
        (ring(94.0, 3000), ring(106.0), ("over_capacity", "track", "left", 2048)),
    ],
)
def test_borders(left: Any, right: Any, expected: tuple[Any, ...]) -> None:
    run = Step()
    for number in range(2):  # what did not pass once does not pass again
        given = cycle(random.Random(1), number, 0.1 * number)
        given.signals["track"] = {"left": left, "right": right, "closed": True}
        assert places(run(given)) == {expected}
    assert run(cycle(random.Random(1), 2, 0.2)).judged is not None


def test_limits_and_capacities_are_the_callers() -> None:
    given = cycle(random.Random(3), 0)
    given.emergency["x"] = given.emergency["x"] + 0.3
    for distance, found in ((0.2, {("starts_elsewhere", "emergency", "x", 0)}), (0.4, set())):
        assert places(Step(start_distance=distance)(given)) == found
    assert ("over_capacity", "driving", "", 49) in places(Step(samples=49)(given))


def test_a_kind_that_is_added_is_checked(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither door lists kinds: a new one of each sort is known to both at once, in the same order."""

    def jumping(info: FieldType | SignalType) -> Any:
        return (
            (("most", 99.0),)
            if isinstance(info, FieldType) and info.name == "x" and info.kind == "number"
            else None
        )

    def even(info: FieldType | SignalType) -> Any:
        return () if isinstance(info, SignalType) and info.many else None

    def far(info: FieldType | SignalType) -> Any:
        return (("most", 5000.0),) if isinstance(info, FieldType) and info.kind == "polyline" else None

    added = [
        Kind("early", "step", Condition("fabs(x - before) <= most"), jumping),
        Kind("late", "value", Condition("x != 7.5"), jumping),
        Kind("stale", "count", Condition("n != 3"), even),
        Kind("skipped", "point", Condition("fabs(x) <= most"), far),
    ]
    monkeypatch.setattr("trackmarshal.runtime.contract.checks.KINDS", [*KINDS, *added])
    monkeypatch.setattr("trackmarshal.backends.c.source._MADE", {})  # nothing was generated with these yet
    now = [0.0]
    found = []
    for backend in ("c", "numpy"):
        made = tm.supervisor(spec(), backend=backend, clock=lambda: now[0])
        said = []
        for number in range(6):
            given = straight(number, 2 if number != 3 else 3)
            if number == 1:
                given.driving["x"][[4, 5]] = 900.0, 7.5
            if number == 2:
                given.signals["ego"]["x"] = 7.5
            if number == 4:
                given.signals["track"]["left"] = given.signals["track"]["left"] + [[9000.0, 0.0]]
            now[0] = number * PERIOD
            said.append([(name_of(f), f.signal, f.field, f.index) for f in made.step(given).faults])
        found.append(said)
    assert found[0] == found[1]
    assert found[0] == [
        [], [("early", "driving", "x", 4), ("late", "driving", "x", 5)], [("late", "ego", "x", None)], [("stale", "objects", "", None)],
        [("skipped", "track", "left", 0)], [],
    ]  # fmt: skip


# What is put into a context ----------------------------------------------------------------------------------------


def refused(**given: Any) -> str:
    with pytest.raises(TrackmarshalError) as caught:
        Stepper(source(), {**_limits(), **given.pop("limits", {})}, lambda: 0.0, **given)
    assert caught.value.code == "E473"
    return str(caught.value)


def _limits() -> dict[str, float]:
    from support.si_cycles import LIMITS

    return dict(LIMITS)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"limits": {"budget": -1.0}}, "limit `budget`"),
        ({"limits": {"apart": math.nan}}, "limit `apart`"),
        ({"params": {"vehicles.devbot.mass": 1.0}}, "parameter `vehicles.devbot.mass`"),
        ({"params": {"vehicles.devbot.mass": math.nan}}, "parameter `vehicles.devbot.mass`"),
        ({"params": {"supervisor.collision.b_rear": 40.0}}, "constraint `specs/supervisor/collision.spec:"),
        ({"tables": {"vehicles.devbot.ax_max": ((1.0, 1.0), (2.0, 3.0))}}, "table `vehicles.devbot.ax_max`"),
        ({"tables": {"vehicles.devbot.ax_max": ((), ())}}, "table `vehicles.devbot.ax_max`"),
        (
            {"tables": {"vehicles.devbot.ax_max": ((1.0, 2.0), (2.0, math.inf))}},
            "table `vehicles.devbot.ax_max`",
        ),
    ],
)
def test_what_cannot_stand_is_refused_by_name(given: dict[str, Any], said: str) -> None:
    assert said in refused(**given)


class Unasked(Stepper):
    """Does not mind that a configuration is refused."""

    def _configure(self, *given: Any) -> None:
        with contextlib.suppress(TrackmarshalError):
            super()._configure(*given)


def test_a_context_that_is_not_configured_admits_no_cycle() -> None:
    driver = Driver(source(), Unasked, budget=-1.0)
    said = driver.step(straight(0), 0.0)
    assert (said.safe, said.driven, said.judged) == (0, 0, 0)
    assert [r.name for r in driver.made.reasons(said)] == ["not_configured", "none_stored"]


def test_what_is_stored_is_driven_when_a_new_configuration_is_refused() -> None:
    driver = Driver(source())
    assert driver.step(straight(0), 0.0).safe
    with pytest.raises(TrackmarshalError):
        driver.made._configure({**_limits(), "blind": math.nan}, {}, {})
    said = driver.step(straight(1), PERIOD)
    assert (said.safe, said.driven, said.driven_number) == (0, 2, 0)
    driver.made._configure(_limits(), {}, {})
    assert driver.step(straight(2), 2 * PERIOD).safe


def test_all_that_a_step_says_is_about_it() -> None:
    """To whoever reads the decision in C: not a word of it is left of the step before, and reasons are no more than there are."""
    driver = Driver(source(), budget=0.5, blind=2.0)
    driver.took = 0.5  # and no more than that
    said = driver.step(straight(7), 0.7)
    assert (said.safe, said.first, said.stored_number, said.stored_t) == (1, 0, 7, straight(7).t)
    assert (said.lost, said.fault_count, said.reason_count) == (0, 0, 0)
    said = driver.step(None, 1.25)
    assert (said.safe, said.driven, said.stored, said.stored_number, said.lost) == (0, 2, 1, 7, 0)
    assert (said.fault_count, [r.name for r in driver.made.reasons(said)]) == (1, ["missing_cycle"])
    said = driver.step(None, math.inf)
    assert (said.driven, next(r.name for r in driver.made.reasons(said))) == (0, "bad_clock")
    said = driver.step(None, 9.0)  # no infinite time has passed
    assert (said.stored, said.stored_number, driver.made.lost(said)) == (0, 0, "none_stored")
    assert math.isnan(said.stored_t)
    assert (said.now, said.fault_count) == (9.0, 1)
    assert [r.name for r in driver.made.reasons(said)] == ["missing_cycle", "none_stored"]


@pytest.mark.verifies("S-1-B-4")
@pytest.mark.parametrize("byte", [0, 0xFF, 0x5A])
def test_a_context_that_was_never_made_drives_nothing(byte: int) -> None:
    driver = Driver(source())
    ctypes.memset(driver.made.context, byte, driver.made._dll.tmg_size())
    for number in range(3):
        said = driver.step(straight(number), number * PERIOD)
        assert (said.serial, said.safe, said.driven, said.stored) == (0, 0, 0, 0)
        assert [r.name for r in driver.made.reasons(said)] == ["not_configured"]


@pytest.mark.parametrize("made_by", ["gcc", "clang"])
def test_no_input_makes_the_door_read_or_compute_what_it_may_not(made_by: str, tmp_path: Path) -> None:
    """Address and undefined-behaviour sanitizers; TRACKMARSHAL_FUZZ=N hands over N mutated cycles."""
    if shutil.which(made_by) is None:
        pytest.skip(f"{made_by} is not installed")
    for name, text in (
        ("supervisor.h", source().header),
        ("supervisor.c", source().source),
        ("fuzz.c", door_fuzz.driver(spec())),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
    flags = ["-std=c99", "-ffp-contract=off", *SANITIZED]
    sizes = {"MAX_SAMPLES": door_fuzz.SAMPLES, "LIMIT_ELEMENTS": door_fuzz.ELEMENTS, "MAX_BORDER": door_fuzz.BORDER}  # fmt: skip
    macros = [f"-DTM_{name}={size}u" for name, size in sizes.items()]
    command = [made_by, *flags, *macros, "supervisor.c", "fuzz.c", "-o", "fuzz", "-lm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    ran = subprocess.run([str(tmp_path / "fuzz"), str(FUZZ)], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, ""), ran.stdout + ran.stderr[:3000]
    assert int(ran.stdout.split()[0]) > FUZZ / 10
