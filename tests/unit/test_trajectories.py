"""Helpers that complete, convert, cut and resample a planner's trajectories, held against motions known in closed form."""

from __future__ import annotations

import gzip
import json
import math
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.shared import shared
from trackmarshal.errors import TrackmarshalError

RADIUS = 16.0


def arc(turn: float = 1.0, v: float = 10.0, step: float = 2.5, count: int = 12) -> dict[str, Any]:
    """A circle through the origin, at first along +x, at constant speed; `turn` is -1 for a right-hander."""
    s = step * np.arange(count)
    angle = s / RADIUS
    return {
        "t": s / v,
        "s": s,
        "x": RADIUS * np.sin(angle),
        "y": turn * RADIUS * (1.0 - np.cos(angle)),
        "heading": turn * angle,
        "kappa": np.full(count, turn / RADIUS),
        "v": np.full(count, v),
        "a": np.zeros(count),
    }


def braking(v: float, b: float, step: float) -> dict[str, Any]:
    """Straight on, braked to rest at b, sampled every `step` m, as grid planners do: the last step goes a whole one."""
    s = step * np.arange(math.ceil(v * v / (2 * b) / step) + 3)
    speed = np.sqrt(np.maximum(0.0, v * v - 2 * b * s))
    columns = {"x": s, "y": 0.0 * s, "heading": 0.0 * s, "kappa": 0.0 * s, "v": speed}
    return tm.complete(columns)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_direction_and_curvature_of_a_circle(turn: float) -> None:
    plan = arc(turn)
    np.testing.assert_allclose(tm.curvature_along(plan["x"], plan["y"]), plan["kappa"], rtol=1e-12)
    np.testing.assert_allclose(tm.direction_along(plan["x"], plan["y"]), plan["heading"], atol=1e-12)


def test_arc_length_is_that_of_the_chords() -> None:
    plan = arc()
    chord = 2.0 * RADIUS * math.sin(2.5 / RADIUS / 2.0)
    np.testing.assert_allclose(tm.arc_length(plan["x"], plan["y"]), chord * np.arange(12), rtol=1e-12)


def test_acceleration_and_time_are_exact_where_it_is_constant() -> None:
    s = np.linspace(0.0, 20.0, 9)
    v = np.sqrt(400.0 - 16.0 * s)
    np.testing.assert_allclose(tm.acceleration_along(s, v)[:-1], -8.0, rtol=1e-12)
    np.testing.assert_allclose(tm.time_along(s, v), (20.0 - v) / 8.0, atol=1e-12)


def test_complete_keeps_what_is_there() -> None:
    plan = arc()
    made = tm.complete(
        {
            **{name: plan[name] for name in ("x", "y", "v")},
            "heading": plan["heading"] + 0.5,
            "grip": plan["v"],
        }
    )
    assert set(made) == {"t", "s", "x", "y", "heading", "kappa", "v", "a", "grip"}
    np.testing.assert_array_equal(made["heading"], plan["heading"] + 0.5)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_what_reverses_points_against_its_travel(turn: float) -> None:
    """Nose along +x at the origin, backwards around a circle of 20 m: what was told ahead at the same places is told with v negative, to rest."""
    psi = np.linspace(0.0, -0.8, 9)  # heading = kappa * way, and the way is negative
    x, y = 20.0 * np.sin(psi), turn * 20.0 * (1.0 - np.cos(psi))
    made = tm.complete({"x": x, "y": y, "v": [-2.0] * 8 + [0.0]})
    assert made["heading"] == pytest.approx(turn * psi, abs=1e-9)
    assert made["kappa"] == pytest.approx(np.full(9, turn / 20.0))
    assert made["a"][-2] > 0.0
    assert np.diff(made["t"]).min() > 0.0
    # a speed about 0 at the end turns nothing
    noisy = tm.complete({"x": x, "y": y, "v": [2.0] * 8 + [-1e-3]})
    assert np.cos(noisy["heading"][0]) == pytest.approx(-1.0)


@pytest.mark.parametrize("first", [1.0, -1.0])
@pytest.mark.parametrize("given", [[], ["heading"], ["kappa"]], ids=lambda names: "_".join(names) or "none")
def test_of_what_is_driven_both_ways_nobody_knows_where_it_points(given: list[str], first: float) -> None:
    """Out of a bay and on: the car points to +x all the while, and the path turned round with it."""
    v = [first * speed for speed in (1.0, 1.0, 0.0, -1.0, -1.0)]
    driven = {"x": [0.0, first, 2 * first, first, 0.0], "y": [0.0] * 5, "v": v}
    with pytest.raises(TrackmarshalError, match="drives ahead and backwards") as caught:
        tm.complete({**driven, **{name: [0.0] * 5 for name in given}})
    assert caught.value.code == "D192"
    assert tm.complete({**driven, "heading": [0.0] * 5, "kappa": [0.0] * 5})["t"][-1] > 0.0


@pytest.mark.parametrize("unknown", range(5))
def test_an_unknown_speed_does_not_hide_that_both_ways_are_driven(unknown: int) -> None:
    v: list[float | None] = [1.0, 1.0, -1.0, -1.0, -1.0]
    v[unknown] = None
    with pytest.raises(TrackmarshalError, match="drives ahead and backwards"):
        tm.complete({"x": [0.0, 1.0, 2.0, 1.0, 0.0], "y": [0.0] * 5, "v": v})


def test_a_speed_just_below_rest_turns_nothing_round() -> None:
    """As a planner's last sample may have it: the path leads on."""
    made = tm.complete({"x": [0.0, 2.0, 3.0, 3.1], "y": [0.0] * 4, "v": [3.0, 2.0, 0.5, -0.001]})
    assert made["heading"].tolist() == [0.0] * 4


def test_standing_samples_point_where_the_path_does() -> None:
    assert tm.direction_along([0, 0, 1, 2, 2], [0, 0, 0, 0, 0]).tolist() == [0.0] * 5
    with pytest.raises(tm.TrackmarshalError, match="all samples are in one place"):
        tm.complete({"x": [1.0, 1.0], "y": [0.0, 0.0], "v": [0.0, 0.0]})


@pytest.mark.parametrize(
    ("given", "convention", "expected"),
    [
        (0.0, {"zero": "+y"}, math.pi / 2),
        (math.pi / 2, {"zero": "+y"}, math.pi),
        (90.0, {"zero": "north", "clockwise": True, "degrees": True}, 0.0),
        (-90.0, {"degrees": True}, -math.pi / 2),
        (3 * math.pi, {}, math.pi),
        (0.25, {"zero": 0.5, "clockwise": True}, 0.25),
    ],
)
def test_headings_of_other_conventions(given: float, convention: dict[str, Any], expected: float) -> None:
    assert tm.heading_from(given, **convention) == pytest.approx(expected, abs=1e-12)
    assert tm.heading_from([given] * 2, **convention) == pytest.approx([expected] * 2, abs=1e-12)


@pytest.mark.parametrize(
    ("call", "code"),
    [
        (lambda: tm.heading_from(0.0, "up"), "D193"),
        (lambda: tm.heading_from(0.0, math.nan), "D193"),
        (lambda: tm.arc_length([0.0, 1.0], [0.0]), "D191"),
        (lambda: tm.arc_length([], []), "D191"),
        (lambda: tm.arc_length(["a"], [0.0]), "D191"),
        (lambda: tm.arc_length(3.0, 4.0), "D191"),
        (lambda: tm.arc_length({0.0, 3.0}, {0.0, 4.0}), "D191"),
        (lambda: tm.arc_length(bytearray(2), [0.0, 4.0]), "D191"),
        (lambda: tm.time_along(np.array([0, 1], "m8[ns]"), [1.0, 1.0]), "D191"),
        (lambda: tm.time_along(np.array([0, 1], "M8[ns]"), [1.0, 1.0]), "D191"),
        (lambda: tm.time_along([0.0, np.timedelta64(1, "ns")], [1.0, 1.0]), "D191"),
        (lambda: tm.arc_length([0.0, 1.0], np.array([5.3e6, 5.3e6], np.float32)), "D191"),
        (lambda: tm.arc_length([0.0, 1.0], list(np.array([5.3e6, 5.3e6], np.float32))), "D191"),
        (lambda: tm.arc_length(np.array([131_072.0, 0.0], ">f4"), [0.0, 1.0]), "D191"),
        (lambda: tm.arc_length(np.array([0.0, 16.0], np.float16), [0.0, 1.0]), "D191"),
        (lambda: tm.complete({"x": [0.0], "y": [0.0]}), "D192"),
        (lambda: tm.complete([1.0]), "D191"),  # type: ignore[arg-type]
        (lambda: tm.cut_at_rest(arc(), -1.0), "D194"),
        (lambda: tm.resample(arc()), "D194"),
        (lambda: tm.resample(arc(), count=1), "D194"),
        (lambda: tm.resample(arc(), count=10**400), "D194"),
        (lambda: tm.resample(arc(), spacing=math.nan), "D194"),
        (lambda: tm.resample(arc(), spacing=10**400), "D194"),
        (lambda: tm.heading_from(0.0, 10**400), "D193"),
        (lambda: tm.resample(arc(), count=5, step=0.1), "D194"),
        (lambda: tm.resample({**arc(), "t": np.zeros(12)}, count=5), "D194"),
    ],
)
def test_what_cannot_be_done_is_refused(call: Any, code: str) -> None:
    with pytest.raises(tm.TrackmarshalError) as caught:
        call()
    assert caught.value.code == code
    assert caught.value.help


def test_whole_numbers_beyond_all_doubles_are_infinite() -> None:
    """As to the Supervisor's own door, which says then that they are not finite."""
    made = tm.complete({"x": [0, 1], "y": [0, 0], "v": [1, 1], "about": [10**400, -(10**400)]})
    assert made["about"].tolist() == [math.inf, -math.inf]
    assert math.isnan(tm.heading_from(10**400))


def test_short_floats_are_taken_where_they_have_lost_nothing() -> None:
    """65 km from the origin they are 8 mm apart; of a survey's northing the door would refuse them, and the helpers make doubles of them."""
    for short in (np.array([65_536.0, 65_539.0], np.float32), [np.float32(65_536.0), np.float32(65_539.0)]):
        assert tm.arc_length(short, np.zeros(2, np.float16)).tolist() == [0.0, 3.0]
    far = np.array([np.nan, np.inf, 1e10], np.float32)
    columns = tm.complete({"x": [0.0, 1.0, 2.0], "y": np.zeros(3), "v": np.ones(3), "about": far})
    assert columns["about"].tolist()[1:] == [math.inf, 1e10]


@pytest.mark.parametrize("v", [9.8, 20.0, 24.49, 31.7])
@pytest.mark.parametrize("step", [0.7, 2.5])
def test_cut_at_rest_is_where_braking_ends(v: float, step: float) -> None:
    """The closed form: rest after v^2 / (2 b) m and v / b s, whatever the samples made of the last step."""
    b = 12.0
    raw = braking(v, b, step)
    cut = tm.cut_at_rest(raw, speed=12.0)  # every tail, however fast its first sample
    assert cut["v"][-1] == 0.0
    assert cut["s"][-1] == pytest.approx(v * v / (2 * b), abs=0.011)
    # The first sample of the tail may be at rest itself, up to 1 cm early; at that deceleration that is 41 ms.
    assert cut["t"][-1] == pytest.approx(v / b, abs=0.042)
    assert cut["t"][-1] <= raw["t"][-1] + 1e-9
    assert np.all(np.diff(cut["t"]) > 0)
    mean = np.diff(cut["v"]) / np.diff(cut["t"])
    np.testing.assert_allclose(mean, -b, rtol=0.01)
    inside = np.minimum(cut["a"][:-1], cut["a"][1:]) - 0.2 <= mean
    assert inside.all()


def test_a_tail_that_creeps_for_more_than_a_minute() -> None:
    """0.07 m/s, and rest 2.5 m further: 71 s. The car stands after a fraction of a millimetre."""
    v = [14.0, 12.0, 9.0, 5.0, 0.07, 0.0]
    plan = tm.complete({"x": 2.5 * np.arange(6.0), "y": np.zeros(6), "v": v})
    assert plan["t"][-1] - plan["t"][-2] > 71.0
    cut = tm.cut_at_rest(plan)
    assert cut["v"].tolist() == [14.0, 12.0, 9.0, 5.0, 0.0]
    assert cut["x"][-1] == 10.0
    assert cut["t"][-1] - cut["t"][-2] == pytest.approx(1.0)  # 2 * 2.5 m / 5 m/s
    assert tm.cut_at_rest(plan, speed=0.05)["t"][-1] == plan["t"][-1]


@pytest.mark.parametrize("samples", [1, 2, 3])
def test_what_stands_from_its_start_is_two_samples(samples: int) -> None:
    """However many it was planned with: the Supervisor refuses a trajectory of a single sample."""
    stands = [0.0] * samples
    plan = {"t": [0.1 * i for i in range(samples)], "x": [3.0] * samples, "y": [4.0] * samples, "v": stands}
    cut = tm.cut_at_rest(plan)
    assert {name: column.tolist() for name, column in cut.items()} == {
        "t": [0.0, 0.1], "x": [3.0, 3.0], "y": [4.0, 4.0], "v": [0.0, 0.0],
    }  # fmt: skip


def test_what_is_never_cut() -> None:
    drives = arc()
    assert all(np.array_equal(tm.cut_at_rest(drives)[name], drives[name]) for name in drives)
    creeping = tm.complete({"x": [0.0, 1.0, 2.0], "y": [0.0] * 3, "v": [0.5, 0.5, 0.5]})
    assert tm.cut_at_rest(creeping)["v"].tolist() == [0.5] * 3  # nothing says that it brakes
    undefined = braking(20.0, 12.0, 2.5)
    undefined["kappa"][-1] = math.nan
    assert math.isnan(tm.cut_at_rest(undefined)["kappa"][-1])
    standing = tm.cut_at_rest({**{name: np.zeros(5) for name in "xyv"}, "t": np.arange(5.0)})
    assert (standing["t"].tolist(), standing["v"].tolist()) == ([0.0, 0.1], [0.0, 0.0])


@pytest.mark.parametrize("way", [{"count": 40}, {"spacing": 0.5}, {"step": 0.05}])
def test_resampled_samples_lie_on_the_circle(way: dict[str, Any]) -> None:
    plan = arc()
    made = tm.resample(plan, **way)
    assert len(made["t"]) > 30
    radius = np.hypot(made["x"], made["y"] - RADIUS)
    assert np.abs(radius - RADIUS).max() < 1e-3  # a straight line between samples would be 0.049 m off
    np.testing.assert_allclose(made["heading"], made["s"] / RADIUS, atol=1e-9)
    for name, column in plan.items():
        assert (made[name][0], made[name][-1]) == (column[0], column[-1])


@pytest.mark.parametrize("way", [{"count": 40}, {"spacing": 0.3}, {"step": 0.02}])
def test_resampled_speeds_are_those_of_constant_deceleration(way: dict[str, Any]) -> None:
    plan = {**braking(20.0, 8.0, 5.0)}
    made = tm.resample({name: column[:6] for name, column in plan.items()}, **way)
    np.testing.assert_allclose(made["v"], np.sqrt(400.0 - 16.0 * made["s"]), atol=1e-6)
    np.testing.assert_allclose(made["t"], (20.0 - made["v"]) / 8.0, atol=1e-6)


@pytest.mark.parametrize("way", [{"count": 40}, {"spacing": 0.5}, {"step": 0.05}])
def test_what_reverses_is_resampled_as_what_drives_ahead(way: dict[str, Any]) -> None:
    """The same places at the same times, with the nose the other way: headings are half a turn apart, and speeds the negative ones."""
    plan = arc()
    back = {name: column for name, column in plan.items() if name in ("x", "y", "t", "s")}
    made = tm.resample(tm.complete({**back, "v": -np.asarray(plan["v"])}), **way)
    ahead = tm.resample(tm.complete({**back, "v": plan["v"]}), **way)
    for name, sign in (("t", 1), ("x", 1), ("y", 1), ("v", -1), ("kappa", -1)):
        np.testing.assert_allclose(made[name], sign * ahead[name], atol=1e-12)
    np.testing.assert_allclose(np.cos(made["heading"] - ahead["heading"]), -1.0)


def test_what_reverses_is_cut_at_rest_as_what_drives_ahead() -> None:
    """2 m before its rest it is at 2 m/s, and would stand 0.2 m further: the acceleration until there is against its speed."""
    x, v = np.array([0.0, 2.0, 2.4, 4.4]), np.array([4.5, 2.5, 2.0, 0.0])
    ahead = tm.cut_at_rest(tm.complete({"x": x, "y": 0.0 * x, "v": v}))
    back = tm.cut_at_rest(tm.complete({"x": -x, "y": 0.0 * x, "v": -v}))
    assert ahead["x"][-1] < 4.4
    assert ahead["a"].min() < -1.0
    for name, sign in (("t", 1), ("s", 1), ("x", -1), ("v", -1), ("a", -1)):
        np.testing.assert_allclose(back[name], sign * ahead[name], atol=1e-12)


def test_emergency_trajectories_of_a_real_planner_end_sooner() -> None:
    """Every one of 1,000: at rest, never further or later than planned, and no last step that takes longer than two seconds."""
    raw = gzip.decompress(shared("data", "planner", "modena.tmrec.jsonl.gz").read_bytes()).decode()
    longest = [0.0, 0.0]
    for line in raw.splitlines()[1::3]:
        plan = json.loads(line)["candidates"]["emergency"]
        cut = tm.cut_at_rest(plan, speed=3.0)
        assert cut["v"][-1] == 0.0
        assert cut["s"][-1] <= plan["s"][-1]
        assert cut["t"][-1] <= plan["t"][-1] + 1e-9
        assert np.all(np.diff(cut["t"]) > 0)
        for place, trajectory in enumerate((plan, cut)):
            longest[place] = max(longest[place], trajectory["t"][-1] - trajectory["t"][-2])
    assert longest[0] > 10.0
    assert longest[1] < 2.0


def test_a_tail_that_is_cut_points_the_shorter_way_round() -> None:
    """It brakes to rest between samples at pi - 0.01 and at -pi + 0.09: between them lies -pi, and not 0."""
    plan = {
        "s": [0.0, 2.5, 5.0, 7.5], "x": [0.0, -2.5, -5.0, -7.5], "y": [0.0] * 4, "v": [5.0, 2.0, 1.5, 0.0],
        "heading": [math.pi - 0.02, math.pi - 0.01, 0.09 - math.pi, 0.2 - math.pi],
    }  # fmt: skip
    share = 2.0**2 / (5.0**2 - 2.0**2)  # of the next step: at 4.2 m/s^2, it stands 0.48 m further
    made = tm.cut_at_rest(plan)
    assert made["heading"][-1] == pytest.approx(-math.pi - 0.01 + 0.1 * share)


def test_a_distance_that_goes_into_the_length_makes_no_sample_of_a_rounding() -> None:
    length = 3 * 0.1  # a rounding more than 0.3
    assert length / 0.1 > 3.0
    column = {"t": [0.0, 1.0], "s": [0.0, length], "x": [0.0, length], "y": [0.0] * 2, "heading": [0.0] * 2}
    made = tm.resample({**column, "v": [length] * 2}, spacing=0.1)
    assert made["s"] == pytest.approx([0.0, 0.1, 0.2, 0.3])


def test_true_is_no_length() -> None:
    with pytest.raises(tm.TrackmarshalError, match=r"`x\[0\]` is bool") as caught:
        tm.arc_length([True, 2.0], [0.0, 0.0])
    assert caught.value.code == "D191"
