"""Stamps out of reach for rules over the run: the same fault, by every backend, and none where no rule looks over the run."""

from __future__ import annotations

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import loads
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of

BACKENDS = (
    "numpy",
    "reference",
    pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
)
HEAD = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s in [-10, 150] }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
"""
RULES = {
    "back": 'rule calm "" require historically[0 s, 1 s] ego.v < 40 m/s\n',
    "a guard": 'rule calm "" whenever once[0 s, 1 s] ego.v < 40 m/s require ego.v < 40 m/s\n',
    "ahead": 'rule calm "" require always[0 s, 1 s] ego.v < 40 m/s\n',
    "a course": 'course lived = ego for 0.4 s then plan\nrule calm "" along lived as c require historically[0 s, 0.3 s] c.v <= 24 m/s\n',
}
FURTHEST = 4e9


def run(rules: str, begin: float, backend: str) -> list[Decision]:
    """Six cycles of a car that drives on straight, 0.1 s apart."""
    now = begin
    supervisor = tm.supervisor(
        loads(HEAD + rules), clock=lambda: now, backend=backend, limits={"budget": 60.0}
    )
    decisions = []
    for number in range(6):
        now = begin + 0.1 * number
        x = 0.5 * number
        plan = {"t": [0.0, 1.0], "x": [x, x + 2.5], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [5.0, 0.0]}
        ego = {"x": x, "y": 0.0, "heading": 0.0, "v": 5.0}
        decisions.append(supervisor.step(Cycle(number, now, plan, plan, {"ego": ego})))
    return decisions


def said(decisions: list[Decision]) -> list[tuple[str, list[str]]]:
    return [
        (
            one.state,
            [f"{name_of(f)} {f.signal}.{f.field}" for f in one.faults] + [v.rule for v in one.violations],
        )
        for one in decisions
    ]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("rules", RULES)
def test_a_stamp_out_of_reach_is_a_fault_of_the_cycle(rules: str, backend: str) -> None:
    safe, far = ("drive", list[str]()), ["out_of_range cycle.t"]
    decisions = run(RULES[rules], FURTHEST - 0.25, backend)
    assert said(decisions) == [safe] * 3 + [("previous_emergency", far)] * 3
    assert f"{decisions[3].t!r} s at " in decisions[3].faults[0].message
    assert said(run(RULES[rules], -FURTHEST - 0.25, backend)) == [("no_emergency_yet", far)] * 3 + [safe] * 3
    assert said(run(RULES[rules], FURTHEST, backend))[0] == ("no_emergency_yet", far)
    assert said(run(RULES[rules], -FURTHEST, backend))[:2] == [("no_emergency_yet", far), safe]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("begin", [FURTHEST - 0.25, 1e12])
def test_without_rules_over_the_run_no_stamp_is_out_of_reach(begin: float, backend: str) -> None:
    assert said(run('rule calm "" require ego.v < 40 m/s\n', begin, backend)) == [("drive", [])] * 6


@pytest.mark.parametrize("first", [-(2**63), -(2**63) + 1, 2**63 - 2 * 10**9, 2**63])
def test_a_stamp_out_of_reach_among_those_of_arrays(first: int) -> None:
    """Less a window, it was far in the future: the first cycle, which violates the rule, was in none, and satisfied it."""
    spec = loads(
        'module m\nsignal ego : state { v: m/s }\nrule calm "" require not once[0 s, 5 s] ego.v > 40 m/s\n'
    )
    stamps = np.array([first, first + 10**9], dtype=np.uint64 if first == 2**63 else np.int64)
    for whole, begin in (
        (tm.Evaluator(spec).whole_run(), stamps),
        (tm.Evaluator(spec).whole_run(), stamps[:1]),
    ):
        with pytest.raises(tm.TrackmarshalError) as refused:
            whole.step(begin, {"ego": {"v": np.array([50.0, 1.0])[: len(begin)]}})
        assert (refused.value.code, "within 4e+09 s" in refused.value.message) == ("D206", True)
    near = tm.Evaluator(spec).whole_run().step(np.array([0, 10**9]), {"ego": {"v": np.array([50.0, 1.0])}})
    assert near.verdicts["calm"].tolist() == ["violated", "violated"]
