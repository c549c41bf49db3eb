"""The safety case as a document: every number is one of the graph, what is wrong stands first, nothing that an author wrote is markup."""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
from collections import Counter
from dataclasses import replace
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import pytest
import yaml

from support.project import command, run_command
from support.safety_case import DAY, NUMBER, Page, corpus, edit, graph_numbers, html, is_place
from trackmarshal import trace
from trackmarshal.cli import assessment
from trackmarshal.records.runs import DriveFacts, LeastMargin, RuleFacts, RunSummary, TruthFacts
from trackmarshal.trace.case.content import NAMES
from trackmarshal.trace.case.templates import unused


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
    stray = [
        text
        for text in page.texts
        if NUMBER.search(text) and text not in said and not is_place(warehouse, text)
    ]
    assert stray == [], "\n".join(stray)


def test_a_report_that_was_not_read_is_not_one_without_tests(warehouse: Path) -> None:
    assert "There are none that name a requirement." in html(warehouse).html
    model = warehouse / "requirements" / "v-model.yaml"
    text = model.read_text("utf-8")
    stage = yaml.safe_load(text)["stages"][-1]["id"]
    said = f"  junit: [{{path: out/robot.xml, stage: {stage}, if_there: true}}]\nstages:\n"
    model.write_text(text.replace("stages:\n", said, 1), "utf-8")
    page = html(warehouse).html
    assert "There are none that name a requirement." not in page
    assert "nothing is known here: " in page


def test_an_accepted_baseline_is_named_however_its_path_is_written(warehouse: Path) -> None:
    edit(warehouse, "requirements/v-model.yaml", "baseline: requirements/", "baseline: ./requirements/")
    sha = hashlib.sha256((warehouse / "requirements" / "baseline.json").read_bytes()).hexdigest()
    assert re.search(rf"accepted baseline, sha</dt><dd><code>{sha}</code>", html(warehouse).first)


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
    assert not re.search(r"url\((?!#)", page.html)


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
    assert top(page) == "not supported"
    assert top(before) == "supported"


def top(page: Page) -> str:
    """What the argument's top goal has come to."""
    title = page.html.partition('id="module-G-Top"')[2].partition("</h2>")[0]
    (status,) = re.findall(r"</span> ([a-z ]+)</span>", title)
    return str(status)


def test_stale_evidence_is_on_the_first_page_and_in_the_status(warehouse: Path) -> None:
    edit(warehouse, "specs/robot.spec", "require   robot.v <= 0.3 m/s", "require   robot.v <= 0.4 m/s")
    page = html(warehouse, expect=1)
    assert '<div class="verdict is-failed">' in page.first
    assert re.search(r"<code>slow_near_people: too fast</code>.*?is-stale", page.first, re.DOTALL)
    assert top(page) == "not supported"


def with_run(project: Path, monkeypatch: pytest.MonkeyPatch, expect: str = "no_fire", **came: Any) -> None:
    """As if a recording had been replayed that is evidence for all; it is stale as soon as the file changes. came: what else it came to."""
    recording = project / "drive.tmrec.jsonl"
    recording.write_text("{}", "utf-8")
    digest = hashlib.sha256(recording.read_bytes()).hexdigest()
    model = project / "requirements/v-model.yaml"
    plain = model.read_text("utf-8")
    scenario = f"  scenarios: [{{path: drive.tmrec.jsonl, stage: TST-1, expect: {expect}, origin: field}}]\n"
    text = plain.replace("counts: [test]", "counts: [test, run]").replace("  specs: [specs]\n", f"  specs: [specs]\n{scenario}")  # fmt: skip
    real = assessment.assess
    facts = real(project, run=False).facts
    model.write_text(text, "utf-8")
    trace.accept_baseline(
        project, facts.items, facts.tests, parts=facts.parts, by="Maria Motor", reason="a drive"
    )

    def made(root: Path, **how: Any) -> Any:
        model.write_text(plain, "utf-8")  # the recording is none that the engine would read
        found = real(root, **how)
        model.write_text(text, "utf-8")
        items = found.facts.items
        counts = {candidate: {"satisfied": 3} for candidate in ("driving", "emergency")}
        inputs = {f"rule {item.name}": item.fingerprint for item in items}
        found.facts = replace(found.facts, run_inputs={"drive.tmrec.jsonl": inputs})
        ran = tuple(RuleFacts(item.name, item.fingerprint, counts) for item in items)
        found.project, _ = trace.load(root)
        run = RunSummary("drive.tmrec.jsonl", digest, "s", 3, ran, {}, False, "now", inputs=inputs)
        found.runs = [replace(run, **came)]
        return found

    monkeypatch.setattr(assessment, "assess", made)


def test_a_stale_run_is_on_the_first_page_in_the_argument_and_in_the_status(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_run(warehouse, monkeypatch)
    before = html(warehouse, expect=0)
    assert top(before) == "supported"
    stale = re.compile(r'<code>drive.tmrec.jsonl</code></td><td[^>]*><span class="chip is-stale')
    assert not stale.search(before.first)
    (warehouse / "drive.tmrec.jsonl").write_text('{"another": "drive"}', "utf-8")
    page = html(warehouse, expect=1)
    assert '<div class="verdict is-failed">' in page.first
    assert stale.search(page.first)
    assert top(page) == "not supported"


@pytest.mark.parametrize(
    ("expect", "came", "outcome"),
    [
        ("ground_truth", {"ground_truth": {"static": TruthFacts(True, (), ())}}, "✓ run"),
        ("ground_truth", {"ground_truth": {"static": TruthFacts(False, ("rated safe at 2 s",), ())}}, "✗ failed"),
        ("ground_truth", {"ground_truth": {"static": TruthFacts(True, (), ())}, "fired": True, "unexpected": (1.25,)}, "✗ failed"),
        ("no_fire", {}, "✓ run"),
        ("no_fire", {"fired": True, "drive": DriveFacts(4.0, 20.0, {}, ())}, "✗ failed"),
        ("fire", {"fired": True}, "✓ run"),
        ("fire", {}, "✗ failed"),
    ],
)  # fmt: skip
def test_a_run_that_is_not_as_it_is_to_be_has_failed(
    expect: str, came: dict[str, Any], outcome: str, warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """That it was made was all that its outcome said, with the sign of what passed."""
    with_run(warehouse, monkeypatch, expect, **came)
    said = re.findall(r"<dt>outcome</dt><dd>(.*?)</dd>", html(warehouse).html)
    assert {re.sub(r"<[^>]*>", "", one) for one in said} == {outcome}


def test_what_no_ground_truth_judges_stands_with_what_is_inside(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The matrix calls the run failed, and its part said no more than that all verdicts are inside."""
    came = {"fired": True, "unexpected": (1.25, 1.5), "uncovered": ("gentle",)}
    truth = {"rule slow_near_people": TruthFacts(True, (), ("slow_near_people",))}
    with_run(warehouse, monkeypatch, "ground_truth", ground_truth=truth, **came)
    page = html(warehouse, expect=1)
    assert ("unexpected/drive.tmrec.jsonl", "1.25") in page.numbers
    said = re.sub(r"<[^>]*>", "", re.findall(r"<dt>ground truth</dt><dd>(.*?)</dd>", page.html)[0])
    assert "all verdicts inside" in said
    assert "failed: unsafe at 1.25 s, of which no ground truth says what to expect" in said
    assert said.endswith("of gentle none is declared")


def test_numbers_of_a_drive_say_whether_they_are_stale_and_when_they_were(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After four hours, a moment to four digits is one of ten seconds."""
    least = (LeastMargin("gentle", "driving", 0.25, "0.25 m/s^2", 14321.75),)
    with_run(warehouse, monkeypatch, drive=DriveFacts(4.0, 20.0, {}, least))

    def told() -> tuple[Page, str]:
        page = html(warehouse)
        begin = page.html.index(">Drives of real vehicles</h")
        return page, page.html[begin : page.html.index(">Faults put in</h")]

    page, said = told()
    assert ("drive/drive.tmrec.jsonl/t gentle driving", "14321.75") in page.numbers
    assert "stale" not in said
    (warehouse / "drive.tmrec.jsonl").write_text('{"another": "drive"}', "utf-8")
    assert '<span class="chip is-stale' in told()[1]


def test_an_expired_waiver_is_on_the_first_page_in_the_argument_and_in_the_status(warehouse: Path) -> None:
    spec = (warehouse / "specs/robot.spec").read_text("utf-8")
    tests = re.findall(r"^test .*?(?=^\S|\Z)", spec, re.DOTALL | re.MULTILINE)
    for one in tests:
        if "gentle" in one:
            spec = spec.replace(one, "")
    (warehouse / "specs/robot.spec").write_text(spec, "utf-8")
    waiver = (
        "waivers:\n  - {id: W-1, stages: [TST-1], requirements: [SYS-2, SW-2], justification: later, residual_risk: small,\n"
        "     owner: Maria Motor, approver: Rolf Reader, granted: 2026-01-01, expires: 2026-06-01}\n"
    )
    with (warehouse / "requirements/v-model.yaml").open("a", encoding="utf-8") as file:
        file.write(waiver)
    command(warehouse, "trace", "--accept-baseline", "--by", "Maria Motor", "--reason", "later", "--quiet")
    held, page = html(warehouse, "--day", "2026-06-01"), html(warehouse, expect=1)
    assert "expired on 2026-06-01" in page.first
    assert "does not hold" in page.first
    assert "expired" not in held.first
    assert (top(held), top(page)) == ("with reservations", "not supported")


@pytest.mark.parametrize(("last", "named", "status"), [(-10, False, 1), (-10, True, 0), (+10, False, 0)])
def test_a_waiver_that_expired_since_the_commit_is_in_the_status(
    last: int, named: bool, status: int, warehouse: Path
) -> None:
    """The document is as of the commit, when the waiver held; whoever makes it today learns that it holds no longer, unless a day was asked for."""
    today = date.today()
    committed, expires = today - timedelta(days=30), today + timedelta(days=last)
    with (warehouse / "requirements/v-model.yaml").open("a", encoding="utf-8") as file:
        file.write(
            "waivers:\n  - {id: W-1, stages: [TST-1], requirements: [SYS-2], justification: later, residual_risk: small,\n"
            f"     owner: Maria Motor, approver: Rolf Reader, granted: {today - timedelta(days=60)}, expires: {expires}}}\n"
        )
    who = ("--by", "Rolf Reader", "--reason", "for a while")
    assert command(warehouse, "trace", "--accept-baseline", *who, "--day", committed.isoformat())[0] == 0
    at = {**os.environ, "GIT_COMMITTER_DATE": f"{committed}T12:00:00+00:00"}
    git = [
        "git",
        "-c",
        "user.name=n",
        "-c",
        "user.email=e",
        "-c",
        "commit.gpgsign=false",
        "-C",
        str(warehouse),
    ]
    for given in (["init", "-q"], ["add", "-A"], ["commit", "-qm", "first"]):
        subprocess.run([*git, *given], check=True, capture_output=True, env=at)
    more = ("--day", committed.isoformat()) if named else ()
    out = warehouse / "out" / "case"
    found, _, err = command(warehouse, "case", "--format", "html", "--out", str(out), *more)
    assert found == status, err
    page = (out / "safety-case.html").read_text("utf-8")
    assert committed.isoformat() in page
    assert "does not hold" not in page
    assert (f"the waiver `W-1` expired on {expires}, after the commit" in err) is (status == 1)


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
    (own / "hazards.html.j2").rename(own / "hazard.html.j2")
    status, _, err = command(warehouse, "case", "--out", str(own), "--format", "html")
    assert (status, "error[T439]: the template `hazard.html.j2` is used by nothing" in err) == (2, True)


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("hazard.html.j2", "hazards.html.j2"),
        ("people.j2", "people.typ.j2"),
        ("styles.css", "style.css"),
        ("common.html.j2", ""),
    ],
)
def test_a_template_that_nothing_uses_is_refused(name: str, meant: str, tmp_path: Path) -> None:
    """What is misspelt stood in place of nothing: the document was the same without it."""
    assert not list(unused(tmp_path, NAMES))
    (tmp_path / name).write_text("ours", "utf-8")
    (tmp_path / "safety-case.html").write_text("what came of it", "utf-8")
    ((found, help_),) = unused(tmp_path, NAMES)
    assert found == name
    assert (f"`{meant}`" in help_) if meant else True
    (tmp_path / "hazards.html.j2").write_text(f'{{% include "{name}" %}}', "utf-8")
    assert not list(unused(tmp_path, NAMES))


def test_styles_of_other_pages_below_the_folder_are_left_alone(tmp_path: Path) -> None:
    """Templates may lie in a folder with much else, such as `docs`."""
    (tmp_path / "hazards.html.j2").write_text("ours", "utf-8")
    (tmp_path / "_static").mkdir()
    (tmp_path / "_static" / "site.css").write_text("body {}", "utf-8")
    assert not list(unused(tmp_path, NAMES))


PAGE = Path(__file__).parents[2] / "docs" / "safety-case.md"


def test_the_page_about_it_says_what_is_so(warehouse: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The commands of docs/safety-case.md run, its template is used, its names are those of the sections."""
    page = PAGE.read_text("utf-8")
    (block,) = re.findall(r"```sh\n(.*?)```", page, re.DOTALL)
    commands = [line.split()[1:] for line in block.splitlines()]
    assert len(commands) == 4
    monkeypatch.chdir(warehouse)
    for arguments in commands:
        status, _, err = run_command(*arguments)
        assert status == 0, err
    assert (warehouse / "out/case/safety-case.html").is_file()
    assert '<html lang="de">' in (warehouse / "out/case/de/safety-case.html").read_text("utf-8")
    (template,) = re.findall(r"```jinja\n(.*?)```", page, re.DOTALL)
    (warehouse / "own").mkdir()
    (warehouse / "own" / "hazards.html.j2").write_text(template, "utf-8")
    assert (
        "Whoever drives on another track rates exposure anew."
        in html(warehouse, "--templates", str(warehouse / "own")).texts
    )
    (row,) = [line for line in page.splitlines() if "one section, by its name" in line]
    assert tuple(re.findall(r"`(\w+)`", row)) == NAMES
