"""Cycles of planners with other names, units and conventions: what they are is found, converted back, and what does not fit is said."""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.length import amount, shared_out
from support.schemas import hold
from support.shared import shared
from support.supervised import ROOT
from trackmarshal.cli.main import main
from trackmarshal.integration.mapping import Column
from trackmarshal.integration.records import by_names
from trackmarshal.ir.spec import Spec
from trackmarshal.scenarios import content

#: So many are looked at of most planners: what is read of them is the same of fewer.
CYCLES = amount(36, 60)
COLUMNS = ("t", "s", "x", "y", "heading", "kappa", "v", "a")


@pytest.fixture(scope="module")
def spec() -> Spec:
    return tm.load(ROOT / "specs" / "supervisor", [ROOT / "specs" / "tracks" / "northfield.spec"])


@cache
def recorded() -> tuple[list[dict[str, Any]], dict[str, Any]]:
    """Cycles of a shipped recording, through a bend; another car drives a circle beside it. And the track."""
    recording = tm.load_recording(ROOT / "specs" / "scenarios" / "free_lap.tmrec.jsonl")
    cycles = []
    for c in recording.cycles[40 : 40 + CYCLES]:
        turn = c.t * 30.0 / 200.0  # 30 m/s at 200 m
        other = {
            "id": "o1", "x": 200.0 * math.cos(turn), "y": 3000.0 + 200.0 * math.sin(turn), "v": 30.0, "length": 4.5, "width": 2.0,
            "heading": math.remainder(turn + math.pi / 2, math.tau), "age": 0.0,
        }  # fmt: skip
        cycles.append({"t": c.t, "ego": c.ego, "objects": [other], "candidates": c.candidates})
    return cycles, {name: recording.track[name] for name in ("left", "right")}


def disguised(
    columns: dict[str, Callable[[dict[str, Any], float], Any]], shape: str = "columns"
) -> list[dict[str, Any]]:
    """The recorded cycles as another planner would send them: `columns` makes each of its columns from ours and the stamp."""
    made = []
    for cycle in recorded()[0]:
        plans: list[Any] = []
        for name in ("driving", "emergency"):
            ours = {key: np.array(value) for key, value in cycle["candidates"][name].items()}
            table = {key: np.asarray(make(ours, cycle["t"])).tolist() for key, make in columns.items()}
            if shape == "records":
                plans.append([dict(zip(table, row)) for row in zip(*table.values())])
            elif shape == "rows":
                plans.append([list(row) for row in zip(*table.values())])
            else:
                plans.append(table)
        others = [
            {"uuid": o["id"], "east": o["x"], "north": o["y"], "course": (90 - math.degrees(o["heading"])) % 360, "kmh": 3.6 * o["v"],
             "len": o["length"], "wid": o["width"]} for o in cycle["objects"]
        ]  # fmt: skip
        ego = cycle["ego"]
        pose = {
            "px": ego["x"],
            "py": ego["y"],
            "yaw": (90 - math.degrees(ego["heading"])) % 360,
            "speed": 3.6 * ego["v"],
        }
        made.append(
            {
                "stamp_ms": 1000 * cycle["t"],
                "trajs": {"nominal": plans[0], "fallback": plans[1]},
                "pose": pose,
                "others": others,
            }
        )
    return made


FOREIGN: dict[str, Callable[[dict[str, Any], float], Any]] = {
    "time_abs": lambda p, t: 1000 * (p["t"] + t),
    "east": lambda p, t: p["x"],
    "north": lambda p, t: p["y"],
    "course": lambda p, t: (90 - np.degrees(p["heading"])) % 360,
    "curv": lambda p, t: -p["kappa"],
    "speed_kmh": lambda p, t: 3.6 * p["v"],
    "acc": lambda p, t: p["a"] / 9.81,
}
#: Rows whose columns nobody names: s, y, x, psi from +y, kappa, v, a, t.
NAMELESS: dict[str, Callable[[dict[str, Any], float], Any]] = {
    "0": lambda p, t: p["s"],
    "1": lambda p, t: p["x"],
    "2": lambda p, t: p["y"],
    "3": lambda p, t: p["heading"] - math.pi / 2,
    "4": lambda p, t: p["kappa"],
    "5": lambda p, t: p["v"],
    "6": lambda p, t: p["t"],
}


def same(cycle: tm.Cycle, place: int, tolerance: float = 1e-6, but: tuple[str, ...] = ()) -> None:
    """A converted cycle against the one that was disguised."""
    ours = recorded()[0][place]
    for name, plan in (("driving", cycle.driving), ("emergency", cycle.emergency)):
        for column in COLUMNS:
            if column in but:
                continue
            expected = np.array(ours["candidates"][name][column])
            got = np.asarray(plan[column])
            if column == "heading":
                got = expected + np.remainder(got - expected + math.pi, math.tau) - math.pi
            np.testing.assert_allclose(got, expected, atol=tolerance, err_msg=f"{name}.{column}")
    np.testing.assert_allclose(cycle.t, ours["t"], atol=1e-9)


@pytest.mark.parametrize("shape", ["columns", "records", "rows"])
def test_another_planners_conventions_are_found_and_undone(spec: Spec, shape: str) -> None:
    report = tm.check_planner(
        disguised(FOREIGN, shape), spec, header=recorded()[1], emergency="trajs.fallback"
    )
    made = report.mapped
    assert (made.driving, made.emergency, made.ego, made.objects) == (
        "trajs.nominal",
        "trajs.fallback",
        "pose",
        "others",
    )
    if shape != "rows":
        assert {name: column.column for name, column in made.plan.items()} == {
            "t": "time_abs", "x": "east", "y": "north", "heading": "course", "kappa": "curv", "v": "speed_kmh", "a": "acc",
        }  # fmt: skip
    heading = made.plan["heading"]
    assert (heading.zero, heading.clockwise, heading.degrees) == ("+y", True, True)
    assert {name: made.plan[name].unit for name in ("t", "v", "a")} == {"t": "ms", "v": "km/h", "a": "g"}
    assert made.plan["kappa"].sign == -1.0
    assert made.computed == ["s"]
    assert (made.ego_fields["v"].unit, made.object_fields["v"].unit) == ("km/h", "km/h")
    assert made.object_fields["heading"].clockwise
    assert [str(f) for f in report.findings if f.level == "broken"] == []
    for place, cycle in enumerate(report.cycles):
        same(cycle, place, but=("s",))
        assert cycle.signals["objects"][0]["heading"] == pytest.approx(
            math.remainder(recorded()[0][place]["objects"][0]["heading"], math.tau), abs=1e-9
        )
    assert "its times are absolute: they begin with the stamp" in str(report)


@pytest.mark.parametrize(("course", "speed"), [("cog", "sog_kn"), ("richtung", "tempo")])
def test_the_car_and_others_are_read_by_the_words_of_the_plan(spec: Spec, course: str, speed: str) -> None:
    """As a ship sends it, over ground, or in a language that nobody here knows: what numbers say of a column of plans holds for its name."""
    knot = 1852.0 / 3600.0
    raws = disguised(
        {
            "east": lambda p, t: p["x"],
            "north": lambda p, t: p["y"],
            "secs": lambda p, t: p["t"],
            course: lambda p, t: (90 - np.degrees(p["heading"])) % 360,
            speed: lambda p, t: p["v"] / knot,
        }
    )
    for raw in raws:
        pose, (other,) = raw["pose"], raw["others"]
        raw["pose"] = {
            "east": pose["px"],
            "north": pose["py"],
            course: pose["yaw"],
            speed: pose["speed"] / 3.6 / knot,
        }
        raw["others"] = [
            {"mmsi": 219012345, "east": other["east"], "north": other["north"], course: other["course"], speed: other["kmh"] / 3.6 / knot,
             "len": other["len"], "wid": other["wid"]}
        ]  # fmt: skip
    report = tm.check_planner(raws, spec, header=recorded()[1], emergency="trajs.fallback")
    for fields in (report.mapped.ego_fields, report.mapped.object_fields):
        assert (fields["heading"].column, fields["v"].column, fields["v"].unit) == (course, speed, "kn")
    assert report.mapped.object_fields["id"].column == "mmsi"
    assert [str(f) for f in report.findings if f.level == "broken"] == []
    for place, cycle in enumerate(report.cycles):
        same(cycle, place, but=("s", "kappa", "a"))


def test_a_word_of_the_plan_comes_before_others_that_are_like_the_field() -> None:
    """A ship that drifts does not head for where it goes: of its plan's `cog`, the record's is `cog`, though `heading` stands before it."""
    plan = {"heading": Column("heading", "cog", "deg"), "v": Column("v", "sog", "kn")}
    names = ["heading", "speed", "cog", "sog"]
    assert by_names(names, ("heading", "v"), plan) == {"heading": "cog", "v": "sog"}
    assert by_names(names, ("heading", "v"), {}) == {"heading": "heading", "v": "speed"}


@pytest.mark.parametrize("cycles", [2, CYCLES])
@pytest.mark.parametrize("behind", [0.0, 0.07])
@pytest.mark.parametrize("absolute", [True, False])
def test_what_times_count_from(spec: Spec, absolute: bool, behind: float, cycles: int) -> None:
    """Absolute ones are told from those that begin before the stamp, however few cycles there are."""
    raws = json.loads(json.dumps(recorded()[0][:cycles]))
    for raw in raws:
        for plan in raw["candidates"].values():
            plan["t"] = [t - behind + absolute * raw["t"] for t in plan["t"]]
    report = tm.check_planner(raws, spec, header=recorded()[1])
    assert (report.mapped.absolute, report.convertible, report.fits) == (absolute, True, not absolute)
    assert "they begin 0.07 to 0.07 s before the stamp" in str(report) or not behind
    for raw, cycle in zip(recorded()[0], report.cycles):
        for plan, own in zip((cycle.driving, cycle.emergency), raw["candidates"].values()):
            np.testing.assert_allclose(plan["t"], np.array(own["t"]) - behind, atol=1e-9)


@pytest.mark.parametrize("begin", [0.02, 7.0, -60.0])
def test_times_that_do_not_cover_the_stamp(spec: Spec, begin: float) -> None:
    """No rule would find such a trajectory where the car is: it does not fit, and nothing is said to mend it."""

    def count(raw: dict[str, Any], number: int) -> None:
        for plan in raw["candidates"].values():
            plan["t"] = [t + begin for t in plan["t"]]

    report = tm.check_planner(broken(count), spec, header=recorded()[1])
    assert not report.convertible
    assert f"in {CYCLES} cycles its times do not cover the stamp" in str(report)


def test_rows_without_names(spec: Spec) -> None:
    """What grows by the distances is s, what over it is the speed is v, what points along the path is the heading."""
    report = tm.check_planner(disguised(NAMELESS, "rows"), spec, header=recorded()[1])
    made = report.mapped
    assert {name: column.column for name, column in made.plan.items()} == {
        "s": "0", "x": "1", "y": "2", "heading": "3", "kappa": "4", "v": "5", "t": "6",
    }  # fmt: skip
    assert made.plan["heading"].zero == "+y"
    for place, cycle in enumerate(report.cycles):
        same(cycle, place, but=("a",))


@pytest.mark.parametrize("columns", [FOREIGN, NAMELESS])
@pytest.mark.parametrize("shape", ["columns", "records", "rows"])
def test_the_adapter_makes_the_same_cycles(spec: Spec, columns: Any, shape: str) -> None:
    raws = disguised(columns, shape)
    report = tm.check_planner(raws, spec, header=recorded()[1], emergency="trajs.fallback")
    scope: dict[str, Any] = {}
    exec(compile(report.adapter, "adapter.py", "exec"), scope)
    track = scope["borders"](recorded()[1])
    supervisor = tm.supervisor(spec, limits={"budget": 1e9}, clock=lambda: raws[0]["stamp_ms"] / 1000)
    cycle = scope["cycle_of"](0, raws[0], track)
    same(cycle, 0, but=("s", "a", "v"))
    decision = supervisor.step(cycle)
    assert decision.faults == ()
    # Times too are as the contract has them: what the rules say of them holds.
    assert not {"stamp_match", "place_match", "heading_match", "pace_integrity"} & {
        v.rule for v in decision.violations
    }


def test_the_adapter_goes_by_keys_whatever_is_in_them(spec: Spec) -> None:
    """Dots, as where somebody has made a log flat, and whole numbers: the cycles that were looked at kept the contract, and the adapter raised."""
    plain, flat = disguised(FOREIGN, "columns"), []
    for raw in plain:
        trajs = raw["trajs"]
        flat.append(
            {
                **{f"car.{name}": value for name, value in raw.items()},
                "car.trajs": {1: trajs["fallback"], "a.b": trajs["nominal"]},
            }
        )
    report = tm.check_planner(flat, spec, header={"race.track": recorded()[1]}, emergency="car.trajs.1")
    scope: dict[str, Any] = {}
    exec(compile(report.adapter, "adapter.py", "exec"), scope)
    track = scope["borders"]({"race.track": recorded()[1]})
    same(scope["cycle_of"](0, flat[0], track), 0, but=("s", "a", "v"))


@pytest.mark.parametrize(
    "first",
    [None, {}, {"note": "none yet"}, {"nominal": [], "fallback": []}, {"nominal": {"note": "none yet"}}],
)
def test_the_adapter_takes_trajectories_as_the_cycles_that_have_some_have_them(
    spec: Spec, first: Any
) -> None:
    """The first cycle has none: a list of points was then taken for columns, and the adapter raised."""
    raws = disguised(FOREIGN, "records")
    raws[0]["trajs"] = first
    report = tm.check_planner(raws, spec, header=recorded()[1], emergency="trajs.fallback")
    scope: dict[str, Any] = {}
    exec(compile(report.adapter, "adapter.py", "exec"), scope)
    same(scope["cycle_of"](1, raws[1], scope["borders"](recorded()[1])), 1, but=("s", "a", "v"))


@pytest.mark.parametrize("shape", ["columns", "records"])
def test_the_adapter_goes_by_columns_that_are_numbered(spec: Spec, shape: str) -> None:
    """By whole numbers that are no texts, as a table without names has them."""
    raws = disguised(FOREIGN, shape)
    for raw in raws:
        for name, plan in raw["trajs"].items():
            tables = plan if isinstance(plan, list) else [plan]
            numbered = [dict(enumerate(table.values())) for table in tables]
            raw["trajs"][name] = tuple(numbered) if isinstance(plan, list) else numbered[0]
    report = tm.check_planner(raws, spec, header=recorded()[1], emergency="trajs.fallback")
    scope: dict[str, Any] = {}
    exec(compile(report.adapter, "adapter.py", "exec"), scope)
    cycle = scope["cycle_of"](1, raws[1], scope["borders"](recorded()[1]))
    for name, values in report.cycles[1].driving.items():
        np.testing.assert_allclose(cycle.driving[name], values, atol=1e-9)


def test_the_planner_as_it_is_recorded(spec: Spec) -> None:
    """In the contract's own terms nothing has to be converted, and s stands for s although t grows with it too."""
    report = tm.check_planner(recorded()[0], spec, header=recorded()[1])
    assert report.fits, str(report)
    assert {name: column.column for name, column in report.mapped.plan.items()} == {
        name: name for name in COLUMNS
    }
    assert str(report).endswith("it keeps the contract as it is")
    json.dumps(report.as_json(), allow_nan=False)


def broken(change: Callable[[dict[str, Any], int], object]) -> list[dict[str, Any]]:
    raws = json.loads(json.dumps(recorded()[0]))
    for number, raw in enumerate(raws):
        change(raw, number)
    return list(raws)


def _drive(raw: dict[str, Any], name: str, value: Callable[[list[float]], list[float]]) -> None:
    raw["candidates"]["driving"][name] = value(raw["candidates"]["driving"][name])


def _freeze(raw: dict[str, Any], number: int) -> None:
    if number in (10, 11):
        raw["candidates"] = json.loads(json.dumps(recorded()[0][9]["candidates"]))


def test_no_other_vehicle_is_lost_silently(spec: Spec) -> None:
    """Where no cycle had one, their fields are not known: an adapter that left them out would be blind."""
    raws = broken(lambda raw, n: raw.update(objects=[]))
    report = tm.check_planner(raws, spec, header=recorded()[1])
    assert "`objects` is empty in all cycles" in str(report)
    scope: dict[str, Any] = {}
    exec(compile(report.adapter, "adapter.py", "exec"), scope)
    assert scope["cycle_of"](0, raws[0]).signals["objects"] == []
    with pytest.raises(NotImplementedError):
        scope["cycle_of"](0, recorded()[0][0])
    none = tm.check_planner(broken(lambda raw, n: raw.pop("objects")), spec, header=recorded()[1])
    assert not none.convertible
    assert '"objects": None,  # TODO' in none.adapter


def mirrored(raw: dict[str, Any], number: int) -> None:
    """The cycle in NED, or any other frame with y to the right of x: all of it fits together."""
    for one in [*raw["candidates"].values(), raw["ego"], *raw["objects"]]:
        for name in {"y", "heading", "kappa"} & one.keys():
            one[name] = [-z for z in one[name]] if isinstance(one[name], list) else -one[name]


def test_borders_on_the_other_side(spec: Spec) -> None:
    """A mirrored planner kept the contract as it is, with the zones and lines of a track where it never drives."""
    borders = recorded()[1]
    turned = {side: [[x, -y] for x, y in points] for side, points in borders.items()}
    for raws, header in (
        (broken(mirrored), turned),
        (recorded()[0], {"left": borders["right"], "right": borders["left"]}),
    ):
        report = tm.check_planner(raws, spec, header=header)
        assert not report.convertible
        assert (
            f"`left` is on the right of the plan and `right` on its left, in {CYCLES} of {CYCLES} cycles"
            in str(report)
        )


def test_objects_by_their_ids(spec: Spec) -> None:
    """A mapping by id was said to keep the contract as it is, and the adapter for it raised."""

    def by_id(raw: dict[str, Any], number: int) -> None:
        raw["objects"] = {one.pop("id"): one for one in raw["objects"]}
        raw["obstacles"] = {"c": {"x": 1.0, "y": 2.0, "heading": 0.5, "length": 0.3, "width": 0.3}}

    raws = broken(by_id)
    report = tm.check_planner(raws, spec, header=recorded()[1])
    assert not report.fits
    assert report.convertible
    assert "`objects` is a mapping by id" in str(report)
    scope: dict[str, Any] = {}
    exec(compile(report.adapter, "adapter.py", "exec"), scope)
    signals = scope["cycle_of"](0, raws[0]).signals
    listed = tm.check_planner(recorded()[0], spec, header=recorded()[1])
    assert signals["objects"] == report.cycles[0].signals["objects"] == listed.cycles[0].signals["objects"]
    assert signals["obstacles"][0]["id"] == "c"


@pytest.mark.parametrize("id_", [[1, 2], {"uuid": [1, 2]}])
def test_ids_that_are_no_single_number_are_told(spec: Spec, id_: Any) -> None:
    """As ROS has them. By their motion, the objects are known again all the same."""
    cycles = [{**one, "objects": [{**each, "id": id_} for each in one["objects"]]} for one in recorded()[0]]
    report = tm.check_planner(cycles, spec)
    told = [str(one) for one in report.findings if one.about == "objects.id"]
    assert [f"wrong_type (D202) in {CYCLES} of {CYCLES} cycles" in one for one in told] == [True]
    assert "times the speed of their motion" in str(report)


def test_of_records_that_are_as_good_as_each_other_the_first_is_taken(spec: Spec) -> None:
    """Whatever the hashes of their names are in this process: which one was the car's changed from run to run."""
    cycles = [
        {"candidates": one["candidates"], **{f"source_{i}": {"ego": one["ego"]} for i in range(50)}}
        for one in recorded()[0][:3]
    ]
    assert tm.check_planner(cycles, spec).mapped.ego == "source_0.ego"


def test_a_second_list_of_others_is_not_lost_silently(spec: Spec) -> None:
    """One list is taken; of the other one nothing was said, and the adapter left it out."""

    def more(raw: dict[str, Any], number: int) -> None:
        raw["pedestrians"] = [{"id": "p", "x": 1.0, "y": 2.0, "heading": 0.5, "v": 1.0}]
        raw["lights"] = [{"id": "l", "x": 1.0, "y": 2.0}]

    report = tm.check_planner(broken(more), spec, header=recorded()[1])
    assert report.mapped.objects == "objects"
    assert not report.convertible
    assert "`pedestrians` has places and speeds as other vehicles have, and is not taken" in str(report)
    assert ("note", "`lights` has places, and is not taken") in {(f.level, f.words) for f in report.findings}


def test_obstacles_by_their_names(spec: Spec) -> None:
    cone = {"id": "c", "x": 1.0, "y": 2.0, "heading": 0.5, "length": 0.3, "width": 0.3}
    report = tm.check_planner(broken(lambda raw, n: raw.update(obstacles=[cone])), spec, header=recorded()[1])
    assert report.cycles[0].signals["obstacles"] == [cone]
    assert "obstacles.heading" in {f.about for f in report.findings}


BROKEN: dict[str, tuple[Callable[[dict[str, Any], int], object], str]] = {
    "no emergency": (lambda raw, n: raw["candidates"].pop("emergency"), "no trajectory is called so, or ends at rest"),
    "no pose": (lambda raw, n: raw.pop("ego"), "no record has x and y near the beginning"),
    "no speed": (lambda raw, n: [p.pop("v") for p in raw["candidates"].values()], "plan.v: no column fits"),
    "no stamp": (lambda raw, n: raw.pop("t"), "no number of the cycle counts its time"),
    "a heading of another path": (
        lambda raw, n: [p.update(heading=np.random.default_rng(n).uniform(-3, 3, len(p["x"])).tolist()) for p in raw["candidates"].values()],
        "does not follow the direction of the path in any convention",
    ),
    "backwards": (
        lambda raw, n: [p.update(v=[-one for one in p["v"]]) for p in raw["candidates"].values()],
        "it is driven backwards, or a speed ahead is negative; take cycles that are driven ahead",
    ),
    "a speed of another run": (
        lambda raw, n: [p.update(v=np.random.default_rng(n).uniform(5, 50, len(p["x"])).tolist()) for p in raw["candidates"].values()],
        "they do not belong together",
    ),
    "a hole": (lambda raw, n: _drive(raw, "v", lambda v: [*v[:7], float("nan"), *v[8:]]) if n == 4 else None, f"not_finite (D215) in 1 of {CYCLES} cycles, first in cycle 4, at 7"),
    "late": (lambda raw, n: raw.update(t=raw["t"] + 0.4 * (n > 30)), f"late (D225) in 1 of {CYCLES} cycles, first in cycle 31"),
    "frozen": (_freeze, "2 cycles repeat the plan of the one before (first: cycle 10)"),
    "an odd column": (lambda raw, n: _drive(raw, "a", lambda a: a[:-1]), "entries, the other columns"),
}  # fmt: skip


@pytest.mark.parametrize("name", shared_out(BROKEN, 2))
def test_what_does_not_fit_is_said(spec: Spec, name: str) -> None:
    change, words = BROKEN[name]
    report = tm.check_planner(broken(change), spec, header=recorded()[1])
    assert words in str(report)
    assert not report.convertible


def test_who_waits_longer_is_told_what_else_has_to(spec: Spec) -> None:
    report = tm.check_planner(broken(BROKEN["late"][0]), spec, header=recorded()[1])
    (said,) = [found.help for found in report.findings if "late (D225)" in found.words]
    assert all(f"`{name}`" in said for name in ("longest_gap", "t_next", "t_unseen", "response"))


def test_a_tail_that_creeps(spec: Spec) -> None:
    def creep(raw: dict[str, Any], number: int) -> None:
        plan = raw["candidates"]["emergency"]
        plan["v"][-2] = 0.05
        plan["t"][-1] = plan["t"][-2] + 60.0

    report = tm.check_planner(broken(creep), spec, header=recorded()[1])
    assert "the last step to rest takes up to 60 s" in str(report)
    assert "emergency = tm.cut_at_rest(emergency)" in report.adapter


@pytest.mark.parametrize("stands", [0, 3])
@pytest.mark.parametrize(("last", "creeps"), [(3.0, False), (5.9, False), (6.1, True), (60.0, True)])
def test_who_brakes_slowly_does_not_creep(last: float, creeps: bool, stands: int) -> None:
    """A ship stops in a minute, and looks ahead in steps of 3 s: its last one is as long as all others. It creeps where it brakes less than half as hard in it."""
    contract = tm.loads("""
module ship
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
rule ends "At rest"
  require plan.last.t >= 0 s
""")
    raws = []
    for number in range(3):
        t = [3.0 * i for i in range(21)]
        v = [6.0 - 0.1 * z for z in t]
        x = [5.0 * 6.0 * number + 6.0 * z - 0.05 * z * z for z in t]
        plan = {"x": x, "y": [0.0] * 21, "heading": [0.0] * 21, "kappa": [0.0] * 21, "v": v}
        slow = {
            **plan,
            "t": [*t[:-1], t[-2] + last],
            "v": [*v[:-1], 0.0],
            "x": [*x[:-1], x[-2] + v[-2] * last / 2.0],
        }
        behind = {name: [values[-1]] * stands for name, values in slow.items()}  # it stays where it stands
        behind["t"] = [slow["t"][-1] + 3.0 * i for i in range(1, stands + 1)]
        slow = {name: [*values, *behind[name]] for name, values in slow.items()}
        ego = {"x": x[0], "y": 0.0, "heading": 0.0, "v": 6.0}
        raws.append(
            {"t": 5.0 * number, "ego": ego, "candidates": {"driving": {**plan, "t": t}, "emergency": slow}}
        )
    report = tm.check_planner(raws, contract)
    assert (f"the last step to rest takes up to {last:.3g} s" in str(report)) == creeps
    assert ("tm.cut_at_rest" in str(report)) == creeps


def test_a_straight_road_does_not_tell_all(spec: Spec) -> None:
    """Any convention fits there by some angle: one along an axis is suggested, and said to be unsure."""
    recording = tm.load_recording(ROOT / "specs" / "scenarios" / "cut_in.tmrec.jsonl")
    cycles = [
        {"t": c.t, "ego": c.ego, "objects": c.objects, "candidates": c.candidates}
        for c in recording.cycles[60:90]
    ]
    cycles = json.loads(json.dumps(cycles))
    for cycle in cycles:
        for plan in cycle["candidates"].values():
            plan["heading"] = [90 - math.degrees(h) for h in plan["heading"]]
    report = tm.check_planner(cycles, spec, header=recorded()[1])
    heading = report.mapped.plan["heading"]
    assert (heading.zero, heading.clockwise, heading.degrees) == ("+y", True, True)
    unsure = {f.about for f in report.findings if "be sure of" in f.words}
    assert unsure >= {"plan.heading", "plan.kappa", "ego.heading"}


def test_whole_numbers_beyond_all_doubles_are_no_end_of_it(spec: Spec, tmp_path: Path) -> None:
    """A seed of a planner, and a number that is wrong: it was an internal error."""
    cycles = [
        {**one, "seed": 10**400, "objects": [{**each, "v": 10**400} for each in one["objects"]]}
        for one in recorded()[0][:20]
    ]
    path = tmp_path / "planner.jsonl"
    path.write_text("\n".join(map(json.dumps, cycles)), encoding="utf-8")
    told = [str(one) for one in tm.check_planner(path, spec).findings if one.about == "objects.v"]
    assert ["not_finite (D215) in 20 of 20 cycles" in one for one in told] == [True]


def test_nothing_to_look_at_is_refused(spec: Spec, tmp_path: Path) -> None:
    for given, code in (([], "D195"), ([{"a": 1.0}], "D196"), ([1], "D195")):
        with pytest.raises(tm.TrackmarshalError) as caught:
            tm.check_planner(given, spec)  # type: ignore[arg-type]
        assert caught.value.code == code
    with pytest.raises(tm.TrackmarshalError, match=r"no cycle has a trajectory `plans\.x`") as caught:
        tm.check_planner(recorded()[0], spec, driving="plans.x")
    path = tmp_path / "bad.jsonl"
    path.write_text('{"t": 0}\n[1]\n', encoding="utf-8")
    with pytest.raises(tm.TrackmarshalError) as caught:
        tm.check_planner(path, spec)
    assert (caught.value.code, caught.value.line) == ("D195", 2)


@pytest.mark.parametrize("before", ["", "\ufeff", "\r\n \n"])
def test_of_a_file_that_is_too_large_as_many_cycles_are_read_as_are_asked_for(
    before: str, spec: Spec, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a planner writes in an hour was refused as a recording, although a hundred cycles of it were to be looked at."""
    path = tmp_path / "hour.jsonl"
    lines = [json.dumps({"format": "ours", **recorded()[1]}), *map(json.dumps, recorded()[0])]
    path.write_bytes((before + "\n\n".join(lines)).encode())
    wanted = [str(one) for one in tm.check_planner(path, spec, most=9).findings]
    monkeypatch.setattr(content, "MAX_BYTES", len((before + "\n\n".join(lines[:10])).encode()) + 3)
    report = tm.check_planner(path, spec, most=9)
    assert (len(report.cycles), [str(one) for one in report.findings]) == (9, wanted)
    with pytest.raises(tm.TrackmarshalError) as caught:
        tm.check_planner(path, spec, most=20)
    assert caught.value.code == "D124"


@pytest.mark.parametrize("data", [b"t,x,y\n0,1,2\n", b"\x89MCAP0\r\n", b"PAR1\x15\x04", b"\xff\xfet\0,\0"])
def test_a_log_is_told_where_to_go(spec: Spec, tmp_path: Path, data: bytes) -> None:
    """It was to be saved as UTF-8, or expected a value at character 1."""
    (tmp_path / "log").write_bytes(data)
    with pytest.raises(tm.TrackmarshalError) as caught:
        tm.check_planner(tmp_path / "log", spec)
    assert caught.value.code == "D195"
    assert "import log" in str(caught.value.help)
    with pytest.raises(tm.TrackmarshalError) as caught:
        tm.load_recording(tmp_path / "log")
    assert caught.value.code == "D121"
    assert "import log" in str(caught.value.help)


def test_an_archive_of_numpy_is_none_of_scenarios(tmp_path: Path) -> None:
    np.savez(tmp_path / "log.npz", t=np.arange(3.0))
    with pytest.raises(tm.TrackmarshalError) as caught:
        tm.load_recording(tmp_path / "log.npz")
    assert "import log" in str(caught.value.help)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, adapter = tmp_path / "cycles.jsonl", tmp_path / "adapter.py"
    header = {"format": "ours", **recorded()[1]}
    path.write_text(
        "".join(json.dumps(line) + "\n" for line in [header, *disguised(FOREIGN)]), encoding="utf-8"
    )
    arguments = ["--project", str(ROOT), "check-planner", str(path), "--adapter", str(adapter)]
    assert main([*arguments, "--emergency", "trajs.fallback"]) == 1
    said = capsys.readouterr().out
    assert "`course`, in degrees, 0 along +y, clockwise" in said
    assert "the adapter is all that it takes" in said
    assert "tm.heading_from" in adapter.read_text("utf-8")
    looked_over = adapter.read_bytes()
    assert main([*arguments, "--emergency", "trajs.fallback"]) == 2  # it is not written over
    err = capsys.readouterr().err
    assert f"error[E412]: {adapter} is there already" in err, err
    assert "choose another" in err
    assert adapter.read_bytes() == looked_over
    asked = ["--project", str(ROOT), "check-planner", str(path), "--format", "json"]
    assert main(asked) == 1
    out = capsys.readouterr().out
    hold(asked, out)
    assert json.loads(out)["mapping"]["plan"]["v"]["unit"] == "km/h"


@pytest.mark.parametrize("name", ["modena", "berlin_cars"])
def test_a_real_planner(spec: Spec, name: str) -> None:
    """Its columns renamed and turned as its own output has them (psi from +y), and its tails found."""
    raw = (
        gzip.decompress(shared("data", "planner", f"{name}.tmrec.jsonl.gz").read_bytes())
        .decode()
        .splitlines()
    )
    cycles = []
    for line in raw[101:161]:
        cycle = json.loads(line)
        for plan in cycle["candidates"].values():
            plan["psi"] = [math.remainder(h - math.pi / 2, math.tau) for h in plan.pop("heading")]
            plan["vx"], plan["ax"] = plan.pop("v"), plan.pop("a")
        cycles.append(cycle)
    report = tm.check_planner(cycles, spec, header=json.loads(raw[0]))
    plan = report.mapped.plan
    assert {n: plan[n].column for n in ("heading", "v", "a", "kappa", "s")} == {
        "heading": "psi", "v": "vx", "a": "ax", "kappa": "kappa", "s": "s",
    }  # fmt: skip
    assert (plan["heading"].zero, plan["heading"].clockwise, plan["heading"].degrees) == ("+y", False, False)
    assert (report.mapped.driving, report.mapped.emergency) == ("candidates.driving", "candidates.emergency")
    assert [f.words for f in report.findings if f.level == "broken" and f.about.startswith("plan")] == []


#: Of its signals, as a project that begins with `init` has them: no borders, nothing that stands about, and neither s nor kappa.
OWN = """
module own
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m, y: m, v: m/s }
rule slow "At most 100 m/s"
  for all   p in plan
  require   p.v <= 100 m/s
"""


@pytest.mark.parametrize("names", [("x", "y", "v"), COLUMNS])
def test_what_a_contract_of_ones_own_does_not_have_is_neither_asked_for_nor_sent(
    names: tuple[str, ...],
) -> None:
    own = tm.loads(OWN)
    cycles = [
        {
            **{
                name: {key: one["candidates"][name][key] for key in names}
                for name in ("driving", "emergency")
            },
            **{name: one[name] for name in ("t", "ego", "objects")},
        }
        for one in recorded()[0]
    ]
    report = tm.check_planner(cycles, own)
    assert report.convertible, [str(one) for one in report.findings]
    assert not {one.about.partition(".")[0] for one in report.findings} & {"track", "obstacles"}
    made: dict[str, Any] = {}
    exec(report.adapter, made)
    now = 0.0
    supervisor = tm.supervisor(own, clock=lambda: now)
    for number, one in enumerate(cycles):
        cycle = made["cycle_of"](number, one)
        now = cycle.t
        decision = supervisor.step(cycle)
        assert decision.state == "drive", [str(reason) for reason in decision.reasons]


def test_what_the_adapter_leaves_to_a_default_is_told() -> None:
    """Also where the planner sends it by the contract's own name: what stands for it then is judged, and nothing breaks the contract."""
    text = OWN.replace(
        "signal ego : state { ", "signal ego : state { boost: bool default false, fuel: kg default 9 kg, "
    )
    assert text != OWN
    own = tm.loads(text + '\nrule no_boost "None"\n  require   not ego.boost\n')
    cycles = [{**one, "ego": {**one["ego"], "boost": True}} for one in recorded()[0]]
    report = tm.check_planner(cycles, own)
    assert "boost" not in report.cycles[0].signals["ego"]
    told = {one.about: one for one in report.findings if "default" in one.words}
    assert told.keys() == {"ego.boost"}  # no rule reads the other one
    assert told["ego.boost"].level == "note"
    assert told["ego.boost"].words.endswith("judged by no_boost")


@pytest.mark.parametrize("objects", [None, []])
def test_of_what_is_not_there_nothing_is_left_to_a_default(objects: list[Any] | None) -> None:
    """The adapter hands on an empty set of what it did not find, and raises on cars that it does not know: no default is judged."""
    text = OWN.replace("set of object { ", "set of object { age: s default 0 s, ")
    text += "\nsignal obstacles : set of object { x: m, y: m, length: m default 1 m }\n"
    rules = "".join(
        f'rule {name} "r"\n  for all o in {signal}\n  require o.{field} <= 9 {unit}\n'
        for name, signal, field, unit in (
            ("fresh", "objects", "age", "s"),
            ("short", "obstacles", "length", "m"),
        )
    )
    own = tm.loads(text + rules)
    cycles = [{name: one[name] for name in one if name != "objects"} for one in recorded()[0]]
    if objects is not None:
        cycles = [{**one, "objects": objects} for one in cycles]
    told = {one.about for one in tm.check_planner(cycles, own).findings if "default" in one.words}
    assert told == set()
