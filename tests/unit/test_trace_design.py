"""Cells that are green only on a section of their own, and on analyses that leave nothing open."""

from __future__ import annotations

from pathlib import Path

import pytest

from golden.trace.cases import Small
from trackmarshal import trace
from trackmarshal.trace.sections import section

DESIGN = """\
document: design
title: The layout
elements:
  - {id: DE-1, title: the watchdog, asil: D, document: docs/layout.md}
"""
ANALYSES = """\
document: assurance
title: Who did what
persons:
  - {id: P-1, title: the maintainers}
  - {id: P-2, title: the safety manager}
  - {id: P-3, title: perception}
analyses:
  - {id: AN-1, title: Common causes, method: dependent failures, of: [S-1-B-1], by: [P-1], made: 2026-02-01, document: docs/layout.md}
"""
PAGE = "# Layout\n\n## S-1-B-1: in time\n\nA timer of its own.\n\n## S-1-B-10\n\nAnother one.\n"


def small(folder: Path, page: str = PAGE, counts: str = "design", more: str = "") -> Small:
    """The small project, its S-1-B-1 allocated to an element with this page; S-2-A counts this."""
    made = Small.copy(folder)
    (made.root / "requirements" / "design.yaml").write_text(DESIGN, encoding="utf-8")
    (made.root / "requirements" / "assurance.yaml").write_text(
        ANALYSES.replace("document: docs/layout.md", f"document: docs/layout.md{more}"), encoding="utf-8"
    )
    (made.root / "docs" / "layout.md").write_text(page, encoding="utf-8")
    made.replace(
        "requirements/v-model.yaml",
        "the layout, applies_to: [S-1-B-*], counts: [document]",
        f"the layout, applies_to: [S-1-B-*], counts: [{counts}]",
    )
    text = (made.root / "requirements" / "criteria.yaml").read_text("utf-8")
    head, mark, tail = text.partition("  - id: S-1-B-1\n")
    links = "    allocated_to: [DE-1]\n    independence: [AN-1]\n"
    (made.root / "requirements" / "criteria.yaml").write_text(head + mark + links + tail, encoding="utf-8")
    return made


def cell(made: Small) -> tuple[str, list[str]]:
    row = next(row for row in made.matrix().rows if row.requirement.id == "S-1-B-1")
    found = row.cells["S-2-A"]
    return found.status, [f"{item.name}: {item.detail}" for item in found.items]


@pytest.mark.parametrize(
    ("page", "status", "detail"),
    [
        (PAGE, "covered", "DE-1: docs/layout.md, section S-1-B-1"),
        (PAGE.replace("S-1-B-1:", "S-1-B-11:"), "partial", "DE-1: no section of docs/layout.md is about S-1-B-1"),
        (PAGE.replace("A timer of its own.\n", ""), "partial", "DE-1: no section of docs/layout.md is about S-1-B-1"),
        (f"```text\n{PAGE}```\n", "partial", "DE-1: no section of docs/layout.md is about S-1-B-1"),
        (PAGE.replace("A timer of its own.", "How has not been\nwritten yet."), "partial", "DE-1: docs/layout.md, section S-1-B-1, says that it is still to come"),
        (PAGE.replace("Another one.", "How has not been\nwritten yet."), "covered", "DE-1: docs/layout.md, section S-1-B-1"),
    ],
)  # fmt: skip
def test_a_cell_is_green_on_its_own_section_alone(
    tmp_path: Path, page: str, status: str, detail: str
) -> None:
    assert cell(small(tmp_path, page)) == (status, [detail])


def test_an_element_without_a_document_says_nothing(tmp_path: Path) -> None:
    made = small(tmp_path)
    made.replace("requirements/design.yaml", ", document: docs/layout.md", "")
    assert cell(made) == ("partial", ["DE-1: no document says how it meets the requirement"])


@pytest.mark.parametrize(
    ("more", "status", "detail"),
    [
        ("", "covered", "AN-1: nothing is left open"),
        (", open: [Both read one clock.]", "partial", "AN-1: left open: Both read one clock."),
    ],
)
def test_an_analysis_that_leaves_something_open_shows_nothing(
    tmp_path: Path, more: str, status: str, detail: str
) -> None:
    assert cell(small(tmp_path, counts="analysis", more=more)) == (status, [detail])


def test_an_analysis_that_says_that_it_was_not_made_shows_nothing(tmp_path: Path) -> None:
    made = small(tmp_path, PAGE + "\n# AN-1\n\nThis analysis has not been done yet.\n", "analysis")
    assert cell(made) == ("partial", ["AN-1: its document says that there is none"])
    said = [(f.subject, f.message) for f in trace.gate(made.matrix()) if f.code == "T253"]
    assert said == [("AN-1", 'the document `docs/layout.md` of the analysis `AN-1` says that there is none: "not been done yet"')]  # fmt: skip
    # One that leaves something open says so itself, and may say it in its document.
    made.replace("requirements/assurance.yaml", "docs/layout.md}", "docs/layout.md, open: [All of it.]}")
    assert "T253" not in {finding.code for finding in made.matrix().findings}


def test_another_section_is_noticed_and_the_rest_of_the_page_is_not(tmp_path: Path) -> None:
    made = small(tmp_path)
    # An analysis is held as a whole page.
    made.replace("requirements/assurance.yaml", "document: docs/layout.md", "document: docs/causes.md")
    (made.root / "docs" / "causes.md").write_text("# Common causes\n", encoding="utf-8")
    made.accept()
    before = {finding.code for finding in trace.gate(made.matrix())}
    made.replace("docs/layout.md", "Another one.", "Quite another one.")
    made.replace("docs/layout.md", "A timer of its own.", "A timer\nof its own.")
    assert {finding.code for finding in trace.gate(made.matrix())} == before
    made.replace("docs/layout.md", "A timer\n", "The planner's timer\n")
    found = [finding for finding in trace.gate(made.matrix()) if finding.code == "T373"]
    assert [finding.subject for finding in found] == ["docs/layout.md#S-1-B-1"]


def test_a_section_ends_at_the_next_heading_of_its_level() -> None:
    text = "# A\n## R-1 and R-2\none\n### deeper\ntwo\n```\n## not a heading\n```\n## R-3\nthree\n"
    assert section(text, "R-1") == section(text, "R-2") == "one\ndeeper\ntwo\n```\n## not a heading\n```"
    assert section(text, "R-3") == "three"
    assert section(text, "A") is not None
    assert section(text, "R-4") is None


@pytest.mark.parametrize(
    "code",
    [
        "````md\n```\n{}\n```\n````", "```\n```python\n{}\n```", "~~~\n```\n{}\n~~~", "```\n~~~\n{}\n```", "```\n````x\n{}\n````", "   ```\n{}\n```",
        "~~~ a`b\n{}\n~~~", "```\n{}",
    ],
)  # fmt: skip
def test_a_heading_in_a_block_of_code_is_none(code: str) -> None:
    """A fence ends with as many signs of its own kind, or more, and nothing behind them."""
    inside = "## R-1\n\nIt plans."
    assert section(f"# Design\n\n{code.format(inside)}\n", "R-1") is None
    below = section(f"# Design\n\n## R-1\n\n{code.format('## R-2')}\n", "R-1")
    assert below is not None
    assert "R-2" in below


@pytest.mark.parametrize("before", ["`````", "```a```", "````\ncode\n````", "~~~\n~~~~", "    ```"])
def test_what_stands_behind_a_block_of_code_is_none_of_it(before: str) -> None:
    before = f"{before}\n`````" if before == "`````" else before
    assert section(f"# Design\n\n{before}\n\n## R-1\n\nIt plans.\n", "R-1") == "It plans."


@pytest.mark.parametrize(
    ("heading", "next_"),
    [("R-1\n---", "R-2\n-"), ("R-1\n===", "## deeper\n\nX\n=="), ("  ## R-1", "   ## R-2"), ("## R-1", "##"), ("## R-1", "R-2\n---")],
)  # fmt: skip
def test_headings_that_are_underlined_or_indented(heading: str, next_: str) -> None:
    said = section(f"Design\n======\n\n{heading}\n\nIt plans.\n\n{next_}\n\ntwo\n", "R-1")
    assert said is not None
    assert "It plans." in said
    assert "two" not in said


@pytest.mark.parametrize(
    "rule",
    [
        "- R-1\n---",
        "> R-1\n---",
        "- a\n  R-1\n---",
        "| R-1 |\n---",
        "    R-1\n---",
        "R-1\n\n---",
        "1. R-1\n---",
    ],
)
def test_a_rule_makes_no_heading_of_what_is_no_paragraph(rule: str) -> None:
    assert section(f"# Design\n\n{rule}\n\nIt plans.\n", "R-1") is None


def test_another_heading_is_another_section(tmp_path: Path) -> None:
    """What it says is held by its hash, and under which heading as it is written; where it was not held yet, nothing is said."""
    made = small(tmp_path)
    made.replace("requirements/assurance.yaml", "document: docs/layout.md", "document: docs/causes.md")
    (made.root / "docs" / "causes.md").write_text("# Common causes\n", encoding="utf-8")
    made.accept()
    before = {finding.code for finding in trace.gate(made.matrix())}
    made.replace("docs/layout.md", "## S-1-B-1: in time", "## S-1-B-1:  in  time ##")
    assert {finding.code for finding in trace.gate(made.matrix())} == before
    made.replace("docs/layout.md", "S-1-B-1:  in  time ##", "S-1-B-1 is not met")
    (found,) = [finding for finding in trace.gate(made.matrix()) if finding.code == "T373"]
    assert "heading" in found.message
    assert "is not met" in found.message


@pytest.mark.parametrize(
    "body", ["TODO", "**T.B.D.**", "---", "```\n```", "[x]: y", "### R-2", "<!-- to be written -->"]
)
def test_a_section_in_which_nothing_is_said_is_none(body: str) -> None:
    assert section(f"# Design\n\n## R-1\n\n{body}\n\n## R-3\n\nthree\n", "R-1") is None


def test_a_comment_that_nothing_ends_hides_the_rest_where_it_begins_a_line() -> None:
    text = "# Design\n\n{}\n\n## R-1\n\nIt plans.\n"
    assert section(text.format("<!--"), "R-1") is None
    assert section(text.format("  <!-- - below is old"), "R-1") is None
    for seen in ("Write <!-- so.", "<!-->", "```\n<!--\n```", "    <!--"):
        assert section(text.format(seen), "R-1") == "It plans."


@pytest.mark.parametrize("tag", ["script", "style", "Template", 'script type="text/plain"'])
def test_what_browsers_show_nothing_of_is_no_section(tag: str) -> None:
    """Ended or not: what is written in scripts and styles is read by nobody."""
    text = "# Design\n\n{}\n\n## R-1\n\nIt plans.\n"
    assert section(text.format(f"<{tag}>"), "R-1") is None
    assert section(f"{text.format(f'<{tag}>')}\n</{tag.split(maxsplit=1)[0]}>\n", "R-1") is None
    assert section(text.format(f"A `<{tag}>` does."), "R-1") == "It plans."


@pytest.mark.parametrize(
    "body", ["---\n\nIt plans.\n\n---", "### R-2\n\nIt plans.", "```\nplan()\n```", "R", "計画する。"]
)
def test_one_in_which_something_is_said_is_one(body: str) -> None:
    """Between two rules, too, which at the head of a document stand around what programs read."""
    assert section(f"# Design\n\n## R-1\n\n{body}\n\n## R-3\n\nthree\n", "R-1")


@pytest.mark.parametrize(
    "path", ["specs/rules.spec", "requirements/criteria.yaml", "./requirements/criteria.yaml", "docs/a.md"]
)
def test_what_is_demanded_is_no_argument(path: str, tmp_path: Path) -> None:
    """Wherever a link to it stands."""
    made = small(tmp_path, counts="analysis")
    made.replace("requirements/assurance.yaml", "docs/layout.md", path)
    (made.root / "specs").mkdir(exist_ok=True)
    (made.root / "specs" / "rules.spec").write_text("module rules -- S-1-B-1\n", encoding="utf-8")
    (made.root / "docs" / "a.md").symlink_to("../specs/rules.spec")
    assert [f.subject for f in trace.gate(made.matrix()) if f.code == "T256"] == ["AN-1"]
    assert cell(made) == ("partial", ["AN-1: its document says what is demanded"])


@pytest.mark.parametrize(
    ("path", "status", "detail"),
    [
        ("requirements/criteria.yaml", "missing", "says what is demanded"),
        ("requirements/baseline.json", "missing", "says what is demanded"),
        ("docs/a.md", "missing", "says what is demanded"),
        ("requirements/drives.json", "covered", ""),  # nothing is read of it: it demands nothing
    ],
)
def test_what_is_demanded_covers_no_cell(path: str, status: str, detail: str, tmp_path: Path) -> None:
    made = small(tmp_path, counts="document")
    made.replace("requirements/v-model.yaml", "evidence:\n", f"evidence:\n  - {{path: {path}, title: all of it, stage: S-2-A, requirements: [S-1-B-1]}}\n")  # fmt: skip
    (made.root / "requirements" / "drives.json").write_text('{"S-1-B-1": "12 of 12"}', encoding="utf-8")
    (made.root / "docs" / "a.md").symlink_to("../requirements/criteria.yaml")
    found = [f"{item.name}: {item.detail}" for row in made.matrix().rows if row.requirement.id == "S-1-B-1" for item in row.cells["S-2-A"].items]  # fmt: skip
    assert f"{path}: {detail}" in found
    assert ("T256" in {f.code for f in made.matrix().findings}) is (status == "missing")
    row = next(row for row in made.matrix().rows if row.requirement.id == "S-1-B-1")
    assert {item.status for item in row.cells["S-2-A"].items if item.name == path} == {status}


def test_the_baseline_is_no_evidence_however_its_path_is_written(tmp_path: Path) -> None:
    made = small(tmp_path, counts="document")
    made.replace("requirements/v-model.yaml", "baseline: requirements", "baseline: ./requirements")
    made.replace("requirements/v-model.yaml", "evidence:\n", "evidence:\n  - {path: requirements/baseline.json, title: all of it, stage: S-2-A, requirements: [S-1-B-1]}\n")  # fmt: skip
    assert "T256" in {f.code for f in made.matrix().findings}
