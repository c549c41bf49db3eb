"""docs/diff.md: its program runs and prints what the page says, its words are the words."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from trackmarshal import comparing

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "diff.md").read_text("utf-8")


def test_the_page_about_diff(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(ROOT)
    (program,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    (output,) = re.findall(r"```text\n(.*?)```", PAGE, re.DOTALL)
    exec(compile(program, "docs/diff.md", "exec"), {})
    assert capsys.readouterr().out == output


@pytest.mark.parametrize("word", ["EQUAL", "STRICTER", "WEAKER", "MIXED", "NOT_COMPARABLE", "NEW", "GONE"])
def test_every_word_is_explained(word: str) -> None:
    assert f"`{getattr(comparing, word)}`" in PAGE
