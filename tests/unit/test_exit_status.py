"""What the exit status says, the same for every verb: 0 all well, 1 somebody has to look at it, 2 it could not be used."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml

from support.length import at_length
from support.project import run_command
from support.shared import REPOSITORY
from support.start import new_project

SCENARIOS = REPOSITORY / "specs" / "scenarios"
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
"""
Truth = dict[str, bool | None]


@pytest.fixture(autouse=True)
def small(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.spec").write_text(SPEC, encoding="utf-8")


def cycle(number: int, v: float = 20.0, other: float = 100.0, truth: Truth | None = None) -> dict[str, Any]:
    """A cycle of a car at x = 0 that plans to drive at v; `other` is where somebody else is, m."""
    columns = {
        "t": [0.0, 1.0],
        "x": [0.0, v],
        "y": [0.0, 0.0],
        "heading": [0.0] * 2,
        "kappa": [0.0] * 2,
        "v": [v] * 2,
        "a": [0.0] * 2,
    }
    stop = {**columns, "t": [0.0, 4.0], "x": [0.0, 2 * v], "v": [v, 0.0]}
    made = {
        "t": 0.1 * number,
        "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": v},
        "objects": [{"id": "o", "x": other, "y": 0.0, "heading": 0.0, "v": 0.0, "length": 4.0, "width": 2.0}],
        "candidates": {"driving": columns, "emergency": stop},
    }
    return made if truth is None else {**made, "ground_truth": truth}


def recorded(*cycles: dict[str, Any]) -> str:
    head = {
        "format": "trackmarshal-recording",
        "version": 1,
        "name": "made",
        "track": {"left": [[-9, 5], [99, 5]], "right": [[-9, -5], [99, -5]]},
    }
    Path("run.tmrec.jsonl").write_text("".join(json.dumps(line) + "\n" for line in (head, *cycles)))
    return "run.tmrec.jsonl"


def replayed(*cycles: dict[str, Any], more: tuple[str, ...] = ()) -> tuple[int, str]:
    status, out, err = run_command("replay", recorded(*cycles), "--spec", "small.spec", *more)
    assert "error" not in err, err
    return status, out


BOTH: Truth = {"dynamic": True, "static": True}


@pytest.mark.parametrize(
    ("cycles", "status"),
    [
        # Nothing is expected: safe or not.
        ([cycle(0), cycle(1)], 0),
        ([cycle(0), cycle(1, v=40.0)], 1),
        ([cycle(0), cycle(1, other=5.0)], 1),
        # Inside the ground truth.
        ([cycle(0, truth=BOTH), cycle(1, v=40.0, truth={"dynamic": True, "static": False})], 0),
        ([cycle(0, truth=BOTH), cycle(1, other=5.0, truth={"dynamic": False, "static": True})], 0),
        ([cycle(0, truth=BOTH), cycle(1, other=5.0, truth={"dynamic": None, "static": True})], 0),
        # A false alarm, and a miss.
        ([cycle(0, truth=BOTH), cycle(1, other=5.0, truth=BOTH)], 1),
        ([cycle(0, truth=BOTH), cycle(1, truth={"dynamic": False, "static": True})], 1),
        # What is expected of the one kind excuses nothing of the other.
        ([cycle(0, truth={"dynamic": True}), cycle(1, v=40.0, truth={"dynamic": True})], 1),
        ([cycle(0, truth={"static": False}, v=40.0), cycle(1, other=5.0, truth={"static": True})], 1),
        # A column without an entry is none.
        ([cycle(0, truth={"dynamic": True, "static": None}), cycle(1, v=40.0, truth={"dynamic": True, "static": None})], 1),
    ],
)  # fmt: skip
@pytest.mark.parametrize("format_", ["text", at_length("jsonl")])
def test_a_replay_is_held_against_what_was_declared(cycles: list[Any], status: int, format_: str) -> None:
    found, out = replayed(*cycles, more=("--format", format_))
    assert found == status, out
    assert replayed(*cycles, more=("--format", format_, "--exit-zero"))[0] == 0


def test_a_rule_of_one_kind_misses_what_the_truth_says_of_the_other() -> None:
    cycles = (cycle(0, truth=BOTH), cycle(1, other=5.0, truth={"dynamic": False, "static": True}))
    status, out = replayed(*cycles, more=("--rule", "fast"))
    assert "OUTSIDE" in out
    assert status == 1


def without_emergency(made: dict[str, Any]) -> dict[str, Any]:
    return {**made, "candidates": {"driving": made["candidates"]["driving"]}}


def moving_at_its_end(made: dict[str, Any]) -> dict[str, Any]:
    """The emergency trajectory does not come to rest, which the Supervisor's door refuses and no rule sees."""
    return {**made, "candidates": {**made["candidates"], "emergency": made["candidates"]["driving"]}}


@pytest.mark.parametrize("spoil", [without_emergency, moving_at_its_end])
@pytest.mark.parametrize(("truth", "status"), [(None, 1), (BOTH, 1), ({"dynamic": True, "static": None}, 0)])
def test_what_is_no_rule_counts_too(
    spoil: Callable[[dict[str, Any]], dict[str, Any]], truth: Truth | None, status: int
) -> None:
    first = cycle(0, truth=truth and BOTH)
    assert replayed(first, spoil(cycle(1, truth=truth)))[0] == status


def test_shipped_runs_are_inside_their_ground_truth() -> None:
    """A rule fires in the cut-in, as it has to."""
    status, out, _ = run_command(
        "replay", str(SCENARIOS / "cut_in.tmrec.jsonl"), "--project", str(REPOSITORY)
    )
    assert "violated" in out
    assert status == 0
    more = ("--rule", "speed_limit", "--project", str(REPOSITORY))
    status, out, _ = run_command("replay", str(SCENARIOS / "cut_in.tmrec.jsonl"), *more)
    assert "OUTSIDE" in out
    assert status == 1


def test_one_run_of_several_is_enough() -> None:
    good, bad = Path("good.tmrec.jsonl"), Path("bad.tmrec.jsonl")
    Path(recorded(cycle(0))).rename(good)
    Path(recorded(cycle(0, v=40.0))).rename(bad)
    for order in ((good, bad), (bad, good)):
        assert run_command("replay", *map(str, order), "--spec", "small.spec")[0] == 1


def data(*speeds: float | None) -> str:
    plan = {"t": [0, 1], "x": [0, 1], "y": [0, 0], "heading": [0, 0]}
    cases = [{"signals": {"plan": {**plan, "v": [1.0, v]}}} for v in speeds]
    Path("cases.jsonl").write_text("".join(json.dumps(case) + "\n" for case in cases))
    return "cases.jsonl"


@pytest.mark.parametrize("format_", ["text", "jsonl"])
@pytest.mark.parametrize(("speeds", "status"), [((1, 2), 0), ((1, 99), 1), ((99, 1), 1), ((1, None), 1)])
def test_eval_says_whether_all_is_safe(speeds: tuple[float | None, ...], status: int, format_: str) -> None:
    arguments = ("eval", "small.spec", "--rule", "fast", "--data", data(*speeds), "--format", format_)
    assert run_command(*arguments)[0] == status
    assert run_command(*arguments, "--exit-zero")[0] == 0


def test_unusable_input_is_not_excused() -> None:
    data(1, 99)
    with Path("cases.jsonl").open("a") as stream:
        stream.write("{\n")
    assert run_command("eval", "small.spec", "--rule", "fast", "--data", "cases.jsonl", "--exit-zero")[0] == 2
    assert run_command("replay", "none.saa", "--spec", "small.spec", "--exit-zero")[0] == 2


@pytest.mark.parametrize("verb", ["check", "test"])
def test_findings_of_other_verbs(verb: str) -> None:
    Path("bad.spec").write_text(SPEC.replace("108 km/h", "108 km"))
    arguments = [verb, "bad.spec"] if verb == "check" else [verb, "small.spec"]  # no rule has tests
    assert run_command(*arguments)[0] == 1
    assert run_command(*arguments, "--exit-zero")[0] == 0


OPTIONS = [
    ("--project", "{project}", "check"),
    ("--project={project}", "check"),
    ("--quiet", "--project", "{project}", "check"),
    ("--exit-zero", "--project", "{project}", "--quiet", "check"),
    ("--proj", "{project}", "check"),
    ("check", "--project", "{project}"),
]


@pytest.mark.parametrize("arguments", OPTIONS, ids=" ".join)
def test_common_options_stand_before_or_after_the_verb(arguments: tuple[str, ...], tmp_path: Path) -> None:
    new_project(tmp_path / "car")
    made = [argument.replace("{project}", str(tmp_path / "car")) for argument in arguments]
    status, _, err = run_command(*made)
    assert (status, err) == (0, "")


def test_an_option_before_the_verb_is_not_lost() -> None:
    """The folder is no project; a verb that ignored the option would find none either, but say so of another folder."""
    status, _, err = run_command("--project", "nowhere", "check")
    assert status == 2
    assert "nowhere has no requirements/v-model.yaml" in err
    assert "unknown verb" not in err
    assert run_command("--project", "nowhere")[0] == 2
    assert run_command("--nonsense", "check", "small.spec")[0] == 2
    assert run_command("--version")[0] == 0


def test_the_version_is_that_of_the_changes() -> None:
    """It was 0.1.0 for two releases, and so was what the safety case says of the parts of this program."""
    root = Path(__file__).resolve().parents[2]
    (number, state), *_ = re.findall(
        r"^## ([0-9.]+)(.*)$", (root / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE
    )
    version = f"{number}.dev0" if "unreleased" in state else number
    assert run_command("--version")[1] == f"trackmarshal {version}\n"
    tools = yaml.safe_load((root / "requirements" / "tools.yaml").read_text("utf-8"))["tools"]
    own = {tool["version"] for tool in tools if not tool["version"].startswith("those of")}
    assert own == {version}


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("show", "fast", "small.spec"), True),
        (("explain", "E301", "small.spec"), True),
        (("show", "fast", "small"), False),
        (("compile", "small.spec", "small.spec", "--out", "c"), False),
    ],
)
def test_a_spec_beside_the_argument_of_a_verb(arguments: tuple[str, ...], told: bool) -> None:
    """As `check` and `test` take it: what is left over may be named by an option."""
    status, _, err = run_command(*arguments)
    assert status == 2
    assert "unrecognized arguments: small" in err
    assert ("; a spec is named by --spec small.spec" in err) == told


@pytest.mark.parametrize(
    ("first", "second", "status"), [("unsafe", "safe", 2), ("unsafe", "unsafe", 1), ("safe", "safe", 0)]
)
def test_an_option_for_one_value_is_given_once(first: str, second: str, status: int) -> None:
    """Of two files of cases, the last one was evaluated: what was unsafe in the first one came out as safe."""
    for name, v in (("unsafe", 40.0), ("safe", 20.0)):
        plan = {"t": [0, 1], "x": [0, v], "y": [0, 0], "heading": [0, 0], "v": [v, v]}
        Path(name).write_text(json.dumps({"signals": {"plan": plan}}), encoding="utf-8")
    found, _, err = run_command("eval", "small.spec", "--rule", "fast", "--data", first, "--data", second)
    assert found == status
    assert ("argument --data: given twice, as unsafe and as safe" in err) == (first != second)


@pytest.mark.parametrize(("arguments", "status"), [(("check", "small.spec"), 0), (("check", "none.spec"), 2)])
def test_the_package_runs_as_a_module(arguments: tuple[str, ...], status: int) -> None:
    """Where the folder of commands is not on the path, as after `pip install --user`."""
    done = subprocess.run(
        [sys.executable, "-m", "trackmarshal", *arguments], capture_output=True, check=False
    )
    assert done.returncode == status, done.stderr


V_MODEL = """document: v-model
title: small
project:
  name: small
  specs: [specs]
  default_spec: specs/small.spec
  baseline: requirements/baseline.json
  scenarios: [{path: run.tmrec.jsonl, title: a run, stage: S-4-A, expect: EXPECT, origin: synthetic}]
stages: [{id: S-4-A, title: validation, shows: That it works., applies_to: [R-*], counts: [run]}]
gate: [{stage: S-4-A, requirements: [R-*], at_least: partial}]
"""
REQUIREMENT = """document: requirements
title: small
source: nobody
requirements:
  - id: R-1
    title: Speed
    statement: The vehicle shall never drive faster than 108 km/h.
    rationale: Speed is dangerous.
    adopted: somebody said so
    status: approved
    asil: D
    verification: [test]
    metrics: [fast]
    source: nobody
"""
TESTS = "".join(
    f'\n\ntest fast "at {v} km/h"\n  given  plan = line(v: {v} km/h)\n  expect {verdict}'
    for v, verdict in ((36, "satisfied"), (144, "violated"), (108, "satisfied, margin 0 m/s"))
)


def assessed(expect: str, *cycles: dict[str, Any], more: str = "") -> tuple[int, str]:
    """`assess` of a project with this one scenario, of which a declared demand is met in any case."""
    for folder in ("requirements", "specs"):
        Path(folder).mkdir(exist_ok=True)
    Path("requirements/v-model.yaml").write_text(V_MODEL.replace("EXPECT", expect))
    Path("requirements/r.yaml").write_text(REQUIREMENT)
    rule = SPEC.partition("\nrule near")[0].replace('"Not too fast"\n', '"Not too fast"\n  satisfies R-1\n')
    Path("specs/small.spec").write_text(rule + TESTS + "\n" + more)
    recorded(*cycles)
    run_command("trace", "--accept-baseline", "--by", "Ann Author", "--reason", "a test")
    status, out, err = run_command("assess", "--quiet")
    loud, _, _ = run_command("trace", "--gate", "--as-is", "--quiet")
    assert loud in (status, 0), "the gate may demand less, never more"
    return status, out + err


SAFE: Truth = {"static": True}
UNSAFE: Truth = {"static": False}


@pytest.mark.parametrize(
    ("expect", "cycles", "status"),
    [
        ("ground_truth", [cycle(0, truth=SAFE), cycle(1, truth=SAFE)], 0),
        ("ground_truth", [cycle(0, truth=SAFE), cycle(1, v=40.0, truth=UNSAFE)], 0),
        ("ground_truth", [cycle(0, truth=SAFE), cycle(1, v=40.0, truth=SAFE)], 1),
        ("ground_truth", [cycle(0, truth=SAFE), cycle(1, truth=UNSAFE)], 1),
        # Its ground truth is about other vehicles, and says nothing of what fires.
        ("ground_truth", [cycle(0, truth={"dynamic": True}), cycle(1, v=40.0, truth={"dynamic": True})], 1),
        ("no_fire", [cycle(0), cycle(1, v=40.0)], 1),
        ("fire, by: [fast]", [cycle(0), cycle(1, v=40.0)], 0),
        ("fire, by: [fast]", [cycle(0), cycle(1)], 1),
    ],
)
def test_assess_holds_runs_against_what_was_declared(expect: str, cycles: list[Any], status: int) -> None:
    found, text = assessed(expect, *cycles)
    assert found == status, text


def test_assess_and_trace_see_a_constraint_that_does_not_hold() -> None:
    cycles = (cycle(0, truth=SAFE), cycle(1, truth=SAFE))
    more = "\nparam a : m = 2 m\nparam b : m = {} m\n\nconstrain a <= b\n"
    assessed("ground_truth", *cycles, more=more.format(3))
    _, text, _ = run_command("trace", "--as-is")
    assert "error[T172]" in text, "no rule reads either of them"
    assert "error[E307]" not in text
    status, text = assessed("ground_truth", *cycles, more=more.format(1))
    assert status == 1
    assert "error[E307]" in text


@pytest.mark.parametrize("verb", ["check", "fmt", "test"])
def test_specs_are_where_the_v_model_says(verb: str) -> None:
    """Of every verb: `check` and `fmt` of a project with two folders may not pass over the second one."""
    assert run_command("init", "car")[0] == 0
    model = Path("car/requirements/v-model.yaml")
    said = model.read_text("utf-8").replace("  specs: [specs]", "  specs: [specs, more]")
    model.write_text(said, "utf-8")
    Path("car/more").mkdir()
    Path("car/more/bad.spec").write_text("module bad\nuse signals\nrule r require ego.v < 3\n", "utf-8")
    more = ("--check",) if verb == "fmt" else ()
    status, out, err = run_command(verb, *more, "--project", "car")
    assert status == (2 if verb == "test" else 1), out + err
    assert "bad.spec" in out + err


def test_fmt_calls_files_as_they_are_called_from_here() -> None:
    """As `check` does: whole paths are long, and another machine's."""
    assert run_command("init", "car")[0] == 0
    Path("car/specs/more.spec").write_text("module more\nparam   x : m = 2 m\n", "utf-8")
    assert run_command("fmt", "--check", "--project", "car")[1] == "would lay out car/specs/more.spec\n"


@pytest.mark.parametrize("verb", ["check", "fmt", "test", "trace", "assess"])
def test_a_v_model_that_names_no_specs_says_why(verb: str) -> None:
    """And not that a folder is missing of which nobody spoke."""
    assert run_command("init", "car")[0] == 0
    Path("car/specs").rename("car/rules")
    model = Path("car/requirements/v-model.yaml")
    model.write_text(model.read_text("utf-8").replace("  specs: [specs]", "  specs: [../rules]"), "utf-8")
    status, out, err = run_command(verb, "--project", "car")
    assert status == 2, out + err
    assert "error[T124]: an entry of `specs` is `../rules`" in err
    assert "requirements/v-model.yaml:8" in err


def test_a_test_that_names_the_wrong_sample_is_told_the_right_one() -> None:
    text = (
        SPEC
        + """
test fast "all of it"
  given plan = line(v: 20 m/s)
  expect satisfied, at p = 3
"""
    )
    Path("small.spec").write_text(text, encoding="utf-8")
    status, out, err = run_command("test", "small.spec")
    assert status == 1
    assert "expected p = 3 to decide, got p = 0\n" in out + err
