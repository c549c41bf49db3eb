"""The shared log of a real drive, whole: nothing fires where it is on the map, and what fires before has its cause."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from shapely import Polygon, box
from shapely.affinity import rotate, translate

from support.shared import shared
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.scenarios.field import mapping
from trackmarshal.scenarios.field.build import Drive, build
from trackmarshal.scenarios.field.causes import firings
from trackmarshal.scenarios.field.judged import Judgement, judge
from trackmarshal.scenarios.field.report import residuals

ROOT = Path(__file__).resolve().parents[2]
MAP = ROOT / "specs" / "field" / "lvms.yaml"

pytestmark = pytest.mark.acceptance


@cache
def drive(begin: float, raw: bool = False) -> tuple[Drive, Judgement]:
    shared("data", "field", "iac_lvms_2023_01_04_b.csv.gz")
    made = build(replace(mapping.read(MAP), begin=begin), raw=raw)
    specs = [ROOT / "specs" / "vehicles" / "av21.spec", ROOT / "specs" / "tracks" / "lvms.spec"]
    return made, judge(made.recording, Evaluator(load([ROOT / "specs" / "supervisor"], specs)))


def test_nothing_fires_from_105_s_on() -> None:
    made, judged = drive(105.0)
    assert len(judged.times) == 5636
    assert min(cycle.ego["v"] for cycle in made.recording.cycles) < -0.3  # the noise is there
    jumps = [
        np.hypot(q.ego["x"] - p.ego["x"], q.ego["y"] - p.ego["y"])
        for p, q in zip(made.recording.cycles, made.recording.cycles[1:])
    ]
    assert max(jumps) > 2.0
    assert firings(made, judged) == []
    assert judged.faults == {}


def test_as_logged_it_fires_and_every_firing_is_noise() -> None:
    found = firings(*drive(105.0, raw=True), drive(105.0)[1])
    assert {one.cause for one in found} == {"noise"}
    assert sum(one.cycles for one in found if one.rule == "acceleration_integrity") > 2500
    assert sum(one.cycles for one in found if one.rule == "no_reversing") > 500


def test_before_every_static_collision_is_a_gap_of_the_map() -> None:
    """Held against shapely: until the last firing, the car as logged has a corner off the road at some time within the horizon."""
    made, judged = drive(0.0)
    found = [one for one in firings(made, judged) if one.rule == "static_collision"]
    assert {one.cause for one in found} == {"map gap"}
    assert found[0].begin == 0.0
    assert 103.0 < found[-1].end < 103.7
    track = made.recording.track
    inner, outer = sorted((Polygon(track["left"]), Polygon(track["right"])), key=lambda ring: ring.area)
    road = outer.difference(inner)
    log = made.log
    times = [
        float(log.t[i])
        for i in np.flatnonzero(log.t < 110.0)[::5]
        if not road.covers(
            translate(
                rotate(box(-2.5, -1.0, 2.5, 1.0), log.heading[i], (0, 0), use_radians=True),
                log.x[i],
                log.y[i],
            )
        )
    ]
    assert max(times) == pytest.approx(103.7, abs=1.0)
    assert found[-1].end <= max(times) + 0.2


def test_what_else_fires_before_is_declared() -> None:
    others = [one for one in firings(*drive(0.0)) if one.rule != "static_collision" and one.begin < 105.0]
    assert all(one.because for one in others)
    assert all(24.0 < one.end < 26.8 for one in others)


def test_the_noise_is_as_the_docs_say() -> None:
    made, _ = drive(105.0)
    before, after = residuals(made, 24.0, 103.7), residuals(made, 105.0)
    assert made.noise.place == pytest.approx(0.034, abs=0.001)
    assert made.noise.speed == pytest.approx(0.144, abs=0.001)
    assert before["speed"]["lag"] == pytest.approx(0.065, abs=0.002)
    assert after["speed"]["lag"] == pytest.approx(0.068, abs=0.002)
    assert after["speed"]["most"] == pytest.approx(1.07, abs=0.01)
    assert after["along"]["most"] == pytest.approx(0.25, abs=0.01)
    assert after["beside"]["most"] == pytest.approx(0.04, abs=0.005)


def test_a_finer_rate_and_other_horizons_fire_nothing_either() -> None:
    made, judged = drive(105.0)
    for declared in (
        replace(made.mapping, rate=25.0),
        replace(made.mapping, horizon=5.0),
        replace(made.mapping, step=0.05),
    ):
        other = build(declared)
        assert firings(other, judge(other.recording, judged.evaluator)) == []
