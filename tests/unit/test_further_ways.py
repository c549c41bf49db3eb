"""Ways past the rules on plans, on the pose and on others that a physically minded reader found: none of them is safe, whichever evaluator looks.

Each cycle is the flawless one of `support.cycles`, its car at 20 m/s or as fast as it says, with one thing changed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from support.cycles import SPEED, cycle
from support.length import shared_out
from support.supervised import BACKENDS, against
from trackmarshal.runtime.cycle import Cycle

Columns = dict[str, Any]
LENGTH, WIDTH = 4.7, 2.8


def along(t: Any, s: Any, v: Any, a: Any, x: float = 0.0, heading: float = 0.0) -> Columns:
    """Columns of a trajectory that goes straight on from x m."""
    t, s, v, a = np.broadcast_arrays(*(np.asarray(each, dtype=float) for each in (t, s, v, a)))
    return {
        "t": t.copy(), "s": s.copy(), "x": x + s * np.cos(heading), "y": s * np.sin(heading), "heading": np.full(len(t), heading),
        "kappa": np.zeros(len(t)), "v": v.copy(), "a": a.copy(),
    }  # fmt: skip


def steady(v: float = SPEED, samples: int = 30, step: float = 0.1, heading: float = 0.0) -> Columns:
    t = np.arange(samples) * step
    return along(t, v * t, v, 0.0, heading=heading)


def braking(b: float = 8.0, v: float = SPEED, samples: int = 60, heading: float = 0.0) -> Columns:
    """To rest in equal times."""
    t = np.linspace(0.0, v / b, samples)
    columns = along(t, v * t - b * t**2 / 2, v - b * t, -b, heading=heading)
    columns["v"][-1] = 0.0
    return columns


def after(held: float, v: float, a: float, b: float, samples: int = 110) -> Columns:
    """For so many seconds with a, then braking to rest with b."""
    top = v + a * held
    t = np.concatenate(
        [np.linspace(0.0, held, samples // 2, endpoint=False), held + np.linspace(0.0, top / b, samples // 2)]
    )
    late = np.maximum(t - held, 0.0)
    early = np.minimum(t, held)
    s = v * early + a * early**2 / 2 + top * late - b * late**2 / 2
    columns = along(t, s, np.where(t < held, v + a * t, top - b * late), np.where(t < held, a, -b))
    columns["v"][-1] = 0.0
    return columns


def standing(x: float = 0.0) -> Columns:
    return along([0.0, 1.0], [0.0, 0.0], 0.0, 0.0, x)


def turning_in(v: float = 60.0, held: float = 0.3, across: float = 12.0) -> Columns:
    """A bend to the left at so many m/s^2 for so many seconds, then straight on."""
    t = np.linspace(0.0, 1.5, 60)
    s = v * t
    kappa = np.where(t < held, across / v**2, 0.0)
    heading = np.concatenate([[0.0], np.cumsum((kappa[1:] + kappa[:-1]) / 2 * np.diff(s))])
    middle = (heading[1:] + heading[:-1]) / 2
    columns = along(t, s, v, 0.0)
    columns["x"] = np.concatenate([[0.0], np.cumsum(np.cos(middle) * np.diff(s))])
    columns["y"] = np.concatenate([[0.0], np.cumsum(np.sin(middle) * np.diff(s))])
    return columns | {"heading": heading, "kappa": kappa}


def zigzag(v: float = 50.0, aside: float = 1.2) -> Columns:
    """From one side to the other every 3 m, while all headings and curvatures are those of a straight line."""
    s = np.arange(40) * np.hypot(3.0, aside)
    columns = along(s / v, s, v, 0.0)
    return columns | {"x": np.arange(40) * 3.0, "y": np.arange(40) % 2 * aside}


def cornering(corner: float = 0.19, v: float = SPEED, step: float = 0.001, steps: int = 8) -> Columns:
    """Round a corner in a few steps that are too short for anybody to look where they lead, the car pointing half-way all the time."""
    way = np.concatenate([np.full(15, 2.0), np.full(steps, step), np.full(25, 2.0)])
    leads = np.concatenate([np.zeros(15), np.linspace(0.0, corner, steps + 2)[1:-1], np.full(25, corner)])
    s = np.concatenate([[0.0], np.cumsum(way)])
    columns = along(s / v, s, v, 0.0)
    columns["x"] = np.concatenate([[0.0], np.cumsum(np.cos(leads) * way)])
    columns["y"] = np.concatenate([[0.0], np.cumsum(np.sin(leads) * way)])
    return columns | {"heading": np.full(len(s), corner / 2)}


def round_a_bend(columns: Columns, radius: float, middle: float) -> Columns:
    """The same on an arc to the left, from (0, middle - radius) on; the road's middle has the radius `middle` and goes through (0, 0)."""
    turned = columns["s"] / radius
    return columns | {
        "x": radius * np.sin(turned), "y": middle - radius * np.cos(turned), "heading": turned,
        "kappa": np.full(len(turned), 1 / radius),
    }  # fmt: skip


def tightly(columns: Columns, radius: float, said: float) -> Columns:
    """The same on an arc to the left, of which the column of curvatures says another radius."""
    return round_a_bend(columns, radius, radius) | {"kappa": np.full(len(columns["s"]), 1 / said)}


def bend(middle: float, half: float) -> dict[str, Any]:
    turned = np.linspace(0.0, 2 * np.pi, 200, endpoint=False)
    ring = np.column_stack([np.sin(turned), -np.cos(turned)])
    return {
        side: ring * radius + [0.0, middle]
        for side, radius in (("left", middle - half), ("right", middle + half))
    } | {"closed": True}


def falling_back(columns: Columns, by: float) -> Columns:
    """The same with one sample more, 2 mm on: from there on, the arc length is less by so much."""
    columns = {name: np.insert(values, 1, values[0]) for name, values in columns.items()}
    for name, more in (("t", 1e-4), ("x", 0.002), ("v", -1e-4)):
        columns[name][1] += more
    columns["s"][1:] -= by
    return columns


def late(columns: Columns, by: float) -> Columns:
    """Due at its last sample so much later."""
    return columns | {"t": np.append(columns["t"][:-1], columns["t"][-1] + by)}


def sooner(columns: Columns, share: float) -> Columns:
    """Due everywhere after so much of the time that its speeds say."""
    return columns | {"t": columns["t"] * share}


def wet(columns: Columns, grip: float) -> Columns:
    return columns | {"grip": np.full(len(columns["t"]), grip)}


def wet_first(columns: Columns, grip: float) -> Columns:
    wet_there = np.ones(len(columns["t"]))
    wet_there[0] = grip
    return columns | {"grip": wet_there}


def car(x: float, y: float = 0.0, v: float = 0.0, width: float = 2.0) -> dict[str, float]:
    return {"x": x, "y": y, "heading": 0.0, "v": v, "length": LENGTH, "width": width}


def thing(x: float, y: float = 0.0, length: float = 0.5, width: float = 0.5) -> dict[str, float]:
    return {"x": x, "y": y, "heading": 0.0, "length": length, "width": width}


def wide(end: float = 2000.0, half: float = 20.0) -> dict[str, Any]:
    return {
        side: np.array([[-50.0, y], [end / 2, y], [end, y]]) for side, y in (("left", half), ("right", -half))
    }


def made(
    driving: Columns, emergency: Columns, ego: Mapping[str, float] | None = None, objects: Any = (), obstacles: Any = (),
    track: Any = None,
) -> Cycle:  # fmt: skip
    given = cycle(0)
    for own, columns in ((given.driving, driving), (given.emergency, emergency)):
        own.clear()
        own.update(columns)
    given.signals["ego"].update({"v": float(driving["v"][0])} | dict(ego or {}))
    given.signals["objects"] = [{"id": f"o{i}"} | one for i, one in enumerate(objects)]
    given.signals["obstacles"] = [{"id": f"c{i}"} | one for i, one in enumerate(obstacles)]
    given.signals["track"] = track or wide()
    return given


#: What is done, and by which rules of which candidates it is found.
WAYS: dict[str, tuple[Cycle, set[tuple[str, str]]]] = {
    "a fallback that is due at rest in 1000 s": (
        made(steady(), late(braking(), 1000.0)), {("time_integrity", "emergency")}),
    "times of who drives a tenth faster, and brakes by a fifth more": (
        made(sooner(steady(60.0), 0.91), sooner(braking(12.9, 60.0), 0.91)), {("pace_integrity", "driving"), ("pace_integrity", "emergency")}),
    "a way to rest that an arc length hides": (
        made(steady(), falling_back(braking(3.0), 60.0), objects=[car(40.0, v=15.0)]),
        {("safe_fallback", "emergency"), ("fallback_collision", "emergency"), ("arc_length_integrity", "emergency")}),
    "20 deg aside at 60 m/s": (
        made(steady(60.0), braking(12.0, 60.0), {"heading": 0.34}), {("drift_match", "driving"), ("drift_match", "emergency")}),
    "a path that jumps aside and back": (
        made(zigzag(), braking(12.0, 50.0)),
        {("path_integrity", "driving"), ("corner_integrity", "driving"), ("swerve_integrity", "driving"), ("heading_integrity", "driving")}),
    "a fallback that drives on at 40 m/s for 20 s": (
        made(steady(40.0), after(20.0, 40.0, 0.0, 8.0, 110)), {("fallback_brakes", "emergency"), ("step_length", "emergency")}),
    "a fallback that drives on where only its first sample is wet": (
        made(steady(40.0), wet_first(after(10.0, 40.0, 0.0, 8.0, 120), 0.12)), {("fallback_brakes", "emergency")}),
    "over in 10 ms, in motion": (
        made(steady(samples=2, step=0.01), braking()), {("outlasts_cycle", "driving")}),
    "60 m in one step": (
        made(along([0.0, 1.2, 1.4], [0.0, 60.0, 70.0], 50.0, 0.0), braking(12.0, 50.0)), {("step_length", "driving")}),
    "round a corner in steps of a millimetre": (
        made(cornering(), braking(heading=0.095), {"heading": 0.095}),
        {("corner_integrity", "driving"), ("swerve_integrity", "driving")}),
    "round one with a single step of a millimetre in it": (
        made(cornering(steps=1), braking(heading=0.095), {"heading": 0.095}),
        {("corner_integrity", "driving"), ("swerve_integrity", "driving")}),
    "turning in beside a car": (
        made(turning_in(), braking(12.0, 60.0), objects=[car(1.0, 2.55, 60.0)]), {("planned_side", "driving")}),
    "turning in beside a faster car whose middle is behind": (
        made(turning_in(), braking(12.0, 60.0), objects=[car(-1.0, 2.55, 62.0)]), {("planned_side", "driving")}),
    "into one that stands, before the next decision": (
        made(turning_in(), braking(12.0, 60.0), objects=[car(12.0, 2.55)]),
        {("planned_side", "driving"), ("driving_collision", "driving")}),
    "over to another car on a wet road": (
        made(wet(steady(30.0, heading=-0.08), 0.2), wet(braking(1.9, 30.0, 110, -0.08), 0.2), {"heading": -0.08},
             [car(1.0, -3.7, 30.0)], track=wide(half=40.0)),
        {("planned_side", "driving"), ("planned_side", "emergency"), ("fallback_line", "emergency")}),
    "over in front of a car that is twice as fast": (
        made(steady(30.0, heading=0.1), braking(8.0, 30.0, heading=0.1), {"heading": 0.1}, [car(-5.5, 3.0, 60.0)]),
        {("cut_in", "driving"), ("cut_in", "emergency"), ("fallback_cut_in", "emergency")}),
    "tighter than the steering allows, by what curvatures tolerate": (
        made(tightly(steady(5.0, 20), 7.5, 11.2), tightly(braking(8.0, 5.0), 7.5, 11.2)),
        {("turn_integrity", "driving"), ("turn_integrity", "emergency")}),
    "back at 8 m/s": (
        made(standing(2.5), standing(2.5), {"v": -8.0}), {("no_rolling", "driving"), ("no_rolling", "emergency")}),
}  # fmt: skip


@BACKENDS
@pytest.mark.parametrize("way", WAYS)
def test_it_is_not_safe(way: str, backend: str) -> None:
    given, found = WAYS[way]
    assert against(given, backend) == found


def swerving(v: float, step: float, over: float = 18.0, aside: float = 3.0) -> Columns:
    """To the left by so many metres over so many, in half a wave, in steps of so many metres."""
    x = np.linspace(0.0, 40.0, 4001)
    u = np.minimum(x / over, 1.0) * np.pi
    slope = aside / 2 * np.pi / over * np.sin(u)
    bend = np.where(x < over, aside / 2 * (np.pi / over) ** 2 * np.cos(u), 0.0)
    s = np.concatenate([[0.0], np.cumsum(np.hypot(1.0, (slope[1:] + slope[:-1]) / 2) * np.diff(x))])
    own = np.arange(0.0, s[-1], step)
    columns = along(own / v, own, v, 0.0)
    columns["x"] = np.interp(own, s, x)
    columns["y"] = np.interp(own, s, aside / 2 * (1.0 - np.cos(u)))
    return columns | {
        "heading": np.interp(own, s, np.arctan(slope)), "kappa": np.interp(own, s, bend / (1.0 + slope**2) ** 1.5),
    }  # fmt: skip


@BACKENDS
@pytest.mark.parametrize("step", [1.0, 2.0, 3.0, 4.0, 6.0, 8.0])
def test_swerving_at_a_car_is_seen_in_steps_of_any_length(step: float, backend: str) -> None:
    given = made(swerving(15.0, step), braking(5.0, 15.0), objects=[car(0.0, 2.6, 15.0)])
    assert ("planned_side", "driving") in against(given, backend)


@BACKENDS
@pytest.mark.parametrize(("room", "safe"), [(0.52, False), (0.7, True)])
def test_what_is_planned_across_within_one_step_is_seen(room: float, safe: bool, backend: str) -> None:
    """Over by 1 m in a step of 10 m, and along the road at both of its ends: 0.2 s later 0.23 m are gone, 0.28 m needed to stop, and 0.11 m in any case."""
    given = made(
        swerving(16.0, 10.0, 10.0, 1.0), braking(12.0, 16.0), objects=[car(0.0, WIDTH / 2 + 1.0 + room, 16.0)]
    )
    assert against(given, backend) == (set() if safe else {("planned_side", "driving")})


@BACKENDS
@pytest.mark.parametrize(("begin", "end"), [(20.0, 30.6), (40.0, 46.6), (60.0, 65.0)])
def test_drag_takes_nothing_off_what_tyres_do_to_get_faster(begin: float, end: float, backend: str) -> None:
    v = np.array([begin, np.sqrt((begin**2 + end**2) / 2), end])
    t = np.concatenate([[0.0], np.cumsum(10.0 / ((v[1:] + v[:-1]) / 2))])
    given = made(along(t, [0.0, 10.0, 20.0], v, 0.0), braking(12.0, begin))
    assert ("speed_integrity", "driving") in against(given, backend)


#: Squares of speeds in m^2/s^2 at the beginning and the end of a step of 10 m, for which tyres do more than 13 m/s^2 and `tol_a` against drag, or
#: with it, wherever in the step they do it. Each fits with the drag of that end at which it is less of a matter.
WITH_DRAG = [(3600.0, 3810.0), (2500.0, 2726.0), (3600.0, 3284.0), (2500.0, 2200.0)]


@BACKENDS
@pytest.mark.parametrize(("begin", "end"), WITH_DRAG)
def test_drag_helps_by_the_least_and_hinders_by_the_most_within_a_step(
    begin: float, end: float, backend: str
) -> None:
    v = np.sqrt([begin, end, end])
    t = np.concatenate([[0.0], np.cumsum(10.0 / ((v[1:] + v[:-1]) / 2))])
    given = made(along(t, [0.0, 10.0, 20.0], v, 0.0), braking(12.0, float(v[0]), 100))
    assert ("speed_integrity", "driving") in against(given, backend)


def in_small_steps(
    steps: Sequence[float], count: int, across: float, v: float = SPEED
) -> tuple[Columns, float]:
    """A turn at so many m/s^2 in as many steps, these over and over, then straight on, the car pointing half-way all the time; and by how much it turns."""
    small = np.resize(np.asarray(steps), count)
    turns = across / v**2 * np.cumsum(small)
    way = np.concatenate([np.full(3, 2.0), small, np.full(20, 2.0)])
    leads = np.concatenate([np.zeros(3), turns, np.full(20, turns[-1])])
    s = np.concatenate([[0.0], np.cumsum(way)])
    columns = along(s / v, s, v, 0.0)
    columns["x"] = np.concatenate([[0.0], np.cumsum(np.cos(leads) * way)])
    columns["y"] = np.concatenate([[0.0], np.cumsum(np.sin(leads) * way)])
    return columns | {"heading": np.full(len(s), turns[-1] / 2)}, float(turns[-1])


#: Steps of m, over and over, and m/s^2 across: tyres can do 13, and `tol_a` more.
SMALL = [
    ([0.004], 20.0), ([0.0051], 30.0), ([0.0051], 60.0), ([0.0099], 14.0), ([0.0101], 14.0), ([0.02], 20.0),
    ([0.001, 0.011], 14.0), ([0.0099, 0.0101], 14.0), ([0.0005, 0.0005, 0.03], 14.0), ([0.001, 0.1], 14.0),
]  # fmt: skip


@BACKENDS
@pytest.mark.parametrize(("steps", "across"), shared_out(SMALL, 2))
def test_a_turn_in_small_steps_is_not_safe(steps: list[float], across: float, backend: str) -> None:
    columns, turned = in_small_steps(steps, 90, across)
    given = made(columns, braking(heading=turned / 2), {"heading": turned / 2})
    assert ("corner_integrity", "driving") in against(given, backend)


#: The same with nothing to object to.
FINE: dict[str, Cycle] = {
    "a way to rest that is short enough": made(
        steady(), falling_back(braking(8.0), 0.0), objects=[car(40.0, v=15.0)]
    ),
    "8 deg aside at 20 m/s": made(steady(), braking(), {"heading": 0.14}),
    "standing where the car stands": made(standing(), standing(), {"v": 0.0}, obstacles=[thing(2.7)]),
    "turning in with room": made(turning_in(), braking(12.0, 60.0), objects=[car(1.0, 6.0, 60.0)]),
    "over in front of a slower car": made(
        steady(30.0, heading=0.1), braking(8.0, 30.0, heading=0.1), {"heading": 0.1}, [car(-5.5, 3.0, 20.0)]
    ),
}


@BACKENDS
@pytest.mark.parametrize("what", FINE)
def test_it_is_safe(what: str, backend: str) -> None:
    assert against(FINE[what], backend) == set()


@BACKENDS
@pytest.mark.parametrize(("gap", "safe"), [(11.0, False), (24.0, True)])
def test_inside_a_bend_the_way_along_the_line_counts(gap: float, safe: bool, backend: str) -> None:
    """11 m along the middle of the road are 6.4 m on a line 5 m inside of it; the fallback takes 10.2 m."""
    turned = (gap + LENGTH) / 17.0
    other = car(12.0 * np.sin(turned), 17.0 - 12.0 * np.cos(turned), 1.0) | {"heading": turned}
    given = made(
        round_a_bend(steady(11.5), 12.0, 17.0),
        round_a_bend(braking(6.5, 11.5, 100), 12.0, 17.0),
        {"y": 5.0},
        [other],
        track=bend(17.0, 7.0),
    )
    found = against(given, backend)
    assert (("safe_fallback", "emergency") in found) is not safe
    assert (found == set()) is safe


@BACKENDS
@pytest.mark.parametrize(("age", "safe"), [(0.0, True), (0.1, False)])
def test_a_pose_that_is_old_takes_room(age: float, safe: bool, backend: str) -> None:
    """6 m of 60 m/s; 18.6 m are needed with a fresh one."""
    driving, emergency = steady(60.0), braking(12.9, 60.0, 100)
    for columns in (driving, emergency):
        columns["x"] += 60.0 * age
    found = against(made(driving, emergency, {"age": age}, [car(LENGTH + 21.0, v=60.0)]), backend)
    assert ({rule for rule, _ in found} >= {"safe_gap", "safe_side"}) is not safe
    assert (found == set()) is safe
