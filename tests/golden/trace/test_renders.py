"""Every format of the matrix, byte for byte: of a project that passes, and of one that fails in many ways."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from jsonschema import Draft202012Validator

from golden.trace.cases import HERE, TODAY, Small, apply, compare
from trackmarshal import trace
from trackmarshal.trace.graph.kinds import LINKS
from trackmarshal.trace.render.table import escaped
from trackmarshal.trace.report import write_report
from trackmarshal.trace.verdict import FAIL, PASS, RESERVED, SIGNS

SUFFIX = {
    "text": "txt",
    "json": "json",
    "csv": "csv",
    "md": "md",
    "html": "html",
    "sarif": "sarif",
    "github": "github",
    "junit": "xml",
}
BROKEN = """\
edit records/test_results.json
- {"rule": "gap", "title": "outside", "outcome": "passed", "fingerprint": "gggggggg", "message": "", "file": "specs/rules.spec", "line": 120},
+ {"rule": "gap", "title": "outside", "outcome": "failed", "fingerprint": "gggggggg", "message": "expected violated, got <satisfied> | =1+1", "file": "specs/rules.spec", "line": 120},
- {"rule": "turn", "title": "inside", "outcome": "passed", "fingerprint": "tttttttt", "message": "", "file": "specs/rules.spec", "line": 128},
+ {"rule": "turn", "title": "inside", "outcome": "passed", "fingerprint": "an older one", "message": "", "file": "specs/rules.spec", "line": 128},
edit requirements/criteria.yaml
-     title: Grip
+     title: '=Grip <b>of the tyres</b> | and 100 %'
-     metrics: [friction]
+     metrics: [friction, slip]
remove docs/seen.md
today 2027-06-02
"""


def broken(folder: Path) -> Small:
    small = Small.copy(folder)
    apply(small, BROKEN.splitlines())
    return small


def test_all_formats_are_here() -> None:
    assert sorted(SUFFIX) == sorted(trace.FORMATS)


@pytest.mark.parametrize("kind", trace.FORMATS)
def test_passing(kind: str) -> None:
    compare(HERE / "renders" / f"passing.{SUFFIX[kind]}", trace.render(Small().matrix(), kind))


@pytest.mark.parametrize("kind", trace.FORMATS)
def test_failing(kind: str, tmp_path: Path) -> None:
    compare(HERE / "renders" / f"failing.{SUFFIX[kind]}", trace.render(broken(tmp_path).matrix(), kind))


def test_colour_is_an_option(tmp_path: Path) -> None:
    matrix = broken(tmp_path).matrix()
    assert "\033[" not in trace.render(matrix)
    assert "\033[1;31mFAIL\033[0m" in trace.render(matrix, colour=True)


def test_an_unknown_format_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown format 'pdf'"):
        trace.render(Small().matrix(), "pdf")


def test_one_verdict_everywhere(tmp_path: Path) -> None:
    """Three matrices, each with its verdict in the same words in every format and on the page of an assessment."""
    small = Small().matrix()
    matrices = {
        PASS: replace(small, rows=(), findings=(), unreviewed=()),
        RESERVED: small,
        FAIL: broken(tmp_path).matrix(),
    }
    for word, matrix in matrices.items():
        summary = json.loads(trace.render(matrix, "json"))
        assert summary["verdict"] == word
        assert bool(summary["reservations"]) or word != RESERVED
        assert json.loads(trace.render(matrix, "sarif"))["runs"][0]["properties"]["verdict"] == word
        page = write_report(tmp_path / word, [], "matrix.html", summary, summary["findings"], {}, {})
        said = {
            "text": f"\n{word.upper()}: ",
            "md": f"\n**{word.upper()}** on ",
            "html": f"<strong>{SIGNS[word]} {word.upper()}</strong>",
            "github": f"title=traceability::{word}: ",
        }
        for kind, words in said.items():
            assert words in trace.render(matrix, kind), kind
        assert f"<b>{SIGNS[word]} {word.upper()}</b>" in page.read_text("utf-8")
        assert bool(trace.gate(matrix)) == (word == FAIL)


def test_json_keeps_to_its_schema(tmp_path: Path) -> None:
    folder = Path(trace.__file__).parent / "render"
    schema = json.loads((folder / "matrix.schema.json").read_text(encoding="utf-8"))
    Draft202012Validator.check_schema(schema)
    # Projects have links that the small one has none of: constraints, works, indicators, malfunctions.
    assert set(schema["properties"]["links"]["items"]["properties"]["kind"]["enum"]) == set(LINKS)
    for small in (Small(), broken(tmp_path)):
        data = json.loads(trace.render(small.matrix(), "json"))
        assert [error.message for error in Draft202012Validator(schema).iter_errors(data)] == []


def test_html_is_self_contained(tmp_path: Path) -> None:
    page = trace.render(broken(tmp_path).matrix(), "html")
    for outside in ("http:", "https:", "src=", "<link", "@import", "url(", "fetch(", "import("):
        assert outside not in page, outside
    assert re.findall(r"<script[^>]*>", page) == [
        '<script type="application/json" id="walk-data">',
        "<script>",
    ]
    assert "<b>of the tyres</b>" not in page  # titles are text
    for word in ("covered", "missing", "failed", "stale", "waived", "partial"):
        assert word in page
    assert 'name="viewport"' in page
    assert "prefers-color-scheme: dark" in page


def test_spreadsheets_get_no_formulas(tmp_path: Path) -> None:
    import csv

    for row in csv.reader(trace.render(broken(tmp_path).matrix(), "csv").splitlines()):
        assert not any(value[:1] in ("=", "+", "-", "@") for value in row)


def test_findings_of_other_rooms_are_passed_on() -> None:
    """What the caller found, such as errors of specs, fails the gate and shows in every format."""
    items, tests, results, runs = Small().parts()
    place = trace.Place("specs/rules.spec", 3, 1)
    other = trace.Finding("E219", "error", "there is no rule `frictoin`", place, "did you mean `friction`?")
    matrix = trace.build(HERE / "project", items, tests, results, runs, TODAY, findings=[other])
    assert trace.gate(matrix) == [other]
    for kind in set(trace.FORMATS) - {"csv"}:
        assert "E219" in trace.render(matrix, kind), kind


def test_markdown_shows_a_title_as_it_is() -> None:
    """References to characters became these, what stands between two tildes was struck through, and between two dollars set as a formula."""
    assert escaped("&lt;5 m, ~1 m or ~2 m, $x$") == r"\&lt;5 m, \~1 m or \~2 m, \$x\$"
