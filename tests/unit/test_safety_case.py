"""The safety case as a document: every number is one of the graph, what is wrong stands first, nothing that an author wrote is markup."""

from __future__ import annotations

import json
import re
import shutil
import string
import sys
from collections import Counter
from pathlib import Path

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from support.project import command, run_command
from support.safety_case import NUMBER, Page
from trackmarshal.cli.assessment import assess
from trackmarshal.meaning.tool import tool
from trackmarshal.trace.case import words
from trackmarshal.trace.case.content import NAMES
from trackmarshal.trace.case.typst import string as typst_string

WAREHOUSE = Path(__file__).parents[1] / "golden" / "trace" / "warehouse"
DAY = "2026-06-02"
STRING = re.compile(r'"(?:[^"\\]|\\.)*"', re.DOTALL)


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The warehouse, accepted, with its evidence."""
    project = tmp_path_factory.mktemp("ready") / "warehouse"
    shutil.copytree(WAREHOUSE, project)
    status, _, err = command(
        project, "trace", "--accept-baseline", "--by", "Maria Motor", "--reason", "the first one", "--quiet"
    )
    assert status == 0, err
    return project


@pytest.fixture
def warehouse(ready: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(ready, tmp_path / "warehouse"))


def html(project: Path, *arguments: str, expect: int | None = None) -> Page:
    out = project / "out" / "case"
    status, _, err = command(project, "case", "--out", str(out), "--day", DAY, "--format", "html", *arguments)
    assert expect is None or status == expect, err
    assert status in (0, 1), err
    return Page((out / "safety-case.html").read_text("utf-8"))


def edit(project: Path, file: str, old: str, new: str) -> None:
    path = project / file
    text = path.read_text("utf-8")
    assert text.count(old) == 1, f"{old!r} is {text.count(old)} times in {file}"
    path.write_text(text.replace(old, new), "utf-8")


def graph_numbers(project: Path) -> dict[str, str]:
    """Numbers under the ids of the document, counted here from what `trace --format json` says."""
    _, out, _ = command(project, "trace", "--as-is", "--format", "json", "--day", DAY)
    said = json.loads(out)
    found = Counter[str]()
    for stage, counts in said["coverage"].items():
        for what, number in counts.items():
            found[f"stages/{stage}/{'all' if what == 'of' else what}"] = number
    for finding in said["findings"]:
        found[f"findings/{finding['level']}/all"] += 1
    found["nodes/requirement/all"] = len(said["requirements"])
    for kind, name in (
        ("rule", "rules"),
        ("test", "tests"),
        ("assumption", "assumptions"),
        ("result", "test_results"),
    ):
        found[f"nodes/{kind}/all"] = said["counts"][name]
    found["nodes/test/passed"] = sum(
        1 for link in said["links"] if link["kind"] == "result" and link["source"] == "passed"
    )
    found["nodes/stage/all"] = len(said["stages"])
    return {id_: str(number) for id_, number in found.items()}


def corpus(project: Path, page: Page) -> str:
    """All that the project says, and the program of it: files, matrix, rules for readers."""
    texts = [command(project, "trace", "--as-is", "--format", "json", "--day", DAY)[1]]
    texts += [command(project, "gsn", "--format", "json")[1]]
    texts += [
        path.read_text("utf-8")
        for path in sorted(project.rglob("*"))
        if path.suffix in (".yaml", ".spec", ".json")
    ]
    texts += [
        text for text in page.texts if re.fullmatch(r"[0-9a-f]{40}|[0-9a-f]{64}|trackmarshal \d.*", text)
    ]
    for rule in re.findall(r"^rule (\w+)", "\n".join(texts), re.MULTILINE):
        texts.append(command(project, "show", rule, "--format", "json")[1])
    texts += [f"{test.distance} {test.within}" for test in assess(project, run=False).facts.tests]
    commands = f"trackmarshal trace --gate --rerun trackmarshal case --day {DAY} --out DIR"
    return " ".join("\n".join([*texts, tool(), DAY, commands]).split())


def test_every_number_is_in_the_graph(warehouse: Path) -> None:
    page = html(warehouse)
    known = graph_numbers(warehouse)
    assert len(page.numbers) > 40
    counted = {id_: text for id_, text in page.numbers if id_ in known}
    assert len(counted) > 30
    assert counted == {id_: known[id_] for id_ in counted}
    said = corpus(warehouse, page)
    unknown = [
        id_ for id_, text in page.numbers if id_ not in known and text != "0" and not id_.startswith("nodes/")
    ]
    assert unknown == []
    # Numbers without an id stand in what people or the program wrote, word for word.
    stray = [text for text in page.texts if NUMBER.search(text) and text.replace("\n", " ") not in said]
    assert stray == [], "\n".join(stray)


def test_a_number_that_is_not_so_is_noticed(warehouse: Path) -> None:
    """The check above can fail: it compares what the page says, not what it was made of."""
    page = html(warehouse)
    wrong = Page(re.sub(r'(data-number="stages/TST-1/covered">)\d+', r"\g<1>99", page.html))
    known = graph_numbers(warehouse)
    assert [id_ for id_, text in wrong.numbers if id_ in known and known[id_] != text] == [
        "stages/TST-1/covered"
    ]


def test_every_kind_of_things_is_counted_right(warehouse: Path) -> None:
    page = html(warehouse)
    numbers = dict(page.numbers)
    fields = {"hazard": "hazards", "safety goal": "safety_goals", "person": "persons", "review": "reviews", "design element": "elements",
              "operational design domain": "domains"}  # fmt: skip
    documents = [
        yaml.safe_load(path.read_text("utf-8")) for path in (warehouse / "requirements").glob("*.yaml")
    ]
    for kind, field in fields.items():
        assert numbers[f"nodes/{kind}/all"] == str(sum(len(one.get(field, ())) for one in documents)), kind


def test_words_are_in_one_place_and_without_numbers() -> None:
    for name, text in words.ENGLISH.items():
        assert not NUMBER.search(text), name
        assert all(field is None or field for _, field, _, _ in string.Formatter().parse(text)), name
    assert {f"{name}.title" for name in NAMES} <= words.ENGLISH.keys()


def test_every_link_has_its_place(warehouse: Path) -> None:
    page = html(warehouse)
    assert len(page.targets) > 40
    assert all(count == 1 for count in Counter(page.ids).values())
    assert {target.removeprefix("#") for target in page.targets} <= set(page.ids)
    inside = re.findall(r'<a href="([^"]*)"', "".join(re.findall(r"<svg.*?</svg>", page.html, re.DOTALL)))
    assert {target.removeprefix("#") for target in inside} <= set(page.ids)
    assert not {"script", "link", "img", "iframe"} & page.tags
    assert not re.search(r"(?:src|href)=[\"'](?!#)", page.html)
    assert "@import" not in page.html
    assert "url(" not in page.html


def test_what_people_wrote_is_told_apart_and_nothing_unread_is_called_reviewed(warehouse: Path) -> None:
    page = html(warehouse)
    flat = " ".join(page.html.split())
    assert (
        '<span class="pen">✎ </span>The robot drives into a person who steps out between two shelves.</span>'
        in flat
    )
    assert '<span class="place">requirements/hazards.yaml:6</span>' in flat
    reviewed = re.findall(r'id="requirement-([A-Z]+-[0-9])".*?<dt>review</dt><dd>(.*?)</dd>', flat)
    said = {id_: re.sub(r"<[^>]+>", "", text) for id_, text in reviewed}
    assert said["SYS-1"] == "RV-1 by P-2 on 2026-03-01: accepted"
    assert {said[id_] for id_ in ("SYS-2", "SW-1", "SW-2")} == {"not reviewed"}


def test_a_review_of_another_version_is_none(warehouse: Path) -> None:
    edit(
        warehouse,
        "requirements/needs.yaml",
        "more than 0.3 m/s.\n    rationale: Below",
        "more than 0.4 m/s.\n    rationale: Below",
    )
    page = html(warehouse, expect=1)
    assert "of another version than this" in page.html


def test_a_failed_test_is_on_the_first_page_and_in_the_status(warehouse: Path) -> None:
    before = html(warehouse, expect=0)
    assert '<div class="verdict is-failed">' not in before.first
    edit(warehouse, "specs/robot.spec", "v: 1 m/s, a: 0 m/s^2, person: 1 m, loaded: false }\n  expect violated", "v: 1 m/s, a: 0 m/s^2, person: 1 m, loaded: false }\n  expect satisfied")  # fmt: skip
    command(warehouse, "trace", "--quiet")
    page = html(warehouse, expect=1)
    assert '<div class="verdict is-failed">' in page.first
    assert "too fast" in page.first


def test_stale_evidence_is_on_the_first_page_and_in_the_status(warehouse: Path) -> None:
    edit(warehouse, "specs/robot.spec", "require   robot.v <= 0.3 m/s", "require   robot.v <= 0.4 m/s")
    page = html(warehouse, expect=1)
    assert '<div class="verdict is-failed">' in page.first
    assert re.search(r"<code>slow_near_people: too fast</code>.*?is-stale", page.first, re.DOTALL)


def test_an_expired_waiver_is_on_the_first_page_and_in_the_status(warehouse: Path) -> None:
    waiver = (
        "waivers:\n  - {id: W-1, stages: [TST-1], requirements: [SYS-2], justification: later, residual_risk: small,\n"
        "     owner: Maria Motor, approver: Rolf Reader, granted: 2026-01-01, expires: 2026-06-01}\n"
    )
    with (warehouse / "requirements/v-model.yaml").open("a", encoding="utf-8") as file:
        file.write(waiver)
    page = html(warehouse, expect=1)
    assert "expired on 2026-06-01" in page.first
    assert "does not hold" in page.first


def test_same_inputs_same_bytes(warehouse: Path) -> None:
    pytest.importorskip("typst", reason="sets the PDF")
    made = []
    for name in ("one", "two"):
        command(warehouse, "case", "--out", str(warehouse / name), "--day", DAY, "--quiet")
        made.append(
            [(warehouse / name / file).read_bytes() for file in ("safety-case.html", "safety-case.pdf")]
        )
    assert made[0] == made[1]
    assert made[0][1].startswith(b"%PDF-")


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
    assert inside == "".join(c if c.isprintable() or c in "\n\u200b" else "\ufffd" for c in text)


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


def test_a_section_is_replaced_by_a_template_of_the_project(warehouse: Path) -> None:
    own = warehouse / "own"
    own.mkdir()
    (own / "hazards.html.j2").write_text(
        '{% extends "ours/section.html.j2" %}{% block before %}<p>Our own words on {{ section.title }}.</p>{% endblock %}',
        "utf-8",
    )
    edit(
        warehouse,
        "requirements/v-model.yaml",
        "  specs: [specs]\n",
        "  specs: [specs]\n  case_templates: own\n",
    )
    assert "Our own words on Hazards and safety goals." in html(warehouse).texts
    (own / "hazards.html.j2").write_text("{% block x %}\n{{ nothing.there }}{% endblock %}", "utf-8")
    status, _, err = command(warehouse, "case", "--out", str(own), "--format", "html")
    assert status == 2
    assert "error[T430]: a template of the safety case: 'nothing' is undefined" in err
    (own / "hazards.html.j2").write_text("\n{% for %}", "utf-8")
    status, _, err = command(warehouse, "case", "--out", str(own), "--format", "html")
    assert status == 2
    assert "hazards.html.j2:2" in err
    status, _, err = command(warehouse, "case", "--out", str(own), "--templates", str(warehouse / "nowhere"))
    assert status == 2
    assert "error[T431]" in err


def test_large_rules_and_bare_requirements(warehouse: Path) -> None:
    """A formula of three hundred symbols, a rule that calls forty definitions, five hundred requirements, one without anything."""
    definitions = "\n".join(
        f"define d{n}(x: m/s) = {f'd{n - 1}(x)' if n else 'x'} + {n} m/s" for n in range(40)
    )
    long = " + ".join(f"{n} * robot.v" for n in range(1, 76))
    with (warehouse / "specs/robot.spec").open("a", encoding="utf-8") as file:
        file.write(
            f'\n{definitions}\n\nrule many "Many"\n  satisfies SW-1\n  require d39(robot.v) <= 9 m/s\n'
        )
        file.write(f'\nrule long "Long"\n  satisfies SW-1\n  require {long} <= 1 m/s\n')
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


PAGE = Path(__file__).parents[2] / "docs" / "safety-case.md"


def test_the_page_about_it_says_what_is_so(warehouse: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The commands of docs/safety-case.md run, its template is used, its names are those of the sections."""
    page = PAGE.read_text("utf-8")
    (block,) = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    commands = [line.split()[1:] for line in block.splitlines()]
    assert len(commands) == 3
    monkeypatch.chdir(warehouse)
    for arguments in commands:
        status, _, err = run_command(*arguments)
        assert status == 0, err
    assert (warehouse / "out/case/safety-case.html").is_file()
    (template,) = re.findall(r"```jinja\n(.*?)```", page, re.DOTALL)
    (warehouse / "own").mkdir()
    (warehouse / "own" / "hazards.html.j2").write_text(template, "utf-8")
    assert (
        "Whoever drives on another track rates exposure anew."
        in html(warehouse, "--templates", str(warehouse / "own")).texts
    )
    (row,) = [line for line in page.splitlines() if "one section, by its name" in line]
    assert tuple(re.findall(r"`(\w+)`", row)) == NAMES
