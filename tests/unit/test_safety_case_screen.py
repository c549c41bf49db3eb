"""The safety case in a headless Chromium: on screens wide and narrow nothing lies beyond the window, and places in files are not broken where there is room."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from support.browser import browser_page, needs_browser
from support.safety_case import edit, html, made_ready

pytestmark = needs_browser
#: What stands in tables as code, is short, and has more than one line.
BROKEN = """[...document.querySelectorAll("td code")].filter((one) => !/\\s/.test(one.textContent) && one.textContent.length < 45
  && one.getClientRects().length > 1).map((one) => one.textContent)"""
BEYOND = "document.documentElement.scrollWidth - document.documentElement.clientWidth"


@pytest.mark.parametrize("language", ["en", "de"])
def test_nothing_lies_beyond_the_window_and_places_stand_on_one_line(tmp_path: Path, language: str) -> None:
    project = made_ready(tmp_path)
    # Findings are long, and beside them are places.
    edit(
        project,
        "specs/robot.spec",
        "require   robot.v <= 0.3 m/s",
        "require   robot.v <= 0.4 m/s",
    )
    page = tmp_path / "page.html"
    page.write_text(html(project, "--words", language).html, "utf-8")
    with browser_page() as browser:
        for wide in (1400, 800, 390):
            browser.size(wide, 1000)
            browser.open(page)
            assert browser.evaluate("document.querySelectorAll('td code').length") > 20
            assert browser.evaluate(BROKEN) == [], wide
            assert browser.evaluate(BEYOND) <= 0, wide
        levels = browser.evaluate(
            "[...document.querySelectorAll('h1, h2, h3, h4, h5')].map((one) => +one.tagName[1])"
        )
        assert [pair for pair in pairwise(levels) if pair[1] > pair[0] + 1] == []
        assert browser.messages == []
