"""What the planner says becomes candidates that agree with themselves."""

from __future__ import annotations

import math

import pytest

from closed_loop.adapter import Columns, candidate, times

RADIUS = 16.0


def circle(v: list[float], step: float = 2.5) -> Columns:
    """A bend to the left in the planner's columns, headings from +y; it begins at the origin, pointing along +x."""
    s = [i * step for i in range(len(v))]
    return {
        "s": s,
        "x": [RADIUS * math.sin(q / RADIUS) for q in s],
        "y": [RADIUS * (1.0 - math.cos(q / RADIUS)) for q in s],
        "psi": [q / RADIUS - math.pi / 2 for q in s],
        "kappa": [1.0 / RADIUS] * len(v),
        "v": v,
        "a": [0.0] * len(v),
    }


def test_headings_are_counted_from_x() -> None:
    found = candidate(circle([10.0] * 5), 0.0, 0.0)
    assert found["heading"][0] == pytest.approx(0.0)


@pytest.mark.parametrize("at", [0.7, 1.25, 3.3])
def test_it_begins_where_the_car_is_on_the_bend(at: float) -> None:
    car = (RADIUS * math.sin(at / RADIUS), RADIUS * (1.0 - math.cos(at / RADIUS)))
    found = candidate(circle([10.0] * 8), *car)
    assert math.dist((found["x"][0], found["y"][0]), car) < 0.01
    assert math.hypot(found["x"][0], found["y"][0] - RADIUS) == pytest.approx(RADIUS, abs=1e-3)
    assert found["heading"][0] == pytest.approx(at / RADIUS, abs=1e-3)
    assert found["s"][0] == found["t"][0] == 0.0
    assert found["s"][-1] == pytest.approx(17.5 - at, abs=0.02)


def test_it_ends_with_the_first_sample_at_rest() -> None:
    found = candidate(circle([10.0, 7.0, 0.0, 0.0, 0.0]), 0.0, 0.0)
    assert found["v"] == [10.0, 7.0, 0.0]
    assert {len(column) for column in found.values()} == {3}
    assert found["t"] == [0.0, pytest.approx(5.0 / 17.0), pytest.approx(5.0 / 17.0 + 5.0 / 7.0)]


def test_a_car_that_stands_stays() -> None:
    found = candidate(circle([0.0] * 4), 0.0, 0.0)
    assert found["v"] == [0.0, 0.0]
    assert found["x"] == [0.0, 0.0]
    assert found["t"] == [0.0, 0.1]


def test_a_car_that_stands_may_drive_off() -> None:
    found = candidate(circle([0.0, 3.0, 4.0, 0.0, 0.0]), 0.0, 0.0)
    assert found["v"] == [0.0, 3.0, 4.0, 0.0]


def test_times_are_those_of_constant_acceleration() -> None:
    v0, a = 20.0, -4.0
    exact = [0.1 * i for i in range(40)]
    s = [v0 * t + a * t * t / 2 for t in exact]
    assert times(s, [v0 + a * t for t in exact]) == pytest.approx(exact)
