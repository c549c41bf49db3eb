"""The safety case of this project: whole, with every rule in its forms, and honest about evidence that is not there."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from support.project import command, copy_project
from support.safety_case import DAY, NUMBER, Page, corpus, graph_numbers, html, is_place


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return copy_project(tmp_path_factory.mktemp("shipped"))


@pytest.fixture(scope="module")
def page(project: Path) -> Page:
    """Without evidence: nothing was run in the copy."""
    return html(project, expect=1)


def test_what_was_not_run_is_no_pass(page: Page) -> None:
    assert '<div class="verdict is-failed">' in page.first
    numbers = dict(page.numbers)
    assert numbers["nodes/test/not run"] == numbers["nodes/test/all"] != "0"
    assert numbers["nodes/test/passed"] == "0"


def test_numbers_are_those_of_the_graph(project: Path, page: Page) -> None:
    known = graph_numbers(project)
    counted = {id_: text for id_, text in page.numbers if id_ in known}
    assert len(counted) > 60
    assert counted == {id_: known[id_] for id_ in counted}


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
    # Rules and assumptions are told by `show`, whose numbers other tests hold against the rules.
    rest = Page(
        re.sub(r'<section id="section-(rules|assumptions)">.*?</section>', "", page.html, flags=re.DOTALL)
    )
    said = corpus(project, rest, rules=False)
    stray = [
        text
        for text in rest.texts
        if NUMBER.search(text) and text not in said and not is_place(project, text)
    ]
    assert stray == [], "\n".join(stray)


def test_links_lead_to_places(page: Page) -> None:
    assert all(count == 1 for count in Counter(page.ids).values())
    assert {target.removeprefix("#") for target in page.targets} <= set(page.ids)


def test_every_rule_stands_in_its_forms(page: Page) -> None:
    parts = re.split(r'<div class="part level-3" id="rule-', page.html)[1:]
    assert str(len(parts)) == dict(page.numbers)["nodes/rule/all"]
    for part in parts:
        name = part.partition('"')[0]
        assert "<pre>rule " in part, name
        assert "<math" in part, name
        for title in ("In words", "Tests"):
            assert f"<h4>{title}</h4>" in part, (name, title)


def test_the_source_of_the_pdf_is_set(project: Path) -> None:
    pytest.importorskip("typst", reason="sets the PDF")
    status, _, err = command(project, "case", "--out", str(project / "out"), "--day", DAY, "--format", "pdf")
    assert status == 1, err
    assert (project / "out" / "safety-case.pdf").read_bytes().startswith(b"%PDF-")
