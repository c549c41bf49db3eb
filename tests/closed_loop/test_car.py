"""The car obeys what its equations say in the cases that can be worked out by hand."""

from __future__ import annotations

import math

import pytest

from closed_loop.car import Build, Car, G, State


def test_it_brakes_as_asked_and_no_harder_than_its_tyres() -> None:
    for asked, had in ((-8.0, 8.0), (-40.0, 1.5 * G)):
        car = Car(Build(drag=0.0), State(0.0, 0.0, 0.0, 40.0, pull=asked))
        car.drive(0.0, asked, 1.0)
        assert 40.0 - car.state.along == pytest.approx(had, rel=0.01)


def test_drag_alone_slows_it_down() -> None:
    build = Build()
    car = Car(build, State(0.0, 0.0, 0.0, 50.0))
    car.drive(0.0, 0.0, 4.0)
    # dv/dt = -k v^2, so 1/v grows by k t
    assert 1.0 / car.state.along == pytest.approx(1.0 / 50.0 + build.drag / build.mass * 4.0, rel=1e-3)


def test_it_stands_when_it_has_stopped_and_does_not_roll_back() -> None:
    car = Car(Build(), State(3.0, 4.0, 0.3, 2.5))
    car.drive(0.0, -5.0, 3.0)
    at = (car.state.x, car.state.y)
    car.drive(0.1, -5.0, 1.0)
    assert car.state.standing
    assert (car.state.x, car.state.y) == at
    assert math.hypot(at[0] - 3.0, at[1] - 4.0) == pytest.approx(
        2.5**2 / (2 * 5.0), rel=0.25
    )  # the brakes lag


def test_slow_circles_have_the_radius_of_the_steering() -> None:
    build = Build(drag=0.0)
    car = Car(build, State(0.0, 0.0, 0.0, 4.0))
    car.drive(0.15, 0.0, 3.0)
    assert car.state.yaw / car.state.v == pytest.approx(math.tan(0.15) / build.base, rel=0.04)


def test_cornering_never_exceeds_the_grip() -> None:
    car = Car(Build(), State(0.0, 0.0, 0.0, 40.0))
    for _ in range(200):
        before = (
            car.state.along * math.cos(car.state.heading) - car.state.across * math.sin(car.state.heading),
            car.state.along * math.sin(car.state.heading) + car.state.across * math.cos(car.state.heading),
        )
        car.drive(0.4, 5.0, 0.01)
        after = (
            car.state.along * math.cos(car.state.heading) - car.state.across * math.sin(car.state.heading),
            car.state.along * math.sin(car.state.heading) + car.state.across * math.cos(car.state.heading),
        )
        drag = Build().drag * 40.0**2 / Build().mass
        assert math.dist(before, after) / 0.01 <= 1.5 * G + drag + 1e-6


def test_it_is_stable_under_braking() -> None:
    car = Car(Build(), State(0.0, 0.0, 0.0, 50.0, yaw=0.1))
    car.drive(0.0, -10.0, 2.0)
    assert abs(car.state.yaw) < 0.1
