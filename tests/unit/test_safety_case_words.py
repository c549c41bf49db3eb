"""The fixed words of the safety case: all in one file a language, whole in each, refused where they are not; and the same case in two of them."""

from __future__ import annotations

import re
import shutil
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
import yaml

from support.project import command
from support.safety_case import DAY, NUMBER, Page, edit, html
from trackmarshal.trace import verdict
from trackmarshal.trace.case import words as room
from trackmarshal.trace.case.content import NAMES
from trackmarshal.trace.case.loop import OUTCOMES
from trackmarshal.trace.graph.kinds import NODES
from trackmarshal.trace.gsn import picture
from trackmarshal.trace.gsn.kinds import KINDS, LINKS
from trackmarshal.trace.report.svg import boundary

FOLDER = Path(room.__file__).parent
#: Beginnings of names that are put together with something of the graph or of a record.
MADE = (
    "lacking.", "status.", "meaning.", "thing.", "what.", "level.", "finding.", "expect.", "fired.", "review.", "clause.", "label.tests_", "label.faults_", "open.", "drawing.none.", "drawing.letter.", "drawing.boundary", "drawing.satisfied", "drawing.violated",
    "role.", "loop.mark.", *(f"loop.{outcome}" for outcome in OUTCOMES), "faults.", "tools.T", "term.", "gsn.kind.", "gsn.state.", *(f"gsn.{kind}" for kind in LINKS),
)  # fmt: skip


def file(language: str) -> dict[str, str]:
    """The words of a file, read by another reader than the program's."""
    found = yaml.safe_load((FOLDER / f"{language}.yaml").read_text("utf-8"))
    assert found["format"] == "trackmarshal-case-words"
    words = found["words"]
    assert all(isinstance(text, str) for text in words.values())
    return {str(name): text for name, text in words.items()}


def test_words_are_in_one_place_and_none_is_left_over() -> None:
    words = file("en")
    source = "".join(
        path.read_text("utf-8")
        for path in (
            *FOLDER.parent.rglob("*"),
            *Path(picture.__file__).parent.glob("*.py"),
            Path(boundary.__file__),
        )
        if path.suffix in (".py", ".j2")
    )
    unused = [
        name for name in words
        if f'"{name}"' not in source and not name.startswith(MADE) and not name.endswith(".title")
    ]  # fmt: skip
    assert unused == []
    assert {f"{name}.title" for name in NAMES} <= words.keys()
    assert {f"term.{name.split('.')[1]}.means" for name in words if name.startswith("term.")} <= words.keys()


@pytest.mark.parametrize("language", ["en", "de"])
def test_no_word_has_a_number_in_it(language: str) -> None:
    assert [name for name, text in file(language).items() if NUMBER.search(text)] == []


def test_german_is_whole_and_has_the_same_places_to_fill_in() -> None:
    english, german = file("en"), file("de")
    assert english.keys() <= german.keys()
    more = german.keys() - english.keys()
    assert {f"what.{kind}" for kind in NODES} | {f"meaning.{word}" for word in verdict.MEANINGS} <= more
    for name, text in english.items():
        places = Counter(re.findall(r"\{(\w+)\}", text))
        assert places == Counter(re.findall(r"\{(\w+)\}", german[name])), name
    # A word that was forgotten to be translated stands there in English.
    alike = {name for name, text in english.items() if german[name] == text and len(text) > 12}
    assert alike == {"hazards.rated", "decomposition.level"}


def test_a_verdict_means_in_german_what_it_means_in_english() -> None:
    """What nobody has reviewed is a reservation, in the glossary of either language; the baseline is called as it is there."""
    german = file("de")
    for word, meaning in verdict.MEANINGS.items():
        assert ("review" in meaning) == ("geprüft" in german[f"meaning.{word}"]), word
    assert not any("Baseline" in text for text in german.values())


@pytest.mark.acceptance
def test_a_german_case_says_the_same_in_german(warehouse: Path) -> None:
    english, german = html(warehouse), html(warehouse, "--words", "de")
    assert '<html lang="de">' in german.html
    assert "Gefährdungen und Sicherheitsziele" in german.texts
    assert "Hazards and safety goals" not in german.texts
    assert german.numbers == english.numbers
    assert german.ids == english.ids
    assert sorted(german.targets) == sorted(english.targets)
    assert '<span class="made">' in english.html
    assert '<span class="made">' not in german.html  # sentences of the program say that they are English
    fixed = {text for name, text in file("en").items() if len(text) > 25 and "{" not in text and name in file("de")}  # fmt: skip
    assert [text for text in german.texts if text in fixed] == []


def test_pictures_of_the_argument_are_in_german_but_for_what_people_wrote(warehouse: Path) -> None:
    english, german = html(warehouse), html(warehouse, "--words", "de")
    pictures = [
        re.findall(r'<svg [^>]*role="group".*?</svg>', page.html, re.DOTALL) for page in (english, german)
    ]
    assert len(pictures[0]) == len(pictures[1]) > 1
    words = [file("en"), file("de")]
    fixed = [words[0][f"gsn.kind.{kind}"] for kind in KINDS] + ["module", "Supported by", "In the context of", "undeveloped", "in the module"]  # fmt: skip
    whole = [" ".join(re.sub(r"<[^>]+>", "\n", "".join(one)).split()) for one in pictures]
    assert "Goal G-Top: " in whole[0]
    assert "Ziel G-Top: " in whole[1]
    assert "✓ gestützt" in whole[1]
    assert "Gestützt durch: " in whole[1]
    assert "Modul G-Top" in whole[1]
    for word in fixed:
        assert not re.search(rf"(?<![\w-]){word}(?= [A-Z][\w-]*[,:]|: |[,)])", whole[1]), word
    assert not re.search(r"(✓|◐|✗) (supported|with reservations|not supported)", whole[1])
    # Titles and sentences stay.
    for title in re.findall(r'<text [^>]*font-size="10.5"[^>]*>([^<]+)</text>', pictures[0][0]):
        assert title in whole[1]


def test_the_project_says_in_which_language(warehouse: Path) -> None:
    edit(warehouse, "requirements/v-model.yaml", "  specs: [specs]\n", "  specs: [specs]\n  case_words: de\n")
    assert "Offene Punkte" in html(warehouse).texts
    assert "Open points" in html(warehouse, "--words", "en").texts


def test_the_commands_that_make_it_again_have_its_words(warehouse: Path) -> None:
    """Without them, they come to an English one, and the document says that they come to the same."""
    commands = {
        language: next(text for text in html(warehouse, *words).texts if "trackmarshal case --day" in text)
        for language, words in (("en", []), ("de", ["--words", "de"]))
    }
    assert commands["en"].endswith(f"trackmarshal case --day {DAY} --out DIR")
    assert commands["de"].endswith(f"trackmarshal case --day {DAY} --words de --out DIR")


def test_it_says_that_it_comes_again_only_where_it_does(warehouse: Path) -> None:
    """Written before its evidence is made, it is another document once its commands have made that; and where there is no commit, it names none."""
    first = html(warehouse)
    assert "With the same tool and the same files, these commands come to the same document, byte for byte:" in first.texts  # fmt: skip
    shutil.rmtree(warehouse / "out")
    lacking = html(warehouse)
    assert not any("byte for byte" in text for text in lacking.texts)
    assert any(text.startswith("Evidence was missing or stale when this was written.") for text in lacking.texts)  # fmt: skip
    assert command(warehouse, "trace", "--gate", "--rerun")[0] == 0
    assert lacking.html != html(warehouse).html == first.html


def test_typst_sets_the_language(warehouse: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from trackmarshal.trace.case import typst

    sources: list[str] = []

    def pdf(source: str, day: Any) -> bytes:
        sources.append(source)
        return b"%PDF-"

    monkeypatch.setattr(typst, "pdf", pdf)
    for language in ("en", "de"):
        status, _, err = command(warehouse, "case", "--out", str(warehouse / language), "--day", DAY, "--format", "pdf", "--words", language)  # fmt: skip
        assert status == 0, err
    assert re.search(r'#set text\([^\n]*lang: "en"', sources[0])
    assert re.search(r'#set text\([^\n]*lang: "de"', sources[1])
    assert '"Gefährdungen und Sicherheitsziele"' in sources[1]


def test_a_pdf_in_german_is_set_and_the_same_again(warehouse: Path) -> None:
    pytest.importorskip("typst", reason="sets the PDF")
    made = []
    for name in ("one", "two"):
        status, _, err = command(warehouse, "case", "--out", str(warehouse / name), "--day", DAY, "--words", "de", "--quiet")  # fmt: skip
        assert (status, err) == (0, "")
        made.append((warehouse / name / "safety-case.pdf").read_bytes())
    assert made[0] == made[1]
    command(warehouse, "case", "--out", str(warehouse / "en"), "--day", DAY, "--quiet")
    assert (warehouse / "en" / "safety-case.pdf").read_bytes() != made[0]


OWN = "own.yaml"


def own(warehouse: Path, old: str = "", new: str = "") -> tuple[int, str]:
    """Exit status and errors of a case with a file of words of the project: the German one, with something replaced."""
    text = (FOLDER / "de.yaml").read_text("utf-8")
    assert not old or text.count(old) == 1, old
    (warehouse / OWN).write_text(text.replace(old, new) if old else text, "utf-8")
    out = warehouse / "out" / "own"
    status, _, err = command(warehouse, "case", "--out", str(out), "--day", DAY, "--format", "html", "--words", str(warehouse / OWN))  # fmt: skip
    if status == 2:
        assert not out.exists()
    return status, err


def test_a_file_of_the_project_is_taken(warehouse: Path) -> None:
    assert own(warehouse, 'open.title: "Offene Punkte"', 'open.title: "Was offen ist"')[0] == 0
    page = Page((warehouse / "out" / "own" / "safety-case.html").read_text("utf-8"))
    assert "Was offen ist" in page.texts


@pytest.mark.parametrize(
    ("old", "new", "code", "said"),
    [
        ('  open.title: "Offene Punkte"\n', "", "T435", "words are missing: `open.title`"),
        ('  what.tool: "ein Programm, auf dessen Ergebnisse man sich verlässt"\n', "", "T435", "`what.tool`"),
        ("  open.title:", "  open.titel:", "T435", "`open.title`"),
        ('  none: "keine"\n', '  none: "keine"\n  noone: "niemand"\n', "T436", "there is no word `noone`"),
        ('"{hour} in der Stunde, {km} auf den Kilometer"', '"{hour} in der Stunde"', "T436", "`{hour}`, `{km}`"),
        ('"{hour} in der Stunde, {km} auf den Kilometer"', '"{hour} in der Stunde, {km} auf {m}"', "T436", "`field.rates` has other places"),
        ('  none: "keine"', '  none: "{keine"', "T436", "the braces of `none` do not pair"),
        ('  none: "keine"', '  none: "0"', "T436", "`none` has a number in it"),
        ('  none: "keine"', "  none: [keine]", "T436", "`none` is to be a text"),
        ('  language: "de"', '  language: "deutsch"', "T436", "`deutsch` is no language"),
        ("version: 1", "version: 2", "T434", "`version` is to be `1`"),
        ("\nwords:\n", "\nwords: [\n", "T434", "not YAML"),
        ("format: trackmarshal-case-words\n", "", "T434", "this is no file of words"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_file_and_help(
    warehouse: Path, old: str, new: str, code: str, said: str
) -> None:
    status, err = own(warehouse, old, new)
    assert status == 2
    assert f"error[{code}]" in err
    assert said in err
    assert f"{OWN}:" in err
    assert "help" in err


def test_a_language_that_there_is_not_is_refused(warehouse: Path) -> None:
    for named, said in (("fr", "known are de, en"), ("nowhere.yaml", "nowhere.yaml")):
        status, _, err = command(
            warehouse, "case", "--out", str(warehouse / "no"), "--day", DAY, "--words", named
        )
        assert status == 2
        assert "error[T434]" in err
        assert said in err


def test_more_missing_words_than_a_line_holds_are_counted(warehouse: Path) -> None:
    text = (FOLDER / "de.yaml").read_text("utf-8")
    kept = [line for line in text.splitlines() if not line.startswith("  column.")]
    missing = len(text.splitlines()) - len(kept)
    (warehouse / OWN).write_text("\n".join(kept) + "\n", "utf-8")
    status, _, err = command(
        warehouse, "case", "--out", str(warehouse / "no"), "--day", DAY, "--words", str(warehouse / OWN)
    )
    assert status == 2
    assert f"and {missing - 12} more" in err
