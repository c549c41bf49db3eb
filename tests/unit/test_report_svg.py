"""Axes, views, labels and pictures of the report."""

from __future__ import annotations

import math
from itertools import combinations, pairwise
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.report_runs import PLACES, SPEC, cycle, evaluator, large, other, overtaking, record, recording
from trackmarshal.scenarios.replay import replay
from trackmarshal.scenarios.run_record import run_record
from trackmarshal.trace.report.reading import read_run, stretches
from trackmarshal.trace.report.scores import scores
from trackmarshal.trace.report.svg import margin_plot, scene, score, timeline
from trackmarshal.trace.report.svg.axis import Axis, margin_axis, nice_step, nice_ticks
from trackmarshal.trace.report.svg.element import tag, text, thinned
from trackmarshal.trace.report.svg.labels import Places, around
from trackmarshal.trace.report.svg.view import NARROW, WIDE, fit
from trackmarshal.trace.report.words import clock, plain, quantity, told

SVG = "{http://www.w3.org/2000/svg}"
sizes = st.floats(1e-6, 1e6)
numbers = st.floats(-1e6, 1e6)


@given(low=numbers, span=sizes, wanted=st.integers(2, 20))
def test_ticks_are_round_few_and_inside(low: float, span: float, wanted: int) -> None:
    step = nice_step(span, wanted)
    mantissa = step / 10 ** math.floor(math.log10(step) + 1e-9)
    assert min(abs(mantissa - m) for m in (1, 2, 5, 10)) < 1e-6
    ticks = nice_ticks(low, low + span, wanted)
    assert len(ticks) <= wanted + 1
    assert all(low - 1e-6 * span - 1e-9 <= t <= low + span * (1 + 1e-6) + 1e-9 for t in ticks)


def test_ticks_of_a_run() -> None:
    assert nice_ticks(0.0, 12.2, 7) == [0.0, 2.0, 4.0, 6.0, 8.0, 10.0, 12.0]


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), max_size=30))
def test_margin_axis_shows_the_bound_and_every_finite_margin_in_order(values: list[float]) -> None:
    axis = margin_axis(values, 100.0, 10.0)
    assert axis.low < 0.0 < axis.high or axis.low <= 0.0 < axis.high or axis.low < 0.0 <= axis.high
    finite = sorted(v for v in values if math.isfinite(v))
    pixels = [axis.at(v) for v in finite]
    assert all(10.0 - 1e-6 <= p <= 100.0 + 1e-6 for p in pixels)
    assert all(a >= b - 1e-9 for a, b in pairwise(pixels))
    assert axis.at(math.inf) == pytest.approx(10.0)
    assert axis.at(-math.inf) == pytest.approx(100.0)
    assert 0.0 in axis.ticks(5) or axis.linear is None


def test_small_violations_stay_visible_beside_huge_margins() -> None:
    axis = margin_axis([-0.5, 1000.0], 100.0, 0.0)
    assert axis.linear is not None
    assert axis.at(-0.5) - axis.at(0.0) > 10.0
    assert margin_axis([-60.0, 25.0], 100.0, 0.0).linear is None


def test_axis_ticks_do_not_crowd() -> None:
    axis = margin_axis([-0.01, 5e6], 130.0, 0.0)
    places = sorted(axis.at(t) for t in axis.ticks(5))
    assert all(b - a > 12.0 for a, b in pairwise(places))


@given(
    st.lists(st.tuples(numbers, numbers), min_size=1, max_size=20),
    st.sampled_from([WIDE, NARROW]),
    st.one_of(st.none(), st.floats(-7, 7)),
)
def test_view_holds_all_points_and_keeps_shapes(
    points: list[tuple[float, float]], frame: Any, direction: float | None
) -> None:
    view = fit(points, frame, direction)
    assert view.width == frame.width
    assert view.height <= frame.highest + 1e-6
    assert all(view.inside(p, 1e-3) for p in view.path(points))
    for a, b in combinations(points[:4], 2):
        assert math.dist(view.at(*a), view.at(*b)) == pytest.approx(
            view.scale * math.dist(a, b), rel=1e-6, abs=1e-3
        )


def test_view_is_not_mirrored() -> None:
    """Left of the direction of travel must be left on the screen, whose y points down."""
    view = fit([(0.0, 0.0), (100.0, 50.0)], WIDE)
    (x0, y0), (x1, y1), (x2, y2) = view.at(0, 0), view.at(1, 0), view.at(0, 1)
    assert (x1 - x0) * (y2 - y0) - (y1 - y0) * (x2 - x0) < 0


def test_upright_view_travels_up() -> None:
    view = fit([(0.0, 0.0), (100.0, 0.0)], NARROW)
    assert view.at(100.0, 0.0)[1] < view.at(0.0, 0.0)[1]


def test_box_has_its_front_first() -> None:
    view = fit([(0.0, 0.0), (10.0, 0.0)], WIDE, 0.0)
    corners = view.box(0.0, 0.0, 0.0, 4.0, 2.0)
    assert corners[0] == pytest.approx(view.at(2.0, 1.0))
    assert corners[1] == pytest.approx(view.at(2.0, -1.0))
    assert corners[3] == pytest.approx(view.at(-2.0, 1.0))


def test_labels_never_overlap_and_stay_inside() -> None:
    places = Places(200.0, 100.0)
    boxes = [
        places.claim(around(20.0 * i, 50.0, 30.0, 10.0, (4.0, 12.0, 25.0), (-1.6, 1.6, 0.0)))
        for i in range(12)
    ]
    found = [box for box in boxes if box is not None]
    assert len(found) > 5
    for a, b in combinations(found, 2):
        assert a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
    assert all(b[0] >= 0 and b[1] >= 0 and b[2] <= 200 and b[3] <= 100 for b in found)


@given(st.lists(st.sampled_from("svu-"), max_size=30))
def test_stretches_cover_everything_once(letters: list[str]) -> None:
    found = list(stretches(letters))
    assert "".join(value * (last - first + 1) for value, first, last in found) == "".join(letters)
    assert all(a[0] != b[0] and a[2] + 1 == b[1] for a, b in pairwise(found))


def test_thinned_keeps_both_ends() -> None:
    line = [(0.1 * i, 0.0) for i in range(100)]
    kept = thinned(line, 1.0)
    assert (kept[0], kept[-1]) == (line[0], line[-1])
    assert len(kept) < 15


def test_elements_escape() -> None:
    made = ET.fromstring(text(1, 2, "<script>&'\"", data_x='"><script>'))
    assert made.text == "<script>&'\""
    assert made.get("data-x") == '"><script>'
    assert tag("line", x1=1 / 3, y1=None) == '<line x1="0.33"/>'


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (0.0, "0"),
        (-2.12345, "−2.123"),
        (12345.6, "12346"),
        (0.00012345, "0.0001234"),
        (2.5e9, "2.5·10⁹"),
        (-1e-9, "−1·10⁻⁹"),
    ],
)
def test_numbers_as_people_read_them(value: float, said: str) -> None:
    assert plain(value) == said


def test_units_and_what_is_not_finite() -> None:
    assert quantity(2.0, "m/s^2") == "2 m/s²"
    assert quantity(0.5, "1") == "0.5"
    assert [quantity(-2.511, unit) for unit in ("mixed", "scaled")] == [
        "−2.511 SI",
        "−2.511 scales",
    ]  # of several dimensions
    assert told("    flag = mixed") == ("flag", "mixed")
    assert [quantity(v, "m") for v in (math.nan, math.inf, -math.inf)] == ["undefined", "+∞", "−∞"]
    assert clock(0.30000000000000004) == "0.3"
    assert clock(1700000012.25) == "1700000012.25"  # of the clock of Unix
    assert clock(-1700000012.25) == "−1700000012.25"
    assert clock(-0.0001) == "0"


# Pictures ------------------------------------------------------------------------------------------------------------


def pictures(run: Any) -> list[ET.Element]:
    """All pictures of a run at both sizes, as XML."""
    made = []
    for layout, frame in ((timeline.WIDE, WIDE), (timeline.NARROW, NARROW)):
        made += [
            timeline.timeline(run, layout, {}),
            score.score_figure(run, scores(run, {}), layout, "s"),
            *scene.scenes(run, frame),
        ]
        made += [margin_plot.margin_plot(run, rule, layout, f"k{i}") for i, rule in enumerate(run.rules)]
        for index in run.beginnings():
            near = scene.moment(run, index, [], frame)
            made += [near] if near else []
    return [ET.fromstring(picture) for picture in made]


def test_pictures_are_xml_with_a_name_and_a_description(tmp_path: Path) -> None:
    found = pictures(read_run(record(tmp_path, overtaking("a <b> & c"))))
    assert len(found) > 10
    for picture in found:
        assert picture.tag == f"{SVG}svg"
        assert picture.findtext(f"{SVG}title")
        assert picture.findtext(f"{SVG}desc")
        coordinates = [
            value
            for e in picture.iter()
            for name, value in e.attrib.items()
            if name in ("d", "x", "y", "x1", "cx", "width")
        ]
        assert not any("nan" in value or "inf" in value for value in coordinates)


def test_timeline_has_a_row_a_rule_and_a_segment_a_stretch(tmp_path: Path) -> None:
    run = read_run(
        record(tmp_path, overtaking(ground_truth={"dynamic": (None,) * 9 + (False,) * 3 + (None,) * 28}))
    )
    picture = ET.fromstring(timeline.timeline(run, timeline.WIDE, {"R-2": "Keep & hold"}))
    words = ["".join(e.itertext()) for e in picture.iter(f"{SVG}text")]
    assert "R-2  Keep & hold" in words
    for rule in run.rules:
        assert any(rule.name in word for word in words)
    notes = [e.text or "" for e in picture.iter(f"{SVG}title")]
    assert (
        "near, driving, 1 to 3 s: violated, worst −10 m at 2 s; o: blue in objects (x = 40 m, y = 3 m)"
        in notes
    )
    # Cycle 9 must be unsafe and is not.
    assert [n for n in notes if "outside" in n] == ["0.9 s: missed: outside the ground truth"]


def test_no_cycle_is_outside_of_a_truth_that_is_about_no_rule(tmp_path: Path) -> None:
    """Where every rule has a truth of its own, the kinds judge nothing: the table said so, and the picture drew false alarms."""
    made = record(tmp_path, overtaking(ground_truth={"dynamic": (True,) * 40}))
    assert "false alarm: outside the ground truth" in timeline.timeline(read_run(made), timeline.WIDE, {})
    run = read_run({**made, "truths": []})
    assert "outside the ground truth" not in timeline.timeline(run, timeline.WIDE, {})


def test_that_a_cycle_is_unsafe_is_asked_of_no_rule_that_is_judged_with_others(tmp_path: Path) -> None:
    truth = (None, True, False, *(None,) * 37)
    run = read_run(record(tmp_path, overtaking(ground_truth={"dynamic": truth, "static": (True,) * 40})))
    dynamic = [rule for rule in run.rules if run.judged_by(rule) == "dynamic"]
    static = [rule for rule in run.rules if run.judged_by(rule) == "static"]
    assert len(dynamic) > 1
    assert static
    for rule in dynamic:
        assert run.asked_of([rule])[:3] == [None, True, None]
    assert run.asked_of(dynamic)[:3] == [None, True, False]
    # What is not asked of one of them is not asked of all, and what one of them has to do, all of them do.
    assert run.asked_of([dynamic[0], *static])[:3] == [None, True, None]
    assert run.asked_of([*dynamic, *static])[:3] == [None, True, False]
    unjudged = read_run(record(tmp_path, overtaking(ground_truth={"dynamic": truth})))
    (without, *_) = (rule for rule in unjudged.rules if unjudged.judged_by(rule) != "dynamic")
    assert unjudged.asked_of([without]) == [None] * 40
    assert unjudged.asked_of([dynamic[0], without])[:3] == [None] * 3
    behind = ET.fromstring(margin_plot.margin_plot(run, dynamic[0], timeline.WIDE, "k"))
    assert {e.get("class") for e in behind.iter(f"{SVG}rect")} & {"g-safe", "g-unsafe"} == {"g-safe"}


def test_timeline_columns_line_up_with_margins(tmp_path: Path) -> None:
    run = read_run(record(tmp_path, overtaking()))
    first = ET.fromstring(timeline.timeline(run, timeline.WIDE, {}))
    second = ET.fromstring(margin_plot.margin_plot(run, run.rules[1], timeline.WIDE, "k"))
    for name in ("data-x0", "data-x1", "data-t0", "data-t1"):
        assert first.get(name) == second.get(name)


def test_scene_shows_every_second_and_the_first_firing(tmp_path: Path) -> None:
    run = read_run(record(tmp_path, overtaking()))
    parts = [ET.fromstring(p) for p in scene.scenes(run, WIDE)]
    classes = [e.get("class") for p in parts for e in p.iter()]
    assert classes.count("foot ego") == 4
    assert classes.count("foot other") == 4
    assert classes.count("firing-ring") == 1
    assert "".join(t for p in parts for t in p.itertext()).count("1 s: near") >= 1


def test_scene_shows_the_places_that_rules_speak_of(tmp_path: Path) -> None:
    rules = evaluator(tmp_path, SPEC + PLACES)
    made = run_record(replay(overtaking(), rules), rules)
    run = read_run(made)
    parts = [ET.fromstring(p) for p in [*scene.scenes(run, WIDE), scene.moment(run, 0, [], WIDE) or ""]]
    for part in parts:
        drawn = [e for e in part.iter() if (e.get("class") or "").startswith("place ")]
        assert [(e.get("class"), (e.get("d") or "").endswith("Z")) for e in drawn] == [
            ("place zone", True),
            ("place line", False),
        ]
        assert {"slow", "start"} <= {t.strip() for t in part.itertext()}
    del made["places"]  # as older records have none
    assert "place zone" not in "".join(scene.scenes(read_run(made), WIDE))


def test_long_straight_scene_is_cut_into_strips_that_share_a_scale(tmp_path: Path) -> None:
    run = read_run(record(tmp_path, overtaking(count=130)))
    parts = [ET.fromstring(p) for p in scene.scenes(run, NARROW)]
    assert len(parts) > 1
    scales = {
        round(math.hypot(*(float(v) for v in (p.get("data-matrix") or "").split()[:2])), 3) for p in parts
    }
    assert len(scales) == 1
    assert sum(e.get("class") == "foot ego" for p in parts for e in p.iter()) == 13


@pytest.mark.parametrize("origin", [0.0, 5334567.8])
def test_the_page_draws_what_moves_where_the_picture_has_it(tmp_path: Path, origin: float) -> None:
    run = read_run(record(tmp_path, recording([cycle(0.0, origin), cycle(0.1, origin + 2.0)])))
    picture = ET.fromstring(scene.scenes(run, WIDE)[0])
    a, _, _, _, e, _ = (float(number) for number in (picture.get("data-matrix") or "").split())
    feet = [foot.get("d") or "" for foot in picture.iter() if foot.get("class") == "foot ego"]
    across = [float(corner.split()[0]) for corner in feet[0][1:-1].split("L")]
    assert a * origin + e == pytest.approx(sum(across) / 4, abs=0.02)


def test_far_vehicles_do_not_shrink_the_scene(tmp_path: Path) -> None:
    near = read_run(record(tmp_path, recording([cycle(0.0, 0.0), cycle(0.1, 2.0)])))
    far = read_run(record(tmp_path, recording([cycle(0.0, 0.0, [other("o", 9000.0)]), cycle(0.1, 2.0)])))
    assert [ET.fromstring(p).get("data-matrix") for p in scene.scenes(near, WIDE)] == [
        ET.fromstring(p).get("data-matrix") for p in scene.scenes(far, WIDE)
    ]


def test_margin_line_breaks_where_there_is_no_margin(tmp_path: Path) -> None:
    cycles = [cycle(0.1 * i, -100.0 if i == 3 else 0.0) for i in range(8)]
    run = read_run(record(tmp_path, recording(cycles)))
    root = next(rule for rule in run.rules if rule.name == "root")
    picture = ET.fromstring(margin_plot.margin_plot(run, root, timeline.WIDE, "k"))
    path = next(e for e in picture.iter(f"{SVG}path") if e.get("id") == "k-driving").get("d") or ""
    assert path.count("M") == 2
    assert any("undefined 0.3 to 0.3" in (e.text or "") for e in picture.iter(f"{SVG}title"))


def test_flicker_is_drawn_in_columns_that_lose_nothing_unsafe(tmp_path: Path) -> None:
    base = record(tmp_path, overtaking(count=2))
    run = read_run(large(base, 3000, 1, lambda rule, i: -1.0 if i == 1500 else 1.0 + (i % 2)))
    rule = run.rules[0]
    shown = ET.fromstring(timeline.timeline(run, timeline.WIDE, {}))
    assert [e for e in shown.iter() if e.get("class") == "b-violated"]
    flicker = read_run(large(base, 3000, 1, lambda rule, i: -1.0 if i % 7 == 0 else 1.0))
    dense = timeline.timeline(flicker, timeline.WIDE, {})
    assert len(dense) < 40_000
    assert 'class="b-violated"' in dense
    assert len(margin_plot.margin_plot(run, rule, timeline.NARROW, "k")) < 20_000


def test_axis_of_equal_margins() -> None:
    assert isinstance(margin_axis([0.0, 0.0], 10.0, 0.0), Axis)
    assert margin_axis([], 10.0, 0.0).at(0.0) == pytest.approx(5.0)
