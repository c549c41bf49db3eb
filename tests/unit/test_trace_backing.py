"""Evidence that a project attaches to assumptions of the library: it counts as if the spec had named it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from support.project import command, run_command
from trackmarshal.records.specs import SpecItem
from trackmarshal.trace.backing import backed
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.model import Backing, Project
from trackmarshal.trace.values import Placed

POSE = (
    "document: requirements\ntitle: Pose\nrequirements:\n  - {id: S-1-A-3, title: Pose, statement: The trajectory shall start where the car is., rationale: So.,\n"
    "     adopted: A law., status: approved, asil: QM, verification: [monitor], assumptions: [A-LOCALISATION], source: A law.}\n"
)


def item(name: str, kind: str = "assume", **more: str) -> SpecItem:
    return SpecItem(kind, name, "t", (), (), "a.spec", 1, 1, "f", **more)  # type: ignore[arg-type]


def entry(name: str, line: int, owner: str = "") -> Backing:
    at = Place("v.yaml", line)
    return Backing(Placed.at(name, at), Placed.at(f"{name}.md", at), owner)


def test_it_fills_in_what_the_spec_leaves_open() -> None:
    items = [item("A-ONE", owner="they"), item("A-TWO", owner="they"), item("A-THREE"), item("A-ONE", "rule")]
    project = Project(backing=(entry("A-ONE", 1, "we"), entry("A-TWO", 2)))
    found: list[Finding] = []
    made = backed(project, items, found)
    assert [(one.evidence, one.owner) for one in made] == [
        ("A-ONE.md", "we"), ("A-TWO.md", "they"), ("", ""), ("", ""),
    ]  # fmt: skip
    assert found == []
    assert [one.fingerprint for one in made] == ["f"] * 4  # what it means is the same


@pytest.mark.parametrize(("given", "code"), [
    ((entry("A-NONE", 3),), "T151"), ((entry("rule", 3),), "T151"), ((entry("A-HAS", 3),), "T142"), ((entry("A-ONE", 1), entry("A-ONE", 3)), "T142"),
])  # fmt: skip
def test_what_is_given_in_vain_is_an_error(given: tuple[Backing, ...], code: str) -> None:
    items = [item("A-ONE"), item("A-HAS", evidence="theirs.md"), item("rule", "rule")]
    found: list[Finding] = []
    made = backed(Project(backing=given), items, found)
    assert [(f.code, f.level, f.place and f.place.line) for f in found] == [(code, "error", 3)]
    assert made[1].evidence == "theirs.md"


def test_an_assumption_of_the_library_is_backed_by_the_project(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is held by its hash as any other, and what the document says of itself counts."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    car = tmp_path / "car"
    assert run_command("init", str(car), "--quiet")[0] == 0
    (car / "requirements" / "pose.yaml").write_text(POSE, "utf-8")
    (car / "specs" / "ours.spec").write_text("module ours\n\nuse supervisor.assumptions\n", "utf-8")

    def said() -> list[tuple[str, str]]:
        findings = json.loads(command(car, "trace", "--as-is", "--format", "json")[1])["findings"]
        return [(f["code"], f["message"]) for f in findings if f["subject"] == "A-LOCALISATION"]

    assert ("T208", "the assumption `A-LOCALISATION` has no evidence") in said()
    model = car / "requirements" / "v-model.yaml"
    with model.open("a", encoding="utf-8") as file:
        file.write("assumptions:\n  - {name: A-LOCALISATION, evidence: docs/pose.md, owner: Ann}\n")
    assert ("T252", "the evidence `docs/pose.md` of the assumption `A-LOCALISATION` is not there") in said()
    (car / "docs").mkdir()
    (car / "docs" / "pose.md").write_text("# Pose\n\nReport 7: at most 60 ms.\n", "utf-8")
    assert not {"T208", "T252", "T253"} & {code for code, _ in said()}
    assert command(car, "trace", "--accept-baseline", "--by", "Ann", "--reason", "a law")[0] in (0, 1)
    (car / "docs" / "pose.md").write_text("# Pose\n\nThis is not yet measured.\n", "utf-8")
    assert {"T253", "T373"} <= {code for code, _ in said()}


def test_the_page_of_an_assessment_says_what_the_project_attaches(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It had what specs say alone: that there is no evidence, of an assumption that the gate passes for its evidence."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path / "cache"))
    car = tmp_path / "car"
    assert run_command("init", str(car), "--quiet")[0] == 0
    with (car / "specs" / "speed.spec").open("a", encoding="utf-8") as file:
        file.write('\nassume A-DRY "The road is dry"\n  satisfies R-1\n  owner     "they"\n')
    with (car / "requirements" / "v-model.yaml").open("a", encoding="utf-8") as file:
        file.write("assumptions:\n  - {name: A-DRY, evidence: docs/dry.md, owner: Ann}\n")
    command(car, "assess", "--quiet")
    page = (car / "out" / "assess" / "index.html").read_text("utf-8")
    (row,) = (row for row in page.split("<tr>") if "A-DRY" in row and 'data-label="evidence"' in row)
    assert re.findall(r'data-label="(?:owner|evidence)">(.*?)</td>', row) == [
        "Ann",
        "<code>docs/dry.md</code>",
    ]
