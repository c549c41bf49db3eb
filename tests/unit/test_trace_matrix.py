"""What the cells say: statuses combine towards the worst, children show above, and nothing depends on order."""

from __future__ import annotations

import random
import re
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest

from golden.trace.cases import HERE, PROJECT, TODAY, Small, apply
from trackmarshal import trace
from trackmarshal.records.faults import FaultCase, FaultResult
from trackmarshal.records.runs import RuleFacts, RunSummary, TruthFacts
from trackmarshal.trace.cells import combined
from trackmarshal.trace.faults import verdict
from trackmarshal.trace.spec import Spec, changed


@pytest.mark.parametrize(
    ("statuses", "expected"),
    [
        ((), None),
        (("covered",), "covered"),
        (("covered", "covered"), "covered"),
        (("covered", "waived"), "waived"),
        (("waived",), "waived"),
        (("missing",), "missing"),
        (("covered", "missing"), "partial"),
        (("waived", "missing"), "partial"),
        (("partial",), "partial"),
        (("partial", "missing"), "partial"),
        (("covered", "stale", "missing"), "stale"),
        (("covered", "stale", "failed"), "failed"),
        (("waived", "failed"), "failed"),
    ],
)
def test_combining(statuses: tuple[str, ...], expected: str | None) -> None:
    assert combined(statuses) == expected
    assert combined(reversed(statuses)) == expected


def test_an_unknown_status_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown status"):
        combined(["fine"])


def status(matrix: trace.Matrix, requirement: str, stage: str) -> str | None:
    row = next(row for row in matrix.rows if row.requirement.id == requirement)
    return row.cells[stage].status if stage in row.cells else None


def build(small: Small, **changes: object) -> trace.Matrix:
    items, tests, results, runs = small.parts()
    given = {
        "spec_items": items,
        "spec_tests": tests,
        "test_results": results,
        "runs": runs,
        "today": TODAY,
        **changes,
    }
    return trace.build(small.root, **given)  # type: ignore[arg-type]


def test_nothing_given_is_nothing_covered() -> None:
    matrix = trace.build(PROJECT, [], [], [], [], TODAY)
    for stage in ("S-2-B", "S-3-B", "S-4-A", "S-4-B"):
        assert status(matrix, "S-1-A-2", stage) == "missing", stage
    assert not matrix.passes


def test_not_run_is_not_covered() -> None:
    matrix = build(Small(), test_results=[], runs=[])
    assert status(matrix, "S-1-A-2", "S-2-B") == "covered"
    assert status(matrix, "S-1-A-2", "S-3-B") == "missing"
    assert status(matrix, "S-1-A-2", "S-4-A") == "missing"


def test_a_failure_shows_at_every_requirement_above() -> None:
    small = Small()
    results = [replace(r, outcome="failed") if r.rule == "turn" else r for r in small.parts()[2]]
    matrix = build(small, test_results=results)
    assert status(matrix, "RR-1", "S-3-B") == "failed"
    assert status(matrix, "S-1-A-5", "S-3-B") == "failed"
    assert status(matrix, "S-1-A-2", "S-3-B") == "covered"


def test_what_a_stage_asks_nothing_of_hides_nothing_below_it(tmp_path: Path) -> None:
    """What is open shows above at any depth: here `RR-2` refines `RR-1`, of which the stage of tests asks nothing."""
    small = Small.copy(tmp_path)
    old = "rationale: The tyres slide otherwise.\n    refines: "
    small.replace("requirements/criteria.yaml", f"{old}[S-1-A-5]", f"{old}[RR-1]")
    asked = 'title: verification, shows: its tests, applies_to: ["*"]'
    small.replace("requirements/v-model.yaml", asked, asked.replace('"*"', "S-1-*, RR-2"))
    results = small.parts()[2]
    assert status(build(small), "RR-1", "S-3-B") is None
    assert status(build(small), "S-1-A-5", "S-3-B") == "covered"
    others = [result for result in results if result.rule != "friction"]
    failed = [replace(result, outcome="failed") for result in results if result.rule == "friction"]
    for made, expected in (([*others, *failed], "failed"), (others, "missing")):
        matrix = build(small, test_results=made, runs=[])
        assert status(matrix, "RR-2", "S-3-B") == expected
        assert status(matrix, "S-1-A-5", "S-3-B") == expected
        assert status(matrix, "S-1-A-2", "S-3-B") == "covered"


def test_of_two_results_the_worse_counts() -> None:
    small = Small()
    results = small.parts()[2]
    both = [*results, replace(results[4], outcome="failed")]
    assert status(build(small, test_results=both), "S-1-A-2", "S-3-B") == "failed"
    assert status(build(small, test_results=both[::-1]), "S-1-A-2", "S-3-B") == "failed"


def test_of_two_results_of_a_fault_the_worse_counts() -> None:
    case = FaultCase("f.yaml", "F-1", "a swerve", "S-1-A-2", 3, "f" * 64)
    passed = FaultResult(
        "f.yaml", "F-1", "passed", "f" * 64, ("friction",), first=2.0, driven="no_safe_trajectory"
    )
    for outcome in ("failed", "error"):
        both = [passed, replace(passed, outcome=outcome, message="nothing fired")]
        for results in (both, both[::-1]):
            spec = Spec((), (), (), (), fault_cases=[case], fault_results=results)
            assert verdict(case, spec) == ("failed", "nothing fired")
    assert verdict(case, Spec((), (), (), (), fault_results=[passed, passed]))[0] == "covered"
    assert (
        verdict(
            replace(case, fingerprint=""),
            Spec((), (), (), (), fault_results=[replace(passed, fingerprint="")]),
        )[0]
        == "stale"
    )


@pytest.mark.parametrize(
    ("before", "now", "said"),
    [
        ({"rule gap": "a", "engine": "e"}, {"engine": "e", "rule gap": "a"}, ""),
        ({"rule gap": "a", "param mu": "1"}, {"rule gap": "a", "param mu": "2"}, "the parameter `mu` has changed since"),
        ({"rule gap": "a"}, {"rule gap": "a", "rule turn": "b"}, "the rule `turn` has joined since"),
        ({"rule gap": "a", "rule turn": "b"}, {"rule gap": "a"}, "it was made from the rule `turn`, which takes no part any more"),
        ({"constraints": "a", "named": "x"}, {"constraints": "b"}, "the constraints on its parameters and tables have changed since"),
        ({"constraints": "a"}, {}, "it was made from the constraints on its parameters and tables, which take no part any more"),
        ({}, {"limits": "a"}, "the limits of the Supervisor have joined since"),
        ({"rule gap": "a", "named": "x"}, {"rule gap": "a"}, "it was made from a file that the scenario names, which takes no part any more"),
    ],
)  # fmt: skip
def test_whatever_differs_of_what_a_result_was_made_from_is_said(
    before: dict[str, str], now: dict[str, str], said: str
) -> None:
    assert changed(before, now) == said


def test_of_runs_a_rule_stands_for_all_that_it_reads() -> None:
    """Its parameter may be what changed, and the rule is then as it was."""
    read = "the rule `gap`, or something that it reads, has changed since"
    assert changed({"rule gap": "a"}, {"rule gap": "b"}, deep=True) == read
    joined = changed({}, {"rule gap": "b"}, deep=True)
    assert joined == "the rule `gap` has joined since"
    assert (
        changed({"signal ego": "a"}, {"signal ego": "b"}, deep=True) == "the signal `ego` has changed since"
    )


def test_a_waiver_excuses_gaps_but_no_failure(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    small.replace(
        "requirements/v-model.yaml",
        "    requirements: [S-1-B-*]\n    justification",
        "    requirements: ['*']\n    justification",
    )
    assert status(build(small, test_results=[]), "S-1-A-2", "S-3-B") == "waived"
    failed = [replace(r, outcome="failed") for r in small.parts()[2]]
    assert status(build(small, test_results=failed), "S-1-A-2", "S-3-B") == "failed"
    stale = [replace(r, fingerprint="older") for r in small.parts()[2]]
    assert status(build(small, test_results=stale), "S-1-A-2", "S-3-B") == "stale"


@pytest.mark.parametrize(
    ("today", "expected"),
    [
        (date(2025, 12, 31), "missing"),
        (date(2026, 1, 1), "waived"),
        (date(2026, 12, 31), "waived"),
        (date(2027, 1, 1), "missing"),
    ],
)
def test_a_waiver_holds_from_its_first_to_its_last_day(today: date, expected: str) -> None:
    assert status(build(Small(), today=today), "S-1-B-1", "S-3-B") == expected


def test_a_waived_child_shows_above(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    small.replace(
        "requirements/v-model.yaml",
        "requirements: [S-1-B-*]\n    justification",
        "requirements: [S-1-B-*, RR-1]\n    justification",
    )
    results = [r for r in small.parts()[2] if r.rule != "turn"]
    matrix = build(small, test_results=results)
    assert status(matrix, "RR-1", "S-3-B") == "waived"
    assert status(matrix, "S-1-A-5", "S-3-B") == "waived"


def run(small: Small, scenario: str, **changes: object) -> list[RunSummary]:
    return [replace(r, **changes) if r.scenario == scenario else r for r in small.parts()[3]]  # type: ignore[arg-type]


CUT_IN = "scenarios/cut_in.jsonl"


def facts(rule: str, fingerprint: str, **counts: int) -> RuleFacts:
    violated = counts.get("violated", 0)
    return RuleFacts(rule, fingerprint, {"driving": counts}, 1.0 if violated else None, due=violated)


@pytest.mark.parametrize(
    ("counts", "expected"),
    [
        ({"satisfied": 90, "violated": 10}, "covered"),
        ({"satisfied": 100}, "partial"),
        ({"inactive": 100}, "missing"),
        ({"undefined": 100}, "missing"),
        ({"open": 100}, "missing"),
        ({}, "missing"),
    ],
)
def test_a_scenario_has_to_be_critical_for_the_rule(counts: dict[str, int], expected: str) -> None:
    small = Small()
    matrix = build(small, runs=run(small, CUT_IN, rules=(facts("gap", "g" * 8, **counts),)))
    assert status(matrix, "S-1-A-2", "S-4-A") == expected


@pytest.mark.parametrize(
    ("of_turn", "expected"),
    [({"satisfied": 100}, "covered"), ({"inactive": 100}, "partial"), ({}, "partial")],
)
def test_every_rule_of_a_requirement_has_to_be_evaluated(of_turn: dict[str, int], expected: str) -> None:
    """One that fired where it had to does not stand for another one that was never asked."""
    small = Small()
    items = {item.name: item for item in small.parts()[0]}
    both = (*items["turn"].satisfies, *items["gap"].satisfies)
    items["turn"] = replace(items["turn"], satisfies=both)
    said = (facts("gap", "g" * 8, satisfied=90, violated=10), facts("turn", "t" * 8, **of_turn))
    truth = {"dynamic": TruthFacts(True, (), ("gap", "turn"))}
    runs = run(small, CUT_IN, rules=said, ground_truth=truth)
    assert status(build(small, spec_items=list(items.values()), runs=runs), "S-1-A-2", "S-4-A") == expected


def test_a_rule_that_nobody_judged_is_not_evaluated_by_that(tmp_path: Path) -> None:
    """One run shows what `gap` is worth; that another one had a verdict of `turn`, of which no truth was declared, shows nothing."""
    small = Small.copy(tmp_path)
    old = "stage: S-3-B, expect: fire, by: [friction], origin: synthetic, requirements: [RR-2]"
    small.replace("requirements/v-model.yaml", old, "stage: S-4-A, expect: ground_truth, origin: synthetic")
    items = {item.name: item for item in small.parts()[0]}
    both = (*items["turn"].satisfies, *items["gap"].satisfies)
    items["turn"] = replace(items["turn"], satisfies=both)
    gap, turn = facts("gap", "g" * 8, satisfied=90, violated=10), facts("turn", "t" * 8, satisfied=100)
    named = {"rule gap": TruthFacts(True, (), ("gap",))}
    cut_in, skid, field = small.parts()[3]
    cut_in = replace(cut_in, rules=(gap,), ground_truth={"dynamic": TruthFacts(True, (), ("gap",))})
    for uncovered, expected in ((("turn",), "partial"), ((), "covered")):
        skid = replace(skid, rules=(gap, turn), ground_truth=named, uncovered=uncovered)
        matrix = build(small, spec_items=list(items.values()), runs=[cut_in, skid, field])
        assert status(matrix, "S-1-A-2", "S-4-A") == expected


def test_a_scenario_that_fires_by_rules_of_others_shows_a_requirement_in_part(tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    small.replace("requirements/v-model.yaml", "requirements: [RR-2]}", "requirements: [RR-2, S-1-A-2]}")
    assert status(build(small), "RR-2", "S-3-B") == "covered"
    assert status(build(small), "S-1-A-2", "S-3-B") == "partial"


@pytest.mark.parametrize(("violated", "expected"), [(10, "covered"), (0, "failed")])
def test_a_rule_that_was_to_fire_and_was_satisfied_fails_though_another_one_fires(
    violated: int, expected: str
) -> None:
    small = Small()
    (fired,) = (run for run in small.parts()[3] if "skid" in run.scenario)
    friction = next(one for one in fired.rules if one.rule == "friction")
    said = facts("friction", friction.fingerprint, satisfied=90, violated=violated)
    others = tuple(one for one in fired.rules if one.rule not in ("friction", "gap"))
    gap = facts("gap", "g" * 8, satisfied=90, violated=10)
    run = replace(fired, rules=(said, gap, *others), fired=True)
    runs = [run, *(one for one in small.parts()[3] if one.scenario != fired.scenario)]
    matrix = build(small, runs=runs)
    assert status(matrix, "RR-2", "S-3-B") == expected
    assert [f.code for f in matrix.findings if f.code == "T245"] == ["T245"] * (expected == "failed")


@pytest.mark.parametrize("turned", [False, True])
def test_of_two_runs_of_a_scenario_the_later_one_counts(turned: bool) -> None:
    small = Small()
    (fine,) = (run for run in small.parts()[3] if run.scenario == CUT_IN)
    wrong = replace(fine, unexpected=(1.5,))
    earlier, later = "2026-06-01T12:00:00+00:00", "2026-06-01T12:00:01+00:00"
    for last, other, expected in ((wrong, fine, "failed"), (fine, wrong, "covered")):
        two = [replace(other, created=earlier), replace(last, created=later)]
        runs = [*two[:: -1 if turned else 1], *(run for run in small.parts()[3] if run.scenario != CUT_IN)]
        assert status(build(small, runs=runs), "S-1-A-2", "S-4-A") == expected


def test_evidence_that_a_link_leads_to_out_of_the_project_shows_nothing(tmp_path: Path) -> None:
    """Whoever has the project has no such page; one that a link leads to within it is there."""
    small = Small.copy(tmp_path)
    page = small.root / "docs" / "architecture.md"
    for to, expected in ((page.with_name("layout.md"), "covered"), (tmp_path / "layout.md", "missing")):
        page.resolve().rename(to)
        page.unlink(missing_ok=True)
        page.symlink_to(to)
        assert status(build(small), "S-1-B-1", "S-2-A") == expected
    (found,) = (one for one in build(small).findings if one.code == "T250")
    assert "is behind a link that leads out of the project" in found.message


@pytest.mark.parametrize(("id_", "as_it_is", "wrong"), [("S-1-B-1", "approved", False), ("S-1-B-1", "obsolete", True), ("S-9-B-1", "approved", True)])  # fmt: skip
def test_a_fault_is_to_violate_what_is_demanded(id_: str, as_it_is: str, wrong: bool, tmp_path: Path) -> None:
    small = Small.copy(tmp_path)
    criteria = small.root / "requirements" / "criteria.yaml"
    before, at, after = criteria.read_text("utf-8").partition("id: S-1-B-1\n")
    criteria.write_text(before + at + after.replace("status: approved", f"status: {as_it_is}", 1), "utf-8")
    matrix = build(small, fault_cases=[FaultCase("f.yaml", "F-1", "a swerve", id_, 3, "f" * 64)])
    assert [one.subject for one in matrix.findings if one.code == "T263"] == ["F-1"] * wrong


@pytest.mark.parametrize("first", ["covered", "partial"])
def test_of_two_demands_of_a_cell_the_greater_one_counts(first: str, tmp_path: Path) -> None:
    """Perception is shown in part there, which all criteria need; of this one, all is demanded besides."""
    small = Small.copy(tmp_path)
    partial = "  - {stage: S-4-A, requirements: [S-1-A-*], at_least: partial}\n"
    covered = "  - {stage: S-4-A, requirements: [S-1-A-1]}\n"
    assert [finding.code for finding in trace.gate(build(small))] == []
    both = covered + partial if first == "covered" else partial + covered
    small.replace("requirements/v-model.yaml", partial, both)
    (short,) = trace.gate(build(small))
    assert (short.code, short.subject) == ("T230", "S-1-A-1")
    assert ": partial, wanted covered; " in short.message


@pytest.mark.parametrize(
    ("low", "high", "reached"),
    [(0.0, 30.0, True), (-1.0, 31.0, True), (0.1, 30.0, False), (0.0, 29.9, False), (10.0, 20.0, False)],
)
def test_a_domain_is_recorded_at_both_of_its_ends(
    low: float, high: float, reached: bool, tmp_path: Path
) -> None:
    small = Small.copy(tmp_path)
    domain = "{id: ODD-1, title: the road, description: Dry., ranges: [{quantity: ego.v, from: 0 m/s, to: 108 km/h}]}"
    (small.root / "requirements" / "hazards.yaml").write_text(
        f"document: hazards\ntitle: Conditions\ndomains: [{domain}]\n", "utf-8"
    )
    matrix = build(small, runs=run(small, CUT_IN, ranges={"ego.v": (low, high)}))
    assert [f.subject for f in matrix.findings if f.code == "T254"] == ["ODD-1"] * (not reached)


@pytest.mark.parametrize("stages", [True, False])
def test_a_domain_of_which_there_is_no_scenario_is_claimed_in_vain(stages: bool, tmp_path: Path) -> None:
    """As long as nothing was to be replayed at all, nothing was said of it; where settings cannot be read, that is what is wrong."""
    small = Small.copy(tmp_path)
    domain = "{id: ODD-1, title: the road, description: Dry., ranges: [{quantity: ego.v, from: 0 m/s, to: 108 km/h}]}"
    (small.root / "requirements" / "hazards.yaml").write_text(
        f"document: hazards\ntitle: Conditions\ndomains: [{domain}]\n", "utf-8"
    )
    model = small.root / "requirements" / "v-model.yaml"
    text = re.sub(r"  scenarios:\n(?:    .*\n)+", "", model.read_text("utf-8"))
    model.write_text(text if stages else "document: v-model\nproject: [\n", "utf-8")
    matrix = build(small, runs=[])
    assert [f.message.partition(", ")[2] for f in matrix.findings if f.code == "T254"] == [
        "and no recording has it"
    ] * stages


def test_a_violation_that_the_ground_truth_leaves_free_is_no_evidence() -> None:
    small = Small()
    loud = facts("gap", "g" * 8, satisfied=90, violated=10)
    matrix = build(small, runs=run(small, CUT_IN, rules=(replace(loud, due=0),)))
    assert status(matrix, "S-1-A-2", "S-4-A") == "partial"


def test_a_rule_of_which_no_ground_truth_was_declared_is_named_and_not_covered() -> None:
    small = Small()
    named = {"rule turn": TruthFacts(True, (), ("turn",)), "rule gap": TruthFacts(True, (), ("gap",))}
    matrix = build(small, runs=run(small, CUT_IN, ground_truth=named, uncovered=("friction",)))
    assert "but no ground truth was declared of friction" in trace.render(matrix, "json")
    matrix = build(small, runs=run(small, CUT_IN, ground_truth=named))
    assert "no ground truth was declared" not in trace.render(matrix, "json")


@pytest.mark.parametrize(
    ("counts", "told"),
    [({"satisfied": 100}, "judged by a ground truth"), ({"inactive": 100}, "satisfied or violated")],
)
def test_what_a_rule_lacks_in_all_runs_is_told(counts: dict[str, int], told: str) -> None:
    """One that is satisfied all the time, and of which nobody said when it has to fire, is not one that never applied."""
    small = Small()
    named = {"rule turn": TruthFacts(True, (), ("turn",)), "rule gap": TruthFacts(True, (), ("gap",))}
    said = {name: facts(name, name[0] * 8, satisfied=90, violated=10) for name in ("gap", "turn")}
    rules = (facts("friction", "f" * 8, **counts), *said.values())
    of = {item.name: item.satisfies for item in small.parts()[0]}
    items = [
        replace(item, satisfies=of["gap"] + of["friction"] if item.name == "friction" else item.satisfies)
        for item in small.parts()[0]
    ]
    runs = run(small, CUT_IN, ground_truth=named, uncovered=("friction",), rules=rules)
    matrix = build(small, spec_items=items, runs=runs)
    lacking = {
        item.detail
        for row in matrix.rows
        for item in (row.cells["S-4-A"].items if "S-4-A" in row.cells else ())
        if item.name == "friction"
    }
    assert lacking == {f"{told} in none of these runs"}


def test_a_run_that_is_unsafe_where_nothing_says_that_it_may_be_is_no_evidence() -> None:
    """As `replay` and `assess` have it: a run whose input broke the contract is inside any ground truth of rules."""
    small = Small()
    unlike = run(small, CUT_IN, unexpected=(1.5, 2.0))
    assert [each.unexpected for each in unlike if each.scenario == CUT_IN] == [(1.5, 2.0)]
    assert [type(each).from_json(each.to_json()) for each in unlike] == list(unlike)
    matrix = build(small, runs=unlike)
    assert status(matrix, "S-1-A-2", "S-4-A") == "failed"
    assert "unsafe at 1.5 s, of which no ground truth says what to expect" in trace.render(matrix, "json")


def test_a_run_outside_the_truth_of_a_rule_says_which() -> None:
    small = Small()
    truth = TruthFacts(False, ("rated unsafe at 1 s, the ground truth is safe",), ("gap",))
    matrix = build(small, runs=run(small, CUT_IN, ground_truth={"rule gap of driving": truth}))
    assert "outside the ground truth of rule gap of driving: rated unsafe at 1 s" in trace.render(
        matrix, "json"
    )


@pytest.mark.parametrize(
    ("recording", "rule", "cell"),
    [("field", "gap", ("S-1-A-2", "S-4-B")), ("skid", "friction", ("RR-2", "S-3-B"))],
)
def test_a_run_that_contradicts_its_ground_truth_fails_whatever_it_was_to_show(
    recording: str, rule: str, cell: tuple[str, str]
) -> None:
    """That nothing fired, or that a rule did, is wrong where the truth is another one: what has to be unsafe came out safe."""
    small = Small()
    truth = {"dynamic": TruthFacts(False, ("rated safe at 1 s, the ground truth is unsafe",), (rule,))}
    runs = run(small, f"scenarios/{recording}.jsonl", ground_truth=truth)
    before, matrix = build(small), build(small, runs=runs)
    (found,) = (one for one in trace.gate(matrix) if one.code == "T243")
    assert "rated safe at 1 s" in found.message
    assert (status(before, *cell), status(matrix, *cell)) == ("covered", "failed")


def test_ground_truth_that_judges_other_rules_does_not_cover() -> None:
    small = Small()
    matrix = build(small, runs=run(small, CUT_IN, ground_truth={"static": TruthFacts(True, (), ("turn",))}))
    assert status(matrix, "S-1-A-2", "S-4-A") == "partial"


def test_a_contradiction_counts_for_the_rules_that_were_judged() -> None:
    small = Small()
    truths = {
        "static": TruthFacts(False, ("rated safe at 1 s",), ("turn",)),
        "dynamic": TruthFacts(True, (), ("gap",)),
    }
    matrix = build(small, runs=run(small, CUT_IN, ground_truth=truths))
    assert status(matrix, "RR-1", "S-4-A") == "failed"
    assert status(matrix, "S-1-A-2", "S-4-A") == "covered"


def test_a_quiet_lap_covers_only_when_it_comes_from_the_field(tmp_path: Path) -> None:
    assert status(build(Small()), "S-1-A-2", "S-4-B") == "covered"
    small = Small.copy(tmp_path)
    small.replace("requirements/v-model.yaml", "origin: field", "origin: simulated")
    assert status(build(small), "S-1-A-2", "S-4-B") == "partial"


def test_a_new_rule_needs_no_edit_of_the_requirements() -> None:
    """One more rule with its tests: it appears, and what was covered stays so."""
    small = Small()
    items, tests, results, runs = small.parts()
    rule = replace(items[1], name="slow", title="Slow at the start", line=60)
    new_tests = [replace(t, rule="slow", line=t.line + 200) for t in tests if t.rule == "gap"]
    new_results = [replace(r, rule="slow", fingerprint=rule.fingerprint) for r in results if r.rule == "gap"]
    runs = [replace(r, rules=(*r.rules, facts("slow", rule.fingerprint, satisfied=3))) for r in runs]
    matrix = trace.build(
        small.root, [*items, rule], [*tests, *new_tests], [*results, *new_results], runs, TODAY
    )
    assert matrix.passes
    row = next(row for row in matrix.rows if row.requirement.id == "S-1-A-2")
    assert [item.name for item in row.cells["S-2-B"].items] == ["gap", "slow"]
    assert [f.code for f in matrix.findings] == ["T226"]


def test_the_order_of_inputs_does_not_matter() -> None:
    small = Small()
    parts = small.parts()
    expected = {kind: trace.render(trace.build(small.root, *parts, TODAY), kind) for kind in trace.FORMATS}
    for seed in range(5):
        shuffled = [random.Random(seed).sample(part, len(part)) for part in parts]
        matrix = trace.build(small.root, *shuffled, TODAY)  # type: ignore[arg-type, call-arg]
        assert {kind: trace.render(matrix, kind) for kind in trace.FORMATS} == expected


def test_a_folder_without_requirements_is_unusable(tmp_path: Path) -> None:
    matrix = trace.build(tmp_path, [], [], [], [], TODAY)
    assert [f.code for f in matrix.findings] == ["T112"]
    assert matrix.unusable
    assert not matrix.passes
    for kind in trace.FORMATS:
        assert trace.render(matrix, kind)


def test_coverage_counts_every_cell_once() -> None:
    matrix = build(Small())
    for stage, count in matrix.coverage.items():
        number = sum(stage in row.cells for row in matrix.rows)
        assert count["of"] == number
        assert sum(value for status_, value in count.items() if status_ != "of") == number


def test_a_rule_that_nothing_is_evaluated_with_by_default_is_called_so() -> None:
    """It is there, and loaded by whoever wants it: that it is evaluated in every cycle, the cell must not say."""
    small = Small()
    items, *_ = small.parts()
    rule = replace(items[1], name="slow", title="Slow at the start", source="code, 1", line=60)
    matrix = build(small, spec_items=[*items, rule])
    row = next(row for row in matrix.rows if row.requirement.id == "S-1-A-2")
    said = {item.name: item.detail for item in row.cells["S-2-B"].items}
    assert "not in" not in said["gap"]
    assert said["slow"] == "code, 1; not in specs: evaluated where its spec is loaded beside that"
    unrun = build(small, spec_items=[*items, rule], runs=[])
    row = next(row for row in unrun.rows if row.requirement.id == "S-1-A-2")
    assert {item.name: item.detail for item in row.cells["S-2-B"].items}["slow"] == "code, 1"


@pytest.mark.parametrize("case", ["T242_log_changed", "T242_made_from_nothing", "T242_recording_changed"])
def test_a_run_that_is_stale_in_cells_is_stale_in_the_graph(case: str, tmp_path: Path) -> None:
    """Which the safety case and the page of the matrix go by: of a kept run whose log has changed, they said that it was run."""
    small = Small.copy(tmp_path)
    apply(
        small, (HERE / "findings" / f"{case}.case").read_text("utf-8").partition("expect\n")[0].splitlines()
    )
    matrix = small.matrix()
    stale = {
        item.name for row in matrix.rows for cell in row.cells.values() for item in cell.items
        if item.kind == "run" and item.status == "stale"
    }  # fmt: skip
    nodes = matrix.graph.by_kind["run"]
    assert len(stale) == 1
    assert {node.id for node in nodes if node.attributes["outcome"] == "stale"} == stale
    links = [link for link in matrix.graph.of_kind("evaluates") if link.source[1] in stale]
    assert {link.state for link in links} == {"outdated"}


@pytest.mark.parametrize(
    ("path", "said", "status", "outcome"),
    [
        ("docs/more.md", "All of it was measured.", "covered", "there"),
        ("docs/more.md", "No evidence exists yet.", "partial", "partial"),
        ("docs/more.md", "", "missing", "missing"),
        ("requirements/more.yaml", "document: nothing", "missing", "missing"),
        # Its first entry says nothing of its contents, this one does.
        ("docs/seen.md", None, "stale", "changed"),
    ],
)
def test_a_document_has_come_to_no_more_than_in_cells(
    path: str, said: str | None, status: str, outcome: str, tmp_path: Path
) -> None:
    small = Small.copy(tmp_path)
    if said is not None:
        (small.root / path).write_text(said, "utf-8")
    entry = f"{{path: {path}, title: more, stage: S-2-A, requirements: [S-1-B-1]}}"
    if said is None:
        entry = f"{entry}\n  - {entry[:-1]}, sha256: {'a' * 64}}}"
    small.replace("requirements/v-model.yaml", "evidence:\n", f"evidence:\n  - {entry}\n")
    matrix = small.matrix()
    row = next(row for row in matrix.rows if row.requirement.id == "S-1-B-1")
    assert status in {item.status for item in row.cells["S-2-A"].items if item.name == path}
    assert matrix.graph.nodes["document", path].attributes["outcome"] == outcome


_PAGE = "title: The layout, stage: S-2-A, requirements: [S-1-B-*]"
_SCENE = "cut_in.jsonl, stage: S-4-A, expect: ground_truth"


@pytest.mark.parametrize(("old", "new", "requirement", "stage", "expected"), [
    (_PAGE, _PAGE, "S-1-B-1", "S-2-A", "covered"), (_PAGE, _PAGE.replace("S-2-A", "S-1-B"), "S-1-B-1", "S-2-A", "missing"),
    (_PAGE, _PAGE.replace("S-1-B-*", "S-1-A-*"), "S-1-B-1", "S-2-A", "missing"),
    (_SCENE, _SCENE, "S-1-A-2", "S-4-A", "covered"), (_SCENE, _SCENE.replace("S-4-A", "S-3-B"), "S-1-A-2", "S-4-A", "missing"),
    (_SCENE, f"{_SCENE}, requirements: [RR-*]", "S-1-A-2", "S-4-A", "missing"),
])  # fmt: skip
def test_evidence_counts_at_its_stage_and_of_its_requirements_alone(
    old: str, new: str, requirement: str, stage: str, expected: str, tmp_path: Path
) -> None:
    small = Small.copy(tmp_path)
    small.replace("requirements/v-model.yaml", old, new)
    assert status(small.matrix(), requirement, stage) == expected


_XML = '<testsuite name="s"><testcase classname="s" name="another"/></testsuite>'


@pytest.mark.parametrize(("method", "report", "there", "run", "level"), [
    ("measurement", "", False, True, "error"), ("test", "", False, True, "error"),
    ("test", ", if_there: true", False, True, "warning"), ("measurement", ", if_there: true", False, True, "error"),
    ("measurement", ", if_there: true, methods: [measurement]", False, True, "warning"), ("measurement", ", if_there: true, methods: [test]", False, True, "error"),
    ("measurement", ", if_there: true, methods: [measurement]", True, True, "error"), ("test", ", if_there: true", True, True, "error"),
    ("measurement", ", methods: [measurement]", False, True, "error"),
    ("scenario", "", True, True, "error"), ("scenario", "", True, False, "warning"), ("measurement", "", True, False, "error"),
])  # fmt: skip
def test_a_method_that_nothing_answers_waits_for_what_may_answer_it_alone(
    method: str, report: str, there: bool, run: bool, level: str, tmp_path: Path
) -> None:
    """A report that is not there excuses as long as it may be missing, and is of the kind; a scenario as long as it was not run."""
    small = Small.copy(tmp_path)
    small.replace("requirements/criteria.yaml", "verification: [review]", f"verification: [{method}]")
    small.replace("requirements/v-model.yaml", "stages:\n", f"  junit:\n    - {{path: out/r.xml, stage: S-3-B{report}}}\nstages:\n")  # fmt: skip
    if there:
        (small.root / "out").mkdir()
        (small.root / "out" / "r.xml").write_text(_XML, "utf-8")
    matrix = build(small, **({} if run else {"runs": []}))
    assert [f.level for f in matrix.findings if f.subject == f"S-1-B-1:{method}"] == [level]


_VERIFIES = '<properties><property name="verifies" value="S-1-B-1"/></properties>'


@pytest.mark.parametrize(("report", "said", "answered"), [
    (", methods: [measurement]", _VERIFIES, True), ("", _VERIFIES, False), (", methods: [analysis]", _VERIFIES, False),
    (", methods: [measurement]", f"{_VERIFIES}<skipped/>", False), (", methods: [measurement]", "", False),
    (", methods: [measurement]", _VERIFIES.replace("S-1-B-1", "RR-1"), False), (", methods: [measurement]", f"{_VERIFIES}<failure/>", True),
])  # fmt: skip
def test_a_report_answers_the_methods_that_it_names_of_what_its_tests_verify(
    report: str, said: str, answered: bool, tmp_path: Path
) -> None:
    """Whether they passed, cells say."""
    small = Small.copy(tmp_path)
    small.replace("requirements/criteria.yaml", "verification: [review]", "verification: [measurement]")
    small.replace("requirements/v-model.yaml", "stages:\n", f"  junit:\n    - {{path: r.xml, stage: S-3-B{report}}}\nstages:\n")  # fmt: skip
    (small.root / "r.xml").write_text(f'<testsuite name="s"><testcase classname="s" name="t">{said}</testcase></testsuite>')  # fmt: skip
    assert [f.level for f in small.matrix().findings if f.code == "T255"] == ["error"] * (not answered)


_BELOW = """document: requirements
title: Paint
requirements:
  - {id: X-1, title: Visible, statement: The vehicle shall be seen., rationale: Who is seen is not run into., adopted: The city demands it.,
     status: approved, asil: QM, verification: [review], source: letter}
  - {id: X-2, title: Bright, statement: The paint shall be bright., rationale: Dark paint is not seen., refines: [X-1],
     status: approved, asil: QM, verification: [review], source: letter}
  - {id: %s, title: Yellow, statement: The paint shall be yellow., rationale: Yellow is bright., refines: [X-2],
     status: %s, asil: QM, verification: [review], source: letter}
"""


@pytest.mark.parametrize(("id_", "status", "told"), [
    ("RR-7", "approved", []), ("X-3", "approved", ["X-1", "X-2", "X-3"]), ("RR-7", "obsolete", ["X-1", "X-2"]),
])  # fmt: skip
def test_what_no_stage_asks_anything_of_is_told(
    id_: str, status: str, told: list[str], tmp_path: Path
) -> None:
    """But not where what refines it is asked, at any depth, as it has to be shown there."""
    small = Small.copy(tmp_path)
    small.replace("requirements/v-model.yaml", 'shows: its tests, applies_to: ["*"]', "shows: its tests, applies_to: [S-1-*, RR-*]")  # fmt: skip
    (small.root / "requirements" / "more.yaml").write_text(_BELOW % (id_, status), "utf-8")
    assert [f.subject for f in small.matrix().findings if f.code == "T149"] == told
    # A stage that asks where there is something asks nothing of what has nothing.
    small.replace("requirements/v-model.yaml", "shows: its assumptions, applies_to: [S-1-A-*, RR-*]", 'shows: its assumptions, applies_to: ["*"]')  # fmt: skip
    assert [f.subject for f in small.matrix().findings if f.code == "T149"] == told
