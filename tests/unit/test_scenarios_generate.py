"""Declarations and what is generated of them: the shipped scenarios, and what is refused."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from support.envelope import same_lane
from trackmarshal import scenarios
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.scenarios import recording_io
from trackmarshal.scenarios.faults import declaration as campaigns
from trackmarshal.scenarios.field import mapping
from trackmarshal.scenarios.generate import __main__ as command
from trackmarshal.scenarios.generate import generate, road
from trackmarshal.scenarios.generate import run as generating
from trackmarshal.scenarios.generate.candidates import Braking, emergency
from trackmarshal.scenarios.generate.motion import Motion, Profile
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import replay

SPECS = Path(__file__).parents[2] / "specs"
CUT_IN = SPECS / "scenarios" / "cut_in.yaml"
FREE_LAP = SPECS / "scenarios" / "free_lap.yaml"
LENGTH, WIDTH, GRIP = 4.7, 2.8, 13.0
#: Of another car, as it is reported.
BODY = 2.0
DRAG = 0.854 / 1160.0
OF_A_SPEC = "vehicle: ../vehicles/devbot.spec\n"


#: What a declaration generates; nobody here changes it.
made = cache(generate)


@pytest.fixture(scope="module")
def cut_in() -> Recording:
    return made(CUT_IN)


@pytest.fixture(scope="module", params=[CUT_IN, FREE_LAP], ids=["cut_in", "free_lap"])
def shipped(request: pytest.FixtureRequest) -> Recording:
    return made(request.param)


def same(one: Any, other: Any, tolerance: float) -> bool:
    """Equal but for the last digits of numbers, which the platforms' sines may round differently."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k], tolerance) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(same(a, b, tolerance) for a, b in zip(one, other))
    if isinstance(one, float):
        return bool(abs(one - other) <= tolerance)
    return bool(one == other)


def test_the_shipped_recording_is_what_its_declaration_generates(cut_in: Recording) -> None:
    lines = (SPECS / "scenarios" / "cut_in.tmrec.jsonl").read_text().splitlines()
    fresh = [json.loads(line) for line in recording_io.encode(cut_in)]
    assert same(fresh, [json.loads(line) for line in lines], 2e-6), (
        "run: python -m trackmarshal.scenarios.generate specs/scenarios/cut_in.yaml specs/scenarios/cut_in.tmrec.jsonl"
    )


@pytest.mark.acceptance  # one is what it was when it was shipped, every day
def test_generating_is_deterministic(cut_in: Recording, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(generating, "run", getattr(generating.run, "__wrapped__", generating.run))
    assert repr(generate(CUT_IN).cycles) == repr(cut_in.cycles)
    assert scenarios.load(CUT_IN) == cut_in


def test_the_schema_knows_generated_lines(cut_in: Recording) -> None:
    schema = json.loads(Path(recording_io.__file__).with_name("recording.schema.json").read_text())
    validator = Draft202012Validator(schema)
    for line in list(recording_io.encode(cut_in))[:4]:
        validator.validate(json.loads(line))


def plans(recording: Recording) -> list[dict[str, list[float]]]:
    return [plan for cycle in recording.cycles for plan in cycle.candidates.values()]


class TestShipped:
    """What holds for every shipped scenario; tolerances are far below the paper's authors' own."""

    def test_size(self, shipped: Recording) -> None:
        assert 10.0 <= shipped.cycles[-1].t <= 15.0
        assert all(b.t - a.t == pytest.approx(0.1) for a, b in zip(shipped.cycles, shipped.cycles[1:]))
        assert all(len(plan["t"]) == 30 for plan in plans(shipped))
        assert all(set(cycle.candidates) == {"driving", "emergency"} for cycle in shipped.cycles)

    def test_trajectories_are_consistent(self, shipped: Recording) -> None:
        for plan in plans(shipped):
            assert (plan["t"][0], plan["s"][0]) == (0.0, 0.0)
            for i in range(29):
                dt, ds = plan["t"][i + 1] - plan["t"][i], plan["s"][i + 1] - plan["s"][i]
                v, w = plan["v"][i], plan["v"][i + 1]
                dx, dy = plan["x"][i + 1] - plan["x"][i], plan["y"][i + 1] - plan["y"][i]
                turn = math.remainder(plan["heading"][i + 1] - plan["heading"][i], math.tau)
                assert dt > 0.0
                assert ds == pytest.approx((v + w) / 2.0 * dt, rel=2e-4, abs=1e-5)
                assert math.hypot(dx, dy) == pytest.approx(ds, rel=1e-4, abs=1e-5)
                assert (w * w - v * v) / (2.0 * ds) == pytest.approx(plan["a"][i], abs=0.11 + 2e-5 / ds)
                off = math.atan2(dy, dx) - plan["heading"][i] - turn / 2.0
                assert math.remainder(off, math.tau) == pytest.approx(0.0, abs=1e-3 + 1e-5 / ds)
                mean = (plan["kappa"][i] + plan["kappa"][i + 1]) / 2.0
                assert turn / ds == pytest.approx(mean, abs=2e-4 + 1e-5 / ds)

    def test_limits_of_the_vehicle_are_respected(self, shipped: Recording) -> None:
        for plan in plans(shipped):
            for v, a, kappa in zip(plan["v"], plan["a"], plan["kappa"]):
                assert math.hypot(a + DRAG * v * v, v * v * kappa) < GRIP
                assert abs(kappa) < 1.0 / 11.0
                assert a + DRAG * v * v < 6.0 - max(0.0, v - 36.0) * 3.6 / 36.0

    def test_the_emergency_trajectory_brakes_to_rest(self, shipped: Recording) -> None:
        for cycle in shipped.cycles:
            emergency = cycle.candidates["emergency"]
            assert emergency["v"][-1] == 0.0
            assert max(emergency["a"]) < -5.0

    def test_candidates_begin_at_the_ego_pose(self, shipped: Recording) -> None:
        for cycle in shipped.cycles:
            for plan in cycle.candidates.values():
                for name in ("x", "y", "heading", "kappa", "v"):
                    assert plan[name][0] == pytest.approx(cycle.ego[name], abs=1e-6)

    def test_the_ego_drives_what_was_planned(self, shipped: Recording) -> None:
        for before, after in zip(shipped.cycles, shipped.cycles[1:]):
            plan = before.candidates["driving"]
            assert plan["t"][1] == pytest.approx(0.1)
            for name in ("x", "y", "heading", "v"):
                assert plan[name][1] == pytest.approx(after.ego[name], abs=1e-5)

    def test_every_footprint_is_on_the_track(self, shipped: Recording) -> None:
        from shapely import Polygon, prepare

        left, right = Polygon(shipped.track["left"]), Polygon(shipped.track["right"])
        assert left.is_valid
        assert right.is_valid
        surface = right.difference(left)  # a left-hand circuit: the left border is the inner one
        prepare(surface)
        for cycle in shipped.cycles:
            poses = [(o["x"], o["y"], o["heading"]) for o in cycle.objects]
            for plan in cycle.candidates.values():
                poses += zip(plan["x"], plan["y"], plan["heading"])
            for pose in poses:
                assert surface.contains(Polygon(corners(*pose)))

    def test_static_ground_truth_is_safe(self, shipped: Recording) -> None:
        assert set(shipped.ground_truth["static"]) == {True}


def corners(x: float, y: float, heading: float) -> list[tuple[float, float]]:
    c, s = math.cos(heading), math.sin(heading)
    ends = [(0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5)]
    return [(x + LENGTH * u * c - WIDTH * w * s, y + LENGTH * u * s + WIDTH * w * c) for u, w in ends]


def relative(recording: Recording) -> list[tuple[float, float, float]]:
    """Time, and the other car's centre ahead of and to the left of the ego's, in the ego's frame."""
    seen = []
    for cycle in recording.cycles:
        (other,) = cycle.objects
        dx, dy = other["x"] - cycle.ego["x"], other["y"] - cycle.ego["y"]
        c, s = math.cos(cycle.ego["heading"]), math.sin(cycle.ego["heading"])
        seen.append((cycle.t, c * dx + s * dy, c * dy - s * dx))
    return seen


class TestCutIn:
    """The story of the scenario, read off the recording alone."""

    def test_at_first_the_other_is_close_behind(self, cut_in: Recording) -> None:
        for t, ahead, _ in relative(cut_in):
            if t <= 3.0:
                assert -14.0 < ahead < -LENGTH

    def test_it_passes_with_room_and_cuts_in(self, cut_in: Recording) -> None:
        seen = relative(cut_in)
        assert all(left > WIDTH + 2.0 for _, ahead, left in seen if abs(ahead) < LENGTH + 2.0 and left > 1.0)
        assert seen[-1][1] > LENGTH
        assert abs(seen[-1][2]) < 0.1

    def test_the_other_respects_friction(self, cut_in: Recording) -> None:
        path = [cycle.objects[0] for cycle in cut_in.cycles]
        for one, two in pairwise(path):
            braking = (two["v"] - one["v"]) / 0.1
            turning = one["v"] * math.remainder(two["heading"] - one["heading"], math.tau) / 0.1
            assert math.hypot(braking, turning) < GRIP

    def test_cars_never_touch(self, cut_in: Recording) -> None:
        from shapely import Polygon

        for cycle in cut_in.cycles:
            ego, other = (
                Polygon(corners(p["x"], p["y"], p["heading"])) for p in (cycle.ego, cycle.objects[0])
            )
            assert ego.distance(other) > 1.0

    def test_dynamic_ground_truth_in_three_stretches(self, cut_in: Recording) -> None:
        truth = cut_in.ground_truth["dynamic"]
        free, unsafe = truth.index(None), truth.index(False)
        assert truth == (True,) * free + (None,) * (unsafe - free) + (False,) * (len(truth) - unsafe)
        assert cut_in.cycles[free].t == pytest.approx(7.8)
        assert cut_in.cycles[unsafe].t == pytest.approx(11.6)

    def test_the_latest_time_is_the_closed_form_of_each_cycle(self, cut_in: Recording) -> None:
        # At the end both drive straight in one lane: contact is due when the gap is below (v - u)^2 / (2 b).
        seen = relative(cut_in)
        for i, (t, ahead, _) in enumerate(seen):
            if t < 9.0:
                continue
            cycle = cut_in.cycles[i]
            due = same_lane(ahead - LENGTH, cycle.ego["v"], cycle.objects[0]["v"], 13.0).latest
            unsafe = due is not None and due <= 0.0
            assert (cut_in.ground_truth["dynamic"][i] is False) == unsafe, t

    def test_the_other_overlaps_the_lane_ahead_from_the_earliest_time_on(self, cut_in: Recording) -> None:
        for i, (t, ahead, left) in enumerate(relative(cut_in)):
            heading = cut_in.cycles[i].objects[0]["heading"] - cut_in.cycles[i].ego["heading"]
            side = (LENGTH * abs(math.sin(heading)) + BODY * abs(math.cos(heading))) / 2.0
            overlaps = ahead > LENGTH and abs(left) < side + WIDTH / 2.0
            if t > 4.0:
                assert (cut_in.ground_truth["dynamic"][i] is True) != overlaps, t


def test_free_lap_is_safe_throughout() -> None:
    recording = made(FREE_LAP)
    assert all(cycle.objects == [] for cycle in recording.cycles)
    assert set(recording.ground_truth["dynamic"]) == {True}
    assert max(abs(k) for plan in plans(recording) for k in plan["kappa"]) > 0.009  # there is a bend


def test_overrides_are_known_to_the_shipped_vehicles(tmp_path: Path) -> None:
    """A vehicle that stands in the declaration is other than the shipped ones, and the recording says so."""
    recording = generate(declared(tmp_path, ("step: 0.1", "step: 1")))
    assert recording.params["mu"] * recording.params["g"] == pytest.approx(GRIP)
    for vehicle in sorted((SPECS / "vehicles").glob("*.spec")):
        names = re.findall(r"^(?:param|table) +(\w+)", vehicle.read_text(), re.MULTILINE)
        assert {*recording.params, *recording.tables} <= set(names), vehicle


SHIPPED = (SPECS / "vehicles" / "devbot.spec").read_text()


def of_a_spec(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    """free_lap.yaml with the shipped vehicle, some of whose text is replaced, beside it."""
    path, text = declared(tmp_path), SHIPPED
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "car.spec").write_text(text)
    path.write_text(path.read_text().replace(VEHICLE, "vehicle: car.spec\n"))
    return path


def test_a_vehicle_of_a_spec_overrides_nothing_and_is_named(tmp_path: Path) -> None:
    recording = generate(of_a_spec(tmp_path))
    assert (recording.params, recording.tables) == ({}, {})
    assert recording.notes[0] == "the vehicle is that of car.spec, whose values stand"
    assert recording.cycles == made(FREE_LAP).cycles


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (("= 13 / 9.81 ", "= 8.2 / 9.81 "), "total acceleration"),
        (("0.854 kg/m  in", "8.54 kg/m  in"), "acceleration 6.6"),  # the drive also pushes against drag
        (("drive_factor : 1     = 1 ", "drive_factor : 1     = 0.2 "), "acceleration 1"),
        (("= 35 m/s^2 ", "= 1.9 m/s^2 "), "deceleration: 8"),
        (("= 11 m ", "= 200 m "), "curvature"),
    ],
)
def test_what_the_spec_of_a_vehicle_says_is_its_limit(
    tmp_path: Path, change: tuple[str, str], part: str
) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        generate(of_a_spec(tmp_path, change))
    assert caught.value.code == ("D151" if part.startswith("deceleration:") else "D152")
    assert part in caught.value.message


@pytest.mark.parametrize(
    ("change", "code", "part"),
    [
        (("param drag ", "param dragging "), "D151", "no `drag`"),
        (("table ax_max(", "table ax_most("), "D151", "no `ax_max`"),
        (("linear clamp", "step clamp"), "D151", "not read linearly"),
    ],
)
def test_a_spec_that_is_no_vehicle_is_refused(
    tmp_path: Path, change: tuple[str, str], code: str, part: str
) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        generate(of_a_spec(tmp_path, change))
    assert (caught.value.code, caught.value.line) == (code, 9)
    assert part in caught.value.message
    assert caught.value.help


def test_a_spec_that_is_not_there_or_elsewhere_is_refused(tmp_path: Path) -> None:
    for name in ("none.spec", "/etc/passwd.spec", "car.txt"):
        path = declared(tmp_path)
        path.write_text(path.read_text().replace(VEHICLE, f"vehicle: {name}\n"))
        with pytest.raises(TrackmarshalError) as caught:
            generate(path)
        assert caught.value.code == "D151"


def test_northfield_closes() -> None:
    track = road.load(SPECS / "tracks" / "northfield.yaml", "northfield.yaml")
    start, end = track.pieces[0].start, track.pieces[-1].pose(track.length)
    assert math.hypot(end[0] - start[0], end[1] - start[1]) < 1e-9
    assert track.pose(track.length + 5.0) == track.pose(5.0)
    assert track.pose(-5.0) == track.pose(track.length - 5.0)
    assert track.borders()["closed"] is True


def test_a_profile_is_the_integral_of_its_knots() -> None:
    profile = Profile(20.0, [[1.0, 2.0], [3.0, -4.0]])
    t, v, way = 0.0, 20.0, 0.0
    for _ in range(50_000):
        a0, a1 = profile.at(t)[0], profile.at(t + 1e-4)[0]
        way += v * 1e-4 + a0 * 5e-9
        v += (a0 + a1) / 2.0 * 1e-4
        t += 1e-4
    assert [*profile.at(5.0)] == [-4.0, pytest.approx(v, abs=1e-6), pytest.approx(way, abs=1e-4)]
    assert profile.at(0.5)[0] == 2.0
    assert profile.at(2.0)[0] == -1.0
    assert profile.time_at(profile.at(3.3)[2], 0.0, 5.0) == pytest.approx(3.3, abs=1e-9)


#: A vehicle that stands in the declaration itself.
VEHICLE = """vehicle:
  length: 4.7
  width: 2.0
  turn_radius: 11
  brake: 13
  grip: 13
  drive: [[0, 6], [36, 6], [72, 2.5]]     # largest acceleration over speed
"""


def declared(tmp_path: Path, *changes: tuple[str, str], track: str | None = None) -> Path:
    """free_lap.yaml, with a vehicle of its own and some of its text replaced, beside its track."""
    text = FREE_LAP.read_text().replace("../tracks/northfield.yaml", "track.yaml")
    assert OF_A_SPEC in text
    text = text.replace(OF_A_SPEC, VEHICLE)
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (tmp_path / "scene.yaml").write_text(text)
    northfield = (SPECS / "tracks" / "northfield.yaml").read_text()
    (tmp_path / "track.yaml").write_text(northfield if track is None else track)
    return tmp_path / "scene.yaml"


@pytest.mark.parametrize(
    ("change", "code", "line", "part"),
    [
        (("name: free_lap", "nmae: free_lap"), "D151", 5, "not known"),
        (("name: free_lap\n", ""), "D151", 3, "`name` is missing"),
        (("name: free_lap", "name: free_lap\nname: twice"), "D151", 6, "twice"),
        (("version: 1", "version: 2"), "D151", 4, "out of range"),
        (("trackmarshal-scenario", "trackmarshal-track"), "D151", 3, "is not"),
        (("duration: 10", "duration: ten"), "D151", 7, "number"),
        (("duration: 10", "duration: '10'"), "D151", 7, "number"),
        (("duration: 10", "duration: .nan"), "D151", 7, "number"),
        (("duration: 10", "duration: 1:30"), "D151", 7, "number"),
        (("duration: 10", "duration: [10]"), "D151", 7, "a list"),
        (("duration: 10", "duration: 30000"), "D151", 7, "cycles"),
        (("s: 620, d: 0", "s: 620, d: 0, d: 1"), "D151", 17, "twice"),
        (("s: 620, d: 0", "s: 620"), "D151", 17, "`d` is missing"),
        (("[1, -2]", "[0, -2]"), "D151", 18, "does not come after"),
        (("[1, -2]", "[1]"), "D151", 18, "1 numbers"),
        (("begin: 7", "begin: 3"), "D151", 21, "does not fit in"),
        (("points: 30, horizon", "points: 30.5, horizon"), "D151", 22, "whole number"),
        (("plan: {points: 30, horizon: 2.9}", "plan: 30"), "D151", 22, "a map"),
        (("name: free_lap", "name: &here free_lap"), "D150", 5, "anchors"),
        (("name: free_lap", "name: !!python/object/apply:os.getcwd []"), "D150", 5, "tags"),
        (("name: free_lap", "name: !local x"), "D150", 5, "tags"),
        (("name: free_lap", "name: free_lap: 5"), "D150", 5, ""),
        (("name: free_lap", "name: [" + "[" * 500), "D150", 5, "deeply"),
        (("name: free_lap", "\tname: free_lap"), "D150", 5, ""),
        (("name: free_lap", "name: \x07"), "D150", None, ""),
        (("track: ../", "track: ../"), "D120", None, ""),
    ],
)
def test_wrong_declarations_are_refused(
    tmp_path: Path, change: tuple[str, str], code: str, line: int | None, part: str
) -> None:
    if code == "D120":
        path = declared(tmp_path)
        (tmp_path / "track.yaml").unlink()
    else:
        path = declared(tmp_path, change)
    with pytest.raises(TrackmarshalError) as caught:
        generate(path)
    assert (caught.value.code, caught.value.line) == (code, line), str(caught.value)
    assert part in caught.value.message
    assert caught.value.help
    assert caught.value.file == str(tmp_path / ("track.yaml" if code == "D120" else "scene.yaml"))


@pytest.mark.parametrize("name", ["field/lvms.yaml", "tracks/northfield.yaml", "scenarios/faults.yaml"])
def test_another_document_is_told_by_its_format(name: str) -> None:
    """Its first key that no scenario has was "not known", with a list of those that one has."""
    with pytest.raises(TrackmarshalError, match=r"format: 'trackmarshal-.*' is not 'trackmarshal-scenario'"):
        generate(SPECS / name)


@pytest.mark.parametrize("read", [mapping.read, lambda path: campaigns.load(path, str(path))])
def test_a_scenario_is_no_mapping_and_no_campaign(read: Callable[[Path], object]) -> None:
    """Its first key was "not known" to these, too."""
    with pytest.raises(TrackmarshalError, match="format: 'trackmarshal-scenario' is not 'trackmarshal-"):
        read(SPECS / "scenarios" / "cut_in.yaml")


@pytest.mark.parametrize(
    ("change", "line", "part"),
    [
        (("ego:\n", "ego:\n  oncoming: true\n"), 17, "ego.oncoming: this key is not known"),
        (("ego:\n", "ego:\n  silent: [[1, 2]]\n"), 17, "ego.silent: this key is not known"),
        (("ego:\n", "ego:\n  id: own\n"), 17, "ego.id: this key is not known"),
        (("ego:\n", "others: [{start: {s: 700, d: 0, v: 25}}]\nego:\n"), 16, "`id` is missing"),
        (
            ("ego:\n", "obstacles:\n" + "  - {id: box, s: 900, d: 4, length: 1, width: 1}\n" * 2 + "ego:\n"),
            17,
            "the id `box` stands twice",
        ),
    ],
)
def test_what_a_car_under_test_or_another_one_does_not_have_is_refused(
    tmp_path: Path, change: tuple[str, str], line: int, part: str
) -> None:
    """The car under test drove against the road, and was compared with the others as if along it: none of them was ever ahead."""
    with pytest.raises(TrackmarshalError, match=re.escape(part)) as caught:
        generate(declared(tmp_path, change))
    assert (caught.value.code, caught.value.line) == ("D151", line)


LANE = "format: trackmarshal-track\nversion: 1\nname: lane\nwidth: 12\npieces: [{line: {length: 300}}]\n"
#: A circuit of 160 m: two straights of 40 m and two bends.
CIRCUIT = """format: trackmarshal-track
version: 1
name: circuit
width: 12
closed: true
repeat: 2
pieces: [{line: {length: 40}}, {arc: {radius: 12.732395447351628, angle: 180}}]
"""


@pytest.mark.parametrize("start", [5, 165, -155])
@pytest.mark.parametrize("zone", ["[10, 30]", "[170, 190]", "[-150, -130]", "[150, 190]"])
def test_a_zone_holds_on_every_lap(tmp_path: Path, start: float, zone: str) -> None:
    """Of zones, places were compared as declared, and the truth of every cycle beyond the finish line was that nothing is too fast."""
    text = "".join([
        "format: trackmarshal-scenario\nversion: 1\nname: laps\ntrack: track.yaml\nduration: 0.2\nstep: 0.1\n", VEHICLE,
        f"ego: {{start: {{s: {start}, d: 0, v: 6}}}}\nplan: {{points: 20, horizon: 2.5}}\n",
        "emergency: {points: 20, deceleration: 10, grip_share: 0.95}\n",
        f"limits: {{zones: [{{s: {zone}, d: [-6, 6], speed: 5}}]}}\n",
    ])  # fmt: skip
    (tmp_path / "scene.yaml").write_text(text)
    (tmp_path / "track.yaml").write_text(CIRCUIT)
    assert generate(tmp_path / "scene.yaml").ground_truth["static"] == (False,) * 3
    (tmp_path / "scene.yaml").write_text(text.replace("speed: 5", "speed: 6.5"))
    assert generate(tmp_path / "scene.yaml").ground_truth["static"] == (True,) * 3
    (tmp_path / "scene.yaml").write_text(text.replace(zone, "[60, 70]"))
    assert generate(tmp_path / "scene.yaml").ground_truth["static"] == (True,) * 3


@pytest.mark.parametrize(
    ("aside", "truth"), [(0.0, True), (0.1, None), (-1.9, None), (2.0, False), (-2.1, False)]
)
def test_a_car_that_is_reported_where_it_is_not_is_unsafe(
    tmp_path: Path, aside: float, truth: bool | None
) -> None:
    """It is 2 m wide: from there on, it does not even overlap its place."""
    text = "".join([
        "format: trackmarshal-scenario\nversion: 1\nname: aside\ntrack: track.yaml\nduration: 0.2\nstep: 0.2\n", VEHICLE,
        "ego: {start: {s: 5, d: 0, v: 5}}\nplan: {points: 16, horizon: 2}\n",
        f"emergency: {{points: 10, deceleration: 5, grip_share: 0.95}}\npose_error: [[0, {aside}]]\n",
    ])  # fmt: skip
    (tmp_path / "scene.yaml").write_text(text)
    (tmp_path / "track.yaml").write_text(CIRCUIT)
    assert generate(tmp_path / "scene.yaml").ground_truth["static"] == (truth,) * 2


def test_drag_helps_to_brake(tmp_path: Path) -> None:
    """At 20 m/s, 0.01 / m of it brake with 4 m/s^2 beside the 5 m/s^2 of the tyres; at rest, with nothing."""
    (tmp_path / "track.yaml").write_text(LANE)
    lane = road.load(tmp_path / "track.yaml", "track.yaml")
    motion = Motion(lane, Profile(20.0, [[0.0, 0.0]]), [], (0.0, 0.0), 8.0)
    braked = emergency(motion, 0.0, Braking(50, 30.0, 5.0, 0.01), lambda way: 0.0).columns
    assert [braked["a"][0], braked["a"][-1]] == pytest.approx([-9.0, -5.0], abs=0.01)


def test_a_car_that_has_left_where_it_was_last_heard_of_is_unsafe(tmp_path: Path) -> None:
    """It is 4.7 m long, and 2 m further in each cycle: while it overlaps its place that is free, and it is safe once it is heard of again."""
    text = "".join([
        "format: trackmarshal-scenario\nversion: 1\nname: silence\ntrack: track.yaml\nduration: 1.2\nstep: 0.2\n", VEHICLE,
        "ego: {start: {s: 5, d: 0, v: 5}}\nothers: [{id: blue, start: {s: 100, d: 0, v: 10}, silent: [[0, 1.1]]}]\n",
        "plan: {points: 16, horizon: 2}\nemergency: {points: 10, deceleration: 5, grip_share: 0.95}\n",
    ])  # fmt: skip
    (tmp_path / "scene.yaml").write_text(text)
    (tmp_path / "track.yaml").write_text(LANE)
    truth = generate(tmp_path / "scene.yaml").ground_truth["dynamic"]
    assert truth == (True, None, None, False, False, False, True)


def test_a_plan_that_rolls_back_is_unsafe(tmp_path: Path) -> None:
    """Slowly, so that neither brakes nor tyres are asked for more than they have."""
    text = "".join([
        "format: trackmarshal-scenario\nversion: 1\nname: back\ntrack: track.yaml\nduration: 1.2\nstep: 0.2\n", VEHICLE,
        "ego: {start: {s: 5, d: 0, v: 0.6}}\nplan: {points: 16, horizon: 1.5}\n",
        "emergency: {points: 10, deceleration: 1, grip_share: 0.95}\n",
        "mistakes: [{begin: 1, end: 1, acceleration: [[0, -1]]}]\n",
    ])  # fmt: skip
    (tmp_path / "scene.yaml").write_text(text)
    (tmp_path / "track.yaml").write_text(CIRCUIT)
    made = generate(tmp_path / "scene.yaml")
    assert min(made.cycles[5].candidates["driving"]["v"]) < -0.8
    assert made.ground_truth["static"] == (True,) * 5 + (False, True)


BLUE = "others:\n  - id: blue\n    start: {s: 700, d: 0, v: 25}\n"


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (("to: 1.5", "to: 5.5"), "leaves the road"),
        (("grip_share: 0.95", "grip_share: 0.5"), "no grip"),
        (("grip: 13", "grip: 8.2"), "total acceleration"),
        (("[9, 2]", "[9, 7]"), "acceleration"),
        (("turn_radius: 11", "turn_radius: 200"), "curvature"),
        (("[1, -2], [3, -2], [4, 0], [8, 0], [9, 2]", "[1, -5]"), "the speed is"),
        (("begin: 1, end: 4, to: 1.5", "begin: 1, end: 1.02, to: 1.5"), "sideways"),
        (("horizon: 2.9", "horizon: 0.5"), "longer than the driving"),
    ],
)
def test_impossible_declarations_are_refused(tmp_path: Path, change: tuple[str, str], part: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        generate(declared(tmp_path, change))
    assert caught.value.code == "D152", str(caught.value)
    assert part in caught.value.message
    assert caught.value.line is not None
    assert caught.value.help


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (("begin: 1, end: 4, to: 1.5", "begin: 0, end: 0.1, to: 1"), "total acceleration"),
        (("[[0, 0], [1, -2]", "[[0, 0], [0.5, 0], [0.55, -40], [0.6, 0], [1, -2]"), "total acceleration"),
        (("plan: {", BLUE + "    moves: [{begin: 1, end: 1.1, to: 1}]\nplan: {"), "total acceleration"),
        (
            ("plan: {", BLUE + "    acceleration: [[0, 0], [0.5, 0], [0.55, 40], [0.6, 0]]\nplan: {"),
            "acceleration",
        ),
    ],
)
def test_what_is_impossible_between_two_cycles_is_refused(
    tmp_path: Path, change: tuple[str, str], part: str
) -> None:
    """A car that stood a metre beside where it was, a tenth of a second before, was generated: in each of the two cycles nothing is asked of it."""
    test_impossible_declarations_are_refused(tmp_path, change, part)


TRACK = "format: trackmarshal-track\nversion: 1\nname: t\nwidth: 10\npieces:\n"


@pytest.mark.parametrize(
    ("track", "code", "part"),
    [
        (TRACK + "  - line: {length: 100}\n", "D152", "beyond the road"),
        (TRACK + "  - arc: {radius: 4, angle: 90}\n", "D152", "tighter"),
        (TRACK + "  - arc: {radius: 40, angle: 10, transition: 50}\n", "D152", "more than the angle"),
        (TRACK + "  - clothoid: {length: 10, to_curvature: 0.5}\n", "D152", "tighter"),
        (TRACK + "  - line: {length: 90000}\n  - line: {length: 90000}\n", "D152", "longer than"),
        (
            TRACK.replace("width", "closed: true\nwidth") + "  - line: {length: 10}\n",
            "D152",
            "from its start",
        ),
        (TRACK + "  - spline: {length: 10}\n", "D151", "no piece"),
        (TRACK + "  - {line: {length: 1}, arc: {radius: 1, angle: 1}}\n", "D151", "2 keys"),
        (TRACK + "  - arc: {radius: 0.5, angle: 1}\n", "D151", "too tight"),
        (TRACK + "  []\n", "D151", "empty"),
        (
            TRACK.replace("width: 10", "width: 10\nclosed: yes") + "  - line: {length: 9}\n",
            "D151",
            "true or false",
        ),
        ("", "D126", "empty"),
        ("# only this", "D126", "empty"),
        ("x" * 100_001, "D124", "bytes"),
    ],
)
def test_wrong_tracks_are_refused(tmp_path: Path, track: str, code: str, part: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        generate(declared(tmp_path, track=track))
    assert caught.value.code == code, str(caught.value)
    assert part in caught.value.message


def test_an_open_road_has_both_ends(tmp_path: Path) -> None:
    track = TRACK + "  - line: {length: 60}\n  - clothoid: {length: 40, to_curvature: 0.01}\n"
    (tmp_path / "t.yaml").write_text(track)
    borders = road.load(tmp_path / "t.yaml", "t.yaml").borders()
    assert borders["closed"] is False
    assert borders["left"][0] == [0.0, 5.0]
    assert len(borders["left"]) == 21
    # the clothoid's end: its heading is 0.2, its offset about kappa l^2 / 6
    x, y = (sum(side) / 2.0 for side in zip(borders["left"][-1], borders["right"][-1]))
    assert (x, y) == pytest.approx((100.0 - 40.0 * 0.2**2 / 10.0, 0.01 * 1600.0 / 6.0), abs=0.01)


def test_the_command_writes_a_recording(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "free_lap.tmrec.jsonl"
    assert command.main([str(FREE_LAP), str(target)]) == 0
    written, generated = scenarios.load(target), made(FREE_LAP)
    assert replace(written, use=()) == replace(generated, use=())
    used = [
        [(at.parent / name).resolve() for name in one.use]
        for at, one in ((target, written), (FREE_LAP, generated))
    ]
    assert used[0] == used[1] != []
    assert command.main([str(FREE_LAP)]) == 2
    assert command.main([str(tmp_path / "none.yaml"), str(target)]) == 2
    assert "D120" in capsys.readouterr().err


def test_nothing_heavy_is_imported() -> None:
    code = (
        "import sys, trackmarshal.scenarios as s; "
        "assert not {'yaml', 'zipfile', 'json', 'dataclasses'} & set(sys.modules); "
        f"s.load({str(SPECS / 'scenarios' / 'cut_in.tmrec.jsonl')!r}); "
        "assert not {'yaml', 'numpy', 'shapely', 'jsonschema', 'zipfile'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


#: What a declaration says of its vehicle in SI, as another spec than the shipped ones declares it.
OF_THE_VEHICLE = {
    "length": ("length : m = 5 m", "length : cm = 500 cm", "length >= 4 m"),
    "b_max": ("b_max : m/s^2 = 9 m/s^2", "b_max : km/h/s = 32 km/h/s", "b_max >= 9 m/s^2"),
    "ax_max": (
        "ax_max(v: m/s) -> m/s^2 = linear clamp | 0 m/s: 5 m/s^2 |",
        "ax_max(v: km/h) -> m/s^2 = linear clamp | 0 m/s: 5 m/s^2 |",
        "ax_max(40 m/s) >= 5 m/s^2",
    ),
}


@pytest.mark.parametrize("name", OF_THE_VEHICLE)
def test_what_is_generated_in_si_is_not_taken_in_another_unit(name: str, tmp_path: Path) -> None:
    """A car of 4.7 m was one of 4.7 cm, which collides with nothing."""
    recording = generate(declared(tmp_path, ("duration: 10", "duration: 0.4")))
    params = {key: value for key, value in recording.params.items() if key == name}
    tables = {key: rows for key, rows in recording.tables.items() if key == name}
    own = replace(recording, params=params, tables=tables, ground_truth={})
    head = "module made\nsignal ego : state { x: m, y: m, heading: rad, v: m/s }\n"
    kind = "table" if "(" in OF_THE_VEHICLE[name][0] else "param"
    in_si, in_another, asked = OF_THE_VEHICLE[name]
    specs = [
        loads(f"{head}{kind} {said}\nrule big require {asked} and ego.v >= 0 m/s\n")
        for said in (in_si, in_another)
    ]
    assert len(replay(own, Evaluator(specs[0])).cycles) == len(own.cycles)
    with pytest.raises(TrackmarshalError, match=f"D147.*`{name}` in "):
        replay(own, Evaluator(specs[1]))
    # What a declaration gives itself, under `params`, is in the declared units, as in any recording.
    assert len(replay(replace(own, in_si=frozenset()), Evaluator(specs[1])).cycles) == len(own.cycles)


def test_what_a_declaration_gives_itself_is_in_declared_units(tmp_path: Path) -> None:
    made_here = generate(declared(tmp_path, ("duration: 10", "params: {length: 470}\nduration: 0.4")))
    assert {key for _, key in made_here.in_si} == {
        "ax_max",
        "width",
        "R_min",
        "b_max",
        "mu",
        "g",
        "drag",
        "drive_factor",
    }
    assert made(FREE_LAP).in_si == frozenset()  # its vehicle is that of a spec
