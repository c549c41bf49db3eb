"""Where on a stored trajectory that turns the car is: both Supervisors against shapely, on arcs of a few samples, far apart."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from shapely import LineString, Point
from shapely.ops import substring

from support.agreement import compiled
from support.length import amount
from support.pairs import Pair
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.step import Stepper
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.cycle import Cycle, Limits

SPEC = """module spots
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
rule slow "made up"
  require ego.v <= 90 m/s
"""
LIMITS = Limits(budget=1e9)


def arc(chance: np.random.Generator) -> dict[str, np.ndarray]:
    """From somewhere to rest in a bend, either way; headings as they come, or within half a turn."""
    count = int(chance.integers(4, 9))
    radius, begin = chance.choice((-1.0, 1.0)) * chance.uniform(8.0, 40.0), chance.uniform(-9.0, 9.0)
    t = np.concatenate(([0.0], np.cumsum(chance.uniform(0.2, 0.7, count - 1))))
    v = chance.uniform(6.0, 20.0) * (1.0 - t / t[-1])
    heading = begin + (v[0] * t - v[0] * t**2 / t[-1] / 2) / radius
    x, y = (
        radius * (np.sin(heading) - math.sin(begin)),
        -radius * (np.cos(heading) - math.cos(begin)),
    )
    if chance.integers(2):
        heading = np.remainder(heading + math.pi, math.tau) - math.pi
    return {"t": t, "x": x, "y": y, "heading": heading, "v": v}


def lost(plan: dict[str, np.ndarray], t: float, ego: dict[str, float]) -> tuple[str, float]:
    """Why it may not be driven any more, and how far the nearest limit is."""
    line = LineString(np.stack((plan["x"], plan["y"]), axis=1))
    stations = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(plan["x"]), np.diff(plan["y"])))))
    due = float(np.interp(t, plan["t"], stations))
    begin = max(0.0, due - LIMITS.apart)
    part = substring(line, begin, min(due + LIMITS.apart, stations[-1]))
    seen = Point(ego["x"], ego["y"])
    at = begin + part.project(seen)
    turn = ego["heading"] - np.interp(at, stations, np.unwrap(plan["heading"]))
    rests = (
        LIMITS.beside - part.distance(seen),
        LIMITS.turned - abs(math.remainder(turn, math.tau)),
        LIMITS.overspeed - (ego["v"] - np.interp(at, stations, plan["v"])),
    )
    said = "apart" if min(rests[:2]) < 0.0 else "too_fast" if rests[2] < 0.0 else ""
    return said, float(min(map(abs, rests)))


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.verifies("S-1-B-6")
def test_a_stored_trajectory_is_driven_where_the_car_is_on_it() -> None:
    chance, said = np.random.default_rng(7), Counter[str]()
    evaluator = Evaluator(compiled(SPEC))
    for _ in range(amount(150, 3000)):
        pair, plan = Pair(evaluator, limits=LIMITS), arc(chance)
        first = {name: float(plan[name][0]) for name in ("x", "y", "heading", "v")}
        assert pair.step(Cycle(0, 0.0, plan, plan, {"ego": first}), 0.0, 0.01).state == "drive"
        t = float(chance.uniform(0.05, 0.95) * plan["t"][-1])
        moved = float(np.clip(t + chance.normal(0.0, 0.3), 0.0, plan["t"][-1]))
        at = {name: float(np.interp(moved, plan["t"], np.unwrap(plan[name]) if name == "heading" else plan[name])) for name in first}  # fmt: skip
        beside = chance.uniform(-1.9, 1.9)
        ego = {
            "x": at["x"] - beside * math.sin(at["heading"]), "y": at["y"] + beside * math.cos(at["heading"]),
            "heading": at["heading"] + chance.uniform(-0.45, 0.45), "v": max(0.0, at["v"] + chance.uniform(-2.0, 6.5)),
        }  # fmt: skip
        decision = pair.step(Cycle(1, t, None, plan, {"ego": ego}), t, t + 0.01)
        expected, near = lost(plan, t, ego)
        if near > 1e-9:
            assert decision.lost == expected, (plan, t, ego)
            said[expected] += 1
    assert min(said[name] for name in ("", "apart", "too_fast")) > 10, said


#: Times in s from the stamp, x in m and speeds in m/s of a trajectory; the stamp, and when the car is next seen, in s; x and speed of
#: the car there; why it may not be driven any more. All numbers are whole multiples of powers of two: what is equal is equal.
SPOTS = {
    "a sample is due at the moment": ([0, 0.5, 1, 2], [0, 4, 6, 8], [8, 6, 2, 0], 0, 0.5, 4, 6, ""),
    "it begins at the moment, and the car is elsewhere": ([0.5, 1, 2], [4, 6, 8], [6, 4, 0], 0, 0.5, 20, 0, "apart"),
    "it ends at the moment": ([0, 0.5, 1], [0, 4, 6], [8, 6, 0], 0, 1, 6, 0, ""),
    "it has ended": ([0, 0.5, 1], [0, 4, 6], [8, 6, 0], 0, 1.25, 6, 0, "expired"),
    "it stands": ([0, 0.5, 1, 2], [0, 0, 0, 0], [0, 0, 0, 0], 0, 0.5, 0, 0, ""),
    "it stands, and the car is beside it": ([0, 0.5, 1, 2], [0, 0, 0, 0], [0, 0, 0, 0], 0, 0.5, 8, 0, "apart"),
    "it comes back: the first of equally near places": ([0, 0.5, 1, 2], [0, 2, 0, -2], [6, 0, -6, 0], 0, 0.25, 1, 5, ""),
    "it leads backwards, and the car goes as much faster as it may": ([0, 0.5, 1, 2], [0, -4, -6, -8], [-8, -6, -2, 0], 0, 0.5, -4, -11, ""),
    "it leads backwards, and the car goes faster": ([0, 0.5, 1, 2], [0, -4, -6, -8], [-8, -6, -2, 0], 0, 0.5, -4, -11.5, "too_fast"),
    "it leads backwards, and the car stands": ([0, 0.5, 1, 2], [0, -4, -6, -8], [-8, -6, -2, 0], 0, 0.5, -4, 0, ""),
    "it leads backwards, and the car goes forwards": ([0, 0.5, 1, 2], [0, -4, -6, -8], [-8, -6, -2, 0], 0, 0.5, -4, 5.5, "too_fast"),
    "it leads forwards, and the car goes backwards": ([0, 0.5, 1, 2], [0, 4, 6, 8], [8, 6, 2, 0], 0, 0.5, 4, -5.5, "too_fast"),
    "its last samples are due at once": ([0, 0.5, 0.5 + 2**-27], [0, 4, 4], [8, 0, 0], 2**31, 2**31 + 0.5, 4, 0, ""),
}  # fmt: skip


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.verifies("S-1-B-6")
@pytest.mark.parametrize("spot", SPOTS)
def test_places_and_times_that_are_met_exactly(spot: str) -> None:
    times, stations, speeds, stamp, seen, x, v, expected = SPOTS[spot]
    plan = {name: np.zeros(len(times)) for name in ("y", "heading")}
    plan |= {name: np.array(row, float) for name, row in (("t", times), ("x", stations), ("v", speeds))}
    pair = Pair(Evaluator(compiled(SPEC)), limits=replace(LIMITS, longest_gap=2.0))
    first = {name: float(plan[name][0]) for name in ("x", "y", "heading", "v")}
    assert pair.step(Cycle(0, float(stamp), plan, plan, {"ego": first}), stamp, stamp + 0.01).safe
    ego = {**first, "x": float(x), "v": float(v)}
    decision = pair.step(Cycle(1, float(seen), None, plan, {"ego": ego}), seen, seen + 0.01)
    assert decision.lost == expected
    assert (decision.driven is None) == bool(expected)
    if not expected:  # from the last sample on that is due
        stepper = pair.c.stepper
        assert isinstance(stepper, Stepper)
        assert stepper.last().first == max(i for i, t in enumerate(times) if t + stamp <= seen)
