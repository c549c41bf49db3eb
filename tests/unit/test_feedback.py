"""What a decision tells a planner: which candidate, which rule, where, by how much; and of what is undefined, which input, where."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import SPEED, cycle
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.decision import Decision

SPEC = """
module told
use prelude.frames
signal plan : trajectory { t: s increasing, s: m, x: m, y: m, heading: rad, kappa: 1/m, v: m/s, a: m/s^2, wet: bool default true }
signal ego : state { x: m, y: m, heading: rad, v: m/s, age: s default 0 s, wet: bool default true }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m, age: s default 0 s }
signal track : corridor { left: polyline, right: polyline }
course way = ego for 1 s then plan
param limit : m/s = 30 m/s
rule slow "Not too fast"
  satisfies S-1-A-4
  for all p in plan
  require p.v <= limit
rule steady "Speeds change no faster than the way goes on"
  for all consecutive p, q in plan
  require (q.v - p.v) / (q.s - p.s) <= 5 1/s
rule gap "Nobody is near"
  for all o in objects
  require distance(o, ego) >= 10 m
rule end "The end is slow"
  require plan.last.v <= 25 m/s
rule on_path "The car is on the path"
  require abs(offset(ego, plan)) <= 2 m
rule somewhere "Some sample is far ahead"
  exists p in plan where p.x >= 1e6 m
  require p.v >= 0 m/s
rule dry "It does not rain"
  require not ego.wet
rule was_dry "It has not rained"
  require not once ego.wet
rule dry_so_far "It has not rained, and will not"
  along way as w
  require not w.wet
"""
BACKENDS = ("numpy", "reference", "c")


@pytest.fixture(scope="module")
def spec() -> Spec:
    return tm.loads(SPEC)


def decide(spec: Spec, backend: str, rules: list[str], **changed: Any) -> Decision:
    """The first cycle under some rules; `driving_v` and so on change a column, other names a signal."""
    given = cycle(0)
    signals = {name: given.signals[name] for name in ("ego", "objects", "track")}
    driving = {name: np.array(column) for name, column in given.driving.items()}
    for name, value in changed.items():
        if name.startswith("driving_"):
            driving[name.removeprefix("driving_")] = value
        else:
            signals[name] = value
    limits = tm.Limits(budget=math.inf)
    made = tm.supervisor(spec, rules, backend, limits=limits, clock=lambda: 0.0)
    return made.step(replace(given, driving=driving, signals=signals))


def only(decision: Decision) -> dict[str, Any]:
    """The one rule that is told of; all of it is strict JSON."""
    told = json.loads(json.dumps(decision.feedback, allow_nan=False))
    (entry,) = [entry for entry in told if entry["kind"] == "rule"]
    return dict(entry)


@pytest.mark.parametrize("backend", BACKENDS)
def test_which_rule_where_and_by_how_much(spec: Spec, backend: str) -> None:
    v = np.full(30, SPEED)
    v[17] = 33.5
    decision = decide(spec, backend, ["slow"], driving_v=v)
    told = only(decision)
    assert (told["candidate"], told["rule"], told["requirements"]) == ("driving", "slow", ["S-1-A-4"])
    assert (told["verdict"], told["margin"], told["by"], told["unit"]) == ("violated", -3.5, 3.5, "m/s")
    given = cycle(0).driving
    where = {name: float(given[name][17]) for name in ("t", "s", "x", "y")}
    assert told["where"] == pytest.approx({"sample": 17, **where, "v": 33.5})
    assert told["at"] == {"p": 17}
    assert told["decided_by"].startswith("<text>:")
    assert (told["object"], told["reason"]) == (None, "")


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_stretch_an_object_and_the_last_sample(spec: Spec, backend: str) -> None:
    v = np.full(30, SPEED)
    v[17:] = 35.0
    stretch = only(decide(spec, backend, ["steady"], driving_v=v))["where"]
    assert (stretch["sample"], stretch["to"]) == (16, 17)
    last = only(decide(spec, backend, ["end"], driving_v=v))
    assert (last["where"]["sample"], last["by"]) == (29, 10.0)
    objects = {**cycle(0).signals["objects"], "x": np.array([400.0, 4.0]), "y": np.array([0.0, 3.0])}
    told = [
        entry for entry in decide(spec, backend, ["gap"], objects=objects).feedback if entry["kind"] == "rule"
    ]
    assert [entry["object"] for entry in told] == [{"signal": "objects", "id": "o1"}] * 2
    assert told[0]["by"] == 5.0
    assert told[0]["where"] is None


@pytest.mark.parametrize("backend", BACKENDS)
def test_undefined_says_which_input_and_where(spec: Spec, backend: str) -> None:
    s = cycle(0).driving["s"].copy()
    s[9:] -= s[9] - s[8]  # two samples at one station
    decision = decide(spec, backend, ["steady"], driving_s=s)
    (violation,) = decision.violations
    assert violation.verdict == "undefined"
    assert violation.reason.startswith("`(plan[9].v - plan[8].v) / (plan[9].s - plan[8].s)` with ")
    assert "plan[8].s = 16, plan[8].v = 20, plan[9].s = 16" in violation.reason
    assert any(violation.reason in reason for reason in decision.reasons)
    told = only(decision)
    assert (told["margin"], told["by"], told["reason"]) == ("nan", None, violation.reason)
    assert (told["where"]["sample"], told["where"]["to"]) == (8, 9)


@pytest.mark.parametrize("backend", BACKENDS)
def test_undefined_by_a_path_in_one_place(spec: Spec, backend: str) -> None:
    decision = decide(spec, backend, ["on_path"], driving_x=np.zeros(30))
    assert [v.reason for v in decision.violations] == [
        "the path of plan has no length: all of its samples are in one place"
    ]


@pytest.mark.parametrize("backend", BACKENDS)
def test_where_nothing_fulfils_it(spec: Spec, backend: str) -> None:
    told = [entry for entry in decide(spec, backend, ["somewhere"]).feedback if entry["kind"] == "rule"]
    assert [(e["margin"], e["by"], e["reason"]) for e in told] == [
        ("-inf", None, "nothing in its range fulfils it")
    ] * 2


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("name", ["dry", "was_dry", "dry_so_far"])
def test_what_a_boolean_decides_is_not_for_want_of_anything(spec: Spec, name: str, backend: str) -> None:
    """Its margin is as infinite as that of `exists` where there is nothing; that of a range was told, of rules that have none."""
    told = [entry for entry in decide(spec, backend, [name]).feedback if entry["kind"] == "rule"]
    assert [(e["verdict"], e["margin"], e["reason"]) for e in told] == [("violated", "-inf", "")] * 2


@pytest.mark.parametrize("backend", ["numpy", "c"])
def test_faults_and_what_was_lost(spec: Spec, backend: str) -> None:
    v = np.full(30, SPEED)
    v[4] = math.nan
    fault, lost = decide(spec, backend, ["slow"], driving_v=v).feedback
    assert fault == {
        "kind": "fault", "candidate": "driving", "fault": "not_finite", "code": "D215", "signal": "driving", "field": "v",
        "index": 4, "message": "the value is missing or no number",
    }  # fmt: skip
    assert lost == {"kind": "lost", "reason": "none_stored"}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("rule", "change", "reason"),
    [
        ("slow", ("v", 3, None), "plan[3].v is missing, or no number"),
        ("slow", ("v", 3, math.inf), "plan[3].v is infinite"),
        ("end", ("v", -1, None), "plan.last.v is missing, or no number"),
        ("steady", ("s", 5, math.nan), "plan[5].s is missing, or no number"),
        ("on_path", ("y", 2, math.nan), "plan[2].y is missing, or no number"),
    ],
)
def test_cases_say_it_too(
    spec: Spec, backend: str, rule: str, change: tuple[str, int, Any], reason: str
) -> None:
    """What no cycle gets past the door with, a case of `eval` and of a recording may have."""
    columns = {name: list(map(float, column)) for name, column in cycle(0).driving.items()}
    name, index, value = change
    columns[name][index] = value
    case = {"signals": {"plan": columns, "ego": cycle(0).signals["ego"]}}
    result = tm.Evaluator(spec, [rule], backend).case(case).rules[rule]
    assert (result.verdict, result.reason) == ("undefined", reason)
