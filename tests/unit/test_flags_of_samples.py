"""A Boolean of the first or the last sample of a trajectory is that sample's, in every evaluator."""

from __future__ import annotations

from typing import Any

import pytest

import trackmarshal as tm
from support.command import BACKENDS
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.cycle import Cycle, Limits

SPEC = """module m
signal plan : trajectory { t: s increasing, v: m/s, hot: bool }
rule first "" require plan.first.hot
rule last "" require plan.last.hot
rule both "" require plan.first.hot and not plan.last.hot
"""
VERDICTS = {True: "satisfied", False: "violated", None: "undefined"}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("hot", [(True, False), (False, True), (True, True), (None, True), (True, None)])
def test_each_is_its_own(backend: str, hot: tuple[bool | None, bool | None]) -> None:
    plan = {"t": [0.0, 1.0, 2.0], "v": [1.0, 1.0, 1.0], "hot": [hot[0], True, hot[1]]}
    evaluator = Evaluator(loads(SPEC), backend=backend)
    rules = evaluator.case({"signals": {"plan": plan}}).rules
    assert (rules["first"].verdict, rules["last"].verdict) == (VERDICTS[hot[0]], VERDICTS[hot[1]])
    if None in hot:
        name = "first" if hot[0] is None else "last"
        assert rules[name].reason == f"plan.{name}.hot is missing, or no number"


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_supervisor_reads_those_of_each_cycle(backend: str) -> None:
    """One of the car and one of a trajectory, as they come and go: nothing is left of those of the cycle before."""
    spec = loads(
        "module m\nsignal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s, hot: bool }\n"
        "signal ego : state { x: m, y: m, heading: rad, v: m/s, lost: bool }\n"
        'rule knows ""\n  require not ego.lost\nrule cool ""\n  for all p in plan\n  require not p.hot\n'
    )
    now = [0.0]
    limits = Limits(rate=50, longest_gap=10.0)
    supervisor: Any = tm.supervisor(spec, None, backend, limits, lambda: now[0])
    for number, (lost, hot) in enumerate(((False, False), (True, False), (False, True), (False, False))):
        now[0] = 0.1 * number
        plan = {"t": [0.0, 1.0], "x": [0.0, 0.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [0.0, 0.0]}
        ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 0.0, "lost": lost}
        driving, emergency = {**plan, "hot": [False, hot]}, {**plan, "hot": [False, False]}
        decision = supervisor.step(Cycle(number, now[0], driving, emergency, {"ego": ego}))
        broken = {(one.rule, one.candidate) for one in decision.violations}
        wanted = {("knows", name) for name in ("driving", "emergency") if lost} | (
            {("cool", "driving")} if hot else set()
        )
        assert (decision.faults, broken, decision.safe) == ((), wanted, not wanted)
