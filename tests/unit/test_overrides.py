"""What a recording has in place of a spec's own values, what it gives that its cycles lack, and what is judged on a default."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator

from support.project import run_command
from support.report_runs import SPEC, cycle, evaluator, other, overtaking, record, recording
from support.shared import REPOSITORY, SUPERVISOR, shared
from trackmarshal.cli.replay import evaluator_for, run_one, summary
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import load as load_spec
from trackmarshal.scenarios import inputs, load, overrides, recording_io
from trackmarshal.scenarios import run_record as module
from trackmarshal.scenarios.recording import Recording
from trackmarshal.scenarios.replay import replay

WHY = "the event says so"


def of_a_file(**head: Any) -> Recording:
    """Two cycles with another car, written and read; `head` goes into the first line."""
    made = recording([cycle(0.1 * i, 2.0 * i, [other("blue", 90.0)]) for i in range(2)])
    lines = [json.loads(line) for line in recording_io.encode(made)]
    for line in lines[1:]:
        del line["objects"][0]["age"]
    text = "\n".join(json.dumps(line) for line in [{**lines[0], **head}, *lines[1:]])
    return recording_io.decode(text.encode(), "x.tmrec.jsonl")


def test_an_override_is_shown_with_what_the_spec_says_and_the_reason(tmp_path: Path) -> None:
    run = overtaking(params={"v_max": 25.0, "width": 2.0}, because={"v_max": WHY})
    made = record(tmp_path, run)
    Draft202012Validator(
        json.loads(Path(module.__file__).with_suffix(".schema.json").read_text("utf-8"))
    ).validate(made)
    # A width that is the spec's own is no override.
    assert made["overrides"] == [
        {"kind": "param", "name": "small.v_max", "value": "25 m/s", "own": "30 m/s", "because": WHY}
    ]
    rules = evaluator(tmp_path)
    said = summary(run_one(run, rules, quiet=True), rules)
    assert f"override: small.v_max = 25 m/s in place of 30 m/s: {WHY}" in said


def test_a_table_that_is_another_one_is_an_override(tmp_path: Path) -> None:
    text = SPEC + "\ntable drive(v: m/s) -> m/s^2 = linear clamp\n  | 0 m/s: 6 m/s^2 | 80 m/s: 3 m/s^2 |\n"
    spec = evaluator(tmp_path, text).spec
    same = overtaking(tables={"drive": [[0.0, 6.0], [80.0, 3.0]]})
    assert list(overrides.overrides(same, spec)) == []
    (found,) = overrides.overrides(overtaking(tables={"drive": [[0.0, 5.0]]}, because={"drive": WHY}), spec)
    assert str(found) == f"small.drive = 1 knots in place of 2 knots: {WHY}"


def test_a_parameter_with_a_reason_is_in_force_where_the_spec_has_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = overtaking(params={"mu": 1.5, "v_max": 10.0}, because={"mu": WHY, "v_max": WHY})
    rules = evaluator(tmp_path)
    outcome = run_one(run, rules, quiet=False)
    assert "its parameter `mu` is unknown to the spec" in capsys.readouterr().err
    assert len(outcome.unsafe_times("driving", "fast")) == 40  # 20 m/s, of 10 m/s that are allowed


def test_a_parameter_without_a_reason_is_refused_where_the_spec_has_none(tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        replay(overtaking(params={"mu": 1.5}), evaluator(tmp_path))
    assert caught.value.code == "D203"


def test_what_is_given_is_in_every_cycle_that_lacks_it(tmp_path: Path) -> None:
    given = of_a_file(
        given={"objects.age": 0.05, "plan.grip": 0.7}, because={"objects.age": WHY, "plan.grip": WHY}
    )
    assert [each["age"] for one in given.cycles for each in one.objects] == [0.05, 0.05]
    assert {x for one in given.cycles for plan in one.candidates.values() for x in plan["grip"]} == {0.7}
    assert recording_io.decode("\n".join(recording_io.encode(given)).encode(), "x.tmrec.jsonl") == given
    made = record(tmp_path, replace(given, cycles=given.cycles))
    assert {one["name"]: (one["value"], one["because"]) for one in made["given"]} == {
        "objects.age": (0.05, WHY), "plan.grip": (0.7, WHY),
    }  # fmt: skip
    assert made["defaults"] == []


def test_what_is_recorded_counts_more_than_what_is_given() -> None:
    made = recording(
        [cycle(0.0, 0.0, [other("blue", 90.0, age=0.2)])],
        given={"objects.age": 0.0},
        because={"objects.age": WHY},
    )
    assert inputs.filled(made).cycles[0].objects[0]["age"] == 0.2


def test_what_only_some_have_is_not_in_the_recording() -> None:
    """It may still be given: it is for those that lack it."""
    some = recording([cycle(0.0, 0.0, [other("blue", 90.0, seen=0.2), other("red", 80.0)])])
    every = recording([cycle(0.0, 0.0, [other("blue", 90.0, seen=0.2), other("red", 80.0, seen=0.1)])])
    assert ["objects.seen" in inputs.recorded(made) for made in (some, every)] == [False, True]


def test_what_is_given_of_obstacles_is_in_those_of_a_cycle_too() -> None:
    box = {"id": "box", "x": 50.0, "y": 9.0, "heading": 0.0, "length": 1.0, "width": 1.0}
    made = recording([cycle(0.0, 0.0), replace(cycle(0.1, 1.0), obstacles=[dict(box)])])
    made = replace(made, obstacles=[box], given={"obstacles.height": 2.0}, because={"obstacles.height": WHY})
    filled = inputs.filled(made)
    assert [each["height"] for one in filled.cycles for each in filled.standing(one)] == [2.0, 2.0]


def test_what_is_judged_on_a_default_is_named_with_who_judges_it(tmp_path: Path) -> None:
    run, rules = of_a_file(), evaluator(tmp_path)
    assert inputs.defaulted(run, rules.spec, rules.rules) == {"objects.age": ("A-FRESH",)}
    assert record(tmp_path, run)["defaults"] == [{"name": "objects.age", "rules": ["A-FRESH"]}]
    said = summary(run_one(run, rules, quiet=True), rules)
    assert "not in the recording: objects.age, so the spec's default is judged by A-FRESH" in said
    # Rules that are not asked judge nothing; and nobody judges the age of an object that is not there.
    asked = [rule for rule in rules.rules if rule.name != "A-FRESH"]
    assert inputs.defaulted(run, rules.spec, asked) == {}
    assert inputs.defaulted(recording([cycle(0.0, 0.0)]), rules.spec, rules.rules) == {}


def test_the_planners_recordings_rest_on_defaults_and_say_so() -> None:
    """They carry neither: by hand that is fine, as evidence it is not."""
    run = load(shared("data", "planner", "modena.tmrec.jsonl.gz"))
    spec = load_spec([SUPERVISOR], [], REPOSITORY)
    found = inputs.defaulted(replace(run, cycles=run.cycles[:2]), spec, spec.rules)
    assert found.keys() == {"plan.grip", "ego.age"}
    assert "A-FRICTION" in found["plan.grip"]
    assert "A-LOCALISATION" in found["ego.age"]


def test_archives_show_the_allowance_and_nothing_by_default() -> None:
    run = load(shared("data", "scenarios", "modena_T1_valid.saa"))
    used = evaluator_for(run, SUPERVISOR, [], REPOSITORY, None, "numpy")
    found = {one.name.rpartition(".")[2]: one for one in overrides.overrides(run, used.spec)}
    assert found.keys() == {"mu", "drive_factor", "ax_max"}
    assert all("allows 115 %" in found[name].because for name in ("mu", "drive_factor"))
    assert found["drive_factor"].own == "1"
    assert inputs.defaulted(run, used.spec, used.rules) == {}


def planned(folder: Path, **head: Any) -> str:
    """A file of a recording that lacks the age of objects."""
    path = folder / "x.tmrec.jsonl"
    recording_io.write(of_a_file(**head), path)
    (folder / "small.spec").write_text(SPEC)
    return str(path)


def replayed(folder: Path, *arguments: str) -> tuple[int, str, str]:
    return run_command("replay", planned(folder), "--spec", str(folder / "small.spec"), *arguments)


def test_whoever_replays_gives_what_is_missing_with_a_reason(tmp_path: Path) -> None:
    default, given = "not in the recording: objects.age", f"given in all cycles: objects.age = 0.15: {WHY}"
    _, out, err = replayed(tmp_path)
    assert default in out
    assert default not in err
    _, out, err = replayed(tmp_path, "--format", "jsonl")
    assert default in err
    assert all(json.loads(line) for line in out.splitlines())
    status, out, _ = replayed(tmp_path, "--given", "objects.age=0.15", "--because", WHY)
    assert given in out
    assert default not in out
    assert status == 1  # older than A-FRESH allows
    assert "A-FRESH" in out


def test_whoever_asks_why_gives_it_as_well(tmp_path: Path) -> None:
    """The numbers were those of the default, with which the rule is satisfied."""
    asked = [
        "explain",
        planned(tmp_path),
        "--spec",
        str(tmp_path / "small.spec"),
        "--rule",
        "A-FRESH",
        "--at",
        "0.1",
    ]
    status, out, _ = run_command(*asked, "--given", "objects.age=0.15", "--because", WHY)
    assert status == 0
    assert "0.15 s" in out
    assert "violated" in out
    status, _, err = run_command(*asked, "--given", "objects.age=0.15")
    assert (status, "error[E437]" in err) == (2, True)


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (("--given", "objects.age=0"), "without a reason"),
        (("--given", "objects.age=0", "--because", " "), "without a reason"),
        (("--because", WHY), "a reason for nothing"),
        (("--given", "objects.age=0", "--given", "objects.age=1", "--because", WHY), "given twice"),
        (("--given", "objects.age=old", "--because", WHY), "no finite number"),
        (("--given", "objects.age=inf", "--because", WHY), "no finite number"),
        (("--given", "age=1", "--because", WHY), "no field of"),
        (("--given", "ego.v=1", "--because", WHY), "part of every cycle"),
    ],
)
def test_what_cannot_be_given_is_refused(arguments: tuple[str, ...], part: str, tmp_path: Path) -> None:
    status, out, err = replayed(tmp_path, *arguments)
    assert (status, out) == (2, "")
    assert "error[E437]" in err
    assert part in err


def test_what_is_recorded_is_not_given(tmp_path: Path) -> None:
    path = planned(tmp_path, given={"objects.age": 0.05}, because={"objects.age": WHY})
    status, _, err = run_command(
        "replay", path, "--spec", str(tmp_path / "small.spec"), "--given", "objects.age=0", "--because", WHY
    )
    assert status == 2
    assert "`objects.age` is in the recording" in err
