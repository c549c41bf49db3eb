"""Stretches of lines: what lies in one, on both sides of each end, over the finish line, and what is refused."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.semantics.compile import compile_text
from trackmarshal.source import SourceFile
from trackmarshal.syntax.format import format_text

BACKENDS = [
    "reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
]  # fmt: skip
TEXT = """module made.stretches

signal ego : state { x: m, y: m }
signal at : state { s: m }
signal track : corridor { left: polyline, right: polyline }
signal flags : set of object { from: m, to: m }

param begins : m = 70 m in [0, 1000]

line straight = (0 m, 0 m) (50 m, 0 m)
stretch chicane "slow" on track = begins to 20 m
stretch lap on centre(track) = 30 m to 30 m
stretch short on straight = 10 m to 20 m

"""
#: A square ring: its centre is 80 m long, from (0, 0) to the east.
SQUARE = {
    "left": [[1, 1], [19, 1], [19, 19], [1, 19]],
    "right": [[-1, -1], [21, -1], [21, 21], [-1, 21]],
    "closed": True,
}


def judged(require: str, backend: str, data: dict[str, Any], params: dict[str, float] | None = None) -> Any:
    spec = loads(f'{TEXT}rule made "made up"\n  require {require}\n')
    case = {"signals": {"track": SQUARE, **data}, **({"params": params} if params else {})}
    return Evaluator(spec, backend=backend).case(case).rules["made"]


def station(s: float) -> dict[str, Any]:
    return {"at": {"s": s}}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("s", "verdict", "margin"),
    [
        (70, "satisfied", 0), (69, "violated", -1), (71, "satisfied", 1), (79, "satisfied", 9), (0, "satisfied", 10),
        (5, "satisfied", 15), (19, "satisfied", 1), (20, "satisfied", 0), (21, "violated", -1), (40, "violated", -20),
        (50, "violated", -20), (-5, "satisfied", 5), (-11, "violated", -1), (80, "satisfied", 10), (155, "satisfied", 5),
        (math.nextafter(20, 99), "violated", 20 - math.nextafter(20, 99)),
    ],
)  # fmt: skip
def test_over_the_finish_line(backend: str, s: float, verdict: str, margin: float) -> None:
    found = judged("at.s in stretch chicane", backend, station(s))
    assert (found.verdict, found.margin) == (verdict, margin)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_point_stands_for_its_station(backend: str) -> None:
    assert judged("ego in stretch chicane", backend, {"ego": {"x": 3, "y": -2}}).margin == 13
    assert judged("ego in stretch chicane", backend, {"ego": {"x": 23, "y": 8}}).margin == -8


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("s", "margin"), [(30, 0), (31, 1), (29, 1), (70, 40), (69, 39)])
def test_what_ends_where_it_begins_is_the_whole_lap(backend: str, s: float, margin: float) -> None:
    found = judged("at.s in stretch lap", backend, station(s))
    assert (found.verdict, found.margin) == ("satisfied", margin)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("start", "end", "s", "margin"),
    [
        (590, 500, 0, 20), (590, 500, 25, -5), (0, 80, 40, 40), (0, 40, 50, -10), (-10, 10, 75, 5),
        (10, 30, 90, 0), (10, 30, 89, -1), (10, 9, 9.5, -0.5), (10, 9, 60, 29),
    ],
)  # fmt: skip
def test_stretches_come_as_data(backend: str, start: float, end: float, s: float, margin: float) -> None:
    data = {**station(s), "flags": [{"from": start, "to": end}]}
    found = judged("for all f in flags: (at.s in stretch(track, f.from, f.to))", backend, data)
    assert (found.verdict, found.margin) == ("satisfied" if margin >= 0 else "violated", margin)


@pytest.mark.parametrize("backend", BACKENDS)
def test_parameters_move_it(backend: str) -> None:
    assert judged("at.s in stretch chicane", backend, station(69), {"begins": 60}).margin == 9


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("s", "verdict", "margin"),
    [
        (10, "satisfied", 0),
        (9, "violated", -1),
        (20, "satisfied", 0),
        (25, "violated", -5),
        (-70, "violated", -80),
        (60, "violated", -40),
    ],
)
def test_an_open_line_does_not_wrap(backend: str, s: float, verdict: str, margin: float) -> None:
    found = judged("at.s in stretch short", backend, station(s))
    assert (found.verdict, found.margin) == (verdict, margin)


@pytest.mark.parametrize("backend", BACKENDS)
def test_one_place_of_an_open_line(backend: str) -> None:
    for s, margin in ((7, 0), (8, -1), (5, -2)):
        found = judged("at.s in stretch(straight, 7 m, 7 m)", backend, station(s))
        assert (found.verdict, found.margin) == ("satisfied" if s == 7 else "violated", margin)


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    "data",
    [
        {**station(5), "flags": [{"from": 5.5, "to": 5}], "track": {**SQUARE, "closed": False}},
        {**station(math.nan), "flags": [{"from": 0, "to": 5}]},
        {**station(math.inf), "flags": [{"from": 0, "to": 5}]},
        {**station(5), "flags": [{"from": math.nan, "to": 5}]},
        {**station(5), "flags": [{"from": 0, "to": None}]},
        {**station(5), "flags": [{"from": 0, "to": 9}], "track": {**SQUARE, "left": [[0, 0]]}},
        {**station(5), "flags": [{"from": 0, "to": 9}], "track": None},
    ],
)
def test_what_is_not_known_is_never_inside(backend: str, data: dict[str, Any]) -> None:
    formula = "for all f in flags: (at.s in stretch(track, f.from, f.to))"
    assert judged(formula, backend, data).verdict == "undefined"
    assert judged(formula.replace(": (", ": not ("), backend, data).verdict == "undefined"


def test_said_in_words() -> None:
    data = {**station(5), "flags": [{"from": 5.5, "to": 5}], "track": {**SQUARE, "closed": False}}
    found = judged("for all f in flags: (at.s in stretch(track, f.from, f.to))", "numpy", data)
    assert "flags[0].from = 5.5, flags[0].to = 5 has no value" in str(found)


def test_laid_out(tmp_path: Path) -> None:
    text = 'module made\n\nstretch  a "b"  on   track.left=\n 1 m\n  to -2 m\nstretch c on l = x + 1 m to y\n'
    assert format_text(SourceFile(str(tmp_path / "a.spec"), text)) == (
        'module made\n\nstretch a "b" on track.left = 1 m to -2 m\nstretch c on l = x + 1 m to y\n'
    )


def test_from_and_to_stay_names() -> None:
    spec = loads(
        "module made\nsignal to : state { to: m, from: m, on: m }\n"
        'rule made "made up"\n  let stretch = to.to\n  require stretch >= to.from and to.on >= 0 m\n'
    )
    assert [rule.name for rule in spec.rules] == ["made"]


def test_a_module_that_uses_it_sees_what_it_is_made_of(tmp_path: Path) -> None:
    (tmp_path / "inner.spec").write_text(TEXT.replace("made.stretches", "inner"), encoding="utf-8")
    (tmp_path / "outer.spec").write_text(
        'module outer\nuse inner\nrule made "made up"\n  require at.s in stretch chicane\n', encoding="utf-8"
    )
    case = {"signals": {"track": SQUARE, **station(75)}}
    assert Evaluator(tm.load(tmp_path / "outer.spec")).case(case).rules["made"].margin == 5


def test_one_of_a_named_track_is_on_that_track(tmp_path: Path) -> None:
    (tmp_path / "tracks").mkdir()
    text = (
        TEXT.replace("made.stretches", "tracks.ring") + 'rule made "m"\n  require at.s in stretch chicane\n'
    )
    (tmp_path / "tracks" / "ring.spec").write_text(text, encoding="utf-8")
    evaluator = Evaluator(tm.load(tmp_path / "tracks" / "ring.spec"))
    for name, faults in (
        ("ring", ()),
        ("oval", ("D230 track.name: the track is `oval`, but `chicane` is on `ring`",)),
    ):
        case = evaluator.case({"signals": {"track": {**SQUARE, "name": name}, **station(75)}})
        assert case.faults == faults


def test_a_definition_and_a_stretch_in_a_circle() -> None:
    made = compile_text(
        "module made\nsignal at : state { s: m }\nline l = (0 m, 0 m) (9 m, 0 m)\n"
        "define a -> m = if at.s in stretch b then 1 m else 2 m\nstretch b on l = a to 5 m\n"
    )
    assert [found.code for found in made.errors][:1] == ["E303"] or made.errors
