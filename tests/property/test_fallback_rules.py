"""The rules of specs/fallback on generated cycles: what they approve can be driven to rest from every moment of the window.

What is driven is computed here, from the columns alone: the square of speed keeps its excess over the emergency trajectory in proportion to what is left
of the way, which is the braking that the rules speak of.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from support.dense.generated import CAR, generated
from support.dense.recording import Columns, Cycle, Floats
from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal.evaluation import Evaluator, load

pytestmark = pytest.mark.verifies("S-1-A-7")

WINDOW, DS, DV = 0.25, 5.0, 2.0
#: What lies between samples, where rules do not look, may ask for this much more of the grip; squares of speed may differ by m^2/s^2.
ABOUT, SQUARE = 0.03, 3.0
RULES = ["takeup_speed", "takeup_friction"]


def approved(cycles: list[Cycle]) -> list[bool]:
    spec = load([SUPERVISOR, REPOSITORY / "specs" / "fallback"])
    evaluator = Evaluator(spec, RULES, "numpy")
    params = {
        "mu": CAR.grip / 9.81,
        "mass": CAR.mass,
        "drag": CAR.drag,
        "dv_takeup": DV,
        "ds_takeup": DS,
        "window": WINDOW,
    }
    cases = [{"signals": signals(one), "params": params} for one in cycles]
    return [result.safe for result in evaluator.evaluate([evaluator.read(case) for case in cases])]


def signals(one: Cycle) -> dict[str, Any]:
    plans = {
        name: {c: column.tolist() for c, column in one.candidates[name].items()}
        for name in ("driving", "emergency")
    }
    driving = {c: plans["driving"][c] for c in ("t", "s", "x", "y", "heading", "v")}
    return {"plan": plans["emergency"], "driving": driving, "emergency": True, "ego": one.ego}


def along(s: Floats, plan: Columns, name: str) -> Floats:
    return np.interp(s, plan["s"], plan[name])


def followed(one: Cycle) -> tuple[Floats, Floats]:
    """Where a car is that begins where the ego is and follows the driving trajectory for a window, and the squares of its speed."""
    driving = one.candidates["driving"]
    begin = float(np.hypot(one.ego["x"], one.ego["y"]))  # the path begins in the origin, along +x
    t0 = float(np.interp(begin, driving["s"], driving["t"]))
    times = t0 + np.linspace(0.0, WINDOW, 11)
    s = np.interp(times, driving["t"], driving["s"])
    return s, along(s, driving, "v") ** 2


def test_what_they_approve_can_be_driven_to_rest() -> None:
    chance = np.random.default_rng(7)
    cycles = [generated(chance) for _ in range(600)]
    judged = approved(cycles)
    assert 60 < sum(judged) < 540
    for one, safe in zip(cycles, judged):
        if not safe:
            continue
        emergency = one.candidates["emergency"]
        way = float(emergency["s"][-1])
        squares = np.square(emergency["v"])
        for s, square in zip(*followed(one)):
            excess = float(square - np.interp(min(s, way), emergency["s"], squares))
            assert s <= way + DS
            # Where the rules' even braking begins with all that they allow, this car has no more than that.
            most = DV * (2.0 * emergency["v"][0] + DV) * (1.0 - s / (way + DS))
            assert excess <= most + SQUARE
            rest = np.linspace(s, way, 200) if s < way else np.array([way])
            left = max(excess, 0.0) * (way + DS - rest) / (way + DS - s)
            u = np.interp(rest, emergency["s"], squares) + left
            pieces = np.clip(np.searchsorted(emergency["s"], rest, side="right") - 1, 0, len(squares) - 2)
            planned = np.diff(squares)[pieces] / (2.0 * np.diff(emergency["s"])[pieces])
            a = planned - max(excess, 0.0) / (2.0 * (way + DS - s))
            tyres = np.hypot(a + CAR.drag * u / CAR.mass, u * along(rest, emergency, "kappa"))
            assert tyres.max() <= CAR.grip * (1.0 + ABOUT), (one.ego, s)
            # Beyond the end it brakes on as it did, within the grip there is.
            assert left[-1] <= 2.0 * CAR.grip * DS


def test_a_planner_that_brakes_at_the_limit_at_once_is_refused() -> None:
    """The rules can say no: where the emergency trajectory takes all the grip that there is, none is left for braking harder."""
    chance = np.random.default_rng(8)
    cycles, seen = [generated(chance) for _ in range(200)], 0
    for one, safe in zip(cycles, approved(cycles)):
        v = one.candidates["emergency"]["v"]
        asks = CAR.tyres(
            v[:-1], one.candidates["emergency"]["a"][:-1], one.candidates["emergency"]["kappa"][:-1]
        ).max()
        if asks > 0.97 * CAR.grip and len(v) > 12:
            assert not safe
            seen += 1
    assert seen >= 5
