"""Findings for machines: JSON, SARIF 2.1.0 and GitHub's workflow commands."""

from __future__ import annotations

import io
import json
import re
import sys
from pathlib import Path
from typing import Any

import pytest

from trackmarshal.cli.main import main
from trackmarshal.diagnostics import github, sarif
from trackmarshal.diagnostics import json as json_format
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.errors import TrackmarshalError
from trackmarshal.source import SourceFile, Span


class Clash(Diagnostic):
    code = "E999"
    title = "a clash"
    text = "{left} beside {right}"
    label = "a {left}"
    other_label = "a {right}"
    remedy = "mend it"
    explanation = "Two things that do not go together."

    span: Span
    left: str
    right: str
    other: Span | None = None


class Noted(Clash):
    code = "E997"
    level = "note"


FILE = SourceFile("specs/with blank, 100%:.spec", 'rule "速度" r\n  require p.v < 3 m\n')
BOTH = Clash(Span(FILE, 22, 25), "speed", "50 %\nor so", Span(FILE, 5, 9))
PLAIN = TrackmarshalError("D101", "unequal columns", file="data/\udce4.jsonl", line=7, help="look")
BARE = TrackmarshalError("T301", "no project")


def strict(text: str) -> Any:
    def refuse(name: str) -> float:
        raise ValueError(name)

    text.encode("utf-8")
    return json.loads(text, parse_constant=refuse)


def test_json_says_all() -> None:
    first, second, third = strict(json_format.render([BOTH, PLAIN, BARE]))
    assert first == {
        "code": "E999", "level": "error", "message": "speed beside 50 %\nor so", "file": FILE.path, "line": 2, "column": 11,
        "end_line": 2, "end_column": 14, "label": "a speed", "help": "mend it",
        "related": [{"file": FILE.path, "line": 1, "column": 6, "end_line": 1, "end_column": 10, "label": "a 50 %\nor so"}],
    }  # fmt: skip
    assert second == {
        "code": "D101", "level": "error", "message": "unequal columns", "file": "data/?.jsonl", "line": 7, "column": None,
        "end_line": None, "end_column": None, "label": None, "help": "look", "related": [],
    }  # fmt: skip
    assert third["file"] is None
    assert strict(json_format.render([])) == []


def test_sarif_says_all() -> None:
    log = strict(
        sarif.render(
            [PLAIN, BOTH, Noted(BOTH.span, "a", "b"), BOTH, BARE],
            {"D101": ("columns", "They are equally long.")},
        )
    )
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    assert run["columnKind"] == "unicodeCodePoints"
    driver = run["tool"]["driver"]
    assert driver["name"] == "trackmarshal"
    assert driver["version"]
    assert driver["rules"] == [
        {
            "id": "D101",
            "shortDescription": {"text": "columns"},
            "fullDescription": {"text": "They are equally long."},
        },
        {
            "id": "E997",
            "shortDescription": {"text": Clash.title},
            "fullDescription": {"text": Clash.explanation},
        },
        {
            "id": "E999",
            "shortDescription": {"text": Clash.title},
            "fullDescription": {"text": Clash.explanation},
        },
        {"id": "T301"},
    ]
    results = run["results"]
    assert [result["ruleId"] for result in results] == ["D101", "E999", "E997", "E999", "T301"]
    assert all(driver["rules"][result["ruleIndex"]]["id"] == result["ruleId"] for result in results)
    assert [result["level"] for result in results] == ["error", "error", "note", "error", "error"]
    assert results[0]["locations"] == [
        {"physicalLocation": {"artifactLocation": {"uri": "data/%3F.jsonl"}, "region": {"startLine": 7}}}
    ]
    (location,) = results[1]["locations"]
    assert location["physicalLocation"] == {
        "artifactLocation": {"uri": "specs/with%20blank%2C%20100%25%3A.spec"},
        "region": {"startLine": 2, "startColumn": 11, "endLine": 2, "endColumn": 14},
    }
    assert results[1]["message"]["text"] == "speed beside 50 %\nor so\na speed\nhelp: mend it"
    (related,) = results[1]["relatedLocations"]
    assert related["message"] == {"text": "a 50 %\nor so"}
    assert related["physicalLocation"]["region"]["startLine"] == 1
    assert "locations" not in results[4]


def test_sarif_of_nothing_is_a_run_without_results() -> None:
    (run,) = strict(sarif.render([]))["runs"]
    assert run["results"] == []


def test_sarif_names_absolute_files_as_such() -> None:
    log = strict(sarif.render([TrackmarshalError("E001", "gone", file="/a b/c.spec")]))
    location = log["runs"][0]["results"][0]["locations"][0]["physicalLocation"]
    assert location == {"artifactLocation": {"uri": "file:///a%20b/c.spec"}}


def test_github_escapes_what_would_end_a_command() -> None:
    first, second, third = github.render([BOTH, PLAIN, BARE]).splitlines()
    assert first == (
        "::error file=specs/with blank%2C 100%25%3A.spec,line=2,endLine=2,col=11,endColumn=14,title=E999 a clash"
        "::speed beside 50 %25%0Aor so%0Aa speed%0Aspecs/with blank, 100%25:.spec:1: a 50 %25%0Aor so%0Ahelp: mend it"
    )
    assert second == "::error file=data/?.jsonl,line=7,title=D101::unequal columns%0Ahelp: look"
    assert third == "::error title=T301::no project"
    assert github.render([]) == ""


def test_github_gives_no_columns_over_several_lines() -> None:
    line = github.render([Noted(Span(FILE, 0, 30), "a", "b")])
    assert line.startswith("::notice file=")
    assert "line=1,endLine=2,title=" in line


@pytest.mark.parametrize("text", ["a\r\nb", "a\x85b", "::error::x", "%0A"])
def test_github_keeps_one_finding_on_one_line(text: str) -> None:
    out = github.render([TrackmarshalError("E001", text, file=text)])
    assert out.count("\n") == 1
    assert out.count("::") == 2 + text.count("::")


@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "utf-16", "utf-8"])
def test_json_is_utf_8_whatever_the_terminal_has(
    encoding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`\\xf6` is no escape of JSON, and a file in Latin-1 is none either."""
    (tmp_path / "größe.spec").write_text('module m\nrule r "𝔸" require ö < 1\n', "utf-8")
    monkeypatch.chdir(tmp_path)
    found = []
    for one in ("utf-8", encoding):
        out = io.BytesIO()
        monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(out, encoding=one))
        assert main(["check", "größe.spec", "--format", "json"]) == 1
        found.append(json.loads(out.getvalue().decode("utf-8")))
    assert found[0] == found[1]
    assert found[0][0]["file"] == "größe.spec"


@pytest.fixture(scope="module")
def named(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new project whose titles have letters that ASCII lacks; `other` is a stricter edit of its rule."""
    root = tmp_path_factory.mktemp("named") / "project"
    assert main(["init", str(root), "--quiet"]) == 0
    spec = root / "specs" / "speed.spec"
    spec.write_text(re.sub(r"Nobody|exactly", "Größe:", spec.read_text("utf-8")), "utf-8")
    requirements = root / "requirements" / "requirements.yaml"
    requirements.write_text(requirements.read_text("utf-8").replace("title: ", "title: Größe, "), "utf-8")
    run = root / "specs" / "scenarios" / "too_fast.yaml"
    run.write_text(run.read_text("utf-8").replace("name: too_fast", "name: größer"), "utf-8")
    (root / "other").mkdir()
    for path in (root / "specs").glob("*.spec"):
        text = path.read_text("utf-8").replace("p.v <= v_event", "p.v <= 10 m/s")
        (root / "other" / path.name).write_text(text, "utf-8")
    return root


@pytest.mark.parametrize(
    "command",
    [
        ("trace", "--as-is", "--format", "junit"), ("trace", "--as-is", "--format", "html"), ("trace", "--as-is", "--format", "csv"),
        ("trace", "--as-is", "--format", "md"), ("gsn", "--format", "yaml"), ("test", "--format", "junit"), ("show", "speed_limit", "--format", "html"),
        ("show", "speed_limit", "--draw"), ("diff", "specs/speed.spec", "other/speed.spec", "--on", "specs/scenarios/too_fast.yaml", "--format", "md"),
    ],
    ids=" ".join,
)  # fmt: skip
def test_what_becomes_a_file_is_utf_8_whatever_the_terminal_has(
    command: tuple[str, ...], named: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """JUnit's XML and a page say themselves that they are, and whoever reads the others takes it for granted."""
    monkeypatch.chdir(named)
    found = []
    for encoding in ("utf-8", "cp1252"):
        out = io.BytesIO()
        monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(out, encoding=encoding))
        assert main([*command]) in (0, 1)
        found.append(out.getvalue().decode("utf-8"))
    assert found[0] == found[1]
    assert not found[0].isascii()
