"""Records of runs: exact margins, one letter a cycle, firings with what decided them, strict JSON."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from support.length import at_length
from support.report_runs import PLACES, SPEC, cycle, evaluator, flat, other, overtaking, record, recording
from support.shared import shared
from trackmarshal.runtime.verdict import CaseResult, RuleResult
from trackmarshal.scenarios import run_record as module
from trackmarshal.scenarios.replay import CycleOutcome, Replay, replay

VALIDATOR = Draft202012Validator(
    json.loads(Path(module.__file__).with_suffix(".schema.json").read_text("utf-8"))
)


def test_record_follows_its_schema(tmp_path: Path) -> None:
    truth = {"dynamic": (True,) * 5 + (None,) * 10 + (False,) * 10 + (None,) * 15}
    made = record(tmp_path, overtaking(ground_truth=truth, notes=("made up",)), "ab12")
    VALIDATOR.validate(made)
    assert made["source_hash"] == "ab12"
    assert made["ground_truth"]["dynamic"][20] is False
    (judged,) = made["truths"]
    assert len(judged.pop("unsafe")) == 40
    assert judged == {
        "kind": "dynamic", "inside": True, "judged": 15, "rules": ["A-FRESH", "near"], "missed": [], "false_alarms": [],
    }  # fmt: skip
    assert made["uncovered"] == [rule["name"] for rule in made["rules"]]  # the generator knows none of them


def test_margins_and_verdicts_are_those_of_the_replay(tmp_path: Path) -> None:
    rules = evaluator(tmp_path)
    run = replay(overtaking(), rules)
    made = json.loads(json.dumps(module.run_record(run, rules), allow_nan=False))
    for entry in made["rules"]:
        for candidate, lane in entry["candidates"].items():
            results = [c.results[candidate].rules[entry["name"]] for c in run.cycles]
            assert lane["verdict"] == "".join(r.verdict[0] for r in results)
            expected = [r.margin if math.isfinite(r.margin) else "inf" for r in results]
            assert lane["margin"] == expected  # bit for bit


def test_firing_says_when_by_how_much_who_and_where(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking())
    (firing,) = flat(made, "near")["firings"]
    assert (firing["from"], firing["to"], firing["cycles"]) == (1.0, 3.0, [10, 30])
    assert (firing["worst"]["t"], firing["worst"]["margin"], firing["worst"]["unit"]) == (2.0, -10.0, "m")
    assert firing["worst"]["line"] == "require abs(o.x - ego.x) > 10 m"
    assert firing["worst"]["span"].startswith("small.spec:")
    (where,) = firing["worst"]["where"]
    assert where == {"name": "o", "value": "blue", "signal": "objects", "t": None, "x": 40.0, "y": 3.0}


def test_deciding_sample_comes_with_its_time_and_place(tmp_path: Path) -> None:
    made = record(tmp_path, recording([cycle(0.0, 7.0, v=40.0)]))
    (where,) = flat(made, "fast")["firings"][0]["worst"]["where"]
    assert where == {"name": "p", "value": 0, "signal": "plan", "t": 0.0, "x": 7.0, "y": 0.0}


def test_flickering_rule_has_a_firing_a_stretch(tmp_path: Path) -> None:
    cycles = [cycle(0.1 * i, 0.0, [other("o", 5.0 if i % 3 == 1 else 50.0)]) for i in range(7)]
    lane = flat(record(tmp_path, recording(cycles)), "near")
    assert lane["verdict"] == "svssvss"
    assert [f["cycles"] for f in lane["firings"]] == [[1, 1], [4, 4]]


def test_worst_of_a_stretch_is_the_largest_violation_and_never_hidden_by_undefined(tmp_path: Path) -> None:
    rules = evaluator(tmp_path)
    run = replay(overtaking(count=4), rules)
    outcomes = [("undefined", math.nan), ("violated", -1.0), ("violated", -3.0), ("undefined", math.nan)]
    cycles = tuple(_with(c, "near", *outcome) for c, outcome in zip(run.cycles, outcomes))
    (firing,) = flat(module.run_record(Replay(run.recording, cycles, (), ()), rules), "near")["firings"]
    assert firing["verdicts"] == ["undefined", "violated"]
    assert (firing["worst"]["cycle"], firing["worst"]["margin"]) == (2, -3.0)


def test_undefined_only_stretch(tmp_path: Path) -> None:
    made = record(tmp_path, recording([cycle(0.0, -100.0), cycle(0.1, 0.0)]))
    lane = flat(made, "root")
    assert lane["verdict"] == "us"
    assert lane["margin"][0] == "nan"
    assert lane["firings"][0]["worst"]["verdict"] == "undefined"
    assert lane["least"]["cycle"] == 1
    VALIDATOR.validate(made)


def test_violated_by_zero_counts_as_least(tmp_path: Path) -> None:
    """A strict comparison on its boundary is violated with margin 0; a satisfied 0 beside it must not hide that."""
    rules = evaluator(tmp_path)
    run = replay(overtaking(count=2), rules)
    cycles = (_with(run.cycles[0], "near", "satisfied", 0.0), _with(run.cycles[1], "near", "violated", 0.0))
    least = flat(module.run_record(Replay(run.recording, cycles, (), ()), rules), "near")["least"]
    assert (least["cycle"], least["verdict"]) == (1, "violated")


def test_missing_candidate_is_absent_and_not_safe(tmp_path: Path) -> None:
    full = cycle(0.1, 2.0)
    first = cycle(0.0, 0.0)
    made = record(
        tmp_path, recording([replace(first, candidates={"driving": first.candidates["driving"]}), full])
    )
    assert flat(made, "fast", "emergency")["verdict"] == "-s"
    assert flat(made, "fast", "emergency")["margin"][0] is None
    assert made["candidates"]["emergency"]["safe"] == [None, True]
    assert made["candidates"]["emergency"]["paths"][0] is None
    assert made["decision"] == ["no_safe_trajectory", "drive"]
    VALIDATOR.validate(made)


def test_candidate_that_never_comes_has_no_lane(tmp_path: Path) -> None:
    cycles = [
        replace(c, candidates={"driving": c.candidates["driving"]})
        for c in (cycle(0.0, 0.0), cycle(0.1, 2.0))
    ]
    made = record(tmp_path, recording(cycles))
    assert list(made["rules"][1]["candidates"]) == ["driving"]
    assert made["candidates"]["emergency"]["safe"] == [None, None]


def test_non_finite_input_is_said_in_words_and_breaks_the_contract(tmp_path: Path) -> None:
    made = record(tmp_path, recording([cycle(0.0, math.nan, [other("o", math.inf)])]))
    VALIDATOR.validate(made)
    assert made["ego"]["x"] == ["nan"]
    assert made["objects"][0]["x"] == ["inf"]
    assert made["candidates"]["driving"]["safe"] == [False]
    assert any("not finite" in text for text in made["candidates"]["driving"]["faults"][0]["faults"])


def test_no_cycles(tmp_path: Path) -> None:
    made = record(tmp_path, recording([]))
    VALIDATOR.validate(made)
    assert made["t"] == []
    assert all(rule["candidates"] == {} for rule in made["rules"])


def test_car_has_the_size_that_the_recording_says_else_the_specs(tmp_path: Path) -> None:
    assert record(tmp_path, overtaking(count=1))["vehicle"] == {"length": 5.0, "width": 2.0}
    assert record(tmp_path, overtaking(count=1, params={"width": 2.8}))["vehicle"] == {
        "length": 5.0,
        "width": 2.8,
    }


def test_spec_without_a_size_leaves_it_open(tmp_path: Path) -> None:
    text = SPEC.replace("param length : m = 5 m in [1, 20]\n", "").replace(
        "param width : m = 2 m in [0.5, 5]\n", ""
    )
    rules = evaluator(tmp_path, text)
    assert module.run_record(replay(overtaking(count=1), rules), rules)["vehicle"] == {
        "length": None,
        "width": None,
    }


def test_places_are_those_that_rules_speak_of(tmp_path: Path) -> None:
    rules = evaluator(tmp_path, SPEC + PLACES)
    made = module.run_record(replay(overtaking(count=1), rules), rules)
    VALIDATOR.validate(made)
    assert made["places"] == [
        {"name": "slow", "kind": "zone", "points": [[10.0, 0.0], [300.0, 0.0], [300.0, 6.0], [10.0, 6.0]]},
        {"name": "start", "kind": "line", "points": [[20.0, -6.0], [20.0, 6.0]]},
    ]
    assert record(tmp_path, overtaking(count=1))["places"] == []


def test_assumptions_rules_and_their_texts(tmp_path: Path) -> None:
    made = record(tmp_path, overtaking(count=1))
    assert [(a["name"], a["monitored"], a["owner"]) for a in made["assumptions"]] == [
        ("A-FRESH", True, "perception"), ("A-WHO", False, "race control"),
    ]  # fmt: skip
    rules = {rule["name"]: rule for rule in made["rules"]}
    assert list(rules) == ["A-FRESH", "near", "fast", "rest", "root"]
    assert rules["near"]["kind"] == "dynamic"
    assert rules["fast"]["kind"] == "static"
    assert rules["fast"]["requirements"] == ["R-3", "R-2"]
    assert rules["fast"]["text"].splitlines()[-1] == "  require p.v <= v_max"


def test_paths_are_thinned_and_keep_their_ends(tmp_path: Path) -> None:
    run = overtaking(count=1)
    path = record(tmp_path, run)["candidates"]["driving"]["paths"][0]
    full = run.cycles[0].candidates["driving"]["x"]
    assert len(path["x"]) == module.PATH_POINTS < len(full)
    assert (path["x"][0], path["x"][-1]) == (full[0], full[-1])


def test_objects_come_and_go(tmp_path: Path) -> None:
    cycles = [
        cycle(0.0, 0.0, [other("a", 90.0)]),
        cycle(0.1, 0.0),
        cycle(0.2, 0.0, [other("b", 80.0), other("a", 91.0)]),
    ]
    objects = {o["id"]: o for o in record(tmp_path, recording(cycles))["objects"]}
    assert objects["a"]["cycles"] == [0, 2]
    assert objects["a"]["x"] == [90.0, 91.0]
    assert objects["b"]["cycles"] == [2]


@pytest.mark.parametrize(
    "name", ["modena_T1_cutin_collision", at_length("modena_T1_infeasible"), at_length("modena_T1_valid")]
)
def test_recordings_of_others(name: str) -> None:
    from support.shared import SUPERVISOR
    from trackmarshal.evaluation import Evaluator, load
    from trackmarshal.scenarios import load as load_recording

    rules = Evaluator(load([SUPERVISOR], [], SUPERVISOR), ["friction", "drive_acceleration", "ends_at_rest"])
    run = replay(load_recording(shared("data", "scenarios", f"{name}.saa")), rules)
    made: dict[str, Any] = json.loads(json.dumps(module.run_record(run, rules), allow_nan=False))
    VALIDATOR.validate(made)
    assert len(made["t"]) == len(run.cycles)
    assert made["vehicle"] == {"length": 4.7, "width": 2.8}


def _with(outcome: CycleOutcome, rule: str, verdict: str, margin: float) -> CycleOutcome:
    """A cycle with another outcome of one rule."""
    results = {}
    for name, result in outcome.results.items():
        changed: dict[str, RuleResult] = {
            **result.rules,
            rule: replace(result.rules[rule], verdict=verdict, margin=margin),
        }
        results[name] = CaseResult(result.id, changed, result.faults)
    return replace(outcome, results=results)
