"""Evidence that says that there is none: of which assumption, and where."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.records import SpecItem
from trackmarshal.trace import denials
from trackmarshal.trace.findings import Place

ITEM = SpecItem("assume", "A-SEEN", "t", (), (), "a.spec", 1, 1, "f", evidence="seen.md")


def of(folder: Path, text: str) -> denials.Denials:
    (folder / "seen.md").write_text(text, "utf-8")
    return denials.load(folder, [ITEM])


@pytest.mark.parametrize("said", [
    "There is none here.", "This repository holds\nnone of these.", "No evidence yet.", "no report exists", "TODO", "It is to be written.", "Tbd.",
])  # fmt: skip
def test_what_says_that_there_is_none(said: str, tmp_path: Path) -> None:
    assert list(of(tmp_path, f"# Seen\n\n{said}\n")) == [("seen.md", "A-SEEN")]


@pytest.mark.parametrize("said", [
    "In 40 h none was missed.", "Report 7: 140 ms at most.", "Nonesuch evidence-free wording is not meant.", "They are not to be seen without light.", "",
])  # fmt: skip
def test_what_does_not(said: str, tmp_path: Path) -> None:
    assert of(tmp_path, f"# Seen\n\n{said}\n") == {}


def test_of_what_is_named_its_own_paragraphs_count(tmp_path: Path) -> None:
    """One page may back an assumption and say that another has nothing yet."""
    other = "A-HEARD: there is none.\n"
    assert of(tmp_path, f"A-SEEN: report 7.\n\n{other}") == {}
    found = of(tmp_path, f"{other}\nOf A-SEEN:\nthere is\nnone.\n")
    assert found == {("seen.md", "A-SEEN"): (Place("seen.md", 4, 1), "there is none")}
    assert list(of(tmp_path, "A-SEEN-TOO: report 7.\n\nThere is none.\n")) == [("seen.md", "A-SEEN")]


def test_what_cannot_be_read_says_nothing(tmp_path: Path) -> None:
    (tmp_path / "seen.md").write_bytes(b"\xff\xfeno evidence")
    assert denials.load(tmp_path, [ITEM]) == {}
    (tmp_path / "seen.md").unlink()
    assert denials.load(tmp_path, [ITEM]) == {}
