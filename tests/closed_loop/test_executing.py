"""The layer below follows what it is given, and knows what to do when it is given nothing."""

from __future__ import annotations

import math

import pytest

from closed_loop.car import Build, Car, State
from closed_loop.executing import Columns, Executing, Given, Sensed

FOREVER = math.inf


def bend(radius: float, v: float, a: float = 0.0, length: float = 120.0) -> Columns:
    """A bend to the left from the origin, from straight on; at constant acceleration, to rest where it comes to rest."""
    s = [0.5 * i for i in range(round(length / 0.5) + 1)]
    speeds = [math.sqrt(max(v * v + 2 * a * q, 0.0)) for q in s]
    return {
        "s": s,
        "x": [radius * math.sin(q / radius) for q in s],
        "y": [radius * (1.0 - math.cos(q / radius)) for q in s],
        "heading": [q / radius for q in s],
        "kappa": [1.0 / radius] * len(s),
        "v": speeds,
        "a": [a] * len(s),
    }


def driven(below: Executing, car: Car, seconds: float, sensed: Sensed | None = None) -> float:
    """Drives, with true poses where no other one is given; the largest offset from the circle is left to the caller."""
    worst = 0.0
    s = car.state
    for tick in range(round(seconds / 0.01)):
        below.locate(sensed or Sensed(s.x, s.y, s.heading, s.v), s.along, s.across, s.yaw, 0.01)
        car.drive(*below.act(0.01 * tick, s.v), 0.01)
        worst = max(worst, abs(math.hypot(s.x, s.y - 60.0) - 60.0))
    return worst


def start(v: float) -> tuple[Executing, Car]:
    build = Build()
    car = Car(build, State(0.0, 0.0, 0.0, v, steering=build.base / 60.0, yaw=v / 60.0))
    return Executing(build, 0.0, 0.0, 0.0), car


@pytest.mark.parametrize("v", [10.0, 18.0, 25.0])
def test_it_stays_on_a_bend(v: float) -> None:
    below, car = start(v)
    below.take(Given("drive", bend(60.0, v, length=300.0), None, FOREVER))
    assert driven(below, car, 4.0) < 0.35
    assert car.state.v == pytest.approx(v, abs=0.5)


def test_it_brakes_to_rest_where_the_trajectory_does() -> None:
    below, car = start(20.0)
    path = bend(60.0, 20.0, -6.0)
    below.take(Given("previous_emergency", path, path, FOREVER))
    assert driven(below, car, 8.0) < 0.35
    assert car.state.standing
    assert 60.0 * math.atan2(car.state.x, 60.0 - car.state.y) == pytest.approx(20.0**2 / 12.0, abs=1.5)


def test_without_a_decision_it_takes_the_fallback() -> None:
    below, car = start(20.0)
    below.take(Given("drive", bend(60.0, 20.0, length=400.0), bend(60.0, 20.0, -6.0), 0.5))
    driven(below, car, 8.0)
    assert below.doing == "fallback"
    assert car.state.standing


def test_where_nothing_can_be_driven_it_takes_the_last_fallback() -> None:
    below, car = start(20.0)
    below.take(Given("drive", bend(60.0, 20.0), bend(60.0, 20.0, -6.0), FOREVER))
    below.take(Given("no_safe_trajectory", None, None, FOREVER))
    assert driven(below, car, 8.0) < 0.35
    assert car.state.standing


def test_without_anything_it_brakes() -> None:
    below, _ = start(20.0)
    assert below.act(0.0, 20.0) == (0.0, -14.0)
    below.take(Given("no_emergency_yet", None, None, FOREVER))
    assert below.act(0.0, 20.0) == (0.0, -14.0)


@pytest.mark.parametrize(
    "wrong",
    [
        Sensed(0.0, 0.0, 0.0, 20.0),
        Sensed(5.0, 30.0, 0.1, 20.0),
        Sensed(math.nan, math.nan, math.nan, math.nan),
    ],
    ids=["stuck", "elsewhere", "nan"],
)
def test_wrong_poses_are_not_believed_and_stop_it(wrong: Sensed) -> None:
    below, car = start(20.0)
    below.take(Given("drive", bend(60.0, 20.0, length=400.0), bend(60.0, 20.0, -6.0), FOREVER))
    assert driven(below, car, 9.0, wrong) < 2.5
    assert below.doing == "lost"
    assert car.state.standing
