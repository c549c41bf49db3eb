"""What commands print for machines: each format has a schema, which says all of it and refuses anything else."""

from __future__ import annotations

import argparse
import importlib
import json
from collections.abc import Callable
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from jsonschema import Draft202012Validator, ValidationError

from support.project import run_command
from support.schemas import SCHEMAS, brief, schema_of, schemas, strict, validator
from support.shared import REPOSITORY
from trackmarshal.cli.main import VERBS
from trackmarshal.comparing.changes import EQUAL, GONE, MIXED, NEW, NOT_COMPARABLE, STRICTER, WEAKER
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.trace.impact.again import DOING

SPEC = """module formats
signal ego : state { v: m/s in [0, 100], braking: bool }
signal plan : series { t: s increasing, v: m/s }
param most : m/s = 20 m/s in [0, 90]
param least : m/s = 1 m/s in [0, 90]
constrain least <= most
rule town "not too fast"
  for all p in plan
  require p.v <= most
rule steady "made up"
  along plan as p
  require historically[0 s, 1 s] p.v <= most
rule gentle "made up"
  severity advisory
  require ego.v <= most
rule stops "made up"
  require ego.braking implies next not ego.braking
rule absent "made up"
  exists p in plan where p.v >= 90 m/s
  require p.v <= 95 m/s
test town "slow"
  given plan = { t: [0 s, 1 s], v: [10 m/s, 11 m/s] }
  expect satisfied
test town "not the one that it says"
  given plan = { t: [0 s, 1 s], v: [10 m/s, 30 m/s] }
  expect satisfied
rulebook strict "a limit before manners"
  town > gentle
"""
#: Those that are not about a run.
ONCE = ("town", "steady", "gentle", "absent")


def case(id_: Any, *speeds: Any, v: Any = 10.0, **more: Any) -> dict[str, Any]:
    plan = {"t": [float(k) for k in range(len(speeds))], "v": list(speeds)}
    return {"id": id_, "signals": {"ego": {"v": v, "braking": True}, "plan": plan}, **more}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "formats.spec").write_text(SPEC, "utf-8")
    return tmp_path


def lines(name: str, *cases: Any) -> str:
    Path(name).write_text("".join(one if isinstance(one, str) else json.dumps(one) + "\n" for one in cases), "utf-8")  # fmt: skip
    return name


def printed(*arguments: str) -> list[Any]:
    """Every value that a command prints, held against its schema."""
    _, out, err = run_command(*arguments)
    assert out, err
    name = schema_of(arguments)
    assert name is not None
    found = [strict(line) for line in (out.splitlines() if "jsonl" in arguments else [out])]
    for value in found:
        validator(name).validate(value)
    return found


def test_every_machine_format_has_a_schema() -> None:
    offering = set()
    for verb in VERBS:
        module = importlib.import_module(f"trackmarshal.cli.{verb.replace('-', '_')}" if verb not in OWN else f"trackmarshal.cli.{OWN[verb]}")  # fmt: skip
        parser = argparse.ArgumentParser()
        module.configure(parser)
        for action in parser._actions:
            if action.dest == "format" and action.choices and {"json", "jsonl"} & set(action.choices):
                offering.add(verb)
    assert offering == {key.partition(" ")[0] for key in SCHEMAS}
    assert {f"{name}.schema.json" for name in SCHEMAS.values()} <= set(schemas())


#: Verbs whose modules are called otherwise.
OWN = {"eval": "evaluate", "test": "run_tests", "import": "importing", "export": "exporting"}


def test_schemas_are_schemas() -> None:
    for name, schema in schemas().items():
        Draft202012Validator.check_schema(schema)
        assert schema.get("$id", name) == name


def test_pages_name_every_schema() -> None:
    page = (REPOSITORY / "docs" / "ci.md").read_text("utf-8")
    for path in (*(REPOSITORY / "engine").rglob("*.schema.json"), *(REPOSITORY / "trace").rglob("*.schema.json")):  # fmt: skip
        assert f"`{path.relative_to(REPOSITORY)}`" in page


def test_words_are_those_of_the_program() -> None:
    assert schemas()["eval.schema.json"]["$defs"]["rule"]["properties"]["verdict"]["enum"] == list(VERDICTS)
    words = schemas()["diff.schema.json"]["properties"]["rules"]["items"]["properties"]["word"]["enum"]
    assert set(words) == {EQUAL, STRICTER, WEAKER, MIXED, NOT_COMPARABLE, NEW, GONE}
    doing = schemas()["impact.schema.json"]["properties"]["again"]["items"]["properties"]["do"]["enum"]
    assert set(doing) == set(DOING)


@pytest.mark.usefixtures("folder")
def test_cases() -> None:
    """With all that a line may carry."""
    data = lines(
        "cases.jsonl", case(1, 10.0, 30.0), case("two", None, 5.0), case(None, 5.0), case(4.5, 5.0, 6.0, params={"least": 50.0}), case(True, 91.0, 1.0),
        "{]\n", case(5, 10.0, 1e999, v=-1.0),
    )  # fmt: skip
    found = printed("eval", "formats.spec", "--data", data, "--series", "--format", "jsonl", *(f"--rule={name}" for name in ONCE))  # fmt: skip
    kinds = {key for one in found for key in one}
    said = {key for one in found for rule in one.get("rules", {}).values() for key in rule}
    assert kinds == {"id", "safe", "rules", "faults", "constraints", "error"}
    assert said == {"verdict", "margin", "unit", "shown", "witness", "span", "decides", "advisory", "reason", "series"}  # fmt: skip
    assert {"nan", "inf"} & {rule["margin"] for one in found for rule in one.get("rules", {}).values()}


@pytest.mark.usefixtures("folder")
def test_cycles_of_a_run() -> None:
    run = [{**case(k, 10.0, 11.0), "t": float(k)} for k in range(3)]
    found = printed("eval", "formats.spec", "--run", "--data", lines("run.jsonl", *run), "--rule", "stops", "--format", "jsonl")  # fmt: skip
    assert {key for one in found for key in one} >= {"id", "safe", "rules", "end"}
    assert any("about" in one["rules"]["stops"] for one in found if "rules" in one)


@pytest.mark.usefixtures("folder")
def test_candidates_and_tests_and_findings() -> None:
    data = lines("both.jsonl", case("a", 10.0, 30.0), case("b", 5.0, 6.0, params={"least": 50.0}))
    chosen = [f"--rule={name}" for name in ONCE]
    (choice,) = printed("choose", "formats.spec", data, "--rulebook", "strict", "--format", "json", *chosen)
    assert {key for one in choice["candidates"] for key in one} == {"id", "safe", "violations", "rules", "constraints"}  # fmt: skip
    (tests,) = printed("test", "formats.spec", "--format", "json")
    assert {one["outcome"] for one in tests["tests"]} == {"passed", "failed"}
    Path("bad.spec").write_text(SPEC.replace("<= most\nrule gentle", "<= 20 kg\nrule gentle"), "utf-8")
    Path("cut.spec").write_text("module cut\nrule", "utf-8")
    (found,) = printed("check", "bad.spec", "cut.spec", "--format", "json")
    assert {"E301"} <= {one["code"] for one in found}
    (untested,) = printed("test", "bad.spec", "cut.spec", "--format", "json")
    assert not untested["tests"]
    assert {one["code"] for one in untested["findings"]} == {one["code"] for one in found}
    assert tests["findings"] == []


@pytest.mark.usefixtures("folder")
def test_benchmarks() -> None:
    Path("requirements").mkdir()
    Path("requirements/v-model.yaml").write_text("project: {name: p}\n", "utf-8")
    Path("tests/benchmarks").mkdir(parents=True)
    text = "LIMITS = {'a': 2.0}\n\n\ndef measure():\n    return {'a': 1.0, 'b (ratio)': float('inf')}\n"
    Path("tests/benchmarks/bench_made.py").write_text(text, "utf-8")
    (found,) = printed("bench", "--format", "json", "--quiet")
    assert [(one["value"], one["limit"]) for one in found["results"]] == [(1.0, 2.0), ("inf", None)]
    # One of two that there is not was left out without a word.
    status, out, err = run_command("bench", "made", "mode", "--quiet")
    assert (status, out) == (2, "")
    assert "error[E461]: no benchmark mode in" in err
    assert "help: made" in err
    # Where there is none, no files can be looked at.
    Path("tests/benchmarks/bench_made.py").unlink()
    assert "help: write a module bench_NAME.py there, with `measure()`" in run_command("bench")[2]


@pytest.mark.usefixtures("folder")
def test_anything_else_is_refused() -> None:
    (one,) = printed("eval", "formats.spec", "--data", lines("one.jsonl", case(1, 10.0)), "--rule", "town", "--format", "jsonl")  # fmt: skip
    changes: tuple[Callable[[Any], object], ...] = (
        lambda x: x.update(more=1),
        lambda x: x.pop("safe"),
        lambda x: x["rules"]["town"].update(verdict="fine"),
        lambda x: x["rules"]["town"].update(margin="-Infinity"),
        lambda x: x["rules"]["town"].pop("unit"),
    )
    for change in changes:
        other = deepcopy(one)
        change(other)
        with pytest.raises(ValidationError):
            validator("eval").validate(other)
    with pytest.raises(ValueError, match="NaN"):
        strict('{"margin": NaN}')


@pytest.mark.parametrize("wrong", [None, True, 7, "fine", -1e9, 1e9])
def test_of_a_long_list_what_alone_is_otherwise_is_held(wrong: Any) -> None:
    long = [{"series": [*(0.5 * k for k in range(50)), wrong, *(0.5 * k for k in range(50))]}]
    (held,) = brief(long)
    assert any(one == wrong and type(one) is type(wrong) for one in held["series"])
    assert len(held["series"]) < 20
    assert brief([0.5] * 3) == [0.5] * 3
    assert 7.5 in brief([*range(20), 7.5, 8.0, 9.0])  # a list of integers has no such
