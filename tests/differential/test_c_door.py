"""The door in generated C: what it admits and refuses against a plain reading of the contract, and what a step then says."""

from __future__ import annotations

import copy
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
from trackmarshal.runtime.case import Fault

from support import door_fuzz
from support.ring_cycles import Cycle, breaches, cycle, mutate, ring
from support.shared import SUPERVISOR
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.c.source import generate
from trackmarshal.backends.c.step import Stepper
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.faults import NAMES
from trackmarshal.runtime.verdict import VERDICTS

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

#: TRACKMARSHAL_CYCLES=N mutates N cycles.
CYCLES = int(os.environ.get("TRACKMARSHAL_CYCLES", "4000"))
FUZZ = int(os.environ.get("TRACKMARSHAL_FUZZ", "20000"))


@cache
def spec() -> Spec:
    return load(SUPERVISOR)


@cache
def program() -> CProgram:
    return CProgram(spec(), [rule for rule in spec().rules if rule.formula is not None], doored=True)


def stepper() -> Stepper:
    made = Stepper(program())
    assert made.track("track", ring(94.0), ring(106.0), True) is None
    return made


def run(made: Stepper, c: Cycle) -> Fault | None:
    return made.step(c.number, c.t, c.now, c.driving, c.emergency, c.signals)


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def records(columns: dict[str, Any]) -> list[dict[str, float]]:
    count = len(next(iter(columns.values())))
    return [{name: float(column[i]) for name, column in columns.items()} for i in range(count)]


def test_a_step_says_of_both_candidates_what_the_reference_says() -> None:
    evaluator = Evaluator(spec(), None, "reference")
    made, seen = stepper(), Counter[str]()
    for seed in range(6):
        given = cycle(random.Random(seed), seed, 0.1 * seed)
        if seed % 2:
            given.driving["a"] = given.driving["a"] + 30.0  # too much
            given.emergency["y"] = given.emergency["y"] + np.linspace(0.0, 20.0, 50)  # off the track
        assert run(made, given) is None
        for side, columns in enumerate((given.driving, given.emergency)):
            raw = {
                "plan": {name: column.tolist() for name, column in columns.items()}, "ego": given.signals["ego"],
                "objects": records(given.signals["objects"]), "obstacles": records(given.signals["obstacles"]),
                "track": {"left": ring(94.0), "right": ring(106.0), "closed": True}, "emergency": bool(side),
            }  # fmt: skip
            expected = next(iter(evaluator.evaluate([evaluator.read({"signals": raw})]))).rules
            for index, rule in enumerate(program().rules):
                verdict, margin = VERDICTS[made.verdicts[side, index]], made.margins[side, index]
                assert (verdict, bits(margin)) == (
                    expected[rule.name].verdict,
                    bits(expected[rule.name].margin),
                ), rule.name
                seen[verdict] += 1
    assert min(seen[name] for name in ("satisfied", "violated", "inactive")) >= 3


def test_mutated_cycles_are_refused_for_what_is_wrong_with_them() -> None:
    """No breach passes, nothing else is refused, the reason is one of those that there are; refused: all undefined."""
    made, last, refused = stepper(), None, Counter[str]()
    undefined = VERDICTS.index("undefined")
    for seed in range(CYCLES):
        r = random.Random(seed)
        number = 0 if last is None else last.number + 1
        given = cycle(r, number, 0.0 if last is None else last.t + 0.1)
        if seed % 4:
            mutate(r, given)
        expected = breaches(spec(), given, last)
        fault = run(made, given)
        if fault is None:
            assert not expected, (seed, expected)
            refused["admitted"] += 1
        else:
            got = (NAMES[fault.code], fault.signal, fault.field, fault.index)
            assert got in expected, (seed, got, expected)
            assert (made.verdicts == undefined).all()
            assert np.isnan(made.margins).all()
            refused[got[0]] += 1
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
        ([(0.0, 0.0)], ring(106.0), ("D217", "track", "left", None)),
        (ring(94.0), [(0.0, 0.0), (math.nan, 1.0)], ("D215", "track", "right", 1)),
        (ring(94.0, 3000), ring(106.0), ("D219", "track", "left", 2048)),
    ],
)
def test_without_borders_no_cycle_is_admitted(left: Any, right: Any, expected: tuple[Any, ...]) -> None:
    made = Stepper(program())
    given = cycle(random.Random(1), 0)
    fault = run(made, given)
    assert fault is not None
    assert (fault.code, fault.signal) == ("D211", "track")
    fault = made.track("track", left, right, True)
    assert fault is not None
    assert (fault.code, fault.signal, fault.field, fault.index) == expected
    assert run(made, cycle(random.Random(1), 1, 100.1)) is not None


def test_an_object_that_stands_twice() -> None:
    made, given = stepper(), cycle(random.Random(4), 0)
    given.signals["objects"] = {name: np.resize(c, 2) for name, c in given.signals["objects"].items()} | {
        "id": ["a", "a"]
    }
    fault = run(made, given)
    assert fault is not None
    assert (fault.code, fault.signal, fault.field, fault.index) == ("D218", "objects", "id", 1)


def test_limits_and_capacities_are_the_callers() -> None:
    given = cycle(random.Random(3), 0)
    given.emergency["x"] = given.emergency["x"] + 0.3
    for distance, code in ((0.2, "D228"), (0.4, None)):
        made = Stepper(program(), start_distance=distance)
        made.track("track", ring(94.0), ring(106.0), True)
        fault = run(made, given)
        assert (None if fault is None else fault.code) == code
    tight = Stepper(program(), samples=49)
    tight.track("track", ring(94.0), ring(106.0), True)
    fault = run(tight, given)
    assert fault is not None
    assert (fault.code, fault.signal, fault.index) == ("D219", "driving", 49)


def test_the_two_doors_agree() -> None:
    """The Supervisor's door refuses just the cycles that the generated one does, and knows its reason too."""
    doors = pytest.importorskip("trackmarshal.runtime.door")
    from trackmarshal.runtime.contract import contract_of
    from trackmarshal.runtime.cycle import Cycle as Given
    from trackmarshal.runtime.cycle import Limits
    from trackmarshal.runtime.faults import name_of

    rules = [rule for rule in spec().rules if rule.formula is not None]
    door = doors.Door(contract_of(spec(), rules), Limits())
    track = {"left": np.array(ring(94.0)), "right": np.array(ring(106.0)), "closed": True}
    made, number, t = stepper(), 0, 100.0
    for seed in range(CYCLES):
        r = random.Random(seed)
        given = cycle(r, number, t)
        if seed % 4:
            mutate(r, given)
        fault = run(made, given)
        signals = {**given.signals, "track": track}
        found, _ = door.check(
            Given(given.number, given.t, given.driving, given.emergency, signals), given.now
        )
        reasons = {(name_of(f), f.signal, f.field, f.index) for f in found}
        if fault is None:
            assert not reasons, seed
        else:
            assert (NAMES[fault.code], fault.signal, fault.field, fault.index) in reasons, seed
        if math.isfinite(given.t) and given.t > t - 0.05 and given.t - given.now <= 0.01:
            number, t = given.number, given.t
        number, t = number + 1, t + 0.1


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_no_input_makes_the_door_read_or_compute_what_it_may_not(compiler: str, tmp_path: Path) -> None:
    """Address and undefined-behaviour sanitizers; TRACKMARSHAL_FUZZ=N hands over N mutated cycles."""
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    rules = [rule for rule in spec().rules if rule.formula is not None]
    source = generate(spec(), rules, doored=True)
    for name, text in (
        ("supervisor.h", source.header),
        ("supervisor.c", source.source),
        ("fuzz.c", door_fuzz.driver(spec())),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
    flags = [
        "-std=c99",
        "-O1",
        "-ffp-contract=off",
        "-fsanitize=address,undefined",
        "-fno-sanitize-recover=all",
    ]
    sizes = [f"-DTM_MAX_SAMPLES={door_fuzz.SAMPLES}u", f"-DTM_MAX_ELEMENTS={door_fuzz.ELEMENTS}u"]
    command = [compiler, *flags, *sizes, "supervisor.c", "fuzz.c", "-o", "fuzz", "-lm"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    ran = subprocess.run([str(tmp_path / "fuzz"), str(FUZZ)], capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stderr) == (0, ""), ran.stdout + ran.stderr[:3000]
    assert int(ran.stdout.split()[0]) > FUZZ / 10
