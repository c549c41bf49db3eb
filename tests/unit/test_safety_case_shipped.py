"""The safety case of this project: whole, with every rule in its forms, and honest about evidence that is not there."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import pytest

from support.project import command, copy_project
from support.safety_case import DAY, Page, graph_numbers, html


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
