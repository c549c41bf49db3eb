"""What the document of the safety case does with markup in titles, missing extras, long formulas and many requirements."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import markupsafe
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.planted.project import SOURCE
from support.project import command
from support.safety_case import DAY, Page, edit, html
from trackmarshal.trace.case.html import _text as html_text
from trackmarshal.trace.case.typst import string as typst_string

STRING = re.compile(r'"(?:[^"\\]|\\.)*"', re.DOTALL)


def test_a_scenario_of_which_it_is_not_known_what_it_is_to_show(tmp_path: Path) -> None:
    shuttle = Path(shutil.copytree(SOURCE, tmp_path / "shuttle"))
    edit(shuttle, "requirements/v-model.yaml", "stage: S-4-A, expect: ground_truth, ", "stage: S-4-A, expect: ground_thruth, ")  # fmt: skip
    page = html(shuttle, expect=1)
    assert "ground_thruth" in " ".join(page.texts)


NASTY = """<script>alert(1)</script> & "quoted" #eval("1 + 1") $x^2$ \\input{passwd} [link] *bold* `raw` // {{ 7 * 7 }} {% x %} \u202e </style>"""


def test_nothing_that_an_author_wrote_is_markup(warehouse: Path) -> None:
    for file, old in (
        ("requirements/needs.yaml", "title: Nobody is hit"), ("requirements/hazards.yaml", "title: A person is hit"),
        ("requirements/design.yaml", None), ("requirements/hazards.yaml", 'title: the hall'),
    ):  # fmt: skip
        if old is not None:
            edit(warehouse, file, old, f"title: {json.dumps(NASTY)}")
    edit(warehouse, "specs/robot.spec", '"Within 2 m of a person, no more than 0.3 m/s"', json.dumps("<b>#panic()</b> $ \\ ${", ensure_ascii=False).replace("\\\\", "/"))  # fmt: skip
    page = html(warehouse)
    assert "script" not in page.tags
    assert "b" not in page.tags
    assert "<script" not in page.html
    assert any("<script>alert(1)</script>" in text for text in page.texts)
    assert any("{{ 7 * 7 }}" in text for text in page.texts)
    typst = pytest.importorskip("typst", reason="sets the PDF")
    assert typst is not None
    status, _, err = command(
        warehouse, "case", "--out", str(warehouse / "pdf"), "--day", DAY, "--format", "pdf"
    )
    assert status == 1, err
    assert (warehouse / "pdf" / "safety-case.pdf").stat().st_size > 10_000


@given(st.text())
def test_a_text_is_one_string_of_typst(text: str) -> None:
    made = typst_string(text)
    assert STRING.fullmatch(made)
    inside = re.sub(r"\\(.)", lambda match: "\n" if match[1] == "n" else match[1], made[1:-1])
    kept = "\n\t\u00a0\u00ad\u2007\u2009\u200b\u202f"
    assert inside == "".join(c if c.isprintable() or c in kept else "\ufffd" for c in text)


def test_of_a_project_in_which_there_is_nothing_not_all_is_well(tmp_path: Path) -> None:
    (tmp_path / "requirements").mkdir()
    (tmp_path / "specs").mkdir()
    (tmp_path / "specs/bare.spec").write_text("module bare\n\nsignal robot : state { v: m/s }\n", "utf-8")
    (tmp_path / "requirements/v-model.yaml").write_text(
        "document: v-model\ntitle: nothing yet\nproject: {name: bare, specs: [specs], default_spec: specs}\n"
        "stages:\n  - {id: TST-1, title: tests, shows: that they pass, applies_to: ['*'], counts: [test]}\n",
        "utf-8",
    )
    page = html(tmp_path, expect=1)
    assert "Every cell" not in page.html
    assert "All that is expected to be read" not in page.html
    assert {"No stage asks anything of a requirement: there is no cell that could be covered.", "Nothing is declared that is expected to be read."} <= set(page.texts)  # fmt: skip


@pytest.mark.parametrize(
    ("file", "none"),
    [
        ("specs/robot.spec", "There are no rules."),
        ("requirements/hazards.yaml", "No hazards: no requirement comes from a hazard analysis."),
        ("requirements/needs.yaml", "There are no requirements."),
    ],
)  # fmt: skip
def test_of_what_could_not_be_read_it_is_said_that_it_is_missing(
    file: str, none: str, warehouse: Path
) -> None:
    """It is no project without rules, or without hazards, where a typing error keeps them from being read."""
    said = "Not all of this project could be read, as the errors say."
    whole = html(warehouse)
    assert not any(text == none or text.startswith(said) for text in whole.texts)
    (warehouse / file).write_text("] {\n", "utf-8")
    assert command(warehouse, "case", "--out", str(warehouse / "out"), "--format", "html")[0] in (1, 2)
    page = Page((warehouse / "out" / "safety-case.html").read_text("utf-8"))
    assert none in page.texts
    assert any(text.startswith(said) for text in Page(page.first).texts)


def test_blanks_that_people_write_are_no_unknown_letters_on_paper() -> None:
    """A tab in a spec, a number and its unit on one line, a place to break a word."""
    said = "\trequire v <= 80\u00a0km/h, 10\u202f000\u2009m, Fahr\u00addynamik"
    assert typst_string(said) == f'"{said}"'
    typst = pytest.importorskip("typst", reason="sets the PDF")
    source = f"#{typst_string(said)}\n#raw({typst_string(said)}, block: true)"
    assert typst.compile(source.encode(), ignore_system_fonts=True, pdf_standards="a-2b")


@given(st.text())
def test_a_text_is_escaped_as_templates_escape_it(text: str) -> None:
    assert html_text(text) == str(markupsafe.escape(text))


def test_without_typst_the_page_comes_all_the_same(warehouse: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "typst", None)
    status, _, err = command(warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY, "--quiet")
    assert status == 0
    assert "error[T432]: there is no PDF, as typst is not installed" in err
    assert "pip install 'trackmarshal[pdf]'" in err
    assert (warehouse / "out" / "safety-case.html").is_file()
    assert not (warehouse / "out" / "safety-case.pdf").exists()
    status, _, _ = command(
        warehouse, "case", "--out", str(warehouse / "out"), "--day", DAY, "--format", "pdf"
    )
    assert status == 2


def test_without_a_layout_engine_the_argument_comes_in_words(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from trackmarshal.trace.gsn.picture import layout

    monkeypatch.setattr(layout, "PROGRAM", "no-such-engine")
    out = warehouse / "words"
    status, _, err = command(warehouse, "case", "--out", str(out), "--day", DAY, "--format", "html")
    assert status == 0
    assert "T424" in err
    assert "It is not drawn here" in (out / "safety-case.html").read_text("utf-8")


def large_rules(project: Path) -> None:
    """A rule that calls forty definitions, and one with a formula of three hundred symbols."""
    definitions = "\n".join(
        f"define d{n}(x: m/s) = {f'd{n - 1}(x)' if n else 'x'} + {n} m/s" for n in range(40)
    )
    long = " + ".join(f"{n} * robot.v" for n in range(1, 76))
    with (project / "specs/robot.spec").open("a", encoding="utf-8") as file:
        file.write(
            f'\n{definitions}\n\nrule many "Many"\n  satisfies SW-1\n  require d39(robot.v) <= 9 m/s\n'
        )
        file.write(f'\nrule long "Long"\n  satisfies SW-1\n  require {long} <= 1 m/s\n')


@pytest.mark.skipif(shutil.which("pdftotext") is None, reason="pdftotext is not installed")
def test_large_rules_are_whole_on_paper(warehouse: Path) -> None:
    """Every term and every definition is in the text of the PDF, and no line of it is wider than the page."""
    pytest.importorskip("typst", reason="sets the PDF")
    large_rules(warehouse)
    status, _, err = command(
        warehouse, "case", "--out", str(warehouse / "pdf"), "--day", DAY, "--format", "pdf"
    )
    assert status == 1, err
    pdf = warehouse / "pdf" / "safety-case.pdf"
    boxes = subprocess.run(["pdftotext", "-bbox", str(pdf), "-"], check=True, capture_output=True).stdout
    pages = re.findall(rb'<page width="([\d.]+)".*?</page>', boxes, re.DOTALL)
    assert pages
    for page in re.findall(rb"<page .*?</page>", boxes, re.DOTALL):
        wide = float(re.findall(rb'<page width="([\d.]+)"', page)[0])
        assert max((float(x) for x in re.findall(rb'xMax="([\d.]+)"', page)), default=0.0) <= wide - 50
    words = [word.decode() for word in re.findall(rb">([^<>\n]+)</word>", boxes)]
    assert {str(n) for n in range(1, 76)} <= set(words)
    assert {f"d{n}" for n in range(40)} <= {word.partition("(")[0] for word in words}


@pytest.mark.parametrize(
    ("entry", "code", "there"),
    [
        ("{id: EMPTY-1}", "T120", True),
        ("{id: EMPTY-1, title: Nothing else}", "T120", True),
        ("{id: '<b>$x$#eval(1)', title: T, statement: It shall be., rationale: R, status: draft, asil: QM, verification: [test], source: S}", "T124", False),
    ],
)  # fmt: skip
def test_a_requirement_without_anything_and_an_id_that_is_markup(
    warehouse: Path, entry: str, code: str, there: bool
) -> None:
    """Each is said on the first pages; the first is in its chapter all the same, of the other only the message is left, as text."""
    with (warehouse / "requirements/needs.yaml").open("a", encoding="utf-8") as file:
        file.write(f"  - {entry}\n")
    page = html(warehouse, expect=1)
    assert code in page.first
    assert ('id="requirement-EMPTY-1"' in page.html) == there
    assert "b" not in page.tags
    assert there or any("<b>$x$#eval(1)" in text for text in page.texts)
    if there:
        for field in ("asil", "rationale", "source", "statement", "status"):
            assert f"has no <code>{field}</code>" in page.html


@pytest.mark.acceptance  # what takes long
def test_large_rules_and_bare_requirements(warehouse: Path) -> None:
    """A formula of three hundred symbols, a rule that calls forty definitions, five hundred requirements, one without anything."""
    large_rules(warehouse)
    with (warehouse / "requirements/needs.yaml").open("a", encoding="utf-8") as file:
        for number in range(500):
            file.write(
                f"  - {{id: X-{number}, title: T, statement: The robot shall be safe., rationale: R, status: draft, asil: QM, verification: [test], source: S}}\n"
            )
    page = html(warehouse, expect=1)
    assert sum('id="requirement-X-' in line for line in page.html.splitlines()) == 500
    assert "no stage asks anything of it" in page.html or "missing" in page.html
    assert len(page.formulas) > 40
    assert len(re.findall(r'<div class="formula" style="--depth: 1">', page.html)) >= 40


def test_an_argument_of_very_many_modules_is_drawn_in_part_and_named_whole(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from trackmarshal.trace.case.sections import argument

    whole = html(warehouse)
    monkeypatch.setattr(argument, "SHOWN", 1)
    page = html(warehouse)
    modules = {id_ for id_ in whole.ids if id_.startswith("module-")}
    assert len(modules) > 1
    assert page.html.count("<svg") < whole.html.count("<svg")
    assert modules == {id_ for id_ in page.ids if id_.startswith("module-")}
    inside = re.findall(r'<a href="#([^"]*)"', page.html)
    assert set(inside) <= set(page.ids)
