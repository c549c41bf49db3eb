"""Vehicles that nobody thought of when the rules were written: no fallback is safe that they cannot drive, and none is refused that they can.

Made up, on a straight road. How they stop is worked out here, from their own brakes, tyres and drag.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray

import trackmarshal as tm
from support.cycles import cycle
from support.length import at_length
from support.supervised import BACKENDS, ROOT, shipped
from trackmarshal.evaluation import load
from trackmarshal.runtime.cycle import Cycle

Floats = NDArray[np.float64]

#: Rooms by the dozen are judged every day by the quick one, which others hold against the reference.
QUICK = pytest.mark.parametrize("backend", [at_length("reference"), "numpy", at_length("c")])

#: Tyres of 7.8 m/s^2, and brakes of half of that.
LORRY = {"length": 12.0, "width": 2.55, "mass": 12000.0, "R_min": 9.0, "mu": 0.8, "drag": 3.0, "b_max": 4.0, "v_max": 25.0}  # fmt: skip


def of_file(name: str) -> dict[str, float]:
    """A shipped vehicle's own values."""
    spec = load([ROOT / "specs" / "supervisor"], [ROOT / "specs" / "vehicles" / f"{name}.spec"])
    return {param: spec.params[f"vehicles.devbot.{param}"].value for param in LORRY}


VEHICLES = {"lorry": LORRY, "compact": of_file("compact"), "av21": of_file("av21")}


def along(s: Floats, v: Floats, a: Floats) -> dict[str, Floats]:
    """Straight on through these places, at these speeds."""
    t = np.concatenate([[0.0], np.cumsum(2.0 * np.diff(s) / (v[1:] + v[:-1]))])
    zero = np.zeros(len(s))
    return {
        "t": t,
        "s": s,
        "x": s.copy(),
        "y": zero,
        "heading": zero.copy(),
        "kappa": zero.copy(),
        "v": v,
        "a": a,
    }


def stopping(brakes: Floats, step: float, told: float) -> dict[str, Floats]:
    """To rest in steps of one length, each with a deceleration of its own, whatever the column says of them."""
    v = np.sqrt(np.append(np.cumsum(2.0 * brakes[::-1] * step)[::-1], 0.0))
    return along(np.arange(len(v), dtype=np.float64) * step, v, np.full(len(v), -told))


def slows(vehicle: Mapping[str, float], v: Floats) -> Floats:
    """With all that tyres and brakes have, but for a hundredth: tyres and drag, and no more than the brakes."""
    return 0.99 * np.minimum(
        vehicle["mu"] * 9.81 + vehicle["drag"] * v**2 / vehicle["mass"], vehicle["b_max"]
    )


def braking(vehicle: Mapping[str, float], v: float) -> dict[str, Floats]:
    speeds = np.linspace(v, 0.0, 5001)
    passed = (speeds[:-1] ** 2 - speeds[1:] ** 2) / 2.0 / slows(vehicle, (speeds[1:] + speeds[:-1]) / 2.0)
    s = np.append(0.0, np.cumsum(passed))
    own = np.linspace(0.0, s[-1], 100)
    at = np.sqrt(np.interp(own, s, speeds**2))
    return along(own, at, -slows(vehicle, at))


def made(emergency: Mapping[str, Floats]) -> Cycle:
    """A car that drives on, and falls back on this."""
    v, t = float(emergency["v"][0]), np.linspace(0.0, 3.0, 31)
    given = cycle(0, objects=0, obstacles=0, v=v)
    for candidate, columns in ((given.driving, along(v * t, np.full(len(t), v), np.zeros(len(t)))), (given.emergency, emergency)):  # fmt: skip
        candidate.clear()
        candidate.update(columns)
    return given


def objections(given: Cycle, vehicle: Mapping[str, float], backend: str) -> set[str]:
    decision = tm.supervisor(shipped(), backend=backend, params=vehicle, clock=lambda: 0.0).step(given)
    assert decision.faults == ()
    return {one.rule for one in decision.violations}


@BACKENDS
@pytest.mark.verifies("S-1-A-5")
@pytest.mark.parametrize("steps", [2, 3, 4, 7])
def test_no_step_brakes_harder_than_the_brakes(steps: int, backend: str) -> None:
    """The first and the last step have no acceleration that anything holds against their speeds: with what the tyres take, it ends 14 m early."""
    brakes = np.full(steps, LORRY["b_max"])
    gentle = stopping(brakes, 8.0, LORRY["b_max"])
    assert objections(made(gentle), LORRY, backend) == set()
    brakes[[0, -1]] = 7.5
    hard = stopping(brakes, 8.0, LORRY["b_max"])
    assert hard["v"][0] ** 2 / (2.0 * LORRY["b_max"]) > hard["s"][-1] + 10.0
    assert objections(made(hard), LORRY, backend) == {"speed_integrity"}


@QUICK
@pytest.mark.verifies("S-1-A-2")
@pytest.mark.parametrize("other", [0.0, 15.0], ids=["stands", "brakes"])
@pytest.mark.parametrize("vehicle", ["compact", "av21", "lorry"])
def test_a_fallback_that_leaves_no_response_is_refused(vehicle: str, other: float, backend: str) -> None:
    """What is approved is driven on for a response, and then the car brakes with all that it has, which is less than b_rear says."""
    values = VEHICLES[vehicle]
    v = min(values["v_max"] - 1.0, 50.0)
    columns = braking(values, v)
    way, ahead = columns["s"][-1], other**2 / (2.0 * 13.0)
    for room in np.linspace(way - ahead + 0.1, way - ahead + 0.2 * v + 60.0, 16):
        given = made(columns)
        body = {
            "x": room + (values["length"] + 4.5) / 2.0,
            "y": 0.0,
            "heading": 0.0,
            "v": other,
            "length": 4.5,
            "width": 2.0,
        }
        given.signals["objects"] = [{"id": "other", **body}]
        if not objections(given, values, backend):
            assert 0.2 * v + way < room + ahead
    assert objections(given, values, backend) == set()


@QUICK
@pytest.mark.verifies("S-1-A-2")
@pytest.mark.parametrize("grip", [0.8, 0.5, 0.2])
def test_nor_on_a_wet_road(grip: float, backend: str) -> None:
    """What is left of the tyres is what a road lets them, of the shipped vehicle, too."""
    shipped_one = of_file("devbot")
    columns = braking({**shipped_one, "mu": shipped_one["mu"] * grip}, 50.0)
    way, columns["grip"] = columns["s"][-1], np.full(len(columns["s"]), grip)
    given = made(columns)
    # RSS by hand, without the drag that helps.
    enough = 0.2 * 50.0 + 6.0 * 0.2**2 / 2.0 + (50.0 + 6.0 * 0.2) ** 2 / (2.0 * 13.0 * grip) + 0.01
    for room in np.linspace(way + 0.1, enough, 17):
        given.signals["objects"] = [
            {"id": "other", "x": room + (shipped_one["length"] + 4.5) / 2.0, "y": 0.0, "heading": 0.0, "v": 0.0,
             "length": 4.5, "width": 2.0}
        ]  # fmt: skip
        if not objections(given, {}, backend):
            assert 0.2 * 50.0 + way < room
    assert objections(given, {}, backend) == set()


@BACKENDS
@pytest.mark.verifies("S-1-A-2")
@pytest.mark.parametrize("v", [3.0, 10.0, 20.0, 24.0])
@pytest.mark.parametrize("change", [{"mu": 0.2}, {"b_max": 1.5}], ids=["snow", "weak"])
def test_a_fallback_that_brakes_with_all_there_is_is_none_too_long(change: dict[str, float], v: float, backend: str) -> None:  # fmt: skip
    values = {**LORRY, **change}
    assert objections(made(braking(values, v)), values, backend) == set()


@QUICK
@pytest.mark.verifies("S-1-A-2")
@pytest.mark.parametrize("grip", [1.8, 2.2, 3.0])
@pytest.mark.parametrize("v", [20.0, 40.0, 55.0])
def test_who_brakes_harder_than_the_one_ahead_touches_it_nowhere(v: float, grip: float, backend: str) -> None:
    """Both stand clear of each other in the end. The one that waits, and brakes with more, is at rest before the one ahead has got there."""
    values = {**LORRY, "length": 3.0, "width": 1.5, "mass": 250.0, "mu": grip, "drag": 0.0, "b_max": 40.0, "v_max": 80.0}  # fmt: skip
    found = 0
    for wait in np.arange(0.2, 2.0, 0.2):
        stops = braking(values, v)
        before = np.linspace(0.0, v * wait, 20, endpoint=False)
        s = np.append(before, stops["s"] + v * wait)
        columns = along(
            s, np.append(np.full(len(before), v), stops["v"]), np.append(np.zeros(len(before)), stops["a"])
        )
        for other in (1.1 * v, 1.25 * v, 1.5 * v):
            t = np.linspace(0.0, columns["t"][-1], 2000)
            drives = other * t - 13.0 * np.minimum(t, other / 13.0) ** 2 / 2.0
            drives[t > other / 13.0] = other**2 / 26.0
            room = max(s[-1] - other**2 / 26.0, 0.0) + 0.3
            given = made(columns)
            body = {"x": room + 3.75, "y": 0.0, "heading": 0.0, "v": other, "length": 4.5, "width": 2.0}
            given.signals["objects"] = [{"id": "other", **body}]
            if np.min(room + drives - np.interp(t, columns["t"], s)) < -0.1:
                found += 1
                assert "safe_fallback" in objections(given, values, backend)
    assert found
