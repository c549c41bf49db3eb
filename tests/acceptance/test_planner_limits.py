"""A planner that nobody here wrote, with its own limits and 1 % allowance: what the rules of one trajectory say of it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from support.shared import SUPERVISOR, shared
from trackmarshal.cli.replay import evaluator_for
from trackmarshal.scenarios import load
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import Replay, replay

pytestmark = pytest.mark.acceptance
ALONE, AMONG_CARS = ("modena", "berlin"), ("modena_cars", "berlin_cars")
ALLOWANCE = 1.01
POSE = ("pose_match", "pose_on_path", "stamp_match", "place_match", "heading_match", "speed_match")
RULES = (
    *POSE, "friction", "turn_radius", "drive_acceleration", "braking_limit", "ends_at_rest", "speed_limit", "no_reversing",
    "arc_length_integrity", "heading_integrity", "curvature_integrity", "acceleration_integrity",
    "pace_integrity", "speed_integrity", "path_integrity", "corner_integrity", "swerve_integrity", "race_direction", "A-LOCALISATION", "A-FRICTION",
)  # fmt: skip


@cache
def recording(name: str) -> Recording:
    return load(shared("data", "planner", f"{name}.tmrec.jsonl.gz"))


@cache
def run(name: str, allowance: float = ALLOWANCE) -> Replay:
    given = recording(name)
    more = {limit: given.params[limit] * allowance for limit in ("mu", "drive_factor")}
    given = replace(given, params={**given.params, **more})
    settings: list[Path] = [shared("data", "planner", f"{what}.spec") for what in ("ltpl_car", "ltpl_track")]
    evaluator = evaluator_for(given, SUPERVISOR, settings, None, list(RULES), "numpy")
    return replay(given, evaluator, brief=True)


def fired(outcome: Replay) -> dict[str, set[float]]:
    """When each rule that fires makes a candidate unsafe."""
    times = {
        rule: {t for c in ("driving", "emergency") for t in outcome.unsafe_times(c, rule)} for rule in RULES
    }
    return {rule: found for rule, found in times.items() if found}


@pytest.mark.parametrize("name", ALONE)
def test_alone_nothing_fires(name: str) -> None:
    assert fired(run(name)) == {}


@pytest.mark.parametrize("name", ALONE)
def test_the_allowance_covers_no_more_than_rounding(name: str) -> None:
    """Without it, friction and drive fire where the planner is at its limit to the last bits, and nothing else does."""
    outcome = run(name, 1.0)
    assert fired(outcome).keys() == {"friction", "drive_acceleration"}
    for rule in ("friction", "drive_acceleration"):
        margins = [result.rules[rule].margin for cycle in outcome.cycles for result in cycle.results.values()]
        assert -1e-10 < min(margins) < 0.0


@pytest.mark.parametrize("name", ALONE)
def test_with_drag_as_tyre_force_it_is_another_car(name: str) -> None:
    """What eq. (2) as printed says of the same cycles: braking, the tyres carry less than the acceleration."""
    given = recording(name)
    mass, drag, most = given.params["mass"], given.params["drag"], 13.0 * ALLOWANCE
    beyond = carried = 0
    for cycle in given.cycles:
        for plan in cycle.candidates.values():
            samples = list(zip(plan["a"], plan["v"], plan["kappa"]))
            beyond += any(math.hypot(a, v * v * k) > most for a, v, k in samples)
            carried += any(math.hypot(a + drag * v * v / mass, v * v * k) > most for a, v, k in samples)
    assert beyond > 300
    assert carried == 0


@pytest.mark.parametrize("name", AMONG_CARS)
def test_a_car_that_stands_is_let_go(name: str) -> None:
    """Trajectories in one place are where the car stands, and nothing about them is undefined."""
    outcome, standing = run(name), 0
    for cycle, seen in zip(recording(name).cycles, outcome.cycles, strict=True):
        for candidate, plan in cycle.candidates.items():
            if len(set(zip(plan["x"], plan["y"]))) == 1:
                standing += 1
                verdicts = {rule: seen.results[candidate].rules[rule].verdict for rule in RULES}
                assert set(verdicts.values()) <= {"satisfied", "inactive"}, (cycle.t, verdicts)
    assert standing == {"modena_cars": 23, "berlin_cars": 315}[name]


def test_among_cars_the_plan_is_where_the_car_is_but_for_one_jump() -> None:
    """At 19.8 s the planner begins at 18.8 m/s, 1.8 m behind a car that drives 14.9 m/s: no car loses that in 1.8 m."""
    assert not fired(run("modena_cars")).keys() & set(POSE)
    found = fired(run("berlin_cars"))
    assert {rule: sorted(found[rule]) for rule in found if rule in POSE} == {
        "speed_match": [pytest.approx(19.8)]
    }
