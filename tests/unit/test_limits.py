"""Limits of a Supervisor: declared by the project, changed by name, and named by the fault that asks for larger ones."""

from __future__ import annotations

import dataclasses
import math
import re
from argparse import Namespace
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import cycle, plan
from support.supervised import BACKENDS, ROOT, shipped
from trackmarshal.cli.main import main
from trackmarshal.cli.options import limits_of
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.process.serving import build
from trackmarshal.runtime.cycle import UNITS
from trackmarshal.scenarios.supervised import frames
from trackmarshal.supervision import rulebox

DECLARED = ROOT / "specs" / "supervisor" / "limits.spec"


def configured(tmp_path: Path, text: str) -> Spec:
    path = tmp_path / "planner.spec"
    path.write_text(f"module planner\n{text}\n", encoding="utf-8")
    return tm.load(ROOT / "specs" / "supervisor", [path])


def declared(tmp_path: Path, text: str) -> Spec:
    path = tmp_path / "limits.spec"
    path.write_text(f"module supervisor.limits\n{text}\n", encoding="utf-8")
    return tm.load(path)


def test_every_limit_has_a_unit() -> None:
    assert UNITS.keys() == {field.name for field in dataclasses.fields(tm.Limits)}


def test_the_projects_limits_are_the_default() -> None:
    written = dict(re.findall(r"param (\w+) *: 1 = (\d+)", DECLARED.read_text("utf-8")))
    held = tm.supervisor(shipped()).limits
    assert {name: str(getattr(held, name)) for name in written} == written
    assert held.longest_gap == tm.Limits().longest_gap


def test_a_planner_has_its_own(tmp_path: Path) -> None:
    spec = configured(tmp_path, "param samples : 1 = 300")
    assert tm.supervisor(spec).limits.samples == 300
    assert tm.supervisor(spec, limits={"samples": 7, "apart": 3.0}).limits == tm.Limits(samples=7, apart=3.0)
    assert tm.supervisor(spec, limits=tm.Limits(apart=3.0)).limits == tm.Limits(apart=3.0)  # as it stands


def test_a_process_has_those_of_the_project(tmp_path: Path) -> None:
    """`serve` and `compile --process` begin with what the project declares, as `tm.supervisor` does."""
    spec = configured(tmp_path, "param samples : 1 = 300")
    assert limits_of(Namespace(limit=["apart=3"]), spec) == tm.Limits(samples=300, apart=3.0)
    with pytest.raises(tm.TrackmarshalError, match="there is no limit `sample`"):
        limits_of(Namespace(limit=["sample=3"]), spec)


SLOWER = "param longest_gap : s = 0.3 s"


def test_whoever_waits_longer_for_a_cycle_has_rules_that_look_as_far(tmp_path: Path) -> None:
    """A driving trajectory that is over after 0.25 s was approved where the next decision may come 0.4 s after its stamp."""
    for changed, looks in (("t_next", "t_unseen"), ("t_unseen", "t_next")):
        spec = configured(tmp_path, f"{SLOWER}\nparam {changed} : s = 0.4 s")
        with pytest.raises(
            tm.TrackmarshalError, match=f"oldest \\+ longest_gap <= {looks}` does not hold"
        ) as caught:
            tm.supervisor(spec)
        assert caught.value.code == "E403"
    spec = configured(tmp_path, f"{SLOWER}\nparam t_next : s = 0.4 s\nparam t_unseen : s = 0.4 s")
    assert tm.supervisor(spec).limits == tm.Limits(longest_gap=0.3)


def test_limits_that_are_given_are_held_to_the_constraints_of_those_that_are_declared() -> None:
    spec, seen = shipped(), {"t_next": 0.4, "t_unseen": 0.4}
    with pytest.raises(
        tm.TrackmarshalError, match="oldest \\+ longest_gap <= t_next` does not hold"
    ) as caught:
        tm.supervisor(spec, limits={"longest_gap": 0.3})
    assert (caught.value.code, caught.value.help) == (
        "E403",
        "change the limits, or the parameters with them",
    )
    assert tm.supervisor(spec, limits={"longest_gap": 0.3}, params=seen).limits.longest_gap == 0.3
    with pytest.raises(tm.TrackmarshalError, match="does not hold"):
        tm.supervisor(spec, limits={"longest_gap": 0.3, "oldest": 0.2}, params=seen)
    with pytest.raises(tm.TrackmarshalError, match="does not hold"):
        limits_of(Namespace(limit=["longest_gap=0.3"]), spec)
    assert limits_of(Namespace(limit=["longest_gap=0.1"]), spec).longest_gap == 0.1


def test_the_help_names_what_would_be_taken() -> None:
    """Of a capacity it said that `inf` takes it away, also where that had been given; and of a number of numpy's, that it is to be a number."""
    samples: list[Any] = [math.inf, np.int64(100)]
    for one in samples:
        with pytest.raises(tm.TrackmarshalError, match="the limit `samples` is") as caught:
            tm.Limits(samples=one)
        assert caught.value.help == "it is a whole number (int), from 2 to 2147483647"
    for one in (-1.0, np.float64(0.1)):
        with pytest.raises(tm.TrackmarshalError, match="the limit `budget` is") as caught:
            tm.Limits(budget=one)
        assert caught.value.help == "it is a number (int or float), at least 0; inf takes the limit away"
    assert tm.Limits(budget=math.inf).budget == math.inf


@BACKENDS
def test_a_parameter_that_declares_a_limit_is_that_limit_where_it_is_given_too(backend: str) -> None:
    """`params` were taken, and the limits stayed as the project declares them: stamps 0.15 s apart were let pass where 0.05 s was asked for."""
    wide = {"longest_gap": 0.3, "t_next": 0.4, "t_unseen": 0.4}
    for params, held in (
        ({"longest_gap": 0.05, "samples": 300.0}, tm.Limits(longest_gap=0.05, samples=300)),
        (wide, tm.Limits(longest_gap=0.3)),
    ):
        assert tm.supervisor(shipped(), ["friction"], backend=backend, params=params).limits == held
    given = {"limits": {"longest_gap": 0.3}, "params": wide}
    assert tm.supervisor(shipped(), ["friction"], backend=backend, **given).limits.longest_gap == 0.3  # type: ignore[arg-type]
    with pytest.raises(
        tm.TrackmarshalError, match=r"`longest_gap` is 0\.2, and 0\.3 by the parameter"
    ) as caught:
        tm.supervisor(shipped(), backend=backend, limits={"longest_gap": 0.2}, params=wide)
    assert caught.value.code == "E481"
    with pytest.raises(tm.TrackmarshalError, match=r"the limit `samples` is 2\.5"):
        tm.supervisor(shipped(), backend=backend, params={"samples": 2.5})


def test_a_process_has_them_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("trackmarshal.process.serving.program", lambda *given: Path("not compiled"))
    box = rulebox(Evaluator(shipped(), ["friction"], "c"), {"longest_gap": 0.05})
    said = build(shipped(), box.evaluator.rules, settings=box.settings).layout.said
    assert said["limits"]["longest_gap"] == 0.05


@pytest.mark.parametrize(("most", "decided"), [(10, "no_safe_trajectory"), (500, "drive")])
def test_so_has_a_recording_that_gives_them(most: int, decided: str) -> None:
    """Its `samples` was listed as an override, and its cycles were held to those of the spec."""
    made = tm.load_recording(ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl")
    given = replace(made, params={**made.params, "samples": most}, cycles=made.cycles[:2])
    evaluator = tm.Evaluator(shipped(), ["friction"])
    assert [one.decision for one in tm.replay(given, evaluator).cycles] == [decided] * 2
    assert {bool(frame.faults) for frame in frames(given, evaluator, {})} == {most == 10}


@BACKENDS
@pytest.mark.parametrize("name", ["longest_gap", "oldest"])
def test_nor_is_one_that_rules_count_on_taken_away_by_name(name: str, backend: str) -> None:
    """`Limits.open_loop` is for who replays a run; by name, and on the command line, it is of a Supervisor that drives along."""
    with pytest.raises(tm.TrackmarshalError, match="does not hold") as caught:
        tm.supervisor(shipped(), backend=backend, limits={name: math.inf})
    assert caught.value.code == "E403"
    with pytest.raises(tm.TrackmarshalError, match="does not hold"):
        limits_of(Namespace(limit=[f"{name}=inf"]), shipped())


@BACKENDS
def test_so_are_limits_that_stand_for_all_of_them(backend: str) -> None:
    """`tm.Limits(...)` was taken as it stands; what has no limit is no car's, and says so."""
    spec, seen = shipped(), {"t_next": 0.4, "t_unseen": 0.4}
    with pytest.raises(tm.TrackmarshalError, match="longest_gap <= t_next` does not hold") as caught:
        tm.supervisor(spec, backend=backend, limits=tm.Limits(longest_gap=0.3))
    assert caught.value.code == "E403"
    for limits, params in (
        (tm.Limits(longest_gap=0.3), seen), (tm.Limits(oldest=0.05, longest_gap=0.2), {}), (tm.Limits.open_loop(spec), {}),
    ):  # fmt: skip
        assert tm.supervisor(spec, backend=backend, limits=limits, params=params).limits == limits


def test_other_limits_are_declared_with_their_units(tmp_path: Path) -> None:
    spec = declared(tmp_path, "param longest_gap : ms = 250 ms\nparam turned : deg = 10 deg")
    assert tm.Limits.of(spec) == tm.Limits(longest_gap=0.25, turned=math.radians(10.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("param sample : 1 = 200", "`sample` is no limit"),
        ("param samples : 1 = 1.5", "the limit `samples` is 1.5"),
        ("param samples : 1 = 1", "the limit `samples` is 1"),
        ("param border : 1 = 3e9", "the limit `border` is 3e\\+09"),
        ("param apart : s = 1 s", "the limit `apart` is in s, not in m"),
    ],
)
def test_what_is_no_limit_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(tm.TrackmarshalError, match=message) as caught:
        tm.Limits.of(declared(tmp_path, text))
    assert (caught.value.code, caught.value.line) == ("E485", 2)
    assert caught.value.help


def test_check_says_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    declared(tmp_path, "param sample : 1 = 200")
    assert main(["check", str(tmp_path / "limits.spec")]) == 2
    said = capsys.readouterr().err
    assert "error[E485]: `sample` is no limit of a Supervisor" in said
    assert "did you mean `samples`?" in said


def test_a_misspelt_change_is_refused() -> None:
    with pytest.raises(tm.TrackmarshalError, match="no limit `sample`") as caught:
        tm.supervisor(shipped(), limits={"sample": 200})
    assert (caught.value.code, caught.value.help) == ("E481", "did you mean `samples`?")


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_the_fault_says_which_limit_to_raise_and_to_what(backend: str) -> None:
    """And raised to that, the same cycle is taken."""
    long = replace(cycle(0), driving=plan(0.0, 0.0, samples=135))

    def faults(samples: int) -> list[str]:
        changes = {"samples": samples, "budget": math.inf}
        made = tm.supervisor(shipped(), ["speed_limit"], backend, changes, lambda: 0.0)
        return [fault.message for fault in made.step(long).faults]

    (message,) = faults(100)
    assert message == "135 samples, room for 100: raise the limit `samples` to 135"
    assert faults(int(message.rpartition(" ")[2])) == []


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_a_set_is_held_to_the_limit_where_another_one_declares_a_capacity(backend: str) -> None:
    """`objects` declare `capacity 32`: generated C, which has room for as many of each set, took as many obstacles."""
    changes = {"elements": 3, "budget": math.inf}

    def faults(obstacles: int) -> list[str]:
        made = tm.supervisor(shipped(), ["obstacle_collision"], backend, changes, lambda: 0.0)
        return [fault.message for fault in made.step(cycle(0, 4, obstacles)).faults]

    assert [faults(count) for count in (2, 3)] == [[], []]
    for count in (4, 5):
        assert faults(count) == [f"{count} elements, room for 3: raise the limit `elements` to {count}"]


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_a_real_plan_of_115_samples_passes_by_default(backend: str) -> None:
    made = tm.supervisor(shipped(), ["speed_limit"], backend, {"budget": math.inf}, lambda: 0.0)
    assert made.step(replace(cycle(0), driving=plan(0.0, 0.0, samples=115))).faults == ()


def test_generated_c_has_the_projects_limits(tmp_path: Path) -> None:
    from trackmarshal.backends.c.source import generate

    spec = configured(tmp_path, "param samples : 1 = 300")
    header = generate(spec, tm.Evaluator(spec).rules, doored=True).header
    assert "#define TM_MAX_SAMPLES 300u" in header
    assert "#define TM_MAX_BORDER 2048u" in header
