"""The detection envelope of the paper's section V-D, against worked cases and against brute force."""

from __future__ import annotations

import math

import pytest

from support.envelope import Envelope, same_lane
from support.shared import oracle
from trackmarshal.scenarios.ground_truth import (
    LaneState,
    encounter,
    may_fire,
    must_fire,
    worst,
)


def test_worked_cases() -> None:
    cases = oracle("envelope_dev.json")["cases"]
    assert len(cases) == 200
    for case in cases:
        found = same_lane(case["gap0"], case["v"], case["u"], case["b"])
        assert found.earliest == (
            None if case["t_earliest"] is None else pytest.approx(case["t_earliest"], rel=1e-12, abs=1e-12)
        ), case
        assert found.latest == (
            None if case["t_latest"] is None else pytest.approx(case["t_latest"], rel=1e-12, abs=1e-12)
        ), case
        assert found.inverted == case["inverted"], case


def test_by_hand() -> None:
    # 40 m/s behind 20 m/s, 10 m/s^2: braking distance 80 m, critical gap 20^2 / 20 = 20 m
    found = same_lane(100.0, 40.0, 20.0, 10.0)
    assert found == Envelope(earliest=1.0, latest=4.0)
    assert [found.truth(t) for t in (0.9, 1.0, 3.9, 4.0, 9.0)] == [True, None, None, False, False]


def test_an_inverted_envelope_is_unsafe_from_the_latest_on() -> None:
    # 20 against 20 m/s, 10 m/s^2: braking distance 20 m, but 60 m are needed
    found = same_lane(100.0, 20.0, -20.0, 10.0)
    assert found == Envelope(earliest=2.0, latest=1.0)
    assert found.inverted
    assert [found.truth(t) for t in (0.9, 1.0, 1.5, 3.0)] == [True, False, False, False]


def test_never_is_safe() -> None:
    assert Envelope(None, None).truth(1e9) is True


@pytest.mark.parametrize("bad", [(1.0, 1.0, 1.0, 0.0), (math.nan, 1.0, 1.0, 1.0), (1.0, -1.0, 1.0, 1.0)])
def test_numbers_that_mean_nothing(bad: tuple[float, float, float, float]) -> None:
    with pytest.raises(ValueError, match="no envelope"):
        same_lane(*bad)


def car(s: float, d: float = 0.0, v: float = 0.0, sideways: float = 0.0) -> LaneState:
    return LaneState(s, d, v, sideways, reach=2.35, side=1.0)


@pytest.mark.parametrize("u", [0.0, 5.0, 12.0, 25.0, 30.0, -6.0])
def test_an_encounter_agrees_with_the_closed_form(u: float) -> None:
    gap, v, b, step = 120.0, 25.0, 8.0, 0.001
    times = [i * step for i in range(10_000)]
    truths = [encounter(car(v * t, v=v), car(gap + 4.7 + u * t, v=u), b) for t in times]
    latest = next((t for t, truth in zip(times, truths) if truth is False), None)
    earliest = next((t for t, truth in zip(times, truths) if truth is not True), None)
    closed = same_lane(gap, v, u, b)
    pairs = [(closed.latest, latest), (closed.earliest, earliest)]
    for expected, actual in pairs[: 2 if u >= 0.0 else 1]:
        if expected is None or expected > times[-1]:
            assert actual is None
        else:
            assert actual == pytest.approx(max(expected, 0.0), abs=1.1 * step)


def test_an_oncoming_car_may_be_fired_on_before_it_must_be() -> None:
    # 30 against 30 m/s, 13 m/s^2: braking distance 34.6 m, and 69.2 m for the other until then; at half of it, 207.7 m
    ego = car(0.0, v=30.0)
    assert encounter(ego, car(4.7 + 103.7, v=-30.0), 13.0) is False
    assert encounter(ego, car(4.7 + 103.9, v=-30.0), 13.0) is None
    assert encounter(ego, car(4.7 + 207.6, v=-30.0), 13.0) is None
    assert encounter(ego, car(4.7 + 207.8, v=-30.0), 13.0) is True
    assert encounter(ego, car(80.0, 2.01, v=-30.0), 13.0) is None
    assert encounter(ego, car(80.0, 2.99, v=-30.0), 13.0) is None
    assert encounter(ego, car(80.0, 3.01, v=-30.0), 13.0) is True
    assert encounter(ego, car(-6.0, v=-30.0), 13.0) is True


def test_the_other_lane_is_no_concern() -> None:
    ego = car(0.0, v=30.0)
    for d in (-2.01, 2.01):
        assert not may_fire(ego, car(10.0, d, v=0.0), 10.0)
        assert not must_fire(ego, car(10.0, d, v=0.0), 10.0)
    for d in (-1.99, 1.99):
        assert may_fire(ego, car(10.0, d, v=0.0), 10.0)
        assert must_fire(ego, car(10.0, d, v=0.0), 10.0)


def test_the_rear_vehicle_is_responsible() -> None:
    ego = car(0.0, v=30.0)
    behind = car(-6.0, v=60.0)
    assert not may_fire(ego, behind, 10.0)
    assert not must_fire(ego, behind, 10.0)


def brute_force(ego: LaneState, other: LaneState, b: float) -> bool:
    """Rectangles, moved in small steps until the ego stands."""
    stop, steps = ego.s_rate / b, 4000
    for i in range(steps + 1):
        t = stop * i / steps
        along = other.s + other.s_rate * t - ego.s - ego.s_rate * t + 0.5 * b * t * t
        across = other.d + other.d_rate * t - ego.d
        if abs(along) <= ego.reach + other.reach and abs(across) < ego.side + other.side:
            return True
    return False


def test_must_fire_agrees_with_brute_force() -> None:
    seen = set()
    for ahead in (3.0, 6.0, 10.0, 20.0, 40.0):
        for offset in (-6.0, -3.0, -1.0, 2.5, 5.0):
            for sideways in (-4.0, -1.0, 0.0, 2.0):
                for u in (-5.0, 0.0, 15.0, 28.0, 45.0):
                    ego, other = car(0.0, v=30.0), car(ahead, offset, u, sideways)
                    expected = brute_force(ego, other, 11.0)
                    seen.add(expected)
                    assert must_fire(ego, other, 11.0) == expected, (ahead, offset, sideways, u)
    assert seen == {True, False}


@pytest.mark.parametrize(
    ("truths", "expected"),
    [([], True), ([True, True], True), ([True, None], None), ([None, False, True], False)],
)
def test_the_worst_of_several(truths: list[bool | None], expected: bool | None) -> None:
    assert worst(truths) is expected
