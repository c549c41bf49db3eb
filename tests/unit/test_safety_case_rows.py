"""Rows of the printed safety case: a short one stands on one page, and nothing of a long one is cut off."""

from __future__ import annotations

import re

import pytest

from trackmarshal.trace.case.model import Code, Document, Line, Section, Table, Written
from trackmarshal.trace.case.typst import fits, source
from trackmarshal.trace.case.words.language import english

DAY = "2026-06-02"


def words(letters: int, word: str) -> Line:
    """At most so many letters of one word again and again."""
    return (Written(" ".join([word] * (letters // (len(word) + 1)))),)


def document(rows: tuple[tuple[Line, ...], ...], widths: tuple[float, ...]) -> Document:
    table = Table(tuple("head" for _ in widths), rows, widths)
    return Document("p", DAY, "fail", (Section("s", "Rows", (table,), "rows"),), (), {}, english())


def most(widths: tuple[float, ...], column: int, word: str) -> tuple[Line, ...]:
    """The longest row that stays on one page, with its text in that column."""
    empty: list[Line] = [() for _ in widths]
    best = tuple(empty)
    for letters in range(100, 4000, 50):
        row = tuple(words(letters, word) if at == column else cell for at, cell in enumerate(empty))
        if not fits(row, widths):
            return best
        best = row
    raise AssertionError("every row is said to fit on a page")


@pytest.mark.parametrize("word", ["M", "WM", "mimmo", "assumption", "Zusammenhänge"])
@pytest.mark.parametrize("widths", [(1.0,), (1.0, 3.0, 2.0), (1.0,) * 7, (3.0, *(1.0,) * 9)])
def test_the_longest_row_kept_whole_is_shorter_than_a_page(word: str, widths: tuple[float, ...]) -> None:
    """As Typst sets it: free to break where a page ends, it does not."""
    typst = pytest.importorskip("typst", reason="sets the PDF")
    row = most(widths, widths.index(min(widths)), word)
    text = source(document((row,), widths))
    free, swapped = re.subn(r"breakable: not whole", "breakable: true", text)
    assert swapped == 1
    whole = free.partition("#pagebreak()")[0]
    pages = typst.compile(whole.encode(), format="png", ppi=10.0, ignore_system_fonts=True)
    assert not isinstance(pages, list) or len(pages) == 1


def test_a_row_longer_than_a_page_is_broken() -> None:
    typst = pytest.importorskip("typst", reason="sets the PDF")
    long = ((Code("T230"),), words(9000, "assumption"))
    assert not fits(long, (1.0, 1.0))
    whole = source(document((long,), (1.0, 1.0))).partition("#pagebreak()")[0]
    pages = typst.compile(whole.encode(), format="png", ppi=10.0, ignore_system_fonts=True)
    assert isinstance(pages, list)
    assert len(pages) > 1


def test_the_place_of_what_people_wrote_counts() -> None:
    short, far = (Written("a" * 2600),), (Written("a" * 2600, "requirements/" + "b" * 200),)
    assert fits((short,), (1.0,))
    assert not fits((far,), (1.0,))
