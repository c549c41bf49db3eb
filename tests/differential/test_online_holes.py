"""Ways in which a run went wrong once, each with every backend: what came before, in this run or in another, said too much of a cycle."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.faults import name_of

C = pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
BACKENDS = pytest.mark.parametrize("backend", ["reference", "numpy", C])
SAVING = pytest.mark.parametrize("backend", ["numpy", C])
PLAIN = """
module holes
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }

rule speed "Speed"
  for all p in plan
  require p.v <= 60 m/s
"""
REMEMBERS = """
module holes
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { v: m/s }
course driven = ego for 1 s then plan

rule never_fast "Whoever was fast in the last ten seconds is unwelcome"
  for all o in objects
  require historically[0 s, 10 s] o.v <= 10 m/s

rule slow "Slow, then and now"
  along driven as c
  require historically[0 s, 1 s] c.v <= 20 m/s
"""


@cache
def spec(text: str) -> Spec:
    return tm.loads(text)


def plan(**others: Any) -> dict[str, Any]:
    return {
        "t": [0.0, 1.0], "x": [0.0, 1.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [1.0, 0.0], **others,
    }  # fmt: skip


def cycle(number: int, t: Any, given: dict[str, Any] | None = None, **signals: Any) -> tm.Cycle:
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 1.0}
    return tm.Cycle(number, t, given or plan(), given or plan(), {"ego": ego, **signals})


class Run:
    def __init__(self, backend: str, text: str = PLAIN, **limits: Any) -> None:
        self.now = 0.0
        held = {"budget": 1e9, **limits}
        self.supervisor = tm.supervisor(spec(text), backend=backend, limits=held, clock=lambda: self.now)

    def step(self, given: tm.Cycle | None, now: float | None = None) -> Any:
        self.now = now if now is not None or given is None else given.t  # type: ignore[assignment]
        return self.supervisor.step(given)


def names(decision: Any) -> list[tuple[str, str, str]]:
    return [(name_of(f), f.signal, f.field) for f in decision.faults]


def cars(**speeds: float) -> dict[str, Any]:
    return {"id": list(speeds), "v": list(speeds.values())}


@SAVING
def test_a_supervisor_that_goes_on_from_elsewhere_forgets_who_was_who(backend: str) -> None:
    """Elements are known again by their ids: those of the run that is gone on with, not of the one before."""
    run, other = Run(backend, REMEMBERS), Run(backend, REMEMBERS)
    assert run.step(cycle(0, 0.0, objects=cars(b=1.0))).safe
    assert not run.step(cycle(1, 0.1, objects=cars(a=20.0, b=1.0))).safe
    for number in (0, 1):
        assert other.step(cycle(number, 0.1 * number, objects=cars(a=1.0))).safe
    other.supervisor.restore(run.supervisor.save())
    for one in (run, other):
        decision = one.step(cycle(2, 0.2, objects=cars(a=1.0)))
        assert not decision.safe
        assert {each.verdict for each in decision.violations} == {"violated"}


@BACKENDS
@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("ahead", [5.0, 1e300])
def test_a_stamp_of_the_future_while_the_clock_is_wrong(backend: str, first: int, ahead: float) -> None:
    """It costs its own cycle and the next: the ones after it are not held to be of the past."""
    run = Run(backend)
    for number in range(first):
        assert run.step(cycle(number, 0.1 * number)).safe
    decision = run.step(cycle(first, ahead), math.nan)
    assert {("bad_clock", "clock", ""), ("early", "cycle", "t")} <= set(names(decision))
    run.step(cycle(first + 1, 0.1 * (first + 1)))
    decision = run.step(cycle(first + 2, 0.1 * (first + 2)))
    assert decision.safe, decision.reasons


@BACKENDS
def test_a_stamp_in_time_while_the_clock_is_wrong(backend: str) -> None:
    run = Run(backend)
    assert run.step(cycle(0, 0.0)).safe
    assert names(run.step(cycle(1, 0.1), math.nan)) == [("bad_clock", "clock", "")]
    assert run.step(cycle(2, 0.2)).safe


@BACKENDS
@pytest.mark.parametrize("name", ["a\0b", "\ud800"])
@pytest.mark.parametrize("where", ["signals", "objects"])
def test_a_name_that_no_text_of_c_has(backend: str, name: str, where: str) -> None:
    """It is unknown as any other is: number and stamp of the cycle are remembered, so the next one is good."""
    run = Run(backend, REMEMBERS)
    assert run.step(cycle(0, 0.0, objects=cars(a=1.0))).safe
    others: dict[str, Any] = {"objects": {**cars(a=1.0), name: [1.0]}} if where == "objects" else {name: 1.0}
    decision = run.step(cycle(1, 0.1, **{"objects": cars(a=1.0), **others}))
    assert [each[:2] for each in names(decision)] == [("unknown", where)]
    for reason in (*decision.reasons, names(decision)[0][2]):
        assert "\0" not in reason
        assert reason.encode("utf-8")
    assert names(run.step(cycle(2, 0.2, objects=cars(a=1.0)))) == []


@BACKENDS
def test_headings_too_far_apart_to_be_subtracted(backend: str) -> None:
    """Where the stored trajectory leads, nobody can say: the car is not on it, and the state machine still works."""
    run = Run(backend)
    assert run.step(cycle(0, 0.0, plan(heading=[1.7e308, -1.7e308]))).safe
    decision = run.step(cycle(1, 0.1, plan(v=[70.0, 0.0])))
    assert (decision.state, decision.lost, names(decision)) == ("no_safe_trajectory", "apart", [])


@BACKENDS
def test_a_trajectory_that_ends_beyond_all_numbers(backend: str) -> None:
    """Also where the caller has numpy raise what overflows."""
    with np.errstate(all="raise"):
        run = Run(backend)
        assert run.step(cycle(0, 1e308, plan(t=[0.0, 1.7e308]))).safe
        decision = run.step(None, 1e308)
    assert (decision.state, names(decision)) == ("previous_emergency", [("missing_cycle", "cycle", "")])


@BACKENDS
@pytest.mark.parametrize("far", [1e300, 1.7e308])
def test_a_plan_that_nobody_can_count_to_the_end(backend: str, far: float) -> None:
    """Nothing is known of the course that it ends; the other rules are judged, and go on remembering."""
    run = Run(backend, REMEMBERS)
    assert run.step(cycle(0, 0.0, objects=cars(a=1.0))).safe
    decision = run.step(cycle(1, 0.1, plan(t=[0.0, far]), objects=cars(a=1.0)))
    assert names(decision) == []
    assert {(one.rule, one.verdict) for one in decision.violations} == {("slow", "undefined")}
    after = run.step(cycle(2, 0.2, objects=cars(a=1.0)))
    assert after.safe, after.reasons


@BACKENDS
@pytest.mark.parametrize("begin", [4.1e9, -4.1e9, 1e15])
def test_stamps_that_are_no_nanoseconds_of_any_run(backend: str, begin: float) -> None:
    """No evaluator judges rules that remember at such a time, where another one could not; those that do not remember are judged."""
    remembering = Run(backend, REMEMBERS)
    for number in range(2):
        decision = remembering.step(cycle(number, begin + 10.0 * number, objects=cars(a=1.0)))
        assert (decision.safe, decision.state) == (False, "no_emergency_yet")
    assert Run(backend).step(cycle(0, begin)).safe


@BACKENDS
def test_the_farthest_stamps_of_a_run(backend: str) -> None:
    run = Run(backend, REMEMBERS, longest_gap=math.inf)
    for number, t in enumerate((-3.9e9, -3.9e9 + 0.5, 3.9e9, 3.9e9 + 0.5)):
        decision = run.step(cycle(number, t, objects=cars(a=1.0)))
        assert decision.safe, decision.reasons


@BACKENDS
@pytest.mark.parametrize("begin", [0.0, 1.0, 1e6])
@pytest.mark.parametrize("later", [2e-10, 4e-10, 7e-10])
def test_two_stamps_within_a_nanosecond(backend: str, begin: float, later: float) -> None:
    """Where a limit lets them come so close, rules that remember see one cycle and a gap, with every evaluator; the others see two."""
    stamps = [begin, max(begin + later, math.nextafter(begin, math.inf)), begin + 0.1, begin + 0.2]
    run, plain = (Run(backend, text, shortest_gap=0.0) for text in (REMEMBERS, PLAIN))
    found = [run.step(cycle(number, t, objects=cars(a=1.0))) for number, t in enumerate(stamps)]
    assert [names(each) for each in found] == [[], [("repeated", "cycle", "t")], [], []]
    assert [each.safe for each in found[:2]] == [True, False]
    assert {each.verdict for each in found[2].violations} == {"undefined"}
    assert all(plain.step(cycle(number, t)).safe for number, t in enumerate(stamps))
