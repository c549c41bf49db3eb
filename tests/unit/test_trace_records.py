"""Records travel through JSON unchanged, and what is no record is refused with its place."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from golden.trace.cases import PROJECT, Small
from support.project import run_command
from trackmarshal.errors import TrackmarshalError
from trackmarshal.records import results_file
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.results_file import Record, ResultsFile
from trackmarshal.records.runs import RuleFacts, RunSummary, TruthFacts
from trackmarshal.records.specs import Ref, SpecItem, SpecTest
from trackmarshal.records.tests import ExternalTest, TestResult

ITEM = SpecItem(
    "rule", "friction", "Grip", (Ref("S-1-A-4", 4, 13),), (Ref("A-FRICTION", 5, 13),), "specs/a.spec", 3, 1, "ab" * 32,
    severity="minor", source="paper eq 2", owner="", evidence="", monitored=True, compares=False,
)  # fmt: skip
TEST = SpecTest("friction", "on the boundary", "satisfied", True, "specs/a.spec", 40, 1)
RESULT = TestResult(
    "friction",
    "on the boundary",
    "failed",
    "ab" * 32,
    "margin 2 N, expected 0 N",
    "specs/a.spec",
    40,
    {"rule friction": "cd" * 32},
)
RUN = RunSummary(
    "specs/scenarios/cut_in.tmrec.jsonl", "01" * 32, "cd" * 32, 122,
    (RuleFacts("friction", "ab" * 32, {"driving": {"satisfied": 120, "violated": 2}, "emergency": {"satisfied": 122}}, 4.5, 2),),
    {"dynamic": TruthFacts(False, ("rated safe at 5.2 s",), ("safe_gap",)), "static": TruthFacts(True)}, True, "2026-06-01T12:00:00+00:00",
    {"../logs/drive.csv": "02" * 32},
)  # fmt: skip


CASE = FaultCase("specs/scenarios/faults.yaml", "F-1", "too fast", "RR-1", 12, "ef" * 32, "no target")
FOUND = FaultResult(
    "specs/scenarios/faults.yaml", "F-1", "failed", "ef" * 32, ("speed_limit", "friction"), "D211", 2.0, 2.2,
    "previous_emergency", 1.9, "apart", 2.1, "found too late",
)  # fmt: skip

EXTERNAL = ExternalTest(
    "tests.test_door", "opens", ("S-1-B-1",), "skipped", "no compiler", "tests/test_door.py", 7, 0.5, "pytest 9",
    "2026-06-01T12:00:00+00:00", "out/results.xml", 3, "ab" * 32,
)  # fmt: skip


@pytest.mark.parametrize(
    ("holds", "record"),
    [
        *(("spec_items", ITEM), ("spec_tests", TEST), ("test_results", RESULT), ("runs", RUN)),
        *(("fault_cases", CASE), ("fault_results", FOUND), ("external_tests", EXTERNAL)),
    ],
)
def test_round_trip(holds: str, record: Record, tmp_path: Path) -> None:
    path = tmp_path / "results" / "file.json"
    second = replace(record, scenario="another one") if isinstance(record, RunSummary) else record
    file = ResultsFile(holds, (record, second), "0.1.0", "2026-06-01T12:00:00+00:00")
    results_file.save(path, file)
    assert results_file.load(path) == file
    assert [p.name for p in path.parent.iterdir()] == ["file.json"]  # no draft is left behind


def test_fields_that_a_later_version_adds_are_ignored() -> None:
    assert SpecTest.from_json({**TEST.to_json(), "colour": "blue"}) == TEST


def test_fields_with_a_default_may_be_absent() -> None:
    data = ITEM.to_json()
    for name in ("severity", "source", "owner", "evidence", "monitored", "compares"):
        del data[name]
    item = SpecItem.from_json(data)
    assert (item.severity, item.owner, item.monitored, item.compares) == ("", "", True, True)


def changed(record: Any, **fields: Any) -> dict[str, Any]:
    data: dict[str, Any] = record.to_json()
    for name, value in fields.items():
        if value is None:
            del data[name]
        else:
            data[name] = value
    return data


@pytest.mark.parametrize(
    ("holds", "data", "said"),
    [
        ("spec_items", changed(ITEM, name=None), "spec item: `name` is missing"),
        ("spec_items", changed(ITEM, kind="law"), "spec item: `kind` is `law`, known are rule, assume"),
        (
            "spec_items",
            changed(ITEM, satisfies=["S-1-A-4"]),
            "`satisfies` must be a list of [id, line, column]",
        ),
        ("spec_items", changed(ITEM, line="3"), "`line` must be a whole number, not a text"),
        ("spec_items", changed(ITEM, line=-3), "`line` must be a whole number from 0"),
        ("spec_items", changed(ITEM, line=True), "`line` must be a whole number from 0"),
        ("spec_items", changed(ITEM, monitored=1), "`monitored` must be true or false, not a number"),
        ("spec_tests", changed(TEST, expects="safe"), "spec test: `expects` is `safe`"),
        (
            "test_results",
            changed(RESULT, outcome="skipped"),
            "test result: `outcome` is `skipped`, known are passed, failed, error",
        ),
        (
            "runs",
            changed(RUN, rules=[{"rule": "a", "fingerprint": "b", "counts": {"driving": {"fine": 3}}}]),
            "`fine` is no verdict",
        ),
        (
            "runs",
            changed(RUN, rules=[{"rule": "a", "fingerprint": "b", "counts": {}, "first_violation": "4"}]),
            "`first_violation`",
        ),
        ("runs", changed(RUN, ground_truth={"dynamic": {}}), "ground truth: `inside` is missing"),
        ("runs", changed(RUN, ground_truth=[]), "`ground_truth` must be an object, not a list"),
        (
            "runs",
            changed(RUN, rules=[{"rule": "a", "fingerprint": "b", "counts": {}}] * 2),
            "run summary: the rule `a` is there twice",
        ),
        ("runs", [], "run summary: an object is expected, not a list"),
        ("opinions", {}, "`holds` is `opinions`"),
    ],
)
def test_what_is_no_record_is_refused(holds: str, data: object, said: str, tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    envelope = {
        "format": results_file.FORMAT,
        "version": 1,
        "tool_version": "0",
        "created": "",
        "holds": holds,
        "items": [data],
    }
    path.write_text(json.dumps(envelope), encoding="utf-8")
    with pytest.raises(TrackmarshalError) as caught:
        results_file.load(path, "out/results/file.json")
    assert caught.value.code == "T290"
    assert caught.value.file == "out/results/file.json"
    assert said in caught.value.message


def test_two_runs_of_one_scenario_in_a_file_are_refused(tmp_path: Path) -> None:
    """As a merge leaves them: the one that was made last counted, whatever the other one had found."""
    path = tmp_path / "drive.json"
    later = replace(RUN, created="2999-01-01T00:00:00+00:00", fired=not RUN.fired)
    results_file.save(path, ResultsFile("runs", (RUN, later), "0", ""))
    with pytest.raises(TrackmarshalError, match=f"T290.*two runs of `{RUN.scenario}`"):
        results_file.load(path)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "not strict JSON"),
        (b"\xff\xfe", "not strict JSON"),
        (b'{"format": NaN}', "NaN is not strict JSON"),
        (b"[" * 100_000, "not strict JSON"),
        (
            b'{"items": [{"outcome": "failed", "outcome": "passed"}]}',
            "`outcome` is there twice in one object",
        ),
        (b'{"items": [{"name": "\\ud800"}]}', "half a pair of surrogates is no character"),
        (b"[]", "results file: an object is expected, not a list"),
        (b'{"format": "sarif"}', "its format is not `trackmarshal-results`"),
        (b'{"format": "trackmarshal-results", "version": 2}', "version 2 is newer"),
    ],
    ids=["empty", "binary", "nan", "deep", "twice", "surrogate", "list", "format", "version"],
)
def test_what_is_no_results_file_is_refused(content: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / "file.json"
    path.write_bytes(content)
    with pytest.raises(TrackmarshalError) as caught:
        results_file.load(path)
    assert caught.value.code == "T290"
    assert said in caught.value.message


def test_a_folder_is_no_results_file(tmp_path: Path) -> None:
    with pytest.raises(TrackmarshalError, match="T290"):
        results_file.load(tmp_path)


def test_the_fixture_is_read_whole() -> None:
    items, tests, results, runs = Small().parts()
    assert (len(items), len(tests), len(results), len(runs)) == (4, 12, 12, 3)
    assert PROJECT.is_dir()


def test_what_a_result_that_is_stale_says_to_run_makes_it_anew(tmp_path: Path) -> None:
    """It said `trackmarshal test`, which keeps no results."""
    car = tmp_path / "car"
    assert run_command("init", str(car), "--quiet")[0] == 0
    spec = car / "specs" / "speed.spec"
    edited = spec.read_text("utf-8").replace("v: 25 m/s", "v: 24 m/s").replace("margin 5", "margin 6")

    def helps() -> list[tuple[str, str]]:
        _, out, _ = run_command("trace", "--as-is", "--format", "json", "--project", str(car))
        found = json.loads(out)["findings"]
        return [(one["code"], one["help"]) for one in found if one["code"] in ("T216", "T217", "T218")]

    for code in ("T218", "T216"):
        ((said, help_),) = helps()
        assert said == code
        (verb,) = re.findall(r"`trackmarshal (\w+)`", help_)
        run_command(verb, "--project", str(car), "--quiet")
        assert helps() == []
        spec.write_text(edited, "utf-8")
