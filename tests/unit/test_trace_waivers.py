"""Who owns a waiver does not approve it, however the two are written; and which waivers are needed."""

from __future__ import annotations

import re
from dataclasses import replace
from datetime import date
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from golden.trace.cases import TODAY, Small
from trackmarshal import trace
from trackmarshal.trace.cells import Cell
from trackmarshal.trace.findings import Place
from trackmarshal.trace.gates import Waivers
from trackmarshal.trace.model import Project, Waiver
from trackmarshal.trace.render.data import render as render_json
from trackmarshal.trace.render.table import render_markdown
from trackmarshal.trace.render.text import render as render_text
from trackmarshal.trace.values import Placed

PERSONS = """document: assurance
title: Who did what
persons:
  - {id: P-1, title: The Maintainers}
  - {id: P-2, title: the safety manager}
"""


@pytest.mark.parametrize(
    ("owner", "approver", "same"),
    [
        ("P-1", "The Maintainers", True),
        ("P-1", "the maintainers", True),
        ("the maintainers", '"THE  maintainers"', True),
        ("p-1", "The Maintainers", True),
        ("P-1", "\u200bThe Maintainers", True),
        ("P-1", "P-2", False),
        ("The Maintainers", "the safety manager", False),
    ],
)
def test_the_owner_does_not_approve(owner: str, approver: str, same: bool, tmp_path: Path) -> None:
    made = Small.copy(tmp_path)
    (made.root / "requirements" / "assurance.yaml").write_text(PERSONS, "utf-8")
    made.replace(
        "requirements/v-model.yaml",
        "owner: the maintainers\n    approver: the safety manager",
        f"owner: {owner}\n    approver: {approver}",
    )
    found = [finding for finding in made.matrix().findings if finding.code == "T234"]
    assert [finding.subject for finding in found] == ["W-1"] * same


@pytest.mark.parametrize(
    ("subjects", "blanket"),
    [
        ("*", True),
        ("*:*", True),
        ("S-*, RR-*, CR-*", True),
        ("S-*:*, RR-*:*, CR-*:*", True),
        ("S-*, RR-*", True),
        ("S-*", False),
        ("*:review", True),
        ("*:wind tunnel", True),
        ("S-*:test, RR-*:test", True),
        ("S-*:test", False),
        ("S-1-A-1:monitor", False),
    ],
)
def test_a_waiver_for_subjects_of_every_requirement_is_a_blanket(
    subjects: str, blanket: bool, tmp_path: Path
) -> None:
    made = Small.copy(tmp_path)
    listed = ", ".join(f'"{pattern}"' for pattern in subjects.split(", "))
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        f"waivers:\n  - {{id: W-2, codes: [T255], subjects: [{listed}], justification: None., residual_risk: None., owner: the maintainers, "
        "approver: the safety manager, granted: 2026-01-01, expires: 2026-12-31}\n",
    )
    found = [finding for finding in made.matrix().findings if finding.code == "T236"]
    assert [finding.subject for finding in found] == ["W-2"] * blanket


@pytest.mark.parametrize(
    ("codes", "subjects", "blanket"),
    [
        ("T208", "A-*", True),
        ("T252", "*-*", True),
        ("T208", "A-S*", False),
        ("T208", "A-SEEN, A-MAP", False),
        ("T207", "A-*", False),
        ("T212", "f*, *t*, *a*", True),
        ("T211", "g*, t*", False),
        ("T254", "f*, *t*, *a*", False),
    ],
)
def test_a_waiver_for_every_rule_or_assumption_is_a_blanket(
    codes: str, subjects: str, blanket: bool, tmp_path: Path
) -> None:
    """By their names it excused each that came later, too: an assumption that nobody backs was green."""
    made = Small.copy(tmp_path)
    listed = ", ".join(f'"{pattern}"' for pattern in subjects.split(", "))
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        f"waivers:\n  - {{id: W-2, codes: [{codes}], subjects: [{listed}], justification: None., residual_risk: None., owner: the maintainers, "
        "approver: the safety manager, granted: 2026-01-01, expires: 2026-12-31}\n",
    )
    items, tests, results, runs = made.parts()
    (seen,) = (item for item in items if item.kind == "assume")
    another = replace(seen, name="A-MAP", line=seen.line + 50, owner="", evidence="")
    matrix = trace.build(made.root, [*items, another], tests, results, runs, TODAY)
    found = [finding for finding in matrix.findings if finding.code == "T236"]
    assert [finding.subject for finding in found] == ["W-2"] * blanket


MORE = {
    "hazards": """domains:
  - {id: ODD-1, title: The road, description: Dry.}
  - {id: ODD-2, title: The road, description: Wet.}
""",
    "assurance": """persons: [{id: P-1, title: Somebody}]
reviews:
  - {id: RV-1, of: [{id: S-1-B-1, fingerprint: "0000000000000000000000000000000000000000000000000000000000000000"}], by: [P-1], made: 2026-01-01, document: docs/architecture.md, outcome: accepted}
  - {id: RV-2, of: [{id: S-1-B-1, fingerprint: "0000000000000000000000000000000000000000000000000000000000000000"}], by: [P-1], made: 2026-01-01, document: docs/architecture.md, outcome: accepted}
analyses:
  - {id: FT-1, title: Down, method: fault tree, of: [S-1-B-1], by: [P-1], made: 2026-01-01, document: docs/architecture.md}
  - {id: FT-2, title: Up, method: fault tree, of: [S-1-B-1], by: [P-1], made: 2026-01-01, document: docs/architecture.md}
""",
}


@pytest.mark.parametrize(
    ("codes", "subjects", "blanket"),
    [
        ("T254", "ODD-*", True),
        ("T253", "ODD-*", False),
        ("T254", "ODD-1*", False),
        ("T254", "ODD-1, ODD-2", False),
        ("T253", "FT-1*, *-2", True),
        ("T254", "FT-*", False),
        ("T253", "RV-*", True),
    ],
)
def test_a_waiver_for_every_domain_analysis_or_review_is_a_blanket(
    codes: str, subjects: str, blanket: bool, tmp_path: Path
) -> None:
    """As one for every assumption: a domain that was claimed later, and of which there is no recording, was green."""
    made = Small.copy(tmp_path)
    listed = ", ".join(f'"{pattern}"' for pattern in subjects.split(", "))
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        f"waivers:\n  - {{id: W-2, codes: [{codes}], subjects: [{listed}], justification: None., residual_risk: None., owner: the maintainers, "
        "approver: the safety manager, granted: 2026-01-01, expires: 2026-12-31}\n",
    )
    for name, said in MORE.items():
        text = f"document: {name}\ntitle: More\n{said}"
        (made.root / "requirements" / f"{name}.yaml").write_text(text, "utf-8")
    found = made.matrix().findings
    assert [one.subject for one in found if one.code == "T236"] == ["W-2"] * blanket
    assert not [one for one in found if one.code.startswith("T12")]


def test_patterns_of_requirements_excuse_no_assumption(tmp_path: Path) -> None:
    """Beside them a waiver for one assumption was one for every, where requirements are called as assumptions are."""
    made = Small.copy(tmp_path)
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        'waivers:\n  - {id: W-2, stages: [S-2-A], requirements: ["A-*"], codes: [T208], subjects: [A-SEEN], justification: None., '
        "residual_risk: None., owner: the maintainers, approver: the safety manager, granted: 2026-01-01, expires: 2026-12-31}\n",
    )
    items, tests, results, runs = made.parts()
    (seen,) = (item for item in items if item.kind == "assume")
    another = replace(seen, name="A-MAP", line=seen.line + 50)
    matrix = trace.build(made.root, [*items, another], tests, results, runs, TODAY)
    assert not [one for one in matrix.findings if one.code == "T236"]


@pytest.mark.parametrize(
    ("codes", "subject", "left"),
    [
        ("T208", "A-MAP", ["T211", "T252"]),
        ("T211", "A-MAP", ["T208", "T252"]),
        ("T208, T211, T252", "A-MAP", []),
        ("T208, T211, T252", "A-SEEN", ["T208", "T211", "T252"]),
        ("T208, T211, T252", "a-map", ["T208", "T211", "T252"]),
        ("T208, T211, T252", "A-M", ["T208", "T211", "T252"]),
    ],
)
def test_a_waiver_answers_for_its_codes_and_subjects_alone(
    codes: str, subject: str, left: list[str], tmp_path: Path
) -> None:
    """Of one thing, each gap is answered for by itself."""
    made = Small.copy(tmp_path)
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        f"waivers:\n  - {{id: W-2, codes: [{codes}], subjects: [{subject}], justification: None., residual_risk: None., owner: the maintainers, "
        "approver: the safety manager, granted: 2026-01-01, expires: 2026-12-31}\n",
    )
    items, tests, results, runs = made.parts()
    (seen,) = (item for item in items if item.kind == "assume")
    another = replace(seen, name="A-MAP", line=seen.line + 50, owner="", evidence="docs/none.md")
    found = trace.gate(trace.build(made.root, [*items, another], tests, results, runs, TODAY))
    gaps = {"T208", "T211", "T252"}
    assert sorted(one.code for one in found if one.subject == "A-MAP" and one.code in gaps) == left


@pytest.mark.parametrize(
    ("excuses", "needless"),
    [
        ("stages: [S-3-B], requirements: [S-1-B-1]", []),
        ("stages: [S-2-B], requirements: [S-1-B-1]", ["W-2"]),
    ],
)
def test_one_that_is_granted_anew_before_the_other_ends_is_needed(
    excuses: str, needless: list[str], tmp_path: Path
) -> None:
    """Who strikes it, because the gap is said to be closed, has a red gate when the other one expires."""
    made = Small.copy(tmp_path)
    made.replace(
        "requirements/v-model.yaml",
        "    expires: 2026-12-31\n",
        f"    expires: 2026-06-30\n  - {{id: W-2, {excuses}, justification: Soon., residual_risk: None., owner: the maintainers, "
        "approver: the safety manager, granted: 2026-06-01, expires: 2026-12-31}\n",
    )
    assert [finding.subject for finding in made.matrix().findings if finding.code == "T232"] == needless


@pytest.mark.parametrize(
    ("stages", "requirements", "statuses", "said"),
    [
        ("S", "R-1, R-2", {"R-1": "missing", "R-2": "covered"}, "R-2"),
        ("S", "R-1, R-2", {"R-1": "missing", "R-2": "partial"}, ""),
        ("S", "R-1, R-2", {"R-1": "missing", "R-2": "failed"}, ""),  # open again, perhaps, when it is mended
        ("S", "R-1, R-2", {"R-1": "missing", "R-2": "stale"}, ""),
        ("S", "R-1, R-3", {"R-1": "missing"}, ""),  # no such one, which is told otherwise (T127)
        ("S", "R-*", {"R-1": "missing", "R-2": "covered"}, ""),
        ("S, T", "R-1", {"R-1": "missing"}, "T"),
        ("S, T", "R-1, R-2", {"R-1": "missing", "R-2": "covered"}, "R-2, T"),
        ("S", "R-1, R-2", {"R-1": "covered", "R-2": "covered"}, "all"),
    ],
)
def test_a_part_of_a_waiver_whose_gap_is_closed_is_told(
    stages: str, requirements: str, statuses: dict[str, str], said: str
) -> None:
    """Beside a requirement that needs it, one that is covered by now was excused when it is not any more, and nobody had looked at that."""

    def placed(words: str) -> tuple[Placed, ...]:
        return tuple(Placed.at(word, Place("v-model.yaml", 1)) for word in words.split(", ") if word)

    (name, other) = placed("W-1, B")
    day = date(2026, 6, 1)
    waiver = Waiver(name, placed(stages), placed(requirements), (), (), "", "", "A", other, day, day)
    waivers = Waivers(Project(waivers=(waiver,)), day)
    cells: dict[str, dict[str, Cell]] = {}
    for id_, status in statuses.items():
        requirement: Any = SimpleNamespace(id=id_)
        stage: Any = SimpleNamespace(id="S")
        cells[id_] = {
            "S": waivers.cell(Cell(status, ()), requirement, stage),
            "T": Cell("covered", ()),
        }
    found = [finding.message for finding in waivers.check(cells)]
    parts = ", ".join(f"`{part}`" for part in said.split(", "))
    of = {"": [], "all": ["the waiver `W-1` excuses nothing"]}
    assert found == of.get(said, [f"the waiver `W-1` excuses nothing of {parts}"])


@pytest.mark.parametrize(
    ("granted", "expires", "longer"),
    [
        ("2026-01-01", "2027-01-01", False),
        ("2026-01-01", "2027-01-02", True),
        ("2024-02-29", "2025-02-28", False),
        ("2024-02-29", "2025-03-01", True),
        ("2023-03-01", "2024-03-01", False),
    ],
)
def test_one_holds_for_a_year_at_most(granted: str, expires: str, longer: bool, tmp_path: Path) -> None:
    made = Small.copy(tmp_path)
    made.replace(
        "requirements/v-model.yaml",
        "    granted: 2026-01-01\n    expires: 2026-12-31\n",
        f"    granted: {granted}\n    expires: {expires}\n",
    )
    found = [finding for finding in made.matrix().findings if finding.code == "T235"]
    assert [finding.subject for finding in found] == ["W-1"] * longer


def test_a_table_for_a_merge_request_says_of_what_a_finding_is_waived(tmp_path: Path) -> None:
    """It named the code alone, and the matrix has many findings of one."""
    made = Small.copy(tmp_path)
    waiver = 'W-2, codes: [T255], subjects: ["S-1-A-1:measurement"], justification: None., residual_risk: None., owner: one, approver: other'
    made.replace(
        "requirements/v-model.yaml",
        "waivers:\n",
        f"waivers:\n  - {{id: {waiver}, granted: 2026-01-01, expires: 2026-12-31}}\n",
    )
    assert "- **W-2** (T255 of S-1-A-1:measurement, one, approved by other, " in render_markdown(
        made.matrix()
    )


@pytest.mark.parametrize(
    ("granted", "expires", "codes"),
    [
        ('""', "9999-12-31", ["T125"]),
        ("2026-01-01", '""', ["T125"]),
        ("2026-02-30", '"?"', ["T125", "T125"]),
        ("0001-01-01", "9999-12-31", ["T235"]),
        ("0001-01-01", "0001-01-01", ["T231"]),
    ],
)
def test_a_waiver_without_its_days_never_holds_and_the_first_day_that_there_is_is_a_day(
    granted: str, expires: str, codes: list[str], tmp_path: Path
) -> None:
    """A day that could not be read was shown as the first one of the year 1; and one that was granted on that day held for ever, and nothing was said."""
    made = Small.copy(tmp_path)
    settings = made.root / "requirements" / "v-model.yaml"
    text = re.sub(r"granted: \S+", f"granted: {granted}", settings.read_text("utf-8"))
    settings.write_text(re.sub(r"expires: \S+", f"expires: {expires}", text), "utf-8")
    matrix = made.matrix()
    assert [f.code for f in matrix.findings if f.code in ("T125", "T231", "T235")] == codes
    waived = any(cell.status == "waived" for row in matrix.rows for cell in row.cells.values())
    assert waived == ("T235" in codes)
    shown = [render_markdown(matrix), render_text(matrix), render_json(matrix)]
    if "T125" in codes:
        assert not any("0001-01-01" in text for text in shown)


@pytest.mark.parametrize("wrong", ["The Maintaners", "the maintainer"])
def test_who_is_misspelt_is_asked_after_by_name(wrong: str, tmp_path: Path) -> None:
    """Ids alone were looked at, which nobody writes: no help named the person."""
    made = Small.copy(tmp_path)
    (made.root / "requirements" / "assurance.yaml").write_text(PERSONS, "utf-8")
    made.replace("requirements/v-model.yaml", "owner: the maintainers", f"owner: {wrong}")
    (found,) = [f for f in made.matrix().findings if f.code == "T153" and f.subject == "W-1"]
    assert "did you mean `The Maintainers`" in found.help
