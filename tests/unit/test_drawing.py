"""Parts of drawings: regions on a grid, samples that are shown, inputs that are chosen, and what `show --draw` and the safety case make of them."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.drawings import SVG, Drawn
from support.project import run_command
from support.safety_case import DAY, html, made_ready
from trackmarshal.cli import drawing
from trackmarshal.cli.facts import Facts
from trackmarshal.reading.drawing.choosing import Known, Standing, ranked, window
from trackmarshal.reading.drawing.contour import Grid, lines
from trackmarshal.reading.drawing.demand import BROKEN, HOLDS, UNKNOWN, Demand
from trackmarshal.reading.drawing.drawn import drawn
from trackmarshal.reading.drawing.making import drawings
from trackmarshal.reading.drawing.points import Points
from trackmarshal.reading.drawing.recorded import CELLS, thinned
from trackmarshal.records.specs import SpecItem
from trackmarshal.runtime.frame import Settings
from trackmarshal.semantics.compile import Compiled, compile_text
from trackmarshal.testing.cases import prepare
from trackmarshal.trace.case.words.language import english
from trackmarshal.trace.report.svg.boundary import picture

ROOT = Path(__file__).resolve().parents[2]


# Regions ------------------------------------------------------------------------------------------------------


def grid(says: Any, cells: int = 24) -> Grid:
    return Grid(lambda x, y: np.asarray(says(x, y), dtype=np.uint8), cells, cells)


def area(points: list[tuple[float, float]]) -> float:
    """With its sign: positive where what is around lies on the left."""
    return sum(ax * by - bx * ay for (ax, ay), (bx, by) in zip(points, points[1:] + points[:1])) / 2


def test_a_disc_has_its_area_and_its_border() -> None:
    (border,) = grid(lambda x, y: np.hypot(x - 0.5, y - 0.4) <= 0.3).borders(1)
    assert area(border.corners) == pytest.approx(math.pi * 0.09, rel=1e-3)
    assert all(math.hypot(x - 0.5, y - 0.4) == pytest.approx(0.3, abs=1e-6) for x, y in border.corners)
    assert set(border.beyond) == {0}


def test_a_ring_has_a_hole() -> None:
    found = grid(lambda x, y: abs(np.hypot(x - 0.5, y - 0.5) - 0.3) <= 0.1).borders(1)
    assert sorted(round(area(one.corners), 2) for one in found) == [-0.13, 0.5]


def test_what_runs_into_the_edge_is_closed_there() -> None:
    (border,) = grid(lambda x, y: y <= 0.25 + 0.5 * x).borders(1)
    assert area(border.corners) == pytest.approx(0.5, rel=1e-6)
    (line,) = lines(border, 0)
    assert [tuple(round(v, 4) for v in end) for end in sorted((line[0], line[-1]))] == [
        (0.0, 0.25),
        (1.0, 0.75),
    ]


def test_all_of_the_plane_and_nothing_of_it() -> None:
    whole = grid(lambda x, y: np.ones_like(x))
    (border,) = whole.borders(1)
    assert area(border.corners) == pytest.approx(1.0)
    assert whole.borders(0) == []
    assert lines(border, 0) == []
    assert whole.widest(0) is None


@pytest.mark.parametrize("joined", [True, False])
def test_two_corners_across_hang_together_where_the_middle_says_so(joined: bool) -> None:
    """A cell whose corners are said crosswise."""
    wide = 0.56 if joined else 0.44

    def says(x: Any, y: Any) -> Any:
        return (abs(x - y) <= wide) if joined else ~(abs(x + y - 1) <= 1 - wide)

    found = Grid(lambda x, y: says(x, y).astype(np.uint8), 1, 1).borders(1)
    assert len(found) == (1 if joined else 2)


def test_three_things_said_meet_without_gaps() -> None:
    said = grid(lambda x, y: np.where(x < 0.37, 2, np.where(y < 0.3 + 0.4 * x, 0, 1)), 30)
    areas = [sum(area(one.corners) for one in said.borders(code)) for code in (0, 1, 2)]
    assert sum(areas) == pytest.approx(1.0, abs=1e-3)
    assert areas[2] == pytest.approx(0.37, abs=1e-6)
    (border,) = said.borders(1)
    assert all(x >= 0.37 - 1e-3 for line in lines(border, 0) for x, _ in line)


def test_what_is_thinner_than_a_cell_is_noticed() -> None:
    assert grid(lambda x, y: abs(x - y - 0.021) < 0.01).hides()
    assert not grid(lambda x, y: abs(x - y) < 0.2).hides()


def test_what_is_not_found_between_lines_of_the_grid_moves_no_corner() -> None:
    """A spike between two lines of the grid, as long as a whole cell and more: it is hidden, and nothing is made up in its place."""
    spiked = grid(lambda x, y: (y <= 0.51) | ((abs(x - 0.5208) < 0.01) & (y <= 0.9)))
    assert spiked.hides()
    (border,) = spiked.borders(1)
    assert area(border.corners) == pytest.approx(0.51, abs=1e-6)


def test_a_letter_stands_well_inside() -> None:
    point = grid(lambda x, y: np.hypot(x - 0.7, y - 0.6) < 0.2).widest(1)
    assert point is not None
    assert math.hypot(point[0] - 0.7, point[1] - 0.6) < 0.08


@pytest.mark.parametrize(
    ("declared", "limit", "shown"),
    [("km in [0, 3]", "2 km", (0.0, 3.0)), ("m in [-1e9, 1e9]", "0.1 m", (-0.5, 0.5))],
)
def test_without_tests_and_recordings_a_picture_shows_the_declared_range(
    declared: str, limit: str, shown: tuple[float, float]
) -> None:
    """The first half metre of three kilometres was drawn, all of it satisfied, with the limit far beyond."""
    compiled = compile_text(
        f'module m\nsignal ego : state {{ s: {declared} }}\nrule r "r"\n  require ego.s <= {limit}\n'
    )
    ((_, made),) = drawings([compiled.spec.rules[0]], compiled.spec, [], [])
    (axis,) = made["axes"]
    assert (axis["low"], axis["high"]) == shown
    assert made["boundary"]


def test_what_is_fixed_without_tests_and_recordings_is_in_its_declared_range() -> None:
    compiled = compile_text(
        "module m\nsignal ego : state { a: m in [0, 9], b: m in [0, 9], c: m in [5, 6] }\n"
        'rule r "r"\n  require ego.a * ego.c <= 9 m * ego.b\n'
    )
    ((_, made),) = drawings([compiled.spec.rules[0]], compiled.spec, [], [], None, "a", "b")
    assert made["fixed"] == [["ego.c", "5 m"]]


@pytest.mark.parametrize(
    ("ends", "limit", "shown"),
    [("[5, 1e9]", ">= 3 m/s", (5.0, 7.5)), ("[1, 1e9] default 200 m/s", "<= 1e9 m/s", (100.0, 300.0))],
)
def test_without_a_range_that_says_much_a_picture_is_around_what_would_be_fixed(
    ends: str, limit: str, shown: tuple[float, float]
) -> None:
    """It was around 0, also where that is beyond what may be: all of it violated, of a rule that always holds."""
    compiled = compile_text(
        f'module m\nsignal ego : state {{ v: m/s in {ends} }}\nrule r "r"\n  allow W301 because "made"\n  require ego.v {limit}\n'
    )
    ((_, made),) = drawings([compiled.spec.rules[0]], compiled.spec, [], [])
    (axis,) = made["axes"]
    assert (axis["low"], axis["high"]) == shown


@pytest.mark.parametrize(("over", "hides"), [("v", False), ("w", False), ("lap", True)])
def test_what_is_the_same_all_over_a_picture_is_not_too_thin_for_it(over: str, hides: bool) -> None:
    """Of an input that is fixed, and of a parameter, a number is the same as another one, or is not, everywhere."""
    compiled = compile_text(
        "module m\nsignal ego : state { v: m/s in [0, 9], w: m/s in [0, 9], lap: 1 in [0, 9] }\nparam mode : 1 = 3\n"
        'rule r "r"\n  require ego.lap == 3 or mode == 2 or ego.v <= ego.w\n'
    )
    against = "w" if over == "v" else "v"
    ((_, made),) = drawings([compiled.spec.rules[0]], compiled.spec, [], [], None, over, against)
    assert made["hides"] is hides


@pytest.mark.parametrize(("op", "hides"), [("!=", True), ("==", True), ("<=", False)])
def test_a_demand_that_numbers_are_the_same_is_too_thin_to_be_drawn(op: str, hides: bool) -> None:
    """`!=` was drawn as met all over, without a word, and is violated on a line."""
    compiled = compile_text(
        "module m\nsignal ego : state { v: m/s in [0, 9], w: m/s in [0, 9] }\n"
        f'rule r "r"\n  allow W301 because "made"\n  require ego.v {op} ego.w * 1.0371 + 0.1 m/s\n'
    )
    ((_, made),) = drawings([compiled.spec.rules[0]], compiled.spec, [], [])
    assert made["hides"] is hides


# Samples ------------------------------------------------------------------------------------------------------


def points(values: Any, codes: Any, margins: Any) -> Points:
    return Points(
        np.array(values),
        np.array(codes, dtype=np.uint8),
        np.array(margins),
        np.zeros(len(codes), dtype=np.intp),
        0,
    )


def test_nothing_that_is_against_the_rule_is_thinned_away() -> None:
    choose = np.random.default_rng(7)
    values = choose.uniform(-0.2, 1.2, (2, 20_000))
    codes = choose.choice([HOLDS, BROKEN, UNKNOWN], 20_000, p=[0.8, 0.15, 0.05])
    kept = thinned(points(values, codes, choose.uniform(0, 1, 20_000)), [0, 1], [(0.0, 1.0), (0.0, 1.0)])
    shown = {tuple(one) for one in np.round(kept.broken * 1000).astype(int).tolist()}
    for place in np.clip(values[:, codes == BROKEN], 0.0, 1.0).T:
        near = np.round(place * 1000).astype(int)
        assert any((near[0] + i, near[1] + j) in shown for i in (-1, 0, 1) for j in (-1, 0, 1)), place
    assert kept.seen == (int((codes == HOLDS).sum()), int((codes == BROKEN).sum()))
    outside = ((values < 0) | (values > 1)).any(axis=0)
    assert kept.beyond == (int((outside & (codes == HOLDS)).sum()), int((outside & (codes == BROKEN)).sum()))


def test_of_a_cell_the_sample_that_is_nearest_to_the_limit_is_shown() -> None:
    choose = np.random.default_rng(8)
    values, margins = choose.uniform(0, 1, (2, 30_000)), choose.uniform(0, 1, 30_000)
    kept = thinned(points(values, np.zeros(30_000), margins), [0, 1], [(0.0, 1.0), (0.0, 1.0)])
    best: dict[tuple[int, int], tuple[float, float, float]] = {}
    for x, y, margin in zip(*values.tolist(), margins.tolist()):
        cell = int(x * CELLS[0]), int(y * CELLS[1])
        best[cell] = min(best.get(cell, (9.0, 0.0, 0.0)), (margin, x, y))
    assert sorted(map(tuple, kept.held.tolist())) == sorted((x, y) for _, x, y in best.values())


# Inputs -------------------------------------------------------------------------------------------------------

PLAIN = """
module m
signal p : state { a: m in [0, 100], b: m in [0, 100], c: m in [0, 100], d: m in [0, 100] default 7 m, on: bool }
param most : m = 50 m in [0, 200]
rule r "a sum"
  require 2 * p.a + 0.1 * p.b + p.c + 0 * p.d <= most
test r "near"
  given p = { a: 10 m, b: 10 m, c: 10 m, d: 1 m }
  expect satisfied
test r "far"
  given p = { a: 30 m, b: 60 m, c: 40 m, d: 1 m }
  expect violated
test r "exactly"
  given most = 31 m
  given p = { a: 10 m, b: 10 m, c: 10 m, d: 1 m }
  expect satisfied, margin 0 m
"""


def compiled(text: str) -> Compiled:
    made = compile_text(text)
    made.raise_errors()
    return made


def made(text: str, rule: str = "r", over: str | None = None, against: str | None = None) -> dict[str, Any]:
    whole = compiled(text)
    info = whole.spec.rule(rule)
    assert info is not None
    ((_, found),) = drawings([info], whole.spec, prepare(whole)[0], (), None, over, against)
    return dict(found)


def test_the_two_that_change_the_margin_most_are_drawn() -> None:
    found = made(PLAIN)
    assert [one["label"] for one in found["axes"]] == ["p.c", "p.a"]
    assert found["fixed"] == [
        ["p.b", "10 m"],
        ["p.d", "7 m"],
    ]  # the middle of the tests; the default, which is declared
    assert [one["with"] for one in found["others"]] == ["most = 31 m, p.d = 1 m"]


def test_inputs_can_be_asked_for() -> None:
    assert [one["label"] for one in made(PLAIN, "r", "p.b", "most")["axes"]] == ["p.b", "most"]
    assert [one["label"] for one in made(PLAIN, "r", None, "c")["axes"]] == ["p.a", "p.c"]


def test_one_input_is_drawn_on_a_line() -> None:
    found = made(PLAIN.replace("2 * p.a + 0.1 * p.b + p.c + 0 * p.d", "2 * p.a"))
    read = Drawn(picture(found, english(), "k").svg)
    (axis,) = found["axes"]
    assert axis["label"] == "p.a"
    for x in (20.0, 24.9, 25.1, 30.0):
        place = read.left + (x - axis["low"]) / (axis["high"] - axis["low"]) * (read.right - read.left)
        assert read.region((place, read.top + 30.0)) == ("holds" if x < 25 else "broken"), x


def test_a_window_shows_where_the_demand_ends_to_hold() -> None:
    """Though tests are far from it, up to what may be."""
    spec = compiled(PLAIN).spec
    demand = Demand(spec.rules[0], spec)
    low = Known([Standing("near", np.array([1.0, 1.0, 1.0, 1.0]), "satisfied", False, Settings())], None)
    fixed = np.array([1.0, 1.0, 1.0, 1.0])
    (a_low, a_high), (_, c_high) = window(demand, [0, 2], fixed, low)
    assert 0.0 <= a_low < a_high <= 100.0
    assert 2 * a_high + c_high > 50.0
    assert ranked(demand, low)[0] == 0


@pytest.mark.parametrize(
    ("demand", "reason"),
    [
        ("p.on", "truth"),
        ("true", "none"),
        ("always[0 s, 1 s] p.a <= 3 m", "memory"),
        ("count(o in os where o.a > 1 m) <= 3", "many"),
        ("max(o.a for o in os else 0 m) <= 3 m", "many"),
        ("p.a <= case p.kind { one: 1 m, two: 2 m }", "member"),
        ("p.a <= (if p.on then 1 m else 2 m)", "truth"),
        ("for all o in os: o.a <= 3 m", "many"),
        ("1 m <= most", "none"),
    ],
)
def test_what_is_no_demand_on_numbers_says_why(demand: str, reason: str) -> None:
    text = (
        PLAIN.partition("rule r")[0].replace("on: bool", "on: bool, kind: kind")
        + f'enum kind {{ one, two }}\nsignal os : set of object {{ a: m }}\nrule r "x"\n  require {demand}\n'
    )
    found = made(text)
    assert found == {"rule": "r", "none": reason}
    assert english()[f"drawing.none.{reason}"]


@pytest.mark.parametrize(
    "clause", ["for all o in os", "exists o in os", "along plan as o", "for all o in os for all q in os"]
)
def test_a_clause_whose_variable_nothing_asks(clause: str) -> None:
    """There is one place all the same: of a rule that holds for as long as there is anything."""
    found = made(f"""
module m
signal p : state {{ a: m in [0, 100], b: m in [0, 100] }}
signal os : set of object {{ a: m }}
signal plan : trajectory {{ t: s increasing, v: m/s }}
rule r "a sum"
  {clause}
  require p.a + p.b <= 50 m
test r "near"
  given p = {{ a: 10 m, b: 10 m }}
  given os = [{{ a: 1 m }}, {{ a: 2 m }}]
  given plan = {{ t: [0 s, 1 s], v: [1 m/s, 1 m/s] }}
  expect satisfied
""")
    assert {one["label"] for one in found["axes"]} == {"p.a", "p.b"}
    assert [one["title"] for one in found["tests"]] == ["near"]


def test_recorded_values_of_a_choice_are_those_of_the_case() -> None:
    """A number is another node wherever a condition stands in it: all its places are one input."""
    text = PLAIN.replace(
        'rule r "a sum"\n  require 2 * p.a + 0.1 * p.b + p.c + 0 * p.d <= most',
        "define far(x: m, y: m, z: m, w: m) -> m = (if x > y then x else y) + z + w\n"
        'rule r "a choice"\n  require far(p.a, p.b, p.c, p.d) <= most and far(p.a, p.b, p.c, p.d) >= 0 m',
    )
    spec = compiled(text).spec
    demand = Demand(spec.rules[0], spec)
    assert [one.label for one in demand.quantities] == ["far(a_p, b_p, c_p, d_p)"]
    codes, margins = demand.judge([np.array([-1.0, 49.0, 51.0, math.nan])])
    assert codes.tolist() == [BROKEN, HOLDS, BROKEN, UNKNOWN]
    assert margins.tolist()[:3] == [-1.0, 1.0, -1.0]


def test_what_authors_write_is_no_markup() -> None:
    evil = '<script>alert(1)</script> & "quotes"'
    found = made(PLAIN.replace('"near"', '"<script>alert(1)</script> & more"'))
    found["fixed"] = [[evil, evil]]
    svg = picture(found, english(), "k").svg
    root = ET.fromstring(svg)
    assert root.find(f".//{SVG}script") is None
    assert "<script>" in "".join(root.itertext())


def test_ids_are_apart_on_a_page() -> None:
    found = made(PLAIN)
    ids = [
        one.get("id")
        for key in ("a", "b")
        for one in ET.fromstring(picture(found, english(), key).svg).iter()
        if one.get("id")
    ]
    assert len(ids) == len(set(ids)) == 6


def test_the_same_drawing_twice() -> None:
    assert made(PLAIN) == made(PLAIN)
    spec = compiled(PLAIN).spec
    demand = Demand(spec.rules[0], spec)
    assert drawn(demand, [0, 2], Known([], None))["boundary"]


# What users see -----------------------------------------------------------------------------------------------


def test_show_writes_a_picture(tmp_path: Path) -> None:
    spec, out = tmp_path / "m.spec", tmp_path / "r.svg"
    spec.write_text(PLAIN)
    assert run_command("show", "r", "--draw", "--spec", str(spec), "--out", str(out)) == (0, "", "")
    status, said, _ = run_command("show", "r", "--draw", "--spec", str(spec))
    assert (status, said) == (0, out.read_text("utf-8"))
    assert len(Drawn(said).tests) == 3


def test_another_value_in_force_moves_the_line_and_leaves_tests_theirs(tmp_path: Path) -> None:
    spec, other = tmp_path / "m.spec", tmp_path / "other.spec"
    spec.write_text(PLAIN.replace("default 7 m", "default 1 m"))
    other.write_text("module other\nparam most : m = 80 m in [0, 200]\n")
    arguments = ("show", "r", "--draw", "--spec", str(spec), "--over", "p.c", "--against", "p.a")
    before, after = (Drawn(run_command(*arguments, *more)[1]) for more in ((), ("--with", str(other))))
    for read, most in ((before, 50.0), (after, 80.0)):
        for line in read.boundary:
            for point in line:
                c, a = read.value(point)
                assert 2 * a + 1.0 + c == pytest.approx(most, abs=0.5)
    filled = {said: alike for _, _, said, alike in before.tests}
    assert any(filled.values())
    assert not any(alike for _, _, _, alike in after.tests)  # all are of 50 m


def test_wrong_inputs_are_refused(tmp_path: Path) -> None:
    spec = tmp_path / "m.spec"
    spec.write_text(PLAIN)
    for more, code, words in (
        (("--over", "p.z"), "E493", "did you mean"), (("--over", "a", "--against", "p.a"), "E493", "are one input"),
    ):  # fmt: skip
        status, _, err = run_command("show", "r", "--draw", "--spec", str(spec), *more)
        assert (status, code in err, words in err) == (2, True, True), err
    spec.write_text(PLAIN.partition("rule r")[0] + 'rule r "x"\n  require p.on\n')
    status, _, err = run_command("show", "r", "--draw", "--spec", str(spec))
    assert status == 2
    assert "E494" in err
    assert f"{spec}:5" in err


@pytest.fixture(scope="module")
def warehouse(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return made_ready(tmp_path_factory.mktemp("drawn"))


def test_the_case_shows_a_drawing_of_each_rule_or_says_why_not(warehouse: Path) -> None:
    page = html(warehouse).html
    rules = page.count('<div class="part level-3" id="rule-')
    assert rules
    assert page.count("<h3>Boundary</h3>") >= rules
    assert page.count('aria-label="Where ') + page.count("No drawing: ") == page.count("<h3>Boundary</h3>")


def test_of_very_many_rules_the_first_are_drawn_and_it_is_said_how_the_others_are(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = html(warehouse).html
    assert "draws this one" not in whole
    drawn = whole.count('aria-label="Where ')
    assert drawn > 1
    monkeypatch.setattr(drawing, "MOST", 1)
    page = html(warehouse).html
    assert page.count('aria-label="Where ') + page.count("No drawing: ") == page.count("<h3>Boundary</h3>")
    assert 'aria-label="Where slow_near_people ceases' in page
    assert page.count('aria-label="Where ') < drawn
    assert re.findall(r"<code>(trackmarshal show \w+ --draw)</code> draws this one", page)


def test_what_is_kept_is_used_and_what_was_changed_is_made_again(
    warehouse: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    first = html(warehouse).html
    (kept,) = tmp_path.glob("drawings-*.json")
    made_: list[list[str]] = []
    really = drawing._made

    def noted(names: Any, *rest: Any) -> Any:
        made_.append(list(names))
        return really(names, *rest)

    monkeypatch.setattr(drawing, "_made", noted)
    assert html(warehouse).html == first
    assert made_ == []
    # Changed by hand, it counts for nothing, and what is made again is the same.
    kept.write_bytes(kept.read_bytes().replace(b"0.5", b"0.6"))
    assert html(warehouse).html == first
    assert len(made_) == 1
    # A test that gives something else is drawn elsewhere: only its rule is made again.
    spec = warehouse / "specs" / "robot.spec"
    text = spec.read_text("utf-8")
    title = text.partition("test ")[2].partition('"')[2].partition('"')[0]
    spec.write_text(text.replace(title, f"{title}, again"), "utf-8")
    html(warehouse)
    spec.write_text(text, "utf-8")
    assert len(made_) == 2
    assert len(made_[1]) == 1
    assert DAY


def test_a_rule_is_drawn_elsewhere_where_a_run_of_its_own_reads_something_else() -> None:
    """The recording, or what the rule is replayed with there, and no rule besides it; a run whose recording is not there is not drawn."""
    items = [
        SpecItem("rule", name, "", (), (), "m.spec", 1, 1, name, inputs={f"rule {name}": name})
        for name in ("a", "b")
    ]
    inputs = {
        "one": {"recording": "1", "signal ego": "1", "rule a": "1"},
        "two": {"recording": "1", "rule b": "1", "rule c": "1"},
        "lost": {"signal ego": "1", "rule a": "1", "rule b": "1"},
    }
    said = Facts(items, [], [], inputs, [], [])

    def moved(run: str, name: str) -> str:
        """The rules that are drawn elsewhere where this is another in this run."""
        other = replace(said, run_inputs={**inputs, run: {**inputs[run], name: "2"}})
        before, after = (drawing._keys(each, {"a": {}, "b": {}}) for each in (said, other))
        return "".join(rule for rule in before if before[rule] != after[rule])

    assert [moved("one", name) for name in inputs["one"]] == ["a", "a", "a"]
    assert [moved("two", name) for name in inputs["two"]] == ["b", "b", ""]
    assert [moved("lost", name) for name in inputs["lost"]] == ["", "", ""]
    others = (("lost", "recording"), ("two", "param most"), ("two", "rule a"))
    assert [moved(run, name) for run, name in others] == ["ab", "b", "a"]
