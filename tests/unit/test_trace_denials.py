"""Evidence that says that there is none: of which assumption, and where."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.trace import denials
from trackmarshal.trace.findings import Place

CLAIM = denials.Claim("seen.md", "A-SEEN", "assumption", Place("a.spec", 1, 1))


def of(folder: Path, text: str) -> denials.Denials:
    (folder / "seen.md").write_text(text, "utf-8")
    return denials.load(folder, [CLAIM])


#: Written down without looking at the phrases: what pages say that hold a place.
EMPTY = (
    "There is none here.", "This repository holds\nnone of these.", "No evidence yet.", "no report exists", "TODO", "It is to be written.", "Tbd.",
    "There is **no** evidence for this.", "There is no evidence of this yet; none was looked for, which is to be done.", "We have no evidence\n> whatsoever.",
    "Without any evidence, this was taken over.", "The survey has not been done yet.", "Latency: not yet measured.", "This has yet to be validated.",
    "Nothing has been measured so far.", "Nobody has shown this.", "The evidence is still missing.", "Evidence is pending.", "The report is still outstanding.",
    "The assumption remains unproven.", "This claim is untested.", "It lacks evidence.", "No tests have been done here.", "No measurements were yet taken.",
    "A figure will be provided later.", "Awaiting the report.", "Pending approval.", "This page is a placeholder.", "(This page intentionally left blank.)",
    "Lorem ipsum dolor sit amet.", "This section is under construction.", "It is still work in progress.", "Coming soon!", "FIXME: numbers", "| latency | TBC |",
    "It is _not yet_ __measured__.", "~~Soon:~~ _to be announced_", "<p>It is <b>not yet</b> measured.</p>", "<TBD>", "`tbd`", "Not yet mea\u00adsured.", "T\u200bBD",
    "TODO: numbers", "- todo", "TODO write this", "Todo.\n\nNext week", "It still has to be measured.", "Records: there are none.", "There is no evidence to support this.", "Without any evidence to show it, this was taken over.", "<!-- TODO: measure -->", "<!-- see report 7 --> Not yet measured.", "40 h.\n\n<!-->\n\nNot yet measured.\n\n<!-- a -->", "40 h were driven.\n\n<!-- open\n\nNot yet measured.",
    "Comments begin with `<!--`, and `-->` ends them.\n\nNot yet measured.\n\n<!-- a -->", "40 h `<!--` not yet measured `-->`", "40 h \\<!-- not yet measured -->", "There is no evidence to date.", "There is no evidence to be found.", "No evidence to justify it.", "Deviations: see below. There are none.",
)  # fmt: skip
#: What real pages say: of what was found, of sensors, of roads.
FULL = (
    "In 40 h none was missed.", "Report 7: 140 ms at most.", "Nonesuch evidence-free wording is not meant.", "They are not to be seen without light.", "",
    "There was no evidence of a missed object in 40 h.", "We found no evidence that the pose drifts.", "No evidence against it came up.",
    "At start-up the pose is not yet available; the monitor says so.", "Unverified objects are dropped.", "A message that is not yet recorded is kept.",
    "Where a measurement is missing, the one before is taken.", "A record is missing in 3 of 40,000 cycles.", "Roads under construction were driven twice.",
    "Road work in progress was signed.", "A tracker awaiting measurements coasts.", "The change has to be confirmed by the driver.", "The field is left blank at night.",
    "No measurement was later than 140 ms.", "No test failed.", "Nothing was missed.", "Nobody has been on the track.", "Tests were done on 12 days; all are in report 7.",
    "The evidence is in report 7.", "The report is complete.", "todo-list.md names who checks what.", "The value will be added to the sum.", "tbdm is a module.", "`todo_list` and _todo_list are modules.", "a < b, not c > yet measured",
    "Where there is none, nothing is driven.", "He asks until there is none.", "40 h were driven; none was missed.", "| S-3 | none | 12 |",
    "Not measured values are marked as such.", "The claim is tested by 40 drives.", "The assumption is not untested: see report 7.",
    "Deviations: there are none.", "## Deviations\n\nThere are none.", "Open points\n-----------\n\nThere are none.", "**Known defects:** there is none", "## Failures\r\n\r\nThere are none.",
    "Todo el recorrido fue medido.", "En todo momento frena.", "Todo o percurso foi medido.", "Frena, sobre todo, a tiempo.", "The todo list is empty.", "No TODO is left.", "All TBD were resolved.", "TBD items: 0",
    "Every deviation has to be documented.", "The check is to be done before each drive.", "If evidence is missing, the gate fails.", "No evidence indicating drift was found.", "There is no evidence to suggest drift.", "There was no evidence to the contrary.", "No evidence to date suggests drift.", "There is no evidence to date of drift.", "In 40 h none was missed. <!-- TODO: link the report -->", "40 h were driven.\n<!--\nTBD: layout\n-->",
)  # fmt: skip


@pytest.mark.parametrize("said", EMPTY)
def test_what_says_that_there_is_none(said: str, tmp_path: Path) -> None:
    assert list(of(tmp_path, f"# Seen\n\n{said}\n")) == [("seen.md", "A-SEEN")]


@pytest.mark.parametrize("said", FULL)
def test_what_does_not(said: str, tmp_path: Path) -> None:
    assert of(tmp_path, f"# Seen\n\n{said}\n") == {}


@pytest.mark.parametrize("phrase", denials.phrases())
def test_each_phrase_is_found_as_it_is_read(phrase: str, tmp_path: Path) -> None:
    """The first and the last of its words, with and without those that may be missing; not inside other words."""
    for pick, optional in ((0, True), (0, False), (-1, True), (-1, False)):
        words = [
            word.strip("?").split("|")[pick]
            for word in phrase.split()
            if not word.startswith("!") and (optional or not word.endswith("?"))
        ]
        assert of(tmp_path, f"So: {' '.join(words)}.") != {}, words
        assert of(tmp_path, f"So: {'  '.join(words).upper()}\n") != {}, words
        assert of(tmp_path, f"So: pre{' '.join(words)}ed.") == {}, words


def test_a_project_has_phrases_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "seen.md").write_text("Der Nachweis steht\nnoch aus.\n", "utf-8")
    assert denials.load(tmp_path, [CLAIM]) == {}
    found = denials.load(tmp_path, [CLAIM], ("steht|stehen noch aus",))
    assert found == {("seen.md", "A-SEEN"): (Place("seen.md", 1, 14), "steht noch aus")}
    (tmp_path / "seen.md").write_text("There is none.\n", "utf-8")
    assert list(denials.load(tmp_path, [CLAIM], ("steht noch aus",))) == [("seen.md", "A-SEEN")]


def test_of_what_is_named_its_own_paragraphs_count(tmp_path: Path) -> None:
    """One page may back an assumption and say that another has nothing yet."""
    other = "A-HEARD: there is none.\n"
    assert of(tmp_path, f"A-SEEN: report 7.\n\n{other}") == {}
    found = of(tmp_path, f"{other}\nOf A-SEEN:\nthere is\nnone.\n")
    assert found == {("seen.md", "A-SEEN"): (Place("seen.md", 4, 1), "there is none")}
    assert list(of(tmp_path, "A-SEEN-TOO: report 7.\n\nThere is none.\n")) == [("seen.md", "A-SEEN")]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "latin-1", "utf-16", "utf-16-be"])
def test_it_says_so_in_any_encoding(encoding: str, tmp_path: Path) -> None:
    mark = b"\xfe\xff" if encoding == "utf-16-be" else b""
    (tmp_path / "seen.md").write_bytes(mark + "Größe: not yet measured".encode(encoding))
    assert list(denials.load(tmp_path, [CLAIM])) == [("seen.md", "A-SEEN")]


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_in_any_encoding_pages_are_read_alike(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "seen.md").write_bytes("Not yet mea\u00adsured.".encode(encoding))
    assert list(denials.load(tmp_path, [CLAIM])) == [("seen.md", "A-SEEN")]
    (tmp_path / "seen.md").write_bytes("# Deviations\n\nThere are none.".encode(encoding))
    assert denials.load(tmp_path, [CLAIM]) == {}


def test_however_long_it_is(tmp_path: Path) -> None:
    (tmp_path / "seen.md").write_text("Not yet measured." + " " * 1_000_001)
    assert list(denials.load(tmp_path, [CLAIM])) == [("seen.md", "A-SEEN")]


def test_what_cannot_be_read_says_nothing(tmp_path: Path) -> None:
    (tmp_path / "seen.md").write_bytes(b"%PDF\x00\x01 tbd \xff no evidence")
    assert denials.load(tmp_path, [CLAIM]) == {}
    (tmp_path / "seen.md").unlink()
    assert denials.load(tmp_path, [CLAIM]) == {}


def about(
    folder: Path, page: str, kind: str = "requirement", name: str = "S-1", path: str = "page.md"
) -> bool:
    """Whether a page denies what it is to show."""
    (folder / path).write_text(page, "utf-8")
    claim = denials.Claim(path, name, kind, Place("v-model.yaml", 1, 1))
    return claim.key in denials.load(folder, [claim])


@pytest.mark.parametrize(
    ("page", "denied"),
    [
        ("# S-1\n\nNo measurement was made yet.\n", True),
        ("Latency\n=======\n\nThis is evidence of S-1.\n\nIt has not been measured yet.\n", True),
        ("# The target\n\nNot yet measured.\n", True),  # it names nothing: all of it counts
        ("## S-1\n\nReport 7.\n\n### In the heat\n\nNot yet measured.\n", True),
        ("## S-1\n\nReport 7.\n\n## Others\n\nNot yet measured.\n", False),
        ("## S-1\n\nReport 7.\n\nS-2 was not yet measured.\n\nNobody has measured it.\n", False),
        ("- S-1: report 7\n- S-2: to be announced\n", False),
        ("- S-2: report 7\n- S-1: to be announced\n", True),
        ("| S-1 | report 7 |\n| S-2 | tbd |\n", False),
        ("| S-2 | report 7 |\n| S-1 | tbd |\n", True),
        ("# S-1\n\n40 drives.\n\n## History\n\n- 0.1: not yet measured\n- 1.0: S-1 by report 7\n", False),
        ("# Drives\n\n40 in time.\n\nRevision history\n---\n\n| 0.1 | S-1 tbd |\n", False),
        (
            "# Drives\r\n\r\n40 in time.\r\n\r\n# 2.1 Change history\r\n\r\nS-1: tbd\r\n\r\n## v1\r\n\r\nS-1: tbd\r\n",
            False,
        ),
        ("# History\n\n- 0.1: not yet measured\n", True),  # there is nothing else
        ("Drives\n======\n\n# History\n\n- 0.1: not yet measured\n", True),
        ("# S-1\n\n40 drives.\n\n## History\n\n- 1.0\n\n## In the heat\n\nNot yet measured.\n", True),
        ("# S-1\n\n40 drives.\n\n## History of S-1\n\nNot yet measured.\n", True),
        ("S-1 is shown by report 7.\n\n# Limits\n\nHeat: not yet measured.\n", False),
    ],
)
def test_what_stands_at_a_name_is_about_it(page: str, denied: bool, tmp_path: Path) -> None:
    assert about(tmp_path, page) is denied
    assert about(tmp_path, page, "assumption") is denied


def test_of_the_design_sections_alone_count(tmp_path: Path) -> None:
    assert about(tmp_path, "# Layout\n\n## S-1\n\nThis has yet to be written.\n", "section")
    assert about(tmp_path, "# Layout\n\n## S-1\n\nAs in S-2.\n\n- DE-2: tbd\n", "section")
    assert not about(tmp_path, "# Layout\n\nS-1 is not yet measured.\n\n## S-1\n\nA timer.\n", "section")
    assert not about(tmp_path, "# Layout\n\n## S-2\n\nThis has yet to be written.\n", "section")
    # Below a heading of another one that stands in it, what names it; and nothing behind its end.
    beside = "## S-1\n\nA timer.\n\n### With S-2\n\n"
    assert about(tmp_path, f"{beside}S-1 is not yet measured.\n", "section")
    assert not about(tmp_path, f"{beside}Not yet measured.\n", "section")
    assert not about(tmp_path, "## S-1\n\nA timer.\n\n## S-2\n\nS-1 is not yet measured.\n", "section")


def test_words_of_data_are_names(tmp_path: Path) -> None:
    assert not about(tmp_path, '{"passed": 12, "todo": 0}', path="counts.json")
    assert about(tmp_path, "passed: 12, todo: 0", "assumption", path="counts.yaml")


def test_a_page_is_read_once_however_much_it_is_to_show(tmp_path: Path) -> None:
    """Blocks are looked through for each claim, and texts are not."""
    (tmp_path / "page.md").write_text("".join(f"- S-{n}: tbd\n" for n in range(300)), "utf-8")
    many = [denials.Claim("page.md", f"S-{n}", "requirement", Place("v.yaml", 1, 1)) for n in range(300)]
    found = denials.load(tmp_path, many)
    assert [place.line for place, _ in found.values()] == list(range(1, 301))
