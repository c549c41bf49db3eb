"""Every declared fault of the shipped scenario is found as its campaign says, and is not without the rule that finds it."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path

import pytest

from support.length import shared_out
from support.project import command, copy_project
from support.shared import REPOSITORY
from trackmarshal import scenarios
from trackmarshal.cli.replay import evaluator_for
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.faults import FAULTS
from trackmarshal.scenarios.faults.campaign import Bench
from trackmarshal.scenarios.faults.declaration import Fault, load
from trackmarshal.scenarios.recording import Recording

FILE = REPOSITORY / "specs" / "scenarios" / "faults.yaml"
CAMPAIGN = load(FILE, "specs/scenarios/faults.yaml")
PUT_IN = [fault for fault in CAMPAIGN.faults if not fault.open]
BY_RULES = [fault for fault in PUT_IN if fault.expected and fault.expected.by not in FAULTS]


def name(fault: Fault) -> str:
    return fault.id


@cache
def full() -> tuple[Recording, Evaluator]:
    recording = scenarios.load(FILE.parent / CAMPAIGN.recording)
    spec = REPOSITORY / "specs" / "supervisor"
    return recording, evaluator_for(recording, spec, [], REPOSITORY, None, "numpy", FILE.parent)


@cache
def bench(without: str = "") -> Bench:
    recording, evaluator = full()
    kept = [rule.name for rule in evaluator.rules if rule.name != without]
    assert len(kept) == len(evaluator.rules) - bool(without)
    return Bench(recording, Evaluator(evaluator.spec, kept) if without else evaluator)


def test_there_are_enough_of_all_kinds() -> None:
    assert len(PUT_IN) >= 60
    rules = {fault.expected.by for fault in BY_RULES if fault.expected}
    others = {fault.expected.by for fault in PUT_IN if fault.expected} - rules
    every = {rule.name for rule in full()[1].rules}
    # rss_eq1 never fires without safe_gap, ends_at_rest never before the door; the other two monitors have no fault here
    # (a trajectory that is planned anew, braking by less or the other way round, is no change of one: tests/unit/test_into_others.py has both;
    # tests/unit/test_further_ways.py those of the last line, tests/acceptance/test_moving_over.py the two about lines)
    assert every - rules == {
        "rss_eq1", "ends_at_rest", "A-LOCALISATION", "A-FRICTION", "safe_fallback", "fallback_collision", "fallback_oncoming", "fallback_line", "fallback_cut_in",
        "race_direction", "planned_side", "cut_in", "driving_collision", "fallback_brakes", "no_rolling", "step_length", "turn_integrity", "corner_integrity",
        "swerve_integrity",
    }  # fmt: skip
    doors = {fault for fault, code in FAULTS.items() if code < "D24"}
    # those are of the program that calls, not of what comes from a car: types, names, a context that was never set up, a defect
    # (and no signal of the shipped rules is of an enumeration)
    assert doors - others == {
        "wrong_type",
        "unknown",
        "wrong_track",
        "not_configured",
        "internal",
        "no_member",
    }
    page = (REPOSITORY / "docs" / "faults.md").read_text("utf-8")
    said = set(re.findall(r"`([\w-]+)`", page.partition("No fault names these as what finds it: ")[2]))
    assert said - {"safe_gap"} == (every - rules) | (doors - others)


@pytest.mark.parametrize("fault", PUT_IN, ids=name)
def test_found_as_expected(fault: Fault) -> None:
    assert bench().run(CAMPAIGN, fault).wrong == "", fault.title


@pytest.mark.parametrize("fault", shared_out(BY_RULES, 3), ids=name)
def test_not_without_its_rule(fault: Fault) -> None:
    assert fault.expected is not None
    outcome = bench(fault.expected.by).run(CAMPAIGN, fault)
    assert "expected" in outcome.wrong, fault.title
    assert fault.expected.by not in outcome.by


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project with the first eight faults and one for each further requirement, and a baseline that knows them."""
    root = copy_project(tmp_path_factory.mktemp("faults") / "project")
    path = root / "specs" / "scenarios" / "faults.yaml"
    head, *blocks = re.split(r"^(?=  - id: )", path.read_text("utf-8"), flags=re.MULTILINE)
    named = [re.findall(r"^    requirement: (.*)$", block, re.MULTILINE) for block in blocks]
    few = [block for place, block in enumerate(blocks) if place < 8 or named[place] not in named[:place]]
    path.write_text(head + "".join(few), encoding="utf-8")
    status, out, err = command(
        root,
        "trace",
        "--accept-baseline",
        "--by",
        "maintainers of trackmarshal",
        "--reason",
        "a few faults are enough here",
    )
    assert status == 0, out + err
    status, out, err = command(root, "trace", "--gate")
    assert status == 0, out + err
    return root


@pytest.mark.acceptance  # evidence is made twice
def test_evidence_goes_stale_and_turns_red(project: Path) -> None:
    """Friction that finds nothing any more: stale as it is, failed when the faults are put in again, and well again after."""
    path = project / "specs" / "supervisor" / "trajectory.spec"
    before = path.read_text("utf-8")
    results = project / "out" / "results"
    kept = {file: file.read_bytes() for file in results.iterdir()}
    rule = (
        "require   mass * sqrt((p.a + drag * p.v^2 / mass)^2 + (p.v^2 * p.kappa)^2) <= mu * p.grip * mass * g"
    )
    assert rule in before
    path.write_text(before.replace(rule, rule.replace("<= mu", "<= 100 * mu")), encoding="utf-8")
    status, out, _ = command(project, "trace", "--gate", "--as-is")
    assert status == 1
    assert "T261" in out
    found = json.loads(command(project, "trace", "--gate", "--as-is", "--format", "json")[1])["findings"]
    alone = [one["code"] for one in found if one["level"] == "error" and not one.get("cause")]
    assert alone == ["T370"]  # and no cell that is open since results of faults are stale
    status, out, _ = command(project, "trace", "--gate", "--verbose")  # it follows from the edited rule
    assert status == 1
    assert "error[T260]: the fault `F-03`" in out, out
    assert "nothing was found; expected friction at 2 s" in out
    path.write_text(before, encoding="utf-8")
    for file, data in kept.items():
        file.write_bytes(data)
    assert command(project, "trace", "--gate", "--as-is")[0] == 0


@pytest.mark.acceptance
def test_a_fault_that_is_struck_is_missed(project: Path) -> None:
    path = project / "specs" / "scenarios" / "faults.yaml"
    before = path.read_text("utf-8")
    start = before.index("  - id: F-05\n")
    path.write_text(before[:start] + before[before.index("  - id: F-06\n") :], encoding="utf-8")
    status, out, _ = command(project, "trace", "--gate", "--as-is")
    assert status == 1
    assert "T265" in out
    path.write_text(before.replace("set: 6.5", "set: 6.6"), encoding="utf-8")
    status, out, _ = command(project, "trace", "--gate", "--as-is")
    assert status == 1
    assert "T261" in out
    path.write_text(before, encoding="utf-8")
    assert command(project, "trace", "--gate", "--as-is")[0] == 0
