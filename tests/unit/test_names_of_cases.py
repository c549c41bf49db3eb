"""Names in the data of `eval`: what any spec of the project declares is fine, what nobody declares is an error with its line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from unittest import mock

import pytest

from support.project import run_command

SPEC = """module small
signal plan : trajectory { t: s increasing, v: m/s }
signal ego : state { x: m, age: s default 0 s }
rule fast "Not too fast"
  for all p in plan
  require p.v <= 100 m/s
rule fresh "Fresh"
  require ego.age <= 1 s
"""
OTHER = """module other
signal ego : state { omega: 1/s }
signal weather : state { rain: 1 }
event wet
rule odd require ego.omega <= 1 1/s
"""
RUN = """module run
signal ego : state { v: m/s }
rule recovers "Whoever is slow is faster within a second"
  whenever  ego.v < 10 m/s
  within    1 s
  require   ego.v >= 10 m/s
"""
V_MODEL = "document: v-model\ntitle: small\nproject:\n  name: small\n  specs: [specs]\n  default_spec: specs/small.spec\n"
GOOD: dict[str, Any] = {"plan": {"t": [0, 1], "v": [9, 0]}, "ego": {"x": 1, "age": 0}}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name, text in {
        "specs/small.spec": SPEC,
        "specs/other.spec": OTHER,
        "requirements/v-model.yaml": V_MODEL,
    }.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path


def evaluated(project: Path, *cases: dict[str, Any]) -> tuple[int, list[dict[str, Any]]]:
    data = project / "cases.jsonl"
    data.write_text("".join(json.dumps(case) + "\n" for case in cases), encoding="utf-8")
    status, out, _ = run_command(
        "eval", str(project / "specs" / "small.spec"), "--data", str(data), "--format", "jsonl"
    )
    return status, [json.loads(line) for line in out.splitlines()]


def test_what_other_specs_of_the_project_declare_is_fine(project: Path) -> None:
    signals = {**GOOD, "ego": {**GOOD["ego"], "omega": 7}, "weather": {"rain": 1}, "wet": True}
    status, (line,) = evaluated(project, {"signals": signals})
    assert (status, line["safe"]) == (0, True)


@pytest.mark.parametrize(
    ("case", "said", "meant"),
    [
        ({"signals": {**GOOD, "ego": {"x": 1, "Age": 9}}}, "ego: nothing declares `Age`", "age"),
        ({"signals": {**GOOD, "ego": {"x": 1, "omegga": 9}}}, "ego: nothing declares `omegga`", ""),
        ({"signals": {**GOOD, "wether": {}}}, "signals: nothing declares `wether`", ""),
        ({"signals": GOOD, "PARAMS": {}}, "a case has no `PARAMS`", "params"),
        ({"signals": GOOD, "zzz": 1}, "a case has no `zzz`", ""),
        ({"data": GOOD}, "a case has no `data`", ""),
    ],
)
def test_what_nobody_declares_is_named_with_its_line(
    project: Path, case: dict[str, Any], said: str, meant: str
) -> None:
    status, lines = evaluated(project, {"signals": GOOD}, case, {"signals": GOOD})
    assert status == 2
    assert [line.get("safe") for line in lines] == [True, None, True]
    error = lines[1]["error"]
    assert (error["code"], error["line"]) == ("D203", 2)
    assert error["message"] == said
    assert f"`{meant}`" in error["help"] or not meant
    assert error["help"]


def test_other_specs_are_asked_only_where_a_name_is_new(project: Path) -> None:
    (project / "specs" / "other.spec").write_text("module other\nthis is no spec\n", encoding="utf-8")
    with mock.patch("trackmarshal.cli.replay.project_specs", side_effect=AssertionError):
        assert evaluated(project, {"signals": GOOD})[0] == 0
    assert evaluated(project, {"signals": {**GOOD, "wet": True}})[0] == 2


def test_without_a_project_only_the_spec_itself_counts(tmp_path: Path) -> None:
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs" / "small.spec").write_text(SPEC, encoding="utf-8")
    (tmp_path / "specs" / "other.spec").write_text(OTHER, encoding="utf-8")
    assert evaluated(tmp_path, {"signals": GOOD})[0] == 0
    assert evaluated(tmp_path, {"signals": {**GOOD, "wet": True}})[0] == 2


def test_a_line_without_an_id_is_called_by_its_number(project: Path) -> None:
    _, lines = evaluated(
        project, {"signals": GOOD}, {"id": "b", "signals": GOOD}, {"id": None, "signals": GOOD}
    )
    assert [line["id"] for line in lines] == [1, "b", 3]


def test_so_are_candidates(tmp_path: Path) -> None:
    """They were called by their place among the lines that are not empty, so that `eval` called the same case otherwise."""
    spec, data = tmp_path / "small.spec", tmp_path / "candidates.jsonl"
    spec.write_text(SPEC + "rulebook small\n  fast > fresh\n", encoding="utf-8")
    data.write_text("".join(f"\n{json.dumps({'signals': GOOD})}\n" for _ in range(2)), encoding="utf-8")
    _, out, _ = run_command("choose", str(spec), str(data), "--format", "json")
    _, lines, _ = run_command("eval", str(spec), "--data", str(data), "--format", "jsonl")
    assert [one["id"] for one in json.loads(out)["candidates"]] == ["2", "4"]
    assert [json.loads(line)["id"] for line in lines.splitlines()] == [2, 4]


def test_so_are_cycles_of_which_later_ones_say_something(tmp_path: Path) -> None:
    (tmp_path / "run.spec").write_text(RUN, encoding="utf-8")
    (tmp_path / "run.jsonl").write_text(
        "".join(json.dumps({"t": t, "signals": {"ego": {"v": 9}}}) + "\n" for t in (0, 0.5, 1.5)), "utf-8"
    )
    command = ("eval", str(tmp_path / "run.spec"), "--run", "--data", str(tmp_path / "run.jsonl"))
    _, out, _ = run_command(*command, "--format", "jsonl")
    *cycles, last = [json.loads(line) for line in out.splitlines()]
    assert [cycle["id"] for cycle in cycles] == [1, 2, 3]
    third = [(one["cycle"], one["verdict"]) for one in cycles[2]["rules"]["recovers"]["about"]]
    assert third == [(3, "open"), (1, "violated"), (2, "violated")]
    assert [one["cycle"] for one in last["end"]["recovers"]] == [3]
    assert run_command(*command)[1].splitlines()[-1].split() == ["recovers", "3", "violated", "-1"]


def test_the_help_says_of_what_is_open_at_the_end_that_it_has_a_line_of_its_own(tmp_path: Path) -> None:
    """Whoever read one line a cycle, as it said, took a run as safe of which a deadline was missed."""
    (tmp_path / "run.spec").write_text(RUN, encoding="utf-8")
    (tmp_path / "run.jsonl").write_text('{"t": 0, "signals": {"ego": {"v": 9}}}\n', "utf-8")
    command = ("eval", str(tmp_path / "run.spec"), "--run", "--data", str(tmp_path / "run.jsonl"))
    status, out, _ = run_command(*command, "--format", "jsonl")
    cycle, last = [json.loads(line) for line in out.splitlines()]
    assert (status, cycle["safe"], list(last)) == (1, True, ["end"])
    assert '{"end": ' in run_command("eval", "--help")[1]


@pytest.mark.parametrize("backend", ["numpy", "reference"])
def test_cycles_have_what_a_rule_comes_to_at_every_sample_too(backend: str, tmp_path: Path) -> None:
    """Of a run, `--series` went unheard."""
    (tmp_path / "low.spec").write_text(
        "module low\nsignal plan : series { t: s increasing, v: m/s }\n"
        "rule slow along plan as p require always[0 s, 1 s] p.v <= 5 m/s\n",
        encoding="utf-8",
    )
    cycle = {"t": 0, "signals": {"plan": {"t": [0, 1, 3], "v": [4, 6, 2]}}}
    (tmp_path / "run.jsonl").write_text(json.dumps(cycle) + "\n", encoding="utf-8")
    command = ["eval", str(tmp_path / "low.spec"), "--data", str(tmp_path / "run.jsonl"), "--series"]
    command += ["--format", "jsonl", "--backend", backend]
    alone, of_run = (json.loads(run_command(*command, *more)[1].splitlines()[0]) for more in ((), ("--run",)))
    said = {"verdict": ["violated", "violated", "satisfied"], "margin": [-1.0, -1.0, 3.0]}
    assert alone["rules"]["slow"]["series"] == of_run["rules"]["slow"]["series"] == said
