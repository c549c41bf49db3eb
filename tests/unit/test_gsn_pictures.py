"""Pictures of modules: well-formed, readable, the same bytes each time, and whatever a title holds is text in them."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from golden.gsn.cases import argued, argument
from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace.case.words.language import english
from trackmarshal.trace.gsn.case import Case, Element, Evidence, Link, Module, Point
from trackmarshal.trace.gsn.kinds import KINDS
from trackmarshal.trace.gsn.modules import LIMIT
from trackmarshal.trace.gsn.picture import layout
from trackmarshal.trace.gsn.picture.boxes import FONT, ROUND, box
from trackmarshal.trace.gsn.picture.content import Shown, content
from trackmarshal.trace.gsn.picture.svg import pictures
from trackmarshal.trace.gsn.picture.wrapping import width, wrapped
from trackmarshal.trace.gsn.statuses import with_statuses

ENGLISH = english()
SVG = "{http://www.w3.org/2000/svg}"
EVIL = "<script>alert(1)</script> & \"quoted\" 'so' ]]> <!-- \x07 $x$ #let \\end{a} " + "ж漢" * 3


def one_of_each(text: str = "It holds.") -> Case:
    """An argument with every kind of elements and links, an away goal, and a defeated one."""
    held = (Evidence("test", text, "covered", "0" * 64, None),)
    elements = [Element(f"E-{kind.replace(' ', '-')}", kind, text, None, None, module="G", leaf="supported", evidence=held, state="open" if kind.startswith("counter") else "") for kind in KINDS]  # fmt: skip
    elements += [
        Element("Away", "goal", text, None, None, module="Other", public=True, undeveloped=True),
        Element("Open", "goal", text, None, None, module="G", undeveloped=True),
        Element("Against", "counter goal", text, None, None, module="G", state="upheld"),
    ]
    links = [("supported_by", "E-goal", "E-strategy"), ("supported_by", "E-strategy", "Open"), ("supported_by", "E-strategy", "Away"),
             ("supported_by", "E-goal", "E-solution"), ("challenges", "E-counter-goal", "Open"), ("challenges", "E-counter-solution", "E-goal"),
             ("challenges", "Against", "E-solution")]  # fmt: skip
    links += [("in_context_of", "E-goal", f"E-{kind}") for kind in ("context", "assumption", "justification")]
    modules = (Module("G", "E-goal", text), Module("Other", "Away", text))
    return with_statuses(Case(text, {e.id: e for e in elements}, tuple(Link(*k, None) for k in links), modules))  # fmt: skip


def drawn(case: Case, module: int = 0, words: Mapping[str, str] = ENGLISH) -> str:
    files = {m.name: f"{m.name}.svg" for m in case.modules}
    return pictures(case, [case.modules[module]], files, words)[0]


def test_every_kind_is_drawn_and_said() -> None:
    case = one_of_each()
    tree = ElementTree.fromstring(drawn(case))
    name, said = tree.find(f"{SVG}title"), tree.find(f"{SVG}desc")
    assert name is not None
    assert said is not None
    assert tree.get("aria-labelledby") == f"{name.get('id')} {said.get('id')}"
    shown = content(case, case.modules[0]).shown
    labels = [group.get("aria-label") or "" for group in tree.iter(f"{SVG}g") if group.get("role") == "img"]
    assert len(labels) == len(shown) == 11
    for id_, one in shown.items():
        assert f"{one.element.kind.capitalize()} {id_}: It holds." in (said.text or "")
        assert any(label.startswith(f"{one.element.kind.capitalize()} {id_}: It holds.") for label in labels)
    words = " ".join(text.text or "" for text in tree.iter(f"{SVG}text"))
    for word in ("✓ supported", "◐ with reservations", "✗ not supported", "! open", "in Other"):
        assert word in words, "no status is told by its colour alone"
    assert [a.get("href") for a in tree.iter(f"{SVG}a")] == ["Other.svg"]
    assert "Challenges: E-solution." in (said.text or "")


def test_confidence_points_are_drawn_where_they_are() -> None:
    points = (Point("ACP-1", "E-goal", "", "Read by two.", None), Point("ACP-2", "E-goal", "E-strategy", "So it is <b>done</b>.", None),
              Point("ACP-3", "Elsewhere", "", "Not here.", None))  # fmt: skip
    tree = ElementTree.fromstring(drawn(replace(one_of_each(), points=points)))
    labels = [g.get("aria-label") for g in tree.iter(f"{SVG}g")]
    assert "Confidence point ACP-1: Read by two." in labels
    assert "Confidence point ACP-2: So it is <b>done</b>." in labels
    assert not any("ACP-3" in (label or "") for label in labels)


def test_markup_is_text(tmp_path: Path) -> None:
    case = one_of_each(EVIL)
    made = drawn(case)
    tree = ElementTree.fromstring(made)
    assert not list(tree.iter(f"{SVG}script"))
    assert {element.tag.removeprefix(SVG) for element in tree.iter()} <= {"svg", "title", "desc", "g", "a", "rect", "circle", "ellipse", "path", "text"}  # fmt: skip
    said = tree.find(f"{SVG}desc")
    assert said is not None
    assert EVIL.replace("\x07", "\ufffd").strip() in (said.text or "")
    assert "http" not in re.sub(r'xmlns="[^"]*"', "", made), "nothing is fetched"


def test_markup_in_a_project(tmp_path: Path) -> None:
    small = argued(tmp_path)
    small.replace("requirements/criteria.yaml", "    statement: The vehicle shall touch nobody.", "    statement: 'The vehicle shall <b onload=x>touch</b> & nobody: \"''. digraph { a -> b }'")  # fmt: skip
    _, case = argument(small)
    assert case.findings == ()
    files = {m.name: f"{m.name}.svg" for m in case.modules}
    for made in pictures(case, case.modules, files, ENGLISH):
        ElementTree.fromstring(made)
        assert "<b " not in made


def test_same_argument_same_bytes() -> None:
    assert drawn(one_of_each()) == drawn(one_of_each())


def test_all_pictures_of_a_project_are_small_and_fit_on_a_page(tmp_path: Path) -> None:
    _, case = argument(argued(tmp_path))
    files = {m.name: f"{m.name}.svg" for m in case.modules}
    for module, made in zip(case.modules, pictures(case, case.modules, files, ENGLISH)):
        shown = content(case, module).shown
        assert len(shown) <= LIMIT
        tree = ElementTree.fromstring(made)
        wide, high = (float((tree.get(name) or "").removesuffix("mm")) for name in ("width", "height"))
        assert min(wide, high) <= 190.01
        assert max(wide, high) <= 277.01
        left, top, right, low = map(float, (tree.get("viewBox") or "").split())
        assert wide / right * 72 / 25.4 * FONT >= 6, "letters of at least 6 points"
        for group in tree.iter(f"{SVG}rect"):
            x, y = float(group.get("x") or 0), float(group.get("y") or 0)
            assert left <= x <= x + float(group.get("width") or 0) <= right + 0.1
            assert top <= y <= y + float(group.get("height") or 0) <= low + 0.1


def test_elements_of_a_picture_do_not_overlap(tmp_path: Path) -> None:
    _, case = argument(argued(tmp_path))
    for module in case.modules:
        shown = content(case, module)
        boxes = {id_: box(one, ENGLISH) for id_, one in shown.shown.items()}
        (placed,) = layout.laid_out([(shown, boxes)])
        spans = {i: (x - boxes[i].width / 2, x + boxes[i].width / 2, y - boxes[i].height / 2, y + boxes[i].height / 2) for i, (x, y) in placed.centres.items()}  # fmt: skip
        names = list(spans)
        for n, one in enumerate(names):
            for other in names[:n]:
                a, b = spans[one], spans[other]
                apart = a[1] <= b[0] + 0.1 or b[1] <= a[0] + 0.1 or a[3] <= b[2] + 0.1 or b[3] <= a[2] + 0.1
                assert apart, (module.name, one, other)
        assert set(placed.curves) == {(link.source, link.target) for link in shown.links}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("text", ["It holds.", EVIL, "a" * 300, "word " * 200, "/very/long/path/to/some_recording.tmrec.jsonl.gz"])  # fmt: skip
def test_words_fit_into_their_outline(kind: str, text: str) -> None:
    element = Element(f"E-{text[:60]}", kind, text, None, None, module="M" * 60, status="with reservations")
    size = box(Shown(element, True), ENGLISH)
    room = size.width - 4
    for line in [*size.lines, *size.module]:
        assert width(line, FONT) <= room
    for line in size.name:
        assert width(line, FONT, bold=True) <= room
    rows = len(size.name) + len(size.lines) + len(size.module) + bool(size.status)
    assert rows * FONT <= size.height
    if kind in ROUND:
        assert size.width == size.height


def test_wrapping_keeps_every_word_that_fits() -> None:
    text = "One sentence that takes some lines, with a/long_path.that-breaks/at_joints.yaml in it."
    lines = wrapped(text, 90.0, 10.0, 20)
    assert "".join(lines).replace(" ", "") == text.replace(" ", "")
    assert all(width(line, 10.0) <= 90.0 for line in lines)
    short = wrapped(text, 90.0, 10.0, 2)
    assert len(short) == 2
    assert short[1].endswith("…")
    with pytest.raises(ValueError, match=r"a line of 5\.0"):
        wrapped(text, 5.0, 10.0, 2)


def test_an_unknown_kind_is_not_drawn() -> None:
    case = one_of_each()
    elements = {i: e._replace(kind="claim") if i == "Open" else e for i, e in case.elements.items()}
    with pytest.raises(ValueError, match="unknown kind of elements 'claim'"):
        drawn(replace(case, elements=elements))


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        (subprocess.CompletedProcess([], 1, "", "out of ink\nmore"), "out of ink"),
        (subprocess.CompletedProcess([], 0, "graph 1 1 1\nstop\n", ""), "positions of 0 of 11 elements"),
        (subprocess.CompletedProcess([], 0, "", ""), "0 positions for 1 pictures"),
        (subprocess.CompletedProcess([], 0, "graph 1 1 1\nnode n99 1 1\nstop\n", ""), "says no positions"),
    ],
)
def test_an_engine_that_does_not_answer(answer: subprocess.CompletedProcess[str], why: str, monkeypatch: pytest.MonkeyPatch) -> None:  # fmt: skip
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: answer)
    with pytest.raises(TrackmarshalError, match=why) as raised:
        drawn(one_of_each())
    assert raised.value.code == "T425"
