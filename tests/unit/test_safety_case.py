"""The safety case as a document: every number is one of the graph, what is wrong stands first, nothing that an author wrote is markup."""

from __future__ import annotations

import re
import shutil
import string
from collections import Counter
from pathlib import Path

import pytest
import yaml

from support.project import command, run_command
from support.safety_case import DAY, NUMBER, Page, edit, graph_numbers, html, made_ready
from trackmarshal.cli.assessment import assess
from trackmarshal.meaning.tool import tool
from trackmarshal.trace.case import words
from trackmarshal.trace.case.content import NAMES


@pytest.fixture(scope="module")
def ready(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_ready(tmp_path_factory.mktemp("ready"))


@pytest.fixture
def warehouse(ready: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(ready, tmp_path / "warehouse"))


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
    room = Path(words.__file__).parent
    source = "".join(
        path.read_text("utf-8")
        for path in room.rglob("*")
        if path.suffix in (".py", ".j2") and path.name != "words.py"
    )
    made = (
        "lacking.",
        "status.",
        "level.",
        "expect.",
        "fired.",
        "review.",
        "clause.",
        "label.tests_",
        "open.",
    )  # of names of the graph
    unused = [
        n
        for n in words.ENGLISH
        if f'"{n}"' not in source and not n.startswith(made) and not n.endswith(".title")
    ]
    assert unused == []


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
    top = page.html.partition('id="module-G-Top"')[2].partition("</h3>")[0]
    assert "not supported" in top
    assert "not supported" not in before.html.partition('id="module-G-Top"')[2].partition("</h3>")[0]


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
