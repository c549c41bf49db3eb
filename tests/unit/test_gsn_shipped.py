"""The shipped project's argument: its form is sound whatever its results are. That it is supported, and has no finding, tests/acceptance/test_gate.py shows."""

from __future__ import annotations

from datetime import date

from trackmarshal import trace
from trackmarshal.records.specs import SpecTest
from trackmarshal.records.tests import TestResult
from trackmarshal.trace.gsn.building import build
from trackmarshal.trace.gsn.case import Case
from trackmarshal.trace.gsn.modules import LIMIT
from trackmarshal.trace.gsn.picture.content import content
from unit.test_trace_shipped import ROOT, invented


def shipped(results: list[TestResult], tests: list[SpecTest]) -> Case:
    """The argument of the shipped requirements, with rules as they wish for them."""
    items, _, _ = invented()
    project, _ = trace.load(ROOT)
    return build(trace.build(ROOT, items, tests, results, [], date(2026, 11, 29)), project, ROOT)


def test_nothing_is_wrong_with_its_form() -> None:
    _, tests, results = invented()
    case = shipped(results, tests)
    # Nothing is replayed here, so what replays are to show is not there.
    assert {finding.code for finding in case.findings} <= {"T419"}
    project, _ = trace.load(ROOT)
    for requirement in project.requirements:
        assert f"G-{requirement.id}" in case.elements or not requirement.demanded


def test_its_pictures_are_small() -> None:
    _, tests, results = invented()
    case = shipped(results, tests)
    assert max(len(content(case, module).shown) for module in case.modules) <= LIMIT


def test_a_failed_test_of_it_shows_up_to_the_top() -> None:
    _, tests, results = invented()
    failed = [TestResult(r.rule, r.title, "failed" if r.rule == "friction" and r.title == "in" else r.outcome, r.fingerprint, "", r.file, r.line) for r in results]  # fmt: skip
    case = shipped(failed, tests)
    (found,) = [finding for finding in case.findings if finding.code == "T413" and "friction: in" in finding.message]  # fmt: skip
    assert found.subject == "CSn-S-1-A-4.S-3-B"
    assert case.elements["G-S-1-A-4"].status == case.elements["G-Top"].status == "not supported"
