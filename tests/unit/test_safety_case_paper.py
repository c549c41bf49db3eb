"""The PDF of the safety case: no letter is missing in it without a word, and ids stand on one line."""

from __future__ import annotations

import re
import shutil
import subprocess
import unicodedata
from pathlib import Path

import pytest

from support.project import command
from support.safety_case import DAY, edit, html
from support.supervised import everything
from trackmarshal.reading import layout as at
from trackmarshal.reading import typst as formulas
from trackmarshal.reading.data import data
from trackmarshal.reading.rule import read
from trackmarshal.reading.sheet import Sheet
from trackmarshal.reading.words.english import ENGLISH
from trackmarshal.syntax.names import GREEK
from trackmarshal.trace.case import typst as paper

typst = pytest.importorskip("typst", reason="sets the PDF")
ROOT = Path(__file__).resolve().parents[2]
PDFTOTEXT = shutil.which("pdftotext")
needs_text = pytest.mark.skipif(PDFTOTEXT is None, reason="pdftotext is not installed")
#: The setting of the document's own template.
FONT = '#set text(font: "Libertinus Serif")\n'


def pdf(source: str, archive: bool = False) -> bytes:
    """archive: refused where a letter has no glyph."""
    how = {"pdf_standards": "a-2b"} if archive else {}
    made = typst.compile((FONT + source).encode(), ignore_system_fonts=True, **how)
    assert isinstance(made, bytes)
    return made


def said(folder: Path, made: bytes, *how: str) -> str:
    """The text layer, with letters of mathematics as letters."""
    file = folder / "made.pdf"
    file.write_bytes(made)
    assert PDFTOTEXT is not None
    done = subprocess.run([PDFTOTEXT, *how, str(file), "-"], check=True, capture_output=True)
    return unicodedata.normalize("NFKC", done.stdout.decode())


@pytest.fixture(scope="module")
def printed() -> list[dict[str, str]]:
    """All formulas of the shipped rules."""
    spec = everything()
    made = [
        data(Sheet(rule, ENGLISH, None, read(rule, spec), None, None, ()))["formula"]
        for rule in spec.rules if rule.typed is not None
    ]  # fmt: skip
    return [one for formula in made for part in ("clauses", "definitions") for one in formula[part]]


@needs_text
def test_every_letter_of_the_shipped_formulas_is_in_the_text_layer(
    printed: list[dict[str, str]], tmp_path: Path
) -> None:
    assert len(printed) > 100
    found = said(tmp_path, pdf("\n".join(one["typst"] for one in printed)))
    assert "\ufffd" not in found
    # A root, a power, and what a fence or a fraction says, is drawn; of all else that a terminal shows, each sign is there.
    wanted = {char for one in printed for char in unicodedata.normalize("NFKC", one["text"])}
    wanted -= set(" \n_/^√{}")
    assert {"κ", "μ", "π", "∀", "∈", "≤"} <= wanted
    assert wanted - set(found) == set()


def test_every_greek_letter_of_the_language_has_a_glyph() -> None:
    letters = [at.Name(letter) for letter in GREEK if len(letter) == 1]
    assert len(letters) > 20
    for make in (
        at.Row(tuple(letters)), at.Row(tuple(at.Name(one.text * 2) for one in letters)),
        at.Index(at.Name("v"), at.Row(tuple(letters))),
    ):  # fmt: skip
        assert pdf(formulas.formula(make), archive=True)
    assert pdf("".join(f'#"{one.text}"' + f'#raw("{one.text}")' for one in letters), archive=True)


def test_what_no_font_has_is_noticed() -> None:
    """The check above can fail."""
    with pytest.raises(RuntimeError, match="could not be displayed"):
        pdf(formulas.formula(at.Name("漢")), archive=True)


def test_letters_without_a_glyph_are_told_by_their_numbers() -> None:
    source = '#"a α é ≈ ✎ 漢 字 \u200b 😀 漢"'
    spelled, lacking = paper.spelled(source)
    assert sorted(lacking) == sorted("漢字😀")
    assert spelled == '#"a α é ≈ ✎ ‹U+6F22› ‹U+5B57› \u200b ‹U+1F600› ‹U+6F22›"'
    assert pdf(spelled, archive=True)
    assert paper.spelled(spelled) == (spelled, "")


@needs_text
def test_a_title_in_letters_that_no_font_has_is_on_paper_by_numbers_and_said(
    ready: Path, tmp_path: Path
) -> None:
    project = Path(shutil.copytree(ready, tmp_path / "warehouse"))
    edit(project, "requirements/needs.yaml", "title: Nobody is hit", "title: Nobody is hit, 漢 and Ω")
    out = tmp_path / "out"
    _, _, err = command(project, "case", "--out", str(out), "--day", DAY, "--quiet")
    assert "T438" in err
    assert "漢 (U+6F22)" in err
    assert "Ω" not in err
    found = said(tmp_path, (out / "safety-case.pdf").read_bytes())
    assert "Nobody is hit, ‹U+6F22› and Ω" in " ".join(found.split())
    assert "Nobody is hit, 漢 and Ω" in (out / "safety-case.html").read_text("utf-8")
    page = html(project)
    assert "U+6F22" not in page.html


IDS = ("S-1-A-4", "FSR-1", "S-1-B-10", "AV-TP.1", "A-FRICTION")


@needs_text
@pytest.mark.parametrize("made", [paper.text, paper.marked])
def test_ids_stand_on_one_line(made: object, tmp_path: Path) -> None:
    words = [f"{'x' * fill} {id_}, {id_}: {id_}" for id_ in IDS for fill in range(1, 12)]
    shown = "\n".join(f"#block(width: 2.2cm, {{{made(one)}}})" for one in words)  # type: ignore[operator]
    found = said(tmp_path, pdf(shown), "-layout")
    assert [line for line in found.splitlines() if re.search(r"[A-Z0-9]-\s*$", line)] == []
    for id_ in IDS:
        assert len(re.findall(rf"(?<![\w-]){re.escape(id_)}(?![\w-])", found)) == 3 * 11


def test_words_with_hyphens_and_long_names_may_be_broken() -> None:
    assert "box" not in paper.text("a well-known state-of-the-art T-shirt-like thing")
    assert "box" not in paper.text("VERY-LONG-NAME-OF-A-REQUIREMENT-1")
    assert "\u200b" in paper.text("VERY-LONG-NAME-OF-A-REQUIREMENT-1")


@needs_text
def test_names_and_hashes_are_copied_and_found_as_they_are(ready: Path, tmp_path: Path) -> None:
    """A sign without width stood wherever a line may end: nobody found `requirements/needs.yaml`, and a copied hash was another one."""
    out = tmp_path / "out"
    command(ready, "case", "--out", str(out), "--day", DAY, "--quiet")
    found = said(tmp_path, (out / "safety-case.pdf").read_bytes(), "-layout")
    assert "\u200b" not in found
    assert "requirements/needs.yaml" in found
    hashes = set(re.findall(r"\b[0-9a-f]{64}\b", html(ready).first))
    assert hashes
    assert [one for one in hashes if one not in found] == []
