"""The critical scenarios beside the cut-in: their recordings, their stories read off the recordings alone, and what is refused."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.length import shared_out
from trackmarshal import scenarios
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import load
from trackmarshal.ir.spec import Spec
from trackmarshal.scenarios import inputs, overrides, recording_io
from trackmarshal.scenarios.generate import generate, road
from trackmarshal.scenarios.generate.boxes import Box, separation
from trackmarshal.scenarios.recording import Cycle, Recording

SPECS = Path(__file__).parents[2] / "specs"
FOLDER = SPECS / "scenarios"
NAMES = (
    "wrong_way",
    "debris",
    "pit_entry",
    "overreach",
    "after_spin",
    "bad_reception",
    "late_brakes",
)
LENGTH, WIDTH = 4.7, 2.8
#: Deceleration by drag over the square of the speed, 1/m: 0.854 kg/m at 1160 kg.
DRAG = 0.854 / 1160.0
STORIES: dict[str, dict[str, list[tuple[float, bool | None]]]] = {
    "wrong_way": {
        "dynamic": [(0.0, True), (4.7, None), (6.3, False), (7.2, None), (7.9, True)],
        "static": [(0.0, True)],
    },
    "debris": {"dynamic": [(0.0, True)], "static": [(0.0, True), (4.7, False), (5.5, True)]},
    "pit_entry": {
        "dynamic": [(0.0, True)],
        "static": [(0.0, True), (0.8, False), (4.1, None), (4.2, True), (9.0, False), (10.1, True)],
    },
    "overreach": {
        "dynamic": [(0.0, True)],
        "static": [
            *((0.0, True), (1.0, False), (1.6, True), (3.0, False), (3.6, True)),
            *((5.0, False), (5.6, True), (11.0, False), (11.6, True)),
        ],
    },
    "after_spin": {
        "dynamic": [(0.0, True)],
        "static": [(0.0, True), (1.0, False), (1.6, True), (4.2, False), (4.8, True), (10.5, False), (11.1, True)],
    },
    "bad_reception": {
        "dynamic": [(0.0, True), (3.1, None), (3.2, False), (4.5, True)],
        "static": [(0.0, True), (6.1, None), (6.7, False), (8.1, None), (8.3, True)],
    },
    "late_brakes": {
        "dynamic": [(0.0, True)],
        "static": [(0.0, True), (0.8, False), (1.4, True), (6.0, False), (6.6, True)],
    },
}  # fmt: skip


@pytest.fixture(scope="module")
def recordings() -> dict[str, Recording]:
    return {name: scenarios.load(FOLDER / f"{name}.tmrec.jsonl.gz") for name in NAMES}


def same(one: Any, other: Any) -> bool:
    """Equal but for the last digits of numbers, which the platforms' sines may round differently."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(same(a, b) for a, b in zip(one, other))
    if isinstance(one, float):
        return bool(abs(one - other) <= 2e-6)
    return bool(one == other)


@pytest.mark.parametrize("name", shared_out(NAMES, 3))
def test_recordings_are_what_their_declarations_generate(name: str, recordings: dict[str, Recording]) -> None:
    fresh = [json.loads(line) for line in recording_io.encode(generate(FOLDER / f"{name}.yaml"))]
    assert same(fresh, [json.loads(line) for line in recording_io.encode(recordings[name])]), (
        f"run: trackmarshal scenario specs/scenarios/{name}.yaml --out specs/scenarios/{name}.tmrec.jsonl.gz"
    )
    assert (FOLDER / f"{name}.tmrec.jsonl.gz").stat().st_size < 200_000


@pytest.mark.parametrize("name", NAMES)
def test_the_ground_truth_tells_the_story(name: str, recordings: dict[str, Recording]) -> None:
    recording = recordings[name]
    for kind, truth in recording.ground_truth.items():
        told: list[tuple[float, bool | None]] = []
        for cycle, value in zip(recording.cycles, truth):
            if not told or told[-1][1] is not value:
                told.append((round(cycle.t, 9), value))
        assert told == STORIES[name][kind], kind


@pytest.mark.parametrize("name", NAMES)
def test_what_is_driven_is_possible(name: str, recordings: dict[str, Recording]) -> None:
    """Limits of the car, off the driven states; and but for the false position, candidates begin where the car is."""
    recording = recordings[name]
    for one, two in pairwise(recording.cycles):
        e = one.ego
        assert math.hypot(e["a"] + DRAG * e["v"] ** 2, e["v"] ** 2 * e["kappa"]) < 13.0
        assert abs(e["kappa"]) < 1.0 / 11.0
        assert two.ego["v"] - e["v"] == pytest.approx(0.05 * (e["a"] + two.ego["a"]), abs=0.03)
        if name != "bad_reception":
            for plan in one.candidates.values():
                for field in ("x", "y", "heading", "v"):
                    assert plan[field][0] == pytest.approx(e[field], abs=1e-6)


@cache
def rules() -> Spec:
    return load([SPECS / "supervisor"], [], SPECS.parent)


@pytest.mark.parametrize(
    "name", sorted(path.stem for path in FOLDER.rglob("*.yaml") if path.stem != "faults")
)
def test_shipped_scenarios_validate_shipped_values(name: str) -> None:
    """But for the limit of an event, which is the event's to say; and what assumptions watch is in every cycle."""
    (path,) = FOLDER.rglob(f"{name}.tmrec.jsonl*")
    recording = scenarios.load(path)
    event = {"overreach": {"v_event": 38.0}}.get(name, {})
    assert (recording.params, recording.tables) == (event, {})
    assert recording.because.keys() == event.keys()
    spec = rules()
    assert inputs.defaulted(recording, spec, spec.rules) == {}
    assert [one.name for one in overrides.overrides(recording, spec)] == [
        f"supervisor.conduct.{key}" for key in event
    ]


def test_slippery_is_what_is_declared_and_the_estimate_alone_is_wrong() -> None:
    """The plan asks for 9 m/s^2 on a road that is said to be dry, and 3 m/s^2 are what was measured."""
    path = FOLDER / "watch" / "slippery.yaml"
    recording = scenarios.load(FOLDER / "watch" / "slippery.tmrec.jsonl.gz")
    fresh, kept = (
        [json.loads(line) for line in recording_io.encode(each)] for each in (generate(path), recording)
    )
    assert same(fresh, kept)
    assert set(recording.ground_truth["static"]) == set(recording.ground_truth["dynamic"]) == {True}
    truth = recording.ground_truth["rule A-GRIP-ATTAINED"]
    for cycle, safe in zip(recording.cycles, truth, strict=True):
        driving, late = cycle.candidates["driving"], at(4.1, 5.5)(cycle)
        assert set(driving["grip"]) == {1.0}
        assert driving["a"][0] == (-9.0 if at(4.0, 5.5)(cycle) else 0.0)
        assert cycle.more["measured"] == {"ahead": -3.0 if late else 0.0, "left": 0.0}
        assert safe is (False if at(4.4, 5.5)(cycle) else None if late else True)


def plans(recording: Recording, test: Callable[[Cycle], bool]) -> list[dict[str, list[float]]]:
    found = [cycle.candidates["driving"] for cycle in recording.cycles if test(cycle)]
    assert found
    return found


def at(begin: float, end: float) -> Callable[[Cycle], bool]:
    return lambda cycle: begin - 1e-6 <= cycle.t <= end + 1e-6


def boxes(plan: dict[str, list[float]]) -> list[Box]:
    return [Box(x, y, h, LENGTH, WIDTH) for x, y, h in zip(plan["x"], plan["y"], plan["heading"])]


def test_wrong_way_the_cars_meet_head_on_and_do_not_touch(recordings: dict[str, Recording]) -> None:
    gaps = []
    for cycle in recordings["wrong_way"].cycles:
        (ghost,) = cycle.objects
        facing = math.remainder(ghost["heading"] - cycle.ego["heading"] - math.pi, math.tau)
        assert abs(facing) < 0.3
        gaps.append(separation(Box.of({**cycle.ego, "length": LENGTH, "width": WIDTH}), Box.of(ghost)))
    assert gaps[0] > 300.0
    assert 1.5 < min(gaps) < 4.0
    assert gaps[-1] > 20.0


def test_debris_lies_in_the_way_until_the_planner_sees_it(recordings: dict[str, Recording]) -> None:
    recording = recordings["debris"]
    pallet = Box.of(recording.obstacles[0])
    for begin, end, hits in ((0.0, 4.6, False), (4.8, 5.4, True), (5.5, 9.0, False)):
        for plan in plans(recording, at(begin, end)):
            assert (min(separation(box, pallet) for box in boxes(plan)) < 0.0) == hits


def test_pit_entry_is_fast_in_the_zone_first_and_when_it_wants_out(recordings: dict[str, Recording]) -> None:
    """The zone of tracks/northfield.spec, in the coordinates of the straight, which begins at 0 with heading 0.35."""

    def fastest(plan: dict[str, list[float]]) -> float:
        c, s = math.cos(0.35), math.sin(0.35)
        inside = [
            v
            for x, y, v in zip(plan["x"], plan["y"], plan["v"])
            if 100.0 < c * x + s * y < 400.0 and -14.0 < c * y - s * x < -8.0
        ]
        return max(inside, default=0.0)

    recording = recordings["pit_entry"]
    for begin, end, fast in ((0.0, 0.7, False), (0.8, 4.0, True), (4.2, 8.9, False), (9.0, 10.0, True), (10.1, 11.0, False)):  # fmt: skip
        for plan in plans(recording, at(begin, end)):
            assert (fastest(plan) > 60.0 / 3.6) == fast
    right = recording.track["right"]
    offsets = [math.cos(0.35) * y - math.sin(0.35) * x for x, y in right[:150]]
    assert min(offsets) == pytest.approx(-14.6, abs=1e-6)
    assert offsets[5] == pytest.approx(-6.0, abs=1e-6)


def test_overreach_asks_too_much_of_one_thing_after_the_other(recordings: dict[str, Recording]) -> None:
    recording = recordings["overreach"]

    def worst(begin: float, end: float, value: Callable[[float, float, float], float]) -> list[float]:
        return [max(map(value, p["v"], p["a"], p["kappa"])) for p in plans(recording, at(begin, end))]

    def grip(v: float, a: float, kappa: float) -> float:
        return math.hypot(a + DRAG * v * v, v * v * kappa)

    assert recording.params == {"v_event": 38.0}
    assert min(worst(1.0, 1.5, lambda v, a, k: v)) > 38.5
    assert max(worst(1.0, 1.5, grip)) < 13.0
    assert min(worst(3.0, 3.5, lambda v, a, k: a)) > 8.0
    assert min(worst(5.0, 5.5, lambda v, a, k: -a)) > 35.0
    assert min(worst(11.0, 11.5, grip)) > 13.3
    assert max(worst(11.0, 11.5, lambda v, a, k: a)) < 6.0
    assert max(worst(6.0, 10.9, grip)) < 12.0


def test_after_spin_each_mistake_is_what_it_says(recordings: dict[str, Recording]) -> None:
    recording = recordings["after_spin"]
    for plan in plans(recording, at(1.0, 1.5)):
        assert max(map(abs, plan["kappa"])) > 1.0 / 8.0
    for plan in plans(recording, at(4.2, 4.7)):
        offset = math.cos(0.35) * plan["y"][-1] - math.sin(0.35) * plan["x"][-1]
        assert offset == pytest.approx(-6.0, abs=0.05)  # the middle of the car on the border
    for plan in plans(recording, at(10.5, 11.0)):
        assert plan["v"][-1] < -0.5
        assert plan["s"][-1] < max(plan["s"])


def test_bad_reception_reports_old_and_shifted_poses(recordings: dict[str, Recording]) -> None:
    recording = recordings["bad_reception"]
    for cycle in recording.cycles:
        (green,) = cycle.objects
        silent = 3.0 + 1e-6 < cycle.t < 4.5 - 1e-6
        assert green["age"] == pytest.approx(cycle.t - 3.0 if silent else 0.0)
        plan = cycle.candidates["driving"]
        aside = math.hypot(plan["x"][0] - cycle.ego["x"], plan["y"][0] - cycle.ego["y"])
        expected = min(4.0, max(0.0, min(4.0 * (cycle.t - 6.0), 4.0 * (8.3 - cycle.t) / 0.3)))
        assert aside == pytest.approx(expected, abs=1e-5)


def test_late_brakes_the_car_overruns_what_it_should_fall_back_to(recordings: dict[str, Recording]) -> None:
    """A quarter of a second of driving on, then braking at 13 m/s^2, as if there were no bend: how far beyond the end."""
    for cycle in recordings["late_brakes"].cycles:
        driving, emergency = cycle.candidates["driving"], cycle.candidates["emergency"]
        v = driving["v"][0] + 0.25 * driving["a"][0]
        overrun = 0.125 * (driving["v"][0] + v) + v * v / 26.0 - emergency["s"][-1]
        late = at(0.8, 1.3)(cycle) or at(6.0, 6.5)(cycle)
        assert overrun > 1.0 if late else overrun < -2.0, cycle.t
        assert max(-a for a in emergency["a"]) < 13.0  # in itself it can be driven


# The parts of the generator -------------------------------------------------------------------------------------

poses = st.tuples(
    st.floats(-9.0, 9.0),
    st.floats(-9.0, 9.0),
    st.floats(-4.0, 4.0),
    st.floats(0.3, 6.0),
    st.floats(0.3, 6.0),
)


@given(poses, poses)
@settings(deadline=None)  # the first call imports shapely
def test_separation_has_the_sign_of_the_polygons_distance(one: Any, other: Any) -> None:
    from shapely import Polygon

    a, b = Box(*one), Box(*other)
    found = separation(a, b)
    polygons = Polygon(list(a.corners())), Polygon(list(b.corners()))
    if found > 1e-6:
        assert polygons[0].distance(polygons[1]) >= found - 1e-6
    elif found < -1e-6:
        assert polygons[0].intersects(polygons[1])


def test_backwards_is_the_same_line() -> None:
    track = road.load(SPECS / "tracks" / "northfield.yaml", "northfield.yaml")
    back = road.Backwards(track)
    for s in (0.0, 300.0, 780.0, 900.0, 2000.0):
        x, y, heading = track.pose(track.length - s)
        assert [*back.pose(s)] == [x, y, pytest.approx(heading + math.pi)]
        ahead = back.pose(s + 0.01)
        assert math.atan2(ahead[1] - y, ahead[0] - x) == pytest.approx(
            math.remainder(heading + math.pi, math.tau), abs=1e-3
        )
        turned = math.remainder(ahead[2] - heading - math.pi, math.tau)
        assert back.curvature(s) == pytest.approx(turned / 0.01, abs=1e-4)


def test_a_widening_opens_and_closes() -> None:
    wider = road.Widening("right", 100.0, 200.0, 8.0, 20.0)
    assert [wider.at(s) for s in (99.0, 100.0, 110.0, 120.0, 150.0, 190.0, 201.0)] == [0, 0, 4, 8, 8, 4, 0]
    track = road.load(SPECS / "tracks" / "northfield.yaml", "northfield.yaml", (wider,))
    assert track.edges(150.0) == track.edges(150.0 + track.length) == (-14.0, 6.0)
    assert track.edges(500.0) == (-6.0, 6.0)


def declared(tmp_path: Path, name: str, old: str, new: str) -> Path:
    text = (
        (FOLDER / f"{name}.yaml")
        .read_text("utf-8")
        .replace("../tracks", os.path.relpath(SPECS / "tracks", tmp_path))
        .replace("../vehicles", os.path.relpath(SPECS / "vehicles", tmp_path))
    )
    assert old in text
    (tmp_path / "scene.yaml").write_text(text.replace(old, new), encoding="utf-8")
    return tmp_path / "scene.yaml"


@pytest.mark.parametrize(
    ("name", "old", "new", "code", "part"),
    [
        ("wrong_way", "oncoming: true", "oncoming: 1", "D151", "true or false"),
        ("wrong_way", "begin: 6.7, end: 8.5", "begin: 6.7, end: 7.2", "D152", "total acceleration"),
        ("debris", "d: -1, length", "d: 2.5, length", "D152", "drives into an obstacle"),
        ("debris", "  - {begin: 0, end: 5.4, moves: []}", "  - {begin: 0, end: 5.4}", "D151", "nothing is planned"),
        ("debris", "end: 5.4, moves", "end: 6, moves", "D152", "in the middle of a move"),
        ("debris", "{begin: 0, end: 5.4, moves", "{begin: 6, end: 5.4, moves", "D151", "before it begins"),
        ("debris", "{id: pallet, ", "{", "D151", "`id` is missing"),
        ("pit_entry", "side: right", "side: up", "D151", "is no side"),
        ("pit_entry", "begin: 30, end: 450", "begin: 450, end: 30", "D151", "from 450 m to 30 m"),
        ("pit_entry", "by: 8.6", "by: 6", "D152", "leaves the road"),
        ("pit_entry", "s: [100, 400]", "s: [400, 100]", "D151", "no stretch"),
        ("pit_entry", "s: [100, 400]", "s: [100]", "D151", "no stretch"),
        ("overreach", "limits: {speed: 38}", "limits: {speeds: 38}", "D151", "not known"),
        ("overreach", "acceleration: [[0, 4]]", "acceleration: [[0, 15]]", "D152", "beyond the path"),
        ("late_brakes", "end: 1.3, deceleration: 18", "end: 1.3, deceleration: 36", "D151", "36"),
        ("late_brakes", "end: 1.3, deceleration: 18", "end: 1.3", "D151", "nothing is planned"),
        ("late_brakes", "begin: 6, end: 6.5", "begin: 60, end: 65", "D151", "no cycle lies from 60 to 65 s"),
        ("late_brakes", "begin: 6, end: 6.5", "begin: 6.01, end: 6.09", "D151", "no cycle lies from 6.01"),
        ("late_brakes", "begin: 6, end: 6.5", "begin: 1.3, end: 6.5", "D151", "in the cycle at 1.3 s"),
        ("late_brakes", "{window: 0.25, beyond: 1}", "{window: 0.25}", "D151", "`beyond` is missing"),
        ("late_brakes", "window: 0.25", "window: -0.25", "D151", "-0.25"),
        ("bad_reception", "silent: [[3, 4.5]]", "silent: [3, 4.5]", "D151", "list is expected"),
        ("bad_reception", "silent: [[3, 4.5]]", "silent: [[-1, 4.5]]", "D151", "before the recording"),
        ("bad_reception", "silent: [[3, 4.5]]", "silent: [[30, 45]]", "D151", "no cycle lies between 30 and 45 s"),
        ("bad_reception", "silent: [[3, 4.5]]", "silent: [[3, 4.5], [4, 5]]", "D151", "silent from 4 s on already"),
        ("bad_reception", "pose_error: [[6, 0],", "pose_error: [[8, 0],", "D151", "does not come after"),
    ],
)  # fmt: skip
def test_wrong_declarations_are_refused(
    tmp_path: Path, name: str, old: str, new: str, code: str, part: str
) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        generate(declared(tmp_path, name, old, new))
    assert caught.value.code == code, str(caught.value)
    assert part in caught.value.message, str(caught.value)
    assert caught.value.line is not None


def test_rolling_back_ends_where_the_recording_begins(tmp_path: Path) -> None:
    text = declared(tmp_path, "after_spin", "begin: 10.5, end: 11,", "begin: 0, end: 0.5,").read_text("utf-8")
    lines = [line for line in text.splitlines(keepends=True) if "moves:" not in line]
    path = tmp_path / "scene.yaml"
    path.write_text("".join(lines).replace("[[0, -2], [1.5, -2], [1.7, 0]]", "[[0, -5]]"), encoding="utf-8")
    with pytest.raises(TrackmarshalError, match="beyond the path") as caught:
        generate(path)
    assert caught.value.code == "D152"
