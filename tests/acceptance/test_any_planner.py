"""Whatever a planner proposes, a car that drives what the Supervisor decides stays on the road and hits nobody who keeps to his line."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from support.any_planner import Cars, Outcome, run
from support.length import amount, shared_out
from support.supervised import ROOT, shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import load
from trackmarshal.ir.spec import RuleInfo

pytestmark = [
    pytest.mark.verifies("S-1-A-2"),
    pytest.mark.skipif(compiler() is None, reason="no C compiler"),
]

RUNS = amount(40, 1500)
#: Cars unlike the shipped one, on the same roads: m, m/s^2, m/s; and the least radius, m.
OTHERS = {
    "lorry": (Cars(12.0, 2.55, 2.0, 6.8, 1.2, 2.0, 45.0, 12), 9.5),
    "kart": (Cars(2.0, 1.4, 1.0, 13.0, 5.0, 5.0, 45.0, 120), 2.5),
    "on snow": (Cars(4.3, 1.8, 1.8, 2.9, 3.0, 3.0, 45.0), 5.5),
    "racer": (Cars(5.0, 2.0, 1.9, 18.0, 9.0, 9.0, 70.0), 10.0),
}
VEHICLE = """module vehicle
param length : m = {cars.length} m
param width : m = {cars.width} m
param R_min : m = {radius} m
param mu : 1 = {grip} / 9.81
param drag : kg/m = 0 kg/m
param v_max : m/s = 100 m/s
param b_rear : m/s^2 = {cars.grip} m/s^2
param b_front : m/s^2 = {cars.grip} m/s^2
param a_response : m/s^2 = {cars.drives} m/s^2
param a_other : m/s^2 = {cars.speeds_up} m/s^2
param b_other : m/s^2 = {gentle} m/s^2
param b_lateral : m/s^2 = {aside} m/s^2
param b_lateral_other : m/s^2 = {aside} m/s^2
param a_loc : m/s^2 = {grip} m/s^2
param longest : m = 40 m
table ax_max(v: m/s) -> m/s^2 = linear clamp | 0 m/s: {cars.drives} m/s^2 | 100 m/s: {cars.drives} m/s^2 |
"""


def rules() -> list[RuleInfo]:
    return [rule for rule in shipped().rules if rule.kind == "rule"]


def outcomes(rules: list[str] | None = None, count: int = RUNS) -> list[Outcome]:
    return [run(shipped(), seed, rules) for seed in range(count)]


def test_nothing_is_hit_whatever_is_proposed() -> None:
    found = outcomes()
    assert {seed: one.wrong for seed, one in enumerate(found) if one.wrong} == {}
    seen = sum((one.seen for one in found), Counter[str]())
    assert seen["safe"] > 15 * RUNS
    assert seen["unsafe"] > 3 * RUNS
    assert seen["driven"] > RUNS / 2


@pytest.mark.acceptance  # the shipped one every day
@pytest.mark.parametrize("vehicle", shared_out(OTHERS, 2))
def test_nor_with_another_vehicle(vehicle: str, tmp_path: Path) -> None:
    cars, radius = OTHERS[vehicle]
    settings = tmp_path / "vehicle.spec"
    limits = {
        "grip": cars.grip + 0.1 * cars.share,
        "gentle": min(4.0, 4.0 * cars.share),
        "aside": 0.6 * cars.grip,
    }
    settings.write_text(VEHICLE.format(cars=cars, radius=radius, **limits), encoding="utf-8")
    spec, count = load([ROOT / "specs" / "supervisor"], [settings]), amount(10, 400)
    found = [run(spec, seed, None, cars) for seed in range(count)]
    assert {seed: one.wrong for seed, one in enumerate(found) if one.wrong} == {}
    seen = sum((one.seen for one in found), Counter[str]())
    assert seen["safe"] > 2 * count
    assert seen["unsafe"] > 2 * count


@pytest.mark.acceptance
def test_without_the_rules_about_others_somebody_is() -> None:
    kept = [r.name for r in rules() if r.module != "supervisor.collision" or r.name == "static_collision"]
    assert sum(one.wrong.startswith("in contact") for one in outcomes(kept, 42)) >= 3


@pytest.mark.acceptance
def test_without_the_rule_about_the_road_it_is_left() -> None:
    kept = [rule.name for rule in rules() if rule.name != "static_collision"]
    assert sum(one.wrong == "off the road" for one in outcomes(kept, 42)) >= 2
