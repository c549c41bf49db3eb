"""`replay --rulebook`: both candidates of every cycle, and runs, beside each other."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from support.project import run_command
from trackmarshal.cli.preferring import Runs
from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.replay import CycleOutcome

SPEC = """module small

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }
signal objects : set of object { x: m, v: m/s }

rule fast "Not too fast"
  for all p in plan
  require p.v <= 108 km/h

rule near "Keep away from others"
  for all o in objects
  require abs(o.x - ego.x) > 10 m

rulebook order "Others first"
  near > fast
"""


@pytest.fixture(autouse=True)
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.spec").write_text(SPEC, encoding="utf-8")


def cycle(number: int, v: float = 20.0, other: float = 100.0, emergency: bool = True) -> dict[str, Any]:
    """A cycle of a car at x = 0 that plans to drive at v in a second, and to stop from 20 m/s; `other` is where somebody else is, m."""
    zero = [0.0, 0.0]
    plan = {
        "t": [0.0, 1.0],
        "x": [0.0, 20.0],
        "y": zero,
        "heading": zero,
        "kappa": zero,
        "v": [20.0, v],
        "a": zero,
    }
    stop = {**plan, "t": [0.0, 4.0], "x": [0.0, 40.0], "v": [20.0, 0.0]}
    return {
        "t": 0.1 * number,
        "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": 20.0},
        "objects": [{"id": "o", "x": other, "y": 0.0, "heading": 0.0, "v": 0.0, "length": 4.0, "width": 2.0}],
        "candidates": {"driving": plan, "emergency": stop} if emergency else {"driving": plan},
    }


def recorded(name: str, *cycles: dict[str, Any], file: str = "") -> str:
    track = {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]}
    head = {"format": "trackmarshal-recording", "version": 1, "name": name, "track": track}
    path = Path(f"{file or name}.tmrec.jsonl")
    path.write_text("".join(json.dumps(line) + "\n" for line in (head, *cycles)))
    return str(path)


def replayed(*recordings: str, more: tuple[str, ...] = ()) -> tuple[int, list[str]]:
    status, out, err = run_command(
        "replay", *recordings, "--spec", "small.spec", "--rulebook", "order", "--quiet", *more
    )
    assert "error" not in err, err
    return status, out.splitlines()


def test_candidates_are_compared_stretch_by_stretch() -> None:
    """0.1 s too fast, 0.2 s as much too fast, 0.3 s without an emergency trajectory, 0.4 s and on too fast again."""
    run = recorded(
        "one", cycle(0), cycle(1, v=40.0), cycle(2, v=35.0), cycle(3, emergency=False), cycle(4, v=40.0)
    )
    status, lines = replayed(run)
    assert status == 1
    assert lines[lines.index("rulebook order, driving beside emergency") + 1 :] == [
        "at s        driving is  for driving  for emergency",
        "0           equal",
        "0.1 to 0.2  worse than               fast",
        "0.4         worse than               fast",
    ]
    _, lines = replayed(run, more=("--format", "jsonl"))
    assert [json.loads(line) for line in lines if "rulebook" in line] == [
        {
            "scenario": "one",
            "rulebook": "order",
            "candidates": [
                {"from": 0.0, "to": 0.0, "outcome": "equal", "for": [], "against": []},
                {"from": 0.1, "to": 0.2, "outcome": "worse", "for": [], "against": ["fast"]},
                {"from": 0.4, "to": 0.4, "outcome": "worse", "for": [], "against": ["fast"]},
            ],
        }
    ]


def test_times_of_a_clock_that_counts_from_far_away_are_told_apart() -> None:
    """Stretches of a log with stamps of Unix were all "1.7e+09"."""
    cycles = [{**cycle(0, v=v), "t": 1.7e9 + 0.1 * number} for number, v in enumerate((20.0, 40.0, 35.0))]
    _, lines = replayed(recorded("one", *cycles))
    assert lines[lines.index("rulebook order, driving beside emergency") + 2 :] == [
        "1700000000                    equal",
        "1700000000.1 to 1700000000.2  worse than               fast",
    ]


def test_runs_are_compared_by_their_worst_cycles() -> None:
    fast = recorded("fast", cycle(0, v=35.0), cycle(1, v=40.0), cycle(2))
    near = recorded("near", cycle(0), cycle(1, other=4.0), cycle(2))
    faster = recorded("faster", cycle(0, v=41.0), cycle(1), cycle(2))
    _, lines = replayed(fast, near, faster)
    assert lines[lines.index("rulebook order: Others first") :] == [
        "rulebook order: Others first",
        "violation of  fast        near    faster",
        "near          -           by 6 m  -",
        "fast          by 36 km/h  -       by 39.6 km/h",
        "fast is better than near: near",
        "fast is better than faster: fast",
        "best by its driving trajectories: fast, no other one beats it",
    ]


def test_runs_of_one_scenario_are_told_apart_by_their_files() -> None:
    one = recorded("same", cycle(0, v=35.0), cycle(1), file="one")
    two = recorded("same", cycle(0), cycle(1, v=35.0), file="two")
    _, lines = replayed(one, two, more=("--format", "jsonl"))
    said = json.loads(lines[-1])
    assert said["best"] == ["one.tmrec.jsonl", "two.tmrec.jsonl"]
    assert said["compared"][0]["outcome"] == "equal"
    assert said["alone"] is False


def test_of_a_cycle_without_a_driving_trajectory_nothing_is_known() -> None:
    spec = tm.load("small.spec")
    outcome = tm.replay(tm.load_recording(recorded("some", cycle(0), cycle(1))), tm.Evaluator(spec))
    first, second = outcome.cycles
    left = CycleOutcome(second.t, {"emergency": second.results["emergency"]}, second.decision, None)
    order, runs = tm.rulebook(spec, "order"), Runs("text")
    runs.add(order, outcome)
    runs.add(order, replace(outcome, cycles=(first, left)))
    assert [line.split() for line in runs.of_all()[2:4]] == [
        ["near", "-", "undefined"],
        ["fast", "-", "undefined"],
    ]
    assert (
        runs.of_all()[4]
        == "some.tmrec.jsonl: all rules count as undefined, since there is no driving trajectory at 0.1 s"
    )
    with pytest.raises(TrackmarshalError, match="has no driving trajectory") as error:
        runs.add(order, replace(outcome, cycles=(left,)))
    assert error.value.code == "E409"


def test_of_a_run_of_which_nothing_can_be_relied_on_it_is_said_why() -> None:
    """A value outside its range leaves rules a verdict, and the table had "undefined" for all of them without a word."""
    Path("small.spec").write_text(SPEC.replace("v: m/s }\nsignal ego", "v: m/s in [-1, 50] }\nsignal ego"))
    _, lines = replayed(recorded("kept", cycle(0), cycle(1)), recorded("beyond", cycle(0), cycle(1, v=60.0)))
    assert (
        "beyond: all rules count as undefined, since what they say at 0.1 s cannot be relied on" in lines
    ), lines


def test_what_cannot_be_compared_is_refused() -> None:
    some = recorded("some", cycle(0))
    status, out, err = run_command("replay", some, "--spec", "small.spec", "--rulebook", "ordre")
    assert (status, out) == (2, "")
    assert "error[E408]" in err
    chosen = ("--rulebook", "order", "--rule", "fast")
    status, _, err = run_command("replay", some, "--spec", "small.spec", *chosen)
    assert status == 2
    assert "error[E409]" in err
