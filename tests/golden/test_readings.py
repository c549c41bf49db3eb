"""All shipped rules as readers are shown them: formulas on a terminal, and in words. `TRACKMARSHAL_UPDATE_GOLDEN=1` writes both files anew."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.supervised import everything
from trackmarshal.reading.rule import read
from trackmarshal.reading.sheet import Sheet
from trackmarshal.reading.telling import tell
from trackmarshal.reading.text import lines
from trackmarshal.reading.words.english import ENGLISH

GOLDEN = Path(__file__).parent
ROOT = GOLDEN.parents[1]
UPDATE = os.environ.get("TRACKMARSHAL_UPDATE_GOLDEN") == "1"


def sheets(form: str) -> Iterator[str]:
    for rule in everything().rules:
        if rule.typed is None:
            continue
        reading = read(rule, everything()) if form == "formulas" else None
        told = tell(rule, everything(), ENGLISH) if form == "english" else None
        yield "\n".join(
            [
                f"# {rule.name}: {rule.title}",
                *lines(Sheet(rule, ENGLISH, None, reading, told, None, ()), True),
            ]
        )


@pytest.mark.parametrize("form", ["formulas", "english"])
def test_shipped_rules(form: str) -> None:
    made = re.sub(
        r"\.spec:\d+:\d+", ".spec", "\n\n".join(sheets(form)) + "\n"
    )  # where a parameter stands in its file says nothing here
    path = GOLDEN / "reading" / f"{form}.txt"
    if UPDATE:
        path.write_text(made, "utf-8", newline="\n")
    assert made == path.read_text("utf-8")


def test_sentences_are_sentences() -> None:
    """Each begins with a capital letter or with what an author named, ends, has no sign in it that nobody would say, and no place left open."""
    for rule in everything().rules:
        if rule.typed is not None:
            told = tell(rule, everything(), ENGLISH)
            for said in (*told.demand, *told.definitions):
                assert re.match(r"[A-Z“]|[a-z]+_", said), said
                assert said.endswith("."), said
                assert not re.search(r"[{}=<>≤≥∧∨¬∀∃|]|  ", said), said
