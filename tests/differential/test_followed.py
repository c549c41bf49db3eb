"""Rules of the emergency trajectory that read the driving one beside it: each evaluator, as a case and in a cycle."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.agreement import compiled
from support.cycles import cycle
from trackmarshal.backends.c.build import compiler
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import of_cycles
from trackmarshal.runtime.frame import Frame

SPEC = """
module followed
signal plan    : trajectory { t: s increasing, s: m, x: m, y: m, heading: rad, kappa: 1/m, v: m/s in [-10, 150], a: m/s^2, grip: 1 default 1 }
signal driving : trajectory { t: s, v: m/s, x: m }
signal ego     : state { x: m, y: m, heading: rad, v: m/s, age: s default 0 s }
signal objects : set of object { x: m, y: m, heading: rad, v: m/s, length: m, width: m, age: s default 0 s }
signal obstacles : set of object { x: m, y: m, heading: rad, length: m, width: m }
signal track : corridor { left: polyline, right: polyline }
event emergency "the candidate is the emergency trajectory"
rule slower "The emergency trajectory is never the faster one"
  whenever emergency
  for all q in driving
  require plan.first.v + 1 m/s >= q.v
rule ahead "The driving trajectory by itself"
  for all q in driving
  require q.v <= 100 m/s
"""
BACKENDS = [
    "reference",
    "numpy",
    pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
]


def given(number: int, **driving: Any) -> Any:
    one = cycle(number, 1, 1)
    return replace(one, driving={**one.driving, **driving})


def step(backend: str, **driving: Any) -> Any:
    one = given(0, **driving)
    return tm.supervisor(compiled(SPEC), backend=backend, clock=lambda: one.t).step(one)


@pytest.mark.parametrize("backend", BACKENDS)
def test_in_cycles(backend: str) -> None:
    assert step(backend).safe
    count = len(given(0).driving["v"])
    v = given(0).driving["v"].copy()
    v[count // 2] += 3.0
    decision = step(backend, v=v)
    assert [(w.rule, w.candidate, w.verdict) for w in decision.violations] == [
        ("slower", "emergency", "violated")
    ]
    assert decision.violations[0].margin == pytest.approx(-2.0)
    assert decision.violations[0].witness.binders == {"q": count // 2}
    v[count // 2] = 120.0
    decision = step(backend, v=v)
    assert [(w.rule, w.candidate) for w in decision.violations] == [
        ("ahead", "driving"), ("slower", "emergency"), ("ahead", "emergency"),
    ]  # fmt: skip


@pytest.mark.parametrize("backend", BACKENDS)
def test_as_a_case(backend: str) -> None:
    from trackmarshal.evaluation import Evaluator

    evaluator = Evaluator(compiled(SPEC), None, backend)
    own = {name: column.tolist() for name, column in given(0).driving.items()}
    signals = {
        "plan": own,
        "driving": {"t": [0.0, 0.1], "v": [own["v"][0] + 3.0] * 2, "x": [0.0, 1.0]},
        "emergency": True,
    }
    (found,) = evaluator.evaluate([evaluator.read({"signals": signals})])
    assert {name: rule.verdict for name, rule in found.rules.items()} == {
        "slower": "violated",
        "ahead": "satisfied",
    }


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_cycle_cannot_bring_another_one(backend: str) -> None:
    one = given(0)
    other = replace(one, signals={**one.signals, "driving": one.driving})
    decision = tm.supervisor(compiled(SPEC), backend=backend, clock=lambda: one.t).step(other)
    assert [(f.code, f.field) for f in decision.faults] == [("D220", "driving")]


def test_faults_of_the_driving_trajectory_are_of_the_rules_that_read_it() -> None:
    from trackmarshal.runtime.door.reading import CycleReader

    frame, faults = CycleReader(of_cycles(compiled(SPEC), compiled(SPEC).rules)).read(
        given(0, v=np.array(["x"] * 30, dtype=object))
    )
    frame.faults = faults
    seen: Frame = frame.of("emergency")
    assert seen.unusable([("driving", "v")]) is not None
    assert seen.unusable([("plan", "v")]) is None
    assert frame.of("driving").unusable([("plan", "v")]) is not None


@pytest.mark.parametrize(
    "declared",
    [
        "trajectory { t: s, jerk: m/s }",
        "trajectory { v: km/h }",
        "state { v: m/s }",
        "set of object { v: m/s }",
    ],
)
def test_it_is_declared_as_the_candidates_are(declared: str) -> None:
    spec = compiled(
        SPEC.replace("trajectory { t: s, v: m/s, x: m }", declared).split("rule slower")[0]
        + 'rule r "r"\n  require ego.v <= 1 m/s\n'
    )
    with pytest.raises(TrackmarshalError, match="driving") as caught:
        of_cycles(spec, spec.rules)
    assert caught.value.code == "E482"
