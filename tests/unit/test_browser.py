"""The browser that tests of pages drive: a page that is left while it is asked is no fault of what is waited for."""

from __future__ import annotations

from pathlib import Path

import pytest

from support.browser import BrowserError, PageLeft, browser_page, needs_browser

LEAVE = "setTimeout(() => document.querySelector('a').click(), 20)"


@needs_browser
def test_waiting_outlasts_a_page_that_is_left(tmp_path: Path) -> None:
    first = tmp_path / "first.html"
    first.write_text("<a href='second.html'>on</a>", "utf-8")
    (tmp_path / "second.html").write_text("there", "utf-8")
    with browser_page() as page:
        page.open(first)
        with pytest.raises(
            PageLeft
        ):  # by what is asked itself: who is asked a moment later may be the page behind it
            page.evaluate("new Promise(() => document.querySelector('a').click())")
        page.open(first)
        page.evaluate(LEAVE)
        page.until(
            "document.body?.innerText === await new Promise((done) => setTimeout(() => done('there'), 40))"
        )
        with pytest.raises(BrowserError, match="nothing"):
            page.until("nothing.at.all")
