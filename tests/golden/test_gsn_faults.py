"""Faults planted in a small project and in its argument, each with all that is said of it, word for word; and those that only a made argument can have."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from golden.gsn.cases import HERE, argued, argument
from golden.trace.cases import UPDATE
from trackmarshal.trace.gsn import checks
from trackmarshal.trace.gsn.case import SUPPORTED, UNSUPPORTED, Case, Element, Link, Module
from trackmarshal.trace.gsn.codes import CODES
from trackmarshal.trace.gsn.modules import in_modules
from trackmarshal.trace.gsn.statuses import with_statuses

CASES = sorted(HERE.glob("*.case"))


def test_the_project_itself_has_none(tmp_path: Path) -> None:
    _, case = argument(argued(tmp_path))
    assert [str(finding) for finding in case.findings] == []
    assert case.elements["G-Top"].status == "with reservations"  # there is a waiver


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.stem)
def test_case(path: Path, tmp_path: Path) -> None:
    edits, _, expected = path.read_text("utf-8").partition("expect\n")
    _, case = argument(argued(tmp_path, edits))
    actual = "".join(f"{finding}\n" for finding in case.findings)
    if UPDATE:
        path.write_text(f"{edits}expect\n{actual}", "utf-8")
        expected = actual
    assert actual == expected
    assert f"error[{path.stem[:4]}]" in actual, "a case is called by the code that it is about"


def test_every_fault_of_form_is_planted() -> None:
    planted = {path.stem[:4] for path in CASES} | {"T402"}  # below
    showing = {"T424", "T425", "T426", "T427"}  # in tests/unit/test_gsn_command.py
    assert planted - {"T153"} == set(CODES) - showing
    assert len(CASES) >= 20


def made(*elements: Element, links: tuple[Link, ...] = (), **fields: object) -> Case:
    """An argument without templates."""
    modules = (Module("G-1", "G-1", ""),)
    case = Case("by hand", {e.id: e._replace(module=e.module or "G-1") for e in elements}, links, modules)
    return with_statuses(replace(case, **fields))  # type: ignore[arg-type]


def goal(id_: str, **fields: object) -> Element:
    return Element(id_, "goal", "It holds.", None, None, **fields)  # type: ignore[arg-type]


def supports(source: str, target: str) -> Link:
    return Link("supported_by", source, target, None)


def codes(case: Case) -> list[str]:
    return sorted({finding.code for finding in checks.check(case)})


def test_a_second_top_goal() -> None:
    case = made(goal("G-1", undeveloped=True), goal("G-2", undeveloped=True))
    (found,) = [finding for finding in checks.check(case) if finding.code == "T401"]
    assert found.message == "`G-2` supports nothing, and `G-1` is the top goal already"


def test_what_the_top_goal_does_not_reach() -> None:
    around = (supports("G-2", "G-3"), supports("G-3", "G-2"))
    case = made(goal("G-1", undeveloped=True), goal("G-2"), goal("G-3"), links=around)
    assert codes(case) == ["T402", "T403", "T419"]


def test_a_goal_of_another_module_is_public_or_not_cited() -> None:
    below = goal("G-2", undeveloped=True, module="G-2")
    case = made(goal("G-1"), below, links=(supports("G-1", "G-2"),))
    assert codes(case) == ["T411", "T419"]
    public = made(goal("G-1"), below._replace(public=True), links=(supports("G-1", "G-2"),))
    assert codes(public) == ["T419"]


def test_a_strategy_of_another_module() -> None:
    strategy = Element("S-1", "strategy", "Over all.", None, None, module="G-2", undeveloped=True)
    case = made(goal("G-1"), strategy, links=(supports("G-1", "S-1"),))
    assert codes(case) == ["T411", "T419"]


def test_evidence_without_a_hash() -> None:
    from trackmarshal.trace.gsn.case import Evidence

    solution = Element("Sn-1", "solution", "A test.", None, None, leaf=SUPPORTED)
    held = Evidence("test", "gap: inside", "covered", "0" * 64, None)
    sound = made(goal("G-1"), solution._replace(evidence=(held,)), links=(supports("G-1", "Sn-1"),))
    assert codes(sound) == []
    bare = made(goal("G-1"), solution._replace(evidence=(held._replace(sha256=""),)), links=(supports("G-1", "Sn-1"),))  # fmt: skip
    assert codes(bare) == ["T409"]
    none = made(goal("G-1"), solution, links=(supports("G-1", "Sn-1"),))
    assert codes(none) == ["T409", "T419"]
    assert none.elements["G-1"].status == UNSUPPORTED


def test_an_unknown_kind_of_elements_or_links() -> None:
    with pytest.raises(ValueError, match="unknown kind of elements 'claim'"):
        list(checks.check(made(goal("G-1", undeveloped=True)._replace(kind="claim"))))


def test_an_unknown_kind_of_links() -> None:
    case = made(goal("G-1", undeveloped=True), goal("G-2"), links=(Link("implied_by", "G-1", "G-2", None),))
    with pytest.raises(ValueError, match="unknown kind of links 'implied_by'"):
        list(checks.check(case))


def test_nothing_is_lost_for_modules() -> None:
    """What has no top, or names what there is not, still is all there, so that the checks can say so."""
    around = (supports("G-1", "G-2"), supports("G-2", "G-1"), supports("G-2", "G-9"))
    case = in_modules(Case("", {"G-1": goal("G-1"), "G-2": goal("G-2")}, around), "", ())
    assert set(case.links) == set(around)
    assert set(codes(with_statuses(case))) == {"T401", "T403", "T410"}
