"""The shipped scenarios against the shipped rules: every verdict lies inside the ground truth, and hangs on the rules it should."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from shapely import Polygon, box
from shapely.affinity import rotate, translate

from support.dense.sweep import corners
from support.length import at_length, shared_out
from support.shared import REPOSITORY
from trackmarshal import scenarios, trace
from trackmarshal.cli.replay import Known, evaluator_for
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.verdict import UNSAFE
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import Replay, replay

FOLDER = REPOSITORY / "specs" / "scenarios"
#: Rules beside the shipped Supervisor's that a recording is about.
BESIDE = {
    "late_brakes.tmrec.jsonl.gz": [REPOSITORY / "specs" / "fallback"],
    "slippery.tmrec.jsonl.gz": [REPOSITORY / "specs" / "watch"],
    **{
        path.name: [REPOSITORY / "specs" / "rulebooks"]
        for path in (FOLDER / "racing").glob("*.tmrec.jsonl.gz")
    },
}

#: What finds who closes the door.
DOOR = ("fallback_cut_in", "cut_in")

_known = Known()


@cache
def shipped(path: Path) -> tuple[Recording, Evaluator]:
    """A recording, and all rules for it."""
    recording = scenarios.load(path)
    spec, more = REPOSITORY / "specs" / "supervisor", BESIDE.get(path.name, [])
    return recording, evaluator_for(recording, spec, [], REPOSITORY, None, "numpy", known=_known, more=more)


def run(path: Path, without: tuple[str, ...] = ()) -> Replay:
    recording, evaluator = shipped(path)
    if without:
        names = [rule.name for rule in evaluator.rules]
        assert set(without) <= set(names)
        evaluator = Evaluator(evaluator.spec, [name for name in names if name not in without], "numpy")
    return replay(recording, evaluator, brief=True)


def test_the_project_declares_every_recording() -> None:
    project, _ = trace.load(REPOSITORY)
    declared = {str(scenario.path) for scenario in project.scenarios if scenario.origin != "field"}
    assert declared == {path.relative_to(REPOSITORY).as_posix() for path in FOLDER.rglob("*.tmrec.jsonl*")}
    assert {path.stem for path in FOLDER.rglob("*.yaml") if "format: trackmarshal-scenario" in path.read_text("utf-8")} == {
        Path(name).name.partition(".")[0] for name in declared
    }  # fmt: skip


@pytest.mark.parametrize(
    "path", shared_out(sorted(FOLDER.rglob("*.tmrec.jsonl*")), 5), ids=lambda path: path.name
)
def test_inside_the_ground_truth(path: Path) -> None:
    """Every day some of them: the gate replays them all, every day."""
    outcome = run(path)
    assert outcome.truths
    assert outcome.met
    assert not outcome.uncovered
    for truth in outcome.truths:
        assert (truth.missed, truth.false_alarms) == ((), ()), truth.kind


@pytest.mark.parametrize(
    ("name", "without", "times"),
    [
        (
            "cut_in.tmrec.jsonl",
            ("safe_gap", "safe_side", "rss_eq1", "safe_fallback", "fallback_collision", "planned_side"),
            (11.6, 12.1),
        ),
        (
            "wrong_way.tmrec.jsonl.gz",
            ("safe_gap_oncoming", "safe_side", "safe_fallback", "fallback_oncoming", "planned_side"),
            (6.3, 7.1),
        ),
        ("debris.tmrec.jsonl.gz", ("obstacle_collision",), (4.7, 5.4)),
        ("pit_entry.tmrec.jsonl.gz", ("zone_speed_limit",), (0.8, 10.0)),
        ("overreach.tmrec.jsonl.gz", ("speed_limit",), (1.0, 1.5)),
        at_length("overreach.tmrec.jsonl.gz", ("drive_acceleration",), (3.0, 3.5)),
        at_length(
            "overreach.tmrec.jsonl.gz",
            ("friction", "speed_integrity", "path_integrity", "corner_integrity", "swerve_integrity"),
            (11.0, 11.5),
        ),
        (
            "overreach.tmrec.jsonl.gz",
            (
                "friction",
                "braking_limit",
                "speed_integrity",
                "path_integrity",
                "corner_integrity",
                "swerve_integrity",
            ),
            (5.0, 11.5),
        ),
        ("after_spin.tmrec.jsonl.gz", ("turn_radius", "turn_integrity"), (1.0, 1.5)),
        ("after_spin.tmrec.jsonl.gz", ("static_collision",), (4.2, 4.7)),
        at_length("late_brakes.tmrec.jsonl.gz", ("takeup_friction",), (0.9, 1.3)),
        at_length("late_brakes.tmrec.jsonl.gz", ("takeup_friction", "takeup_speed"), (0.8, 6.5)),
        ("bad_reception.tmrec.jsonl.gz", ("A-PERCEPTION",), (3.2, 4.3)),
        (
            "bad_reception.tmrec.jsonl.gz",
            ("pose_match", "pose_on_path", "place_match", "heading_match"),
            (6.7, 8.0),
        ),
    ],
)
def test_without_the_rules_it_is_outside(name: str, without: tuple[str, ...], times: tuple[float, float]) -> None:  # fmt: skip
    """What the ground truth demands is found by these rules and no others."""
    missed = sorted(t for truth in run(FOLDER / name, without).truths for t in truth.missed)
    assert (missed[0], missed[-1]) == pytest.approx(times)


@pytest.mark.acceptance  # that it is inside its ground truth, every day
def test_a_fallback_through_another_car_is_found_by_one_rule_alone() -> None:
    """By shapely, too: bodies at the samples of the emergency trajectory lie on the other car in these cycles and in no others."""
    path = FOLDER / "stranded.tmrec.jsonl.gz"
    times = pytest.approx([5.5, 5.6, 5.7, 5.8, 5.9, 6.0])
    fired = unsafe(run(path))
    assert sorted({t for t, _ in fired}) == times
    assert {rule for _, rule in fired} == {"fallback_collision"}
    assert unsafe(run(path, ("fallback_collision",))) == []
    recording, evaluator = shipped(path)
    length, width = (evaluator.spec.params[f"vehicles.devbot.{name}"].value for name in ("length", "width"))
    over = []
    for cycle in recording.cycles:
        (other,), plan = cycle.objects, cycle.candidates["emergency"]
        there = body(other["x"], other["y"], other["heading"], other["length"], other["width"])
        bodies = [body(*pose, length, width) for pose in zip(plan["x"], plan["y"], plan["heading"])]
        over += [cycle.t] * any(one.intersection(there).area > 0.01 for one in bodies)
    assert over == times


@pytest.mark.acceptance  # that it is inside its ground truth, every day
def test_who_closes_the_door_is_found_by_two_rules_alone() -> None:
    """Worked out in small steps: whoever is behind brakes after its response as hard as it can, and is in the car ahead, which brakes, too."""
    path = FOLDER / "closing_door.tmrec.jsonl.gz"
    times = {name: {round(t, 1) for t, rule in unsafe(run(path)) if rule == name} for name in DOOR}
    assert {rule for _, rule in unsafe(run(path))} == set(DOOR)
    assert times == {"fallback_cut_in": {t / 10 for t in range(34, 45)}, "cut_in": {4.2, 4.3, 4.4}}
    assert unsafe(run(path, DOOR)) == []
    recording, _ = shipped(path)
    for cycle in recording.cycles:
        (other,), ego, t = cycle.objects, cycle.ego, round(cycle.t, 1)
        ahead = math.hypot(ego["x"] - other["x"], ego["y"] - other["y"]) - 4.7
        step, least = 0.001, ahead
        front, rear = ego["v"], other["v"]
        for k in range(6000):
            ahead += (front - rear) * step
            front, rear = (
                max(0.0, front - 13.0 * step),
                max(0.0, rear - (13.0 * step if k * step >= 0.2 else 0.0)),
            )
            least = min(least, ahead)
        if t in times["cut_in"]:
            assert least < -20.0
        if cycle.t < 1.0:
            assert least > 0.0
        if t < 4.5:  # from then on it gives way
            assert met_by(other, cycle.candidates["emergency"]) == (t in times["fallback_cut_in"]), t


def met_by(other: dict[str, Any], emergency: dict[str, list[float]]) -> bool:
    """Whether a car that goes straight on, and brakes from 0.2 s on, is in one that drives a fallback."""
    t = np.arange(0.0, 0.2 + other["v"] / 13.0, 0.01)
    x, y, heading = (np.interp(t, emergency["t"], emergency[name]) for name in ("x", "y", "heading"))
    ours = shapely.polygons(corners(x, y, heading, 4.7, 2.8))
    brakes = np.maximum(t - 0.2, 0.0)
    way = other["v"] * np.minimum(t, 0.2) + other["v"] * brakes - 13.0 * brakes**2 / 2
    x, y = (other[axis] + way * turned(other["heading"]) for axis, turned in (("x", np.cos), ("y", np.sin)))
    theirs = shapely.polygons(
        corners(x, y, np.full(len(t), other["heading"]), other["length"], other["width"])
    )
    return bool(shapely.intersects(ours, theirs).any())


def unsafe(replayed: Replay) -> list[tuple[float, str]]:
    """When which rule is against a candidate."""
    return [
        (cycle.t, name)
        for cycle in replayed.cycles
        for result in cycle.results.values()
        for name in result.rules
        if result.said(name).verdict in UNSAFE
    ]


def body(x: float, y: float, heading: float, length: float, width: float) -> Polygon:
    flat = box(-length / 2, -width / 2, length / 2, width / 2)
    return translate(rotate(flat, heading, origin=(0, 0), use_radians=True), x, y)
