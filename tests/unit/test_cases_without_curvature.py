"""A case that leaves out curvature altogether is swept straight; one in which it is missing at a sample is undefined."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.command import BACKENDS
from support.shared import REPOSITORY
from support.supervised import shipped
from trackmarshal.evaluation import Evaluator, load

SPECS = REPOSITORY / "specs"
SUPERVISOR = SPECS / "supervisor"
STRAIGHT = [SUPERVISOR, SPECS / "variants" / "straight_sweep.spec"]
RADIUS, STEP = 16.0, 2.5


def bend(n: int) -> dict[str, Any]:
    """Samples 2.5 m apart around a circle, at the door of a ring as a track."""
    angles = [STEP / RADIUS * i for i in range(n)]
    plan = {
        "t": [0.25 * i for i in range(n)],
        "x": [RADIUS * math.sin(angle) for angle in angles],
        "y": [RADIUS * (1.0 - math.cos(angle)) for angle in angles],
        "heading": angles,
        "kappa": [1.0 / RADIUS] * n,
    }
    turns = [math.tau * i / 60 for i in range(60)]
    left, right = (
        [[r * math.sin(angle), RADIUS - r * math.cos(angle)] for angle in turns] for r in (13.0, 19.0)
    )
    obstacles = [{"x": 0.0, "y": 14.2, "heading": 0.0, "length": 0.4, "width": 0.4}]
    return {
        "plan": plan,
        "track": {"left": left, "right": right, "closed": True},
        "obstacles": obstacles,
    }


def without(signals: dict[str, Any]) -> dict[str, Any]:
    plan = {name: column for name, column in signals["plan"].items() if name != "kappa"}
    return {**signals, "plan": plan}


RULES = ["static_collision", "obstacle_collision"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_straight_without_and_curved_with(backend: str) -> None:
    """Among each other, in any order: each as by itself, without as the rules that name the straight hull."""
    spec = load(STRAIGHT)
    evaluator = Evaluator(spec, RULES, backend)
    named = Evaluator(spec, [f"{rule}_straight" for rule in RULES], backend)
    broken = bend(8)
    broken["plan"]["kappa"][3] = None
    nothing = bend(8)
    nothing["plan"]["kappa"] = None
    cases = [without(bend(9)), bend(9), without(bend(4)), broken, without(bend(9)), bend(4), nothing]
    found = list(
        evaluator.evaluate(evaluator.read_all([{"id": i, "signals": c} for i, c in enumerate(cases)]))
    )
    assert [result.id for result in found] == list(range(len(cases)))
    for result, case in zip(found, cases):
        kappa = case["plan"].get("kappa", ())
        missing = kappa is None or None in kappa
        wanted = (evaluator if "kappa" in case["plan"] else named).case({"signals": case})
        for rule, own in zip(RULES, wanted.rules.values()):
            assert result.rules[rule].verdict == ("undefined" if missing else own.verdict)
            assert missing or result.rules[rule].margin == own.margin
        assert bool(result.faults) == missing, "what is left out is no fault, null is"
    curved, straight = (found[i].rules["static_collision"].margin for i in (1, 0))
    assert 0.03 < curved - straight < 0.2, "inside the bend the hull is too wide"


def test_arrays_without_curvature() -> None:
    signals = [bend(5), bend(5)]
    columns = {name: np.array([one["plan"][name] for one in signals]) for name in signals[0]["plan"]}
    shared = {name: signals[0][name] for name in ("track", "obstacles")}
    evaluator = Evaluator(shipped(), RULES)
    for taken in (columns, {name: column for name, column in columns.items() if name != "kappa"}):
        batch = evaluator.batch({"plan": taken}, shared)
        case = {"plan": {name: column[0].tolist() for name, column in taken.items()}, **shared}
        alone = evaluator.case({"signals": case})
        for rule in RULES:
            assert batch.margins[rule].tolist() == [alone.rules[rule].margin] * 2


def test_another_rule_that_reads_it_is_undefined() -> None:
    """Only the sweep can do without."""
    case = without(bend(5))
    case["plan"] |= {"s": [STEP * i for i in range(5)], "v": [10.0] * 5, "a": [0.0] * 5}
    result = Evaluator(shipped(), ["static_collision", "turn_radius"]).case({"signals": case})
    assert result.rules["static_collision"].verdict != "undefined"
    assert result.rules["turn_radius"].verdict == "undefined"
    assert any("kappa" in fault for fault in result.faults)


def test_in_operation_it_has_to_be_there() -> None:
    """Even where no rule but the sweep reads it."""
    supervisor = tm.supervisor(shipped(), ["static_collision"])
    full = bend(9)
    plan = {**full["plan"], "v": [10.0] * 8 + [0.0]}
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 10.0}
    for given, expected in ((plan, False), ({k: v for k, v in plan.items() if k != "kappa"}, True)):
        cycle = tm.Cycle(0, 0.0, given, given, {"ego": ego, "track": full["track"]})
        decision = supervisor.step(cycle)
        assert any(fault.field == "kappa" for fault in decision.faults) == expected


def test_a_default_stands_for_what_is_left_out() -> None:
    """A spec that says what an absent curvature is, is taken at its word."""
    text = """
module made
signal plan : trajectory {{ t: s increasing, x: m, y: m, heading: rad, kappa: 1/m{default} }}
zone z = polygon (-40 m, -40 m) (40 m, -40 m) (40 m, 40 m) (-40 m, 40 m)
rule inside "in the zone"
  for all p in plan
  require swept_footprint(p, 4 m, 2 m) inside z
"""
    case = {"signals": {"plan": without(bend(9))["plan"]}}
    full = {"signals": {"plan": {**case["signals"]["plan"], "kappa": [0.05] * 9}}}
    declared = Evaluator(tm.loads(text.format(default=" default 0.05")))
    straight = Evaluator(tm.loads(text.format(default="")))
    assert declared.case(case).rules == declared.case(full).rules
    assert straight.case(case).rules != declared.case(case).rules
