"""The safety case of this project: whole, with every rule in its forms, and honest about evidence that is not there."""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import yaml

from support.project import command, copy_project
from support.safety_case import DAY, NUMBER, Page, corpus, graph_numbers, html, is_place
from support.shared import REPOSITORY
from trackmarshal.trace.case.sections.driven import at_most
from unit.test_safety_case_results import counted, picture, under, words

#: Half a minute for the document of the whole project; every day that of a small one is made in test_safety_case.py.
whole = pytest.mark.acceptance


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_project(tmp_path_factory.mktemp("shipped"))


@pytest.fixture(scope="module")
def page(project: Path) -> Page:
    """Without evidence: nothing was run in the copy."""
    return html(project, expect=1)


@whole
def test_what_was_not_run_is_no_pass(page: Page) -> None:
    assert '<div class="verdict is-failed">' in page.first
    numbers = dict(page.numbers)
    assert numbers["nodes/test/not run"] == numbers["nodes/test/all"] != "0"
    assert numbers["nodes/test/passed"] == "0"


@whole
def test_numbers_are_those_of_the_graph(project: Path, page: Page) -> None:
    known = graph_numbers(project)
    counted = {id_: text for id_, text in page.numbers if id_ in known}
    assert len(counted) > 60
    assert counted == {id_: known[id_] for id_ in counted}


@whole
def test_every_number_is_found_again(project: Path, page: Page) -> None:
    """Those with an id among what the graph, the kept run and the results of the closed loop count; all others in what people or the program wrote."""
    known: dict[str, str] = {}
    _, out, _ = command(project, "trace", "--statistics", "--as-is", "--format", "json", "--day", DAY)
    for table, counts in json.loads(out).items():
        if not isinstance(counts, dict):
            continue
        known |= {
            f"{table}/{of}/{what}": str(number)
            for of, whats in counts.items()
            for what, number in whats.items()
        }
    known |= graph_numbers(project)
    elsewhere = (
        "loop/",
        "drive/",
        "node/run/",
        "tests/",
    )  # counted again in test_safety_case_results.py and test_trace_tools.py
    unknown = [(id_, text) for id_, text in page.numbers if known.get(id_, "0") != text and not id_.startswith(elsewhere)]  # fmt: skip
    assert unknown == []
    # Rules and assumptions are told by `show`, whose numbers other tests hold against the rules; so are ranges of parameters, which stand in both.
    shown = r'<section id="section-(?:rules|assumptions)">.*?</section>'
    told = Page("".join(re.findall(shown, page.html, flags=re.DOTALL)))
    allowed = re.findall(r'<td data-label="allowed">(.*?)</td>', told.html)
    ranges = {text for cell in allowed for text in Page(cell).texts}
    rest = Page(re.sub(shown, "", page.html, flags=re.DOTALL))
    said = corpus(project, rest, rules=False)
    stray = [
        text
        for text in rest.texts
        if NUMBER.search(text) and text not in said and text not in ranges and not is_place(project, text)
    ]
    assert stray == [], "\n".join(stray)


@whole
def test_links_lead_to_places(page: Page) -> None:
    assert all(count == 1 for count in Counter(page.ids).values())
    assert {target.removeprefix("#") for target in page.targets} <= set(page.ids)


@whole
def test_every_rule_stands_in_its_forms(page: Page) -> None:
    parts = re.split(r'<div class="part level-3" id="rule-', page.html)[1:]
    assert str(len(parts)) == dict(page.numbers)["nodes/rule/all"]
    for part in parts:
        name = part.partition('"')[0]
        assert "<pre>rule " in part, name
        assert "<math" in part, name
        for title in ("In words", "Tests"):
            assert f"<h3>{title}</h3>" in part, (name, title)


@pytest.mark.acceptance  # some 200 pages; every day a small one is set in test_safety_case.py
def test_the_source_of_the_pdf_is_set(project: Path) -> None:
    html(project, "--format", "both", expect=1)
    pytest.importorskip("typst", reason="sets the PDF")
    assert (project / "out" / "case" / "safety-case.pdf").read_bytes().startswith(b"%PDF-")


# Results: every number is counted again from the evidence.


@whole
def test_numbers_of_the_closed_loop_are_those_of_its_results(page: Page) -> None:
    kept = json.loads((REPOSITORY / "tests/closed_loop/results.json").read_text("utf-8"))
    assert under(page, "loop/") == counted(kept["runs"])
    svg = picture(page, "What became of the car")
    marks = {
        "drives_on": "D", "resumed": "R", "stopped": "S", "off_road": "O", "contact": "C",
    }  # fmt: skip
    cells = Counter(f"{marks[run['outcome']]} {run['speed']:.0f}" for run in kept["runs"])
    drawn = Counter(word for word in words(svg) if re.fullmatch(r"[A-Z] \d+", word))
    assert drawn == cells
    told = svg.partition("<desc>")[2].partition("</desc>")[0]
    for run in kept["runs"]:
        assert (
            f"{run['fault']}, {run['track']}, {'with others' if run['traffic'] else 'alone'}, {run['speed']:.1f} m/s: "
            in told
        )


@whole
def test_numbers_of_a_drive_are_those_that_were_kept(page: Page) -> None:
    (run,) = json.loads((REPOSITORY / "specs/field/lvms.run.json").read_text("utf-8"))["items"]
    drive = run["drive"]
    fired = sum(drive["firings"].values())
    begin = "node/run/specs/field/lvms.yaml/"
    assert under(page, begin) == {
        f"{begin}cycles": str(run["cycles"]), f"{begin}hours": f"{drive['hours']:.4g}", f"{begin}km": f"{drive['km']:.4g}", f"{begin}firings": str(fired),
        **{f"{begin}least {one['rule']} {one['candidate']}": one["shown"] for one in drive["least"]},
    }  # fmt: skip
    begin = "drive/specs/field/lvms.yaml/"
    assert under(page, begin) == {
        f"{begin}per hour": f"{fired / drive['hours']:.4g}", f"{begin}per km": f"{fired / drive['km']:.4g}",
        # Nothing fired, so that of a mean of three nothing is seen once in twenty times.
        f"{begin}at most per hour": f"{-math.log(0.05) / drive['hours']:.4g}", f"{begin}at most per km": f"{-math.log(0.05) / drive['km']:.4g}", f"{begin}confidence": "95",
        **{f"{begin}t {one['rule']} {one['candidate']}": f"{one['t']:.3f}".rstrip("0").rstrip(".") for one in drive["least"]},
    }  # fmt: skip
    # The cycles are a tenth of a second apart, and the drive took as long as they do.
    assert drive["hours"] * 3600 == pytest.approx(run["cycles"] / 10, rel=1e-3)
    for one in drive["least"]:
        number, _, unit = one["shown"].partition(" ")
        factor = 1e-3 if unit == "ms" else 1.0
        assert float(number) * factor == pytest.approx(one["margin"], rel=1e-3, abs=1e-9)


@pytest.mark.parametrize(
    ("events", "most"), [(0, 2.9957), (1, 4.7439), (10, 16.962), (100, 118.08), (2000, 2075.0)]
)
def test_how_much_may_have_been_missed(events: int, most: float) -> None:
    """As tables of the Poisson distribution have it, for 95 %."""
    assert at_most(events, 0.05) == pytest.approx(most, rel=1e-4)


@whole
def test_rules_that_a_drive_says_nothing_of_are_named(page: Page) -> None:
    (run,) = json.loads((REPOSITORY / "specs/field/lvms.run.json").read_text("utf-8"))["items"]
    silent = [
        rule["rule"]
        for rule in run["rules"]
        if all(set(counts) == {"inactive"} for counts in rule["counts"].values())
    ]
    assert silent
    assert re.search(
        r"<dt>nothing to say</dt><dd>"
        + ", ".join(f'<span class="given">{re.escape(rule)}</span>' for rule in silent)
        + "</dd>",
        page.html,
    )


@pytest.fixture(scope="module")
def matrix(project: Path) -> dict[str, Any]:
    _, out, _ = command(project, "trace", "--as-is", "--format", "json", "--day", DAY)
    found: dict[str, Any] = json.loads(out)
    return found


def test_no_assumption_rests_on_the_page_that_says_there_is_none(matrix: dict[str, Any]) -> None:
    """`docs/assumptions.md` says that no assumption names evidence; one named that page, and was covered by it."""
    items = [
        item
        for requirement in matrix["requirements"]
        for stage in requirement["stages"].values()
        for item in stage["items"]
        if item["kind"] == "assumption"
    ]
    assert items
    assert {item["status"] for item in items} == {"partial"}


def test_a_count_of_instructions_is_no_measurement_of_time(matrix: dict[str, Any]) -> None:
    """S-1-B-2 is about time on the target, of which `docs/embedded.md` says that it has none."""
    asked = [
        found for found in matrix["findings"] if found["code"] == "T255" and "`S-1-B-2`" in found["message"]
    ]
    assert ["by measurement" in found["message"] for found in asked] == [True]


def test_goals_whose_interval_is_over_before_an_answer_are_named_as_open() -> None:
    """What a safe cycle approves is driven until `oldest` and `longest_gap` after its stamp. The safety concept counted from its arrival, and nothing was open."""
    limits = re.findall(
        r"^param (?:oldest|longest_gap) *: s = ([\d.]+) s",
        (REPOSITORY / "specs/supervisor/limits.spec").read_text("utf-8"),
        re.M,
    )
    answered = sum(map(float, limits)) * 1000
    assert answered == 250
    goals = re.findall(
        r"id: (SG-\d).*?tolerance: (\d+) ms",
        (REPOSITORY / "requirements/hazards.yaml").read_text("utf-8"),
        re.S,
    )
    short = [goal for goal, interval in goals if float(interval) < answered]
    said = (REPOSITORY / "requirements/assurance.yaml").read_text("utf-8").split("id: AN-2")[1]
    assert short == re.findall(r"SG-\d", said.split("open:")[1])


def test_no_issue_of_the_system_model_is_left_out_of_the_hazard_analysis() -> None:
    """Issues of what is no more than fairness apart: what may go wrong on the way of data, or when a fallback is taken up, led to no hazard.
    And what answers for a sign that is not recognised served no goal of the hazard that arises from it."""
    hazards, model, criteria = (
        yaml.safe_load((REPOSITORY / "requirements" / name).read_text("utf-8"))
        for name in ("hazards.yaml", "system-model.yaml", "s-1-a.yaml")
    )
    leads_to = {
        issue["id"]: issue["leads_to"] for at in model["interfaces"] for issue in at.get("issues", ())
    }
    arising = {issue for hazard in hazards["hazards"] for issue in hazard["arises_from"]}
    left_out = set(leads_to) - arising
    assert {answer[:3] for issue in left_out for answer in leads_to[issue]} == {"CR-"}
    (perception,) = (each for each in criteria["requirements"] if each["id"] == "S-1-A-1")
    (people,) = (hazard["id"] for hazard in hazards["hazards"] if "AV-TI.1" in hazard["arises_from"])
    (goal,) = (each["id"] for each in hazards["safety_goals"] if people in each["prevents"])
    assert leads_to["AV-TI.1"] == ["S-1-A-1"]
    assert goal in perception["achieves"]
