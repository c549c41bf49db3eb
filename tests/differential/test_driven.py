"""Both evaluators on trajectories as they are driven: straight on, round a bend, changing lanes, standing still, backwards.

Then corners of two footprints lie on one line, up to rounding, and the evaluators may take another one of equally near
corners and sides: margins agree to `NEAR` metres, verdicts wherever margins are farther than that from zero.
"""

from __future__ import annotations

import math
from typing import Any

import pytest

from support.agreement import compiled, read, results
from support.generated import RandomChoices
from support.generated.places import Road
from support.length import amount, shared_out

NEAR = 1e-9
SPEC = """
module driven
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m }
signal objects : set of object { x: m, y: m, heading: rad, length: m, width: m }
signal ego : state { x: m, y: m, heading: rad }
signal track : corridor { left: polyline, right: polyline }
signal fence : polyline
zone box = polygon (-20, -8) (30, -8) (30, 8) (-20, 8)
rule on_track "inside"
  for all p in plan
  require swept_footprint(p, 4.7 m, 2 m) inside track
rule in_zone "inside a box"
  for all p in plan
  require swept_footprint(p, 4.7 m, 2 m) inside box
rule clear "of all"
  for all o in objects
  for all p in plan
  require swept_footprint(p, 4.7 m, 2 m) clear_of footprint(o)
rule straight_on_track "the straight hull"
  for all p in plan
  require swept_hull(p, 4.7 m, 2 m) inside track
rule still "standing"
  require footprint(ego, 4.7 m, 2 m) inside track
rule along_track "coordinates"
  for all consecutive p, q in plan
  require station_gap(track, station(p, track), station(q, track)) >= 0 m and abs(offset(p, track)) <= 3 m
rule turned "to the track"
  for all p in plan
  require abs(p.heading - direction(p, track)) <= 0.2
rule near_fence "a line"
  exists p in plan
  require distance_to(p, fence) <= 1 m
rule near_plan "the path"
  require distance_to(ego, plan) <= 0.5 m
"""
KINDS = ("straight", "bend", "lane change", "standing", "backwards", "grid")


def driven(kind: str, choices: RandomChoices) -> dict[str, list[float]]:
    """A plan of ten samples."""
    x, y, heading = (
        choices.pick((-12.0, 0.0, choices.real(-5.0, 5.0))),
        choices.pick((0.0, choices.real(-3.0, 3.0))),
        0.0,
    )
    if kind in ("straight", "backwards") and choices.chance(50):
        heading = choices.pick((math.pi / 2, math.pi, 0.3, -2.0))
    step = {"standing": 0.0, "backwards": -0.7}.get(kind, choices.pick((0.5, 1.3, 4.7)))
    bend = choices.pick((0.1, -0.05, 1e-9)) if kind == "bend" else 0.0
    columns: dict[str, list[float]] = {"t": [], "x": [], "y": [], "heading": [], "kappa": []}
    for k in range(10):
        for column, value in zip(columns.values(), (0.1 * k, x, y, heading, bend), strict=True):
            column.append(value)
        x, y, heading = x + step * math.cos(heading), y + step * math.sin(heading), heading + bend * step
        if kind == "lane change":
            heading = 0.1 * math.sin(2 * math.pi * (k + 1) / 9)
        if kind == "grid":
            x, y, heading = round(x), round(y), math.pi / 2 * choices.integer(0, 3)
    return columns


def case(kind: str, choices: RandomChoices) -> dict[str, Any]:
    plan = driven(kind, choices)
    ahead = [
        {"x": plan["x"][-1] + dx, "y": plan["y"][-1] + dy, "heading": plan["heading"][-1] + turn, "length": 4.7, "width": 2.0}
        for dx, dy, turn in ((9.0, 0.0, 0.0), (0.0, choices.pick((2.0, 3.5, 2.1)), 0.0), (5.0, 5.0, choices.real(-1.0, 1.0)))
    ]  # fmt: skip
    ego = {name: plan[name][0] + choices.pick((0.0, 0.1)) for name in ("x", "y", "heading")}
    road = Road(choices)
    return {
        "signals": {"plan": plan, "objects": ahead[: choices.integer(1, 3)], "ego": ego, **road.signals(0)}
    }


@pytest.mark.parametrize("kind", shared_out(KINDS, 2))
def test_driven_trajectories(kind: str) -> None:
    spec = compiled(SPEC)
    cases = read(spec, [case(kind, RandomChoices(seed)) for seed in range(amount(20, 60))])
    assert not any(one.faults for one in cases)
    verdicts = set()
    for seed, (one, other) in enumerate(
        zip(results(spec, cases, "numpy"), results(spec, cases, "reference"), strict=True)
    ):
        for name, rule in one.rules.items():
            expected = other.rules[name]
            verdicts.add(rule.verdict)
            assert (rule.verdict == "undefined") == (expected.verdict == "undefined"), (
                seed,
                name,
                rule,
                expected,
            )
            if rule.verdict != "undefined":
                assert abs(rule.margin - expected.margin) <= NEAR, (seed, name, rule, expected)
                assert rule.verdict == expected.verdict or abs(rule.margin) <= NEAR, (
                    seed,
                    name,
                    rule,
                    expected,
                )
    assert {"satisfied", "violated"} <= verdicts
