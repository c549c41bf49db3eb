"""Analyses in the safety case: one that leaves something open is nowhere called finished; and what the program says of its own is told as that."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from support.safety_case import Page, edit, html

ANALYSIS = """analyses:
  - id: AN-7
    title: What both motors share
    method: dependent failures
    of: [SYS-1]
    by: [P-1]
    made: 2026-02-02
    document: requirements/needs.yaml
"""
OPEN = """    open:
      - Both motors hang on one battery.
      - Both go by one clock.
"""


def analysed(project: Path, analysis: str) -> str:
    """The section on decomposition and analyses of the project, with SYS-1 divided, and an analysis that argues for that."""
    needs = project / "requirements/needs.yaml"
    text = needs.read_text("utf-8").replace("    achieves: [SG-1]\n", "    achieves: [SG-1]\n    independence: [AN-7]\n", 1)  # fmt: skip
    head, last, tail = text.partition("  - id: SW-1\n")
    needs.write_text(head + last + tail.replace("asil: B\n", "asil: B(B)\n", 1), "utf-8")
    people = project / "requirements/people.yaml"
    people.write_text(people.read_text("utf-8") + analysis, "utf-8")
    section = (
        html(project).html.partition('<section id="section-decomposition"')[2].partition("</section>")[0]
    )
    return " ".join(re.sub(r"<[^>]*>", " ", section).split())


def test_what_an_analysis_leaves_open_stands_with_it_and_it_argues_for_nothing(warehouse: Path) -> None:
    said = analysed(warehouse, ANALYSIS + OPEN)
    assert "left open ✎ Both motors hang on one battery. Both go by one clock." in said
    assert "AN-7 ; it leaves points open (below), so that independence is not shown" in said
    assert "finished on" not in said


def test_a_finished_analysis_is_called_so(warehouse: Path) -> None:
    said = analysed(warehouse, ANALYSIS)
    assert "finished on 2026-02-02" in said
    assert "open" not in said


def test_a_file_in_which_an_analysis_is_to_be_stands_with_what_it_has_come_to(warehouse: Path) -> None:
    """It stood there as if it were written down, where the matrix had no such file."""
    (warehouse / "motors.md").write_text("Each motor has a battery of its own.\n", "utf-8")
    said = analysed(warehouse, ANALYSIS.replace("requirements/needs.yaml", "motors.md"))
    assert re.search(r"written down in motors\.md (review|reviewed|not reviewed)", said)
    (warehouse / "motors.md").unlink()
    page = " ".join(re.sub(r"<[^>]*>", " ", html(warehouse).html).split())
    assert re.search(r"written down in motors\.md \S missing", page)


def test_where_hazards_and_goals_are_from_is_said(warehouse: Path) -> None:
    edit(
        warehouse,
        "requirements/hazards.yaml",
        "safe_state:",
        "source: minutes of the workshop\n    safe_state:",
    )
    assert "minutes of the workshop" in html(warehouse).texts


def test_kinds_are_in_the_language_of_the_document_and_sentences_of_the_program_say_that_they_are_english(warehouse: Path) -> None:  # fmt: skip
    spec = "module robot\n"
    edit(
        warehouse,
        "specs/robot.spec",
        spec,
        spec + '\nparam slow : m/s = 0.3 m/s in [0.1, 1] source "concept, 3.1"\n',
    )
    edit(warehouse, "specs/robot.spec", "require   robot.v <= 0.3 m/s", "require   robot.v <= slow")
    page: Page = html(warehouse, "--words", "de")
    first = page.first.partition("Von niemandem geprüft")[2]
    assert "<td" in first
    kinds = set(re.findall(r'<tr><td data-label="Art">([^<]*)</td>', first))
    assert "Anforderung" in kinds, kinds
    assert not kinds & {"requirement", "hazard", "safety goal", "design element"}
    said = re.sub(r"<[^>]*>", "", page.html)
    assert "0.3 m/s, von 0.1 bis 1 m/s" in said
    assert "concept, 3.1; angegeben in specs/robot.spec:3" in said
    assert "from 0.1 to" not in said
    sentences = re.findall(r"<span class=\"made\"([^>]*)>", page.html)
    assert sentences
    assert all('lang="en"' in attributes for attributes in sentences), sentences


@pytest.mark.parametrize(
    ("ends", "said"), [("[0.1, inf]", "at least 0.1 m/s"), ("[-inf, 1]", "at most 1 m/s"), (None, "")]
)
def test_ranges_with_one_end_or_none(warehouse: Path, ends: str | None, said: str) -> None:
    spec = "module robot\n"
    bounds = f" in {ends}" if ends else ""
    edit(warehouse, "specs/robot.spec", spec, f"{spec}\nparam slow : m/s = 0.3 m/s{bounds}\n")
    edit(warehouse, "specs/robot.spec", "require   robot.v <= 0.3 m/s", "require   robot.v <= slow")
    cells = re.findall(r'<td data-label="allowed">(.*?)</td>', html(warehouse).html)
    assert [re.sub(r"<[^>]*>", "", cell) for cell in cells] == [said]


def test_parameters_have_the_units_of_the_spec_everywhere(warehouse: Path) -> None:
    spec = "module robot\n"
    edit(
        warehouse,
        "specs/robot.spec",
        spec,
        spec + '\nparam slow : m/s = 1 km/h in [0, 1] source "concept, 3.1"\n',
    )
    edit(warehouse, "specs/robot.spec", "require   robot.v <= 0.3 m/s", "require   robot.v <= slow")
    (row,) = re.findall(r'<tr id="parameter-robot-slow">(.*?)</tr>', html(warehouse).html)
    assert "1 km/h, from 0 to 3.6 km/h" in re.sub(r"<[^>]*>", "", row)
    assert "0.2777" not in row


def test_methods_that_requirements_name_are_not_said_to_be_none(warehouse: Path) -> None:
    assert "verification: [test]" in (warehouse / "requirements/needs.yaml").read_text("utf-8")
    said = html(warehouse).first
    assert "No methods of verification are described: requirements name some" in said


def test_indicators_and_conditions_of_the_domain_are_in_it(warehouse: Path) -> None:
    people = warehouse / "requirements/people.yaml"
    said = "indicators:\n  - {id: SPI-1, title: Near misses, claims: [SG-1], owner: P-1, threshold: at most 1 in 100 km, data: log of each drive}\n"
    people.write_text(people.read_text("utf-8") + said, "utf-8")
    edit(
        warehouse,
        "requirements/hazards.yaml",
        'on foot."}',
        'on foot.", ranges: [{quantity: robot.v, from: 0 m/s, to: 2 m/s}]}',
    )
    page = html(warehouse)
    texts = " ".join(page.texts)
    assert re.search(r"SPI-1</span>.*?SG-1</a>.*?at most 1 in", page.html)
    assert "at most 1 in 100 km" in texts
    assert "log of each drive" in texts
    assert "robot.v: from 0 m/s to 2 m/s" in re.sub(r"<[^>]*>", "", page.html)
    german = html(warehouse, "--words", "de")
    assert "robot.v: von 0 m/s bis 2 m/s" in re.sub(r"<[^>]*>", "", german.html)


def test_indicators_are_in_it_where_there_is_no_hazard_and_no_goal(warehouse: Path) -> None:
    """They may watch requirements and assumptions: without hazards their section left itself out."""
    (warehouse / "requirements/hazards.yaml").unlink()
    people = warehouse / "requirements/people.yaml"
    said = "indicators:\n  - {id: SPI-1, title: Near misses, claims: [SYS-1], owner: P-1, threshold: at most 1 in 100 km, data: log of each drive}\n"
    people.write_text(people.read_text("utf-8") + said, "utf-8")
    page = html(warehouse)
    assert re.search(r"SPI-1</span>.*?SYS-1</a>.*?at most 1 in 100 km.*?log of each drive", page.html)
    assert "No hazards" in page.first
