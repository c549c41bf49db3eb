"""Noise, smoother and braking against motions that are known, and against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from support import field_logs
from support.field_logs import Floats
from support.length import shared_out
from trackmarshal.scenarios.field import candidates, smoother
from trackmarshal.scenarios.field.candidates import Braking
from trackmarshal.scenarios.field.log import Log
from trackmarshal.scenarios.field.noise import Noise, estimate
from trackmarshal.scenarios.field.smoother import Motion

#: What the made-up sensors do: place m, heading rad, speed m/s, yaw rate rad/s.
PLACE, HEADING, SPEED, YAW = 0.05, 0.004, 0.1, 0.003


def as_log(columns: dict[str, Floats]) -> Log:
    t, x, y, heading, v, yaw = columns.values()
    return Log(t, x, y, np.angle(np.exp(1j * heading)), v, yaw, 0.0, "made up", "")


def noisy_ring(seed: int) -> tuple[dict[str, Floats], Log]:
    truth = field_logs.ring()
    return truth, as_log(field_logs.noisy(truth, seed, PLACE, HEADING, SPEED, YAW))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_noise_is_found_from_the_log_alone(seed: int) -> None:
    noise = estimate(noisy_ring(seed)[1])
    assert noise is not None
    # Of the way between two samples, the mean speed times the step is taken off, noise of it and all: never less than there is.
    assert PLACE * 0.9 < noise.along < PLACE * 1.15
    assert PLACE * 0.9 < noise.across < PLACE * 1.15 + 15.0 / 25 * HEADING
    assert HEADING * 0.9 < noise.heading < HEADING * 2.0
    assert SPEED * 0.9 < noise.speed < SPEED * 1.6
    assert YAW * 0.9 < noise.yaw_rate < YAW * 2.0


@pytest.mark.parametrize("seed", shared_out([1, 2, 3], 3))
def test_gentle_bends_are_found_in_a_noisy_heading_alone(seed: int) -> None:
    """At 50 Hz without a yaw rate, 0.9 m/s^2 to either side, every 15 s: from sample to sample the heading turns by noise, and every bend was
    ironed out."""
    t = np.arange(3000) / 50
    v, rate = 26.0, 0.9 / 26.0 * np.sin(2 * np.pi * t / 15)
    heading = np.cumsum(rate) / 50
    columns = {
        "time": t, "x": np.cumsum(v * np.cos(heading)) / 50, "y": np.cumsum(v * np.sin(heading)) / 50, "heading": heading,
        "v": np.full_like(t, v), "yaw": rate,
    }  # fmt: skip
    log = replace(as_log(field_logs.noisy(columns, seed, PLACE, 0.002, SPEED, YAW)), yaw_rate=None)
    noise = estimate(log)
    assert noise is not None
    motion = smoother.smooth(log, noise)
    turned = np.angle(np.exp(1j * (motion.heading - heading)))
    assert turned[50:-50].std() < 0.002
    assert all(0.2 < value < 2.0 for value in motion.innovations.values())


def test_too_little_motion_tells_no_noise() -> None:
    assert estimate(as_log(field_logs.straight(14.0))) is None


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_smoother_finds_the_motion(seed: int) -> None:
    """Far closer to the truth than the log is, in every column; and acceleration and curvature, which no sensor gave."""
    truth, log = noisy_ring(seed)
    noise = estimate(log)
    assert noise is not None
    motion = smoother.smooth(log, noise)
    inner = slice(25, -25)
    for name, deviation in (("x", PLACE), ("y", PLACE), ("v", SPEED)):
        error = getattr(motion, name) - truth[name]
        assert error[inner].std() < 0.5 * deviation
    turned = np.angle(np.exp(1j * (motion.heading - truth["heading"])))
    assert turned[inner].std() < 0.5 * HEADING
    assert np.abs(motion.kappa[inner] - 0.01).max() < 0.002
    assert np.abs(motion.a[inner]).max() < 0.5
    assert not motion.standing.any()
    assert all(0.2 < value < 2.0 for value in motion.innovations.values())


def test_columns_of_the_motion_are_one_motion() -> None:
    """The way is the integral of the speed, and the heading is where the car goes: told by differences, with nothing of the smoother."""
    log = as_log(field_logs.noisy(field_logs.straight(40.0), 5, PLACE, HEADING, SPEED, YAW))
    noise = estimate(log)
    assert noise is not None
    motion = smoother.smooth(log, noise)
    dt = np.diff(motion.t)
    assert np.abs(np.diff(motion.s) / dt - 0.5 * (motion.v[1:] + motion.v[:-1]))[150:].max() < 0.1
    assert np.abs(np.hypot(np.diff(motion.x), np.diff(motion.y)) - np.diff(motion.s)).max() < 0.02
    assert (
        np.abs(np.diff(motion.v) / dt - motion.a[:-1])[~(motion.standing[1:] | motion.standing[:-1])].max()
        < 0.2
    )


def test_a_car_that_stands_is_in_one_place() -> None:
    """Whatever its sensors say: the speed reads -0.35 m/s, and the place jumps."""
    columns = field_logs.straight(40.0)
    rest = columns["time"] < 4.0
    columns["v"] = np.where(rest, -0.35 * (columns["time"] > 1.0), columns["v"])
    columns["x"] = np.where(columns["time"] > 2.0, columns["x"] + 0.1, columns["x"])
    log = as_log(field_logs.noisy(columns, 6, 0.01, HEADING, 0.02, YAW))
    noise = estimate(log)
    assert noise is not None
    motion = smoother.smooth(log, replace(noise, speed=max(noise.speed, 0.15)))
    held = motion.t < 3.5
    assert motion.standing[held].all()
    assert np.unique(motion.v[held]).tolist() == [0.0]
    assert len(np.unique(motion.s[held])) == 1
    assert len(np.unique(motion.x[held].round(9))) == 1
    assert motion.v.min() >= 0.0


def motion_of(t: Floats, v: Floats, kappa: float) -> Motion:
    """A motion at constant curvature, exactly."""
    s = np.concatenate([[0.0], np.cumsum(np.diff(t) * 0.5 * (v[1:] + v[:-1]))])
    psi = kappa * s
    x, y = (np.sin(psi) / kappa, (1.0 - np.cos(psi)) / kappa) if kappa else (s, np.zeros_like(s))
    return Motion(t, s, x, y, psi, v, np.gradient(v, t), np.full_like(s, kappa), v == 0.0, {})


T = np.arange(0.0, 30.0, 0.04)


@pytest.mark.parametrize(("v", "brake"), [(20.0, 8.0), (10.0, 3.0), (5.5, 9.3)])
def test_braking_straight_on(v: float, brake: float) -> None:
    """Without drag: v / b seconds and v^2 / 2b metres."""
    (found,) = candidates.emergency(
        motion_of(T, np.full_like(T, v), 0.0), np.array([1.0]), 0.1, Braking(brake, 99.0, 0.0)
    )
    assert found is not None
    assert found["t"][-1] == pytest.approx(v / brake, abs=0.011)
    assert found["s"][-1] == pytest.approx(v * v / (2 * brake), abs=0.01)
    assert found["v"][-1] == 0.0
    assert found["a"] == pytest.approx([-brake] * len(found["a"]), abs=1e-6)


def test_drag_helps_and_the_brakes_limit() -> None:
    """With drag c: from v to rest at b + c v^2 in atan(v sqrt(c / b)) / sqrt(b c) seconds."""
    (found,) = candidates.emergency(
        motion_of(T, np.full_like(T, 60.0), 0.0), np.array([1.0]), 0.1, Braking(9.0, 6.0, 0.0007)
    )
    assert found is not None
    assert found["t"][-1] == pytest.approx(
        math.atan(60.0 * math.sqrt(0.0007 / 6.0)) / math.sqrt(6.0 * 0.0007), abs=0.03
    )
    assert found["a"][0] == pytest.approx(-6.0 - 0.0007 * 3600.0, abs=0.03)


def test_in_a_bend_what_is_left_of_the_grip_brakes() -> None:
    braking = Braking(10.0, 99.0, 0.0)
    motion = motion_of(T, np.full_like(T, 18.0), 0.02)
    (found,) = candidates.emergency(motion, np.array([1.0]), 0.1, braking)
    assert found is not None
    used = np.hypot(found["a"], np.square(found["v"]) * found["kappa"])[:-1]
    assert used == pytest.approx(np.full(len(used), 10.0), abs=0.05)
    radius = np.hypot(np.array(found["x"]), np.array(found["y"]) - 50.0)
    assert radius == pytest.approx(np.full(len(radius), 50.0), abs=0.01)  # on the path that was driven


def test_it_stops_where_the_car_did_at_the_latest() -> None:
    v = np.clip(6.0 * (5.0 - T), 0.0, 12.0)
    motion = motion_of(T, v, 0.0)
    (found,) = candidates.emergency(motion, np.array([3.5]), 0.1, Braking(2.0, 99.0, 0.0))
    assert found is not None
    assert found["v"][-1] == 0.0
    assert motion.s[-1] - found["s"][-1] == pytest.approx(float(np.interp(3.5, T, motion.s)), abs=0.05)


def test_a_car_that_stands_stays_and_a_log_that_ends_has_no_braking() -> None:
    stands = motion_of(T, np.zeros_like(T), 0.0)
    (found,) = candidates.emergency(stands, np.array([2.0]), 0.1, Braking(9.0, 99.0, 0.0))
    assert found is not None
    assert found["t"] == [0.0, 0.1]
    assert found["x"] == [0.0, 0.0]
    assert found["v"] == [0.0, 0.0]
    fast = motion_of(T, np.full_like(T, 20.0), 0.0)
    assert candidates.emergency(fast, np.array([28.0, 29.5]), 0.1, Braking(9.0, 99.0, 0.0))[1] is None


def test_what_does_not_come_to_rest_in_the_middle_of_a_log_is_no_end_of_it() -> None:
    """Round a circle with more than the grip that may be taken, and off it: the cycles behind were left out as if the log ended there."""
    t = np.arange(0.0, 120.0, 0.04)
    round_, straight = (motion_of(t, np.full_like(t, 20.0), kappa) for kappa in (0.02, 0.0))
    motion = replace(round_, kappa=np.where(t < 90.0, round_.kappa, straight.kappa))
    with pytest.raises(candidates.NoRest) as caught:
        candidates.emergency(motion, np.array([5.0, 10.0, 100.0]), 0.1, Braking(2.0, 99.0, 0.0))
    assert caught.value.t == 5.0
    assert candidates.emergency(motion, np.array([100.0]), 0.1, Braking(2.0, 99.0, 0.0))[0] is not None


def turned_in_three() -> Motion:
    """Straight ahead at 4 m/s until 12 s, back around a bend of 12.5 m at 2 m/s until 20 s, and ahead again in another direction."""
    v = np.clip(4.0 * (12.0 - T), 0.0, 4.0) - np.clip(4.0 * np.minimum(T - 12.0, 20.0 - T), 0.0, 2.0)
    v += np.clip(4.0 * (T - 20.0), 0.0, 4.0)
    kappa = np.where((T > 12.0) & (T < 20.0), 0.08, 0.0)
    ds = np.diff(T) * 0.5 * (v[1:] + v[:-1])
    s = np.concatenate([[0.0], np.cumsum(ds)])
    psi = np.concatenate([[0.0], np.cumsum(ds * kappa[1:])])
    half = 0.5 * (psi[1:] + psi[:-1])
    x, y = (np.concatenate([[0.0], np.cumsum(ds * part)]) for part in (np.cos(half), np.sin(half)))
    return Motion(T, s, x, y, psi, v, np.gradient(v, T), kappa, v == 0.0, {})


@pytest.mark.parametrize(("t", "v"), [(5.0, 4.0), (16.0, -2.0), (22.0, 4.0), (26.0, 4.0)])
def test_a_car_that_turns_back_is_braked_where_it_is(t: float, v: float) -> None:
    """From the place and the speed of the cycle, v^2 / 2b metres along the heading: not on a path of before, and backwards where it drives so."""
    motion = turned_in_three()
    (found,) = candidates.emergency(motion, np.array([t]), 0.1, Braking(2.0, 99.0, 0.0))
    (driven,) = candidates.driving(motion, np.array([t]), 1.0, 0.1)
    assert found is not None
    for name in ("x", "y", "heading", "v"):
        assert found[name][0] == pytest.approx(driven[name][0], abs=1e-5)
    assert found["v"][0] == pytest.approx(v)
    assert found["v"][-1] == 0.0
    assert found["a"][0] == pytest.approx(-math.copysign(2.0, v), abs=0.05)  # the bend takes 0.02 of it
    assert found["s"][-1] == pytest.approx(v * v / 4.0, abs=0.02)
    assert driven["s"] == pytest.approx(abs(v) * np.array(driven["t"]), abs=1e-5)
    went = (found["x"][-1] - found["x"][0]) * math.cos(found["heading"][0])
    went += (found["y"][-1] - found["y"][0]) * math.sin(found["heading"][0])
    assert went == pytest.approx(math.copysign(v * v / 4.0, v), abs=0.03)


def test_before_it_turns_back_it_stands() -> None:
    """Where brakes would take longer than the car did, and in the cycles between: each has a braking, since none of them is the log's end."""
    motion = turned_in_three()
    times = np.arange(11.0, 22.0, 0.04)
    found = candidates.emergency(motion, times, 0.1, Braking(2.0, 99.0, 0.0))
    driven = candidates.driving(motion, times, 1.0, 0.1)
    for braked, columns in zip(found, driven):
        assert braked is not None
        assert [braked[name][0] for name in ("x", "y")] == pytest.approx(
            [columns[name][0] for name in ("x", "y")], abs=0.01
        )
        assert braked["v"][0] == pytest.approx(columns["v"][0], abs=0.17)
        assert np.diff(braked["t"]).min() > 0.0
        assert np.diff(braked["s"]).min() >= 0.0


def test_what_was_driven_is_cut_out_of_the_motion() -> None:
    motion = motion_of(T, np.full_like(T, 10.0), 0.01)
    found = candidates.driving(motion, np.array([1.0, 2.0]), 1.0, 0.25)
    for start, columns in zip((1.0, 2.0), found):
        assert columns["t"] == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0])
        assert columns["s"] == pytest.approx([0.0, 2.5, 5.0, 7.5, 10.0])
        assert columns["heading"] == pytest.approx(0.01 * (10.0 * start + np.array(columns["s"])), abs=1e-6)


def test_declared_noise_is_used() -> None:
    assert set(Noise(1, 2, 3, 4, 5, 6, 7).named()) == {
        "along",
        "across",
        "heading",
        "speed",
        "yaw_rate",
        "jerk",
        "lateral_jerk",
    }
    assert Noise(1, 2, 3, 4, 5, 6, 7).place == 2
