"""A run's page in a browser: scrubbing, `#t=`, the numbers at the cursor, printing; nothing said in the console, nothing asked of a network."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from support.browser import Page, browser_page, needs_browser
from support.report_runs import evaluator, overtaking
from trackmarshal.explaining.moments import told_moments
from trackmarshal.scenarios.replay import replay
from trackmarshal.scenarios.run_record import run_record
from trackmarshal.trace.report import write_report

pytestmark = needs_browser
TRUTH = (True,) * 8 + (None,) * 4 + (False,) * 18 + (None,) * 10


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    folder = tmp_path_factory.mktemp("run")
    rules = evaluator(folder)
    found = replay(overtaking(ground_truth={"dynamic": TRUTH}), rules, keep=True)
    record = json.loads(json.dumps({**run_record(found, rules), "told": told_moments(found, rules)}))
    write_report(folder, [record], "matrix.html", {"coverage": {}}, [], {}, {})
    return folder / "runs" / "run.html", record


@pytest.fixture(scope="module")
def page() -> Iterator[Page]:
    with browser_page() as one:
        yield one


def at(page: Page) -> str:
    found: str = page.evaluate('document.querySelector("#stepper output").textContent')
    return found.split(" · ", maxsplit=1)[0]


def cursors(page: Page) -> list[float]:
    """Where the cursors of all plots that are shown stand, as times."""
    found: list[float] = page.evaluate(
        """Array.from(document.querySelectorAll("svg.plot")).filter(p => p.getBoundingClientRect().width).map(p => {
          const c = p.querySelector(".cursor"), d = p.dataset;
          return c.getAttribute("visibility") === "visible" ? +d.t0 + (c.getAttribute("x1") - d.x0) / (d.x1 - d.x0) * (d.t1 - d.t0) : null; })"""
    )
    return found


def settled(page: Page) -> None:
    page.evaluate("new Promise(done => setTimeout(() => done(1), 400))")


@pytest.mark.parametrize(
    ("asked", "shown"), [("1.2", "1.2 s"), ("1.25", "1.2 s"), ("0", "0 s"), ("99", "3.9 s"), ("2e0", "2 s")]
)
def test_a_link_opens_at_its_second(
    page: Page, written: tuple[Path, dict[str, Any]], asked: str, shown: str
) -> None:
    page.open(written[0], f"#t={asked}")
    assert at(page) == shown
    drawn = cursors(page)
    assert len(drawn) >= 3
    assert drawn == pytest.approx([float(shown.split(maxsplit=1)[0])] * len(drawn), abs=1e-3)


def test_what_is_open_makes_nothing_unsafe(
    page: Page, written: tuple[Path, dict[str, Any]], tmp_path: Path
) -> None:
    """It stood among the rules that do, and the legend said so, too."""
    text = written[0].read_text("utf-8")
    opened, count = re.subn(r'"v":"([sviou-]+)"', lambda found: f'"v":"{"o" * len(found[1])}"', text)
    assert count > 0
    changed = tmp_path / "open.html"
    changed.write_text(opened, "utf-8")
    page.open(changed, "#t=2")
    assert page.evaluate('document.querySelector("#stepper output").textContent').endswith("all safe")
    assert "unsafe until" not in text


@pytest.mark.parametrize("fragment", ["", "#margins", "#t=", "#t=never", "#t=1e999", "#t=--3"])
def test_any_other_fragment_is_none_of_ours(
    page: Page, written: tuple[Path, dict[str, Any]], fragment: str
) -> None:
    page.open(written[0], fragment)
    assert at(page) == "0 s"
    assert page.messages == []


def test_the_slider_moves_every_plot_and_writes_the_second(
    page: Page, written: tuple[Path, dict[str, Any]]
) -> None:
    page.open(written[0])
    page.evaluate('document.querySelector("#stepper input").focus()')
    for _ in range(3):
        page.key("ArrowRight")
    assert at(page) == "0.3 s"
    assert cursors(page) == pytest.approx([0.3] * len(cursors(page)), abs=1e-3)
    settled(page)
    assert page.evaluate("location.hash") == "#t=0.3"
    page.evaluate('document.querySelector("[data-by=change]").click()')
    assert at(page) == "1 s"  # where the other is too near for the first time
    page.evaluate('location.hash = "#t=2.5"')
    settled(page)
    assert at(page) == "2.5 s"
    page.evaluate("document.querySelector('#score ~ figure .wide svg.plot').scrollIntoView()")
    x, y = page.evaluate(
        """(() => { const p = document.querySelector("#score ~ figure .wide svg.plot"), b = p.getBoundingClientRect(), d = p.dataset;
        const x = +d.x0 + (1.55 - d.t0) / (d.t1 - d.t0) * (d.x1 - d.x0);
        return [b.left + x * b.width / p.viewBox.baseVal.width, b.top + 30]; })()"""
    )
    page.click(x, y)
    assert at(page) == "1.5 s"


def test_numbers_at_the_cursor_are_those_of_the_record(
    page: Page, written: tuple[Path, dict[str, Any]]
) -> None:
    path, record = written
    page.open(path)
    page.evaluate('document.getElementById("cursor").open = true')
    cards = 'Array.from(document.querySelectorAll("#cursor section")).map(s => Array.from(s.querySelectorAll("h4, p, li")).map(e => e.textContent))'
    for number in (10, 20, 30):
        page.evaluate(f'location.hash = "#t={record["t"][number]}"')
        settled(page)
        shown = {card[0].split(" ")[0]: card[1:] for card in page.evaluate(cards)[1:]}
        told = {
            entry["rule"]: [line.strip() for line in entry["cycles"][str(number)]]
            for entry in record["told"]
            if str(number) in entry["cycles"]
        }
        assert told["near"]
        assert shown == told
    scores = page.evaluate(cards)[0]
    assert any(line.startswith("R-2: violated, ") and "by near" in line for line in scores)


def test_a_cycle_without_numbers_leads_to_one_that_has_some(
    page: Page, written: tuple[Path, dict[str, Any]]
) -> None:
    page.open(written[0], "#t=0.5")
    page.evaluate('document.getElementById("cursor").open = true')
    settled(page)
    buttons = page.evaluate('Array.from(document.querySelectorAll("#cursor button")).map(b => b.textContent)')
    assert "0.9 s" in buttons  # the last cycle before the rule fires
    page.evaluate(
        'Array.from(document.querySelectorAll("#cursor button")).find(b => b.textContent === "0.9 s").click()'
    )
    assert at(page) == "0.9 s"


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("width", [1400, 390])
def test_nothing_overflows_and_nothing_is_asked_or_said(
    page: Page, written: tuple[Path, dict[str, Any]], width: int, theme: str
) -> None:
    page.size(width, 900)
    page.media(prefers_color_scheme=theme)
    page.open(written[0], "#t=1.5")
    page.evaluate('document.querySelectorAll("details").forEach(d => { d.open = true; })')
    settled(page)
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    wide = """Array.from(document.querySelectorAll("main p, main td, main li, main h3, #cursor h4")).filter(e => {
      const b = e.getBoundingClientRect(); return b.width && b.right > innerWidth + 1; }).map(e => e.textContent.slice(0, 60))"""
    assert page.evaluate(wide) == []
    assert page.messages == []
    assert [url for url in page.requests if not url.startswith("file:")] == []
    assert len(page.requests) == 1
    page.size(1400, 1000)
    page.media()


def test_on_paper_everything_is_open_and_the_slider_is_gone(
    page: Page, written: tuple[Path, dict[str, Any]]
) -> None:
    page.open(written[0])
    shut = 'document.querySelectorAll("main details:not([open])").length'
    before = page.evaluate(shut)
    assert before > 3
    page.evaluate('window.dispatchEvent(new Event("beforeprint"))')
    assert page.evaluate(shut) == 0
    page.media("print")
    assert page.evaluate('getComputedStyle(document.getElementById("stepper")).display') == "none"
    page.media()
    page.evaluate('window.dispatchEvent(new Event("afterprint"))')
    assert page.evaluate(shut) == before
    assert page.pdf().startswith(b"%PDF")
    assert page.messages == []
