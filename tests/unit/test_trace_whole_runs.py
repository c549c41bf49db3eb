"""Runs as a whole: what they show about a requirement that no rule evaluates, such as that nothing fires falsely."""

from __future__ import annotations

from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from golden.trace.cases import TODAY, Small
from trackmarshal import trace
from trackmarshal.records.runs import TruthFacts

FIELD = "scenarios/field.jsonl"
CUT_IN = "scenarios/cut_in.jsonl"


def named(folder: Path, stage: str, scenario: str, requirements: str = '["*", S-1-B-1]') -> Small:
    """The small project, in which a stage asks about S-1-B-1, which has no rule, and a scenario names it."""
    small = Small.copy(folder)
    path = small.root / "requirements" / "v-model.yaml"
    lines = path.read_text("utf-8").splitlines()
    for number, line in enumerate(lines):
        if f"id: {stage}," in line:
            lines[number] = line.replace(
                "applies_to: [S-1-A-*, RR-*]", "applies_to: [S-1-A-*, RR-*, S-1-B-1]"
            )
        if f"path: {scenario}," in line:
            lines[number] = line.replace("}", f", requirements: {requirements}}}")
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return small


def matrix(small: Small, **changed: Any) -> trace.Matrix:
    """`changed`: fields of the runs."""
    items, tests, results, runs = small.parts()
    runs = [replace(run, **changed) for run in runs]
    inputs = {run.scenario: {f"rule {item.name}": item.fingerprint for item in items} for run in runs}
    return trace.build(small.root, items, tests, results, runs, TODAY, run_inputs=inputs)


def cell(small: Small, stage: str, **changed: Any) -> tuple[str, list[str]]:
    """The cell of S-1-B-1, as above."""
    row = next(row for row in matrix(small, **changed).rows if row.requirement.id == "S-1-B-1")
    found = row.cells[stage]
    return found.status, [f"{item.name}: {item.detail}" for item in found.items]


def test_nothing_fires_in_the_field(tmp_path: Path) -> None:
    status, said = cell(named(tmp_path, "S-4-B", FIELD), "S-4-B")
    assert status == "covered"
    assert said[0].startswith(f"{FIELD}: nothing fired in ")


def test_something_fires_in_the_field(tmp_path: Path) -> None:
    assert cell(named(tmp_path, "S-4-B", FIELD), "S-4-B", fired=True)[0] == "failed"


def test_a_rule_that_was_not_evaluated_leaves_it_in_part(tmp_path: Path) -> None:
    """Whether the run counts nothing of it, or does not speak of it."""
    small = named(tmp_path, "S-4-B", FIELD)
    (run,) = (one for one in small.parts()[3] if one.scenario == FIELD)
    first, *others = run.rules
    idle = replace(first, counts={"driving": {"inactive": 100}})
    status, said = cell(small, "S-4-B", rules=(idle, *others))
    assert status == "partial"
    assert said[0].endswith(f"but 1 rule was not evaluated in it: `{first.rule}`")
    for rules in ((), tuple(others)):  # of a run that says nothing of a rule, nobody knows how it was with it
        assert cell(small, "S-4-B", rules=rules)[0] == "stale"


def test_a_recording_that_was_made_shows_it_in_part(tmp_path: Path) -> None:
    small = named(tmp_path, "S-4-B", FIELD)
    small.replace("requirements/v-model.yaml", "origin: field", "origin: synthetic")
    assert cell(small, "S-4-B")[0] == "partial"


def test_all_verdicts_together_lie_inside_the_ground_truth(tmp_path: Path) -> None:
    status, said = cell(named(tmp_path, "S-4-A", CUT_IN), "S-4-A")
    assert status == "covered"
    assert "inside the ground truth (" in said[0]


def test_what_is_unsafe_where_no_ground_truth_speaks_of_it_is_not_inside(tmp_path: Path) -> None:
    """As by a breach of the input contract, or by a rule that nobody declared a truth of: of all kinds there are, all verdicts lie inside."""
    small = named(tmp_path, "S-4-A", CUT_IN)
    status, said = cell(small, "S-4-A", unexpected=(3.5,))
    assert (status, said) == (
        "failed",
        [f"{CUT_IN}: unsafe at 3.5 s, of which no ground truth says what to expect"],
    )
    found = [one.message for one in matrix(small, unexpected=(3.5,)).findings if one.code == "T243"]
    assert found == [
        f"the run of `{CUT_IN}` is unsafe at 3.5 s, of which no ground truth says what to expect"
    ]


def against(small: Small, *names: str) -> dict[str, Any]:
    """What is different of the run in the field where these rules are violated."""
    (run,) = (one for one in small.parts()[3] if one.scenario == FIELD)
    loud = {"driving": {"satisfied": 90, "violated": 10}}
    rules = tuple(replace(one, counts=loud) if one.rule in names else one for one in run.rules)
    return {"rules": rules, "fired": bool(names)}


@pytest.mark.parametrize(("by", "violated", "status"), [
    ("gap", ["gap"], "covered"), ("gap, turn", ["gap"], "failed"), ("gap", ["turn"], "failed"), ("gap", [], "failed"),
])  # fmt: skip
def test_what_is_to_fire_fires_by_all_that_are_named(
    by: str, violated: list[str], status: str, tmp_path: Path
) -> None:
    small = named(tmp_path, "S-4-B", FIELD)
    small.replace("requirements/v-model.yaml", "expect: no_fire", f"expect: fire, by: [{by}]")
    assert cell(small, "S-4-B", **against(small, *violated))[0] == status


@pytest.mark.parametrize("expect", ["no_fire", "fire, by: [gap]", "ground_truth"])
def test_a_run_that_contradicts_its_ground_truth_shows_nothing_else(expect: str, tmp_path: Path) -> None:
    small = named(tmp_path, "S-4-B", FIELD)
    small.replace("requirements/v-model.yaml", "expect: no_fire", f"expect: {expect}")
    came = against(small, *(["gap"] if "fire, " in expect else []))
    wrong = TruthFacts(False, ("rated safe at 1 s, the ground truth is unsafe",))
    assert cell(small, "S-4-B", ground_truth={"dynamic": TruthFacts(True)}, **came)[0] == "covered"
    status, said = cell(small, "S-4-B", ground_truth={"dynamic": wrong}, **came)
    assert (status, said) == (
        "failed",
        [f"{FIELD}: outside the dynamic ground truth: rated safe at 1 s, the ground truth is unsafe"],
    )


def test_without_a_ground_truth_nothing_is_shown(tmp_path: Path) -> None:
    status, said = cell(named(tmp_path, "S-4-A", CUT_IN), "S-4-A", ground_truth={})
    assert (status, said) == ("missing", [f"{CUT_IN}: the recording carries no ground truth"])


def test_where_rules_are_asked_for_other_rules_stand_in_for_nothing(tmp_path: Path) -> None:
    small = named(tmp_path, "S-4-B", FIELD)
    small.replace(
        "requirements/v-model.yaml",
        "shows: its rules, applies_to: [S-1-A-*, RR-*]",
        "shows: its rules, applies_to: [S-1-A-*, RR-*, S-1-B-1]",
    )
    assert cell(small, "S-4-B") == ("missing", [])


@pytest.mark.parametrize("requirements", ['["*"]', "[S-1-A-*]"])
def test_only_a_scenario_that_names_it_counts(tmp_path: Path, requirements: str) -> None:
    assert cell(named(tmp_path, "S-4-B", FIELD, requirements), "S-4-B") == ("missing", [])


@pytest.mark.parametrize(("changed", "told"), [
    ({}, True), ({"source_hash": "0" * 64}, False),
])  # fmt: skip
def test_what_a_monitor_judges_by_default_is_told_of_runs_of_today(
    changed: dict[str, str], told: bool
) -> None:
    """Of a run that is stale nothing is known any more; and of a rule that there is no more, nothing either."""
    found = matrix(Small(), defaults={"plan.seen": "A-GONE, A-SEEN, gap"}, **changed).findings
    said = {f.message for f in found if f.code == "T249" and f.subject == FIELD}
    expected = {f"`{FIELD}` does not have `plan.seen`, so A-SEEN is judged on the default of the spec"}
    assert said == (expected if told else set())


@pytest.mark.parametrize(("there", "status", "told"), [
    (b"t,x\n0,1\n", "covered", []), (b"t,x\r\n0,1\r\n", "covered", []), (None, "covered", ["T248"]), (b"t,x\n0,2\n", "stale", ["T242"]),
    (b"", "stale", ["T242"]),
])  # fmt: skip
def test_a_kept_run_is_of_the_log_that_is_here_wherever_that_is(
    there: bytes | None, status: str, told: list[str], tmp_path: Path
) -> None:
    """Logs need not be part of the project; of one that is another one now, the run shows nothing."""
    small = named(tmp_path, "S-4-B", FIELD)
    small.replace("requirements/v-model.yaml", "origin: field", "origin: field, kept: records/runs.json")
    if there is not None:
        (tmp_path / "drive.csv").write_bytes(there)
    made_from = {"../drive.csv": sha256(b"t,x\n0,1\n").hexdigest()}
    assert cell(small, "S-4-B", made_from=made_from)[0] == status
    found = [f.code for f in matrix(small, made_from=made_from).findings if f.subject == FIELD]
    assert [code for code in found if code in ("T242", "T248")] == told
