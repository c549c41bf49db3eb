"""Drawings of boundaries against the reference evaluator: what the picture shows at a place, read back from its SVG, is what the rule itself says of a case that is there."""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.drawings import Drawn
from support.length import amount
from support.shared import REPOSITORY, SUPERVISOR
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.reading.drawing.demand import BROKEN, HOLDS, UNKNOWN, Demand
from trackmarshal.reading.drawing.making import drawings
from trackmarshal.reading.drawing.points import Places
from trackmarshal.reading.drawing.quantities import Undrawable
from trackmarshal.scenarios import load as load_recording
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.testing.cases import PreparedTest, prepare
from trackmarshal.testing.si import spec_in_si
from trackmarshal.trace.case.words.language import english
from trackmarshal.trace.report.svg.boundary import picture

#: Places on each side of a boundary that are asked about, and how far from it they are at least, in pixels.
PLACES, BESIDE = amount(50, 150), 1.2
SAID = {"satisfied": "holds", "violated": "broken", "undefined": "unknown"}
#: A case of a rule with these two numbers, and what the picture says it is drawn with.
Case = Callable[[float, float, Mapping[str, float]], Mapping[str, Any]]


def drawn(compiled: Compiled, rule: str, over: str | None = None, against: str | None = None) -> Drawn:
    info = compiled.spec.rule(rule)
    assert info is not None
    tests, _ = prepare(compiled)
    ((_, found),) = drawings([info], compiled.spec, tests, (), None, over, against)
    return Drawn(picture(found, english(), "k").svg)


def fixed(picture_: Drawn) -> dict[str, float]:
    """What a picture says that it is drawn with."""
    lines = [one for one in picture_.words if one.startswith("Drawn with ")]
    said = lines[0].removeprefix("Drawn with ").rstrip(".") if lines else ""
    return {
        name: float(value.split()[0])
        for name, _, value in (one.partition(" = ") for one in said.split(", ") if one)
    }


def plan(**columns: float) -> dict[str, Any]:
    row = {
        "t": 0.0,
        "s": 0.0,
        "x": 0.0,
        "y": 0.0,
        "heading": 0.0,
        "kappa": 0.0,
        "v": 10.0,
        "a": 0.0,
        "grip": 1.0,
        **columns,
    }
    return {"plan": {name: [value, value + (name == "t")] for name, value in row.items()}}


def friction(x: float, y: float, others: Mapping[str, float]) -> Mapping[str, Any]:
    return {"signals": plan(kappa=x, v=y, a=others["p.a"], grip=others["p.grip"])}


def drive(x: float, y: float, others: Mapping[str, float]) -> Mapping[str, Any]:
    return {"signals": plan(v=x, a=y)}


def heading(x: float, y: float, others: Mapping[str, float]) -> Mapping[str, Any]:
    return {"signals": {**plan(heading=x), "ego": {"heading": y, "x": 0.0, "y": 0.0, "v": 1.0, "age": 0.0}}}


def gap(x: float, y: float, others: Mapping[str, float]) -> Mapping[str, Any]:
    """On a straight track, one behind the other: from bumper to bumper, both 4.7 m long as the vehicle is."""
    car = {"y": 0.0, "heading": 0.0, "length": 4.7, "width": 2.8, "age": 0.0}
    return {
        "signals": {
            "ego": {"x": 0.0, "y": 0.0, "heading": 0.0, "v": y, "age": 0.0},
            "objects": [{**car, "id": "o", "x": x + 4.7, "v": others["along_track(o)"]}],
            "track": {
                "left": [[-100.0, 6.0], [900.0, 6.0]],
                "right": [[-100.0, -6.0], [900.0, -6.0]],
                "closed": False,
            },
        }
    }


@pytest.fixture(scope="module")
def shipped() -> Compiled:
    return compile_paths([SUPERVISOR], REPOSITORY)


@pytest.mark.parametrize(
    ("rule", "axes", "case", "least"),
    [
        ("friction", ("kappa", "v"), friction, -math.inf),
        ("drive_acceleration", ("v", "a"), drive, -math.inf),
        ("safe_gap", ("gap_lon", "along_track(ego)"), gap, 0.01),  # of those who overlap, another rule speaks
    ],
)
def test_both_sides_are_what_the_reference_says(
    shipped: Compiled, rule: str, axes: tuple[str, str], case: Case, least: float
) -> None:
    picture_ = drawn(shipped, rule, *axes)
    evaluator = Evaluator(spec_in_si(shipped.spec), [rule], "reference")
    choose, others = random.Random(rule), fixed(picture_)
    seen = {"holds": 0, "broken": 0}
    for _ in range(40 * PLACES):
        point = choose.uniform(picture_.left, picture_.right), choose.uniform(picture_.top, picture_.low)
        x, y = picture_.value(point)
        if picture_.near(point) < BESIDE or x < least:
            continue
        region = picture_.region(point)
        if seen[region] == PLACES:
            continue
        seen[region] += 1
        verdict = evaluator.case(case(x, y, others)).rules[rule].verdict
        assert SAID[verdict] == region, (x, y, verdict)
        if min(seen.values()) == PLACES:
            break
    assert min(seen.values()) >= PLACES / 2, seen


def test_the_line_is_where_the_verdict_changes(shipped: Compiled) -> None:
    """Across every piece of the line, a pixel to each side."""
    picture_ = drawn(shipped, "friction", "kappa", "v")
    evaluator = Evaluator(spec_in_si(shipped.spec), ["friction"], "reference")
    others, pieces = fixed(picture_), 0
    for line in picture_.boundary:
        for (ax, ay), (bx, by) in zip(line, line[1:]):
            length = math.hypot(bx - ax, by - ay)
            if length < 1.0:
                continue
            right = (by - ay) / length, -(bx - ax) / length
            sides = [((ax + bx) / 2 + k * right[0], (ay + by) / 2 + k * right[1]) for k in (-1.0, 1.0)]
            if not all(
                picture_.left < x < picture_.right and picture_.top < y < picture_.low for x, y in sides
            ):
                continue
            said = [
                evaluator.case(friction(kappa, v, others)).rules["friction"].verdict
                for kappa, v in map(picture_.value, sides)
            ]
            assert sorted(said) == ["satisfied", "violated"], (line, said)
            pieces += 1
    assert pieces > 20


def test_tests_lie_where_they_are_decided(shipped: Compiled) -> None:
    """Those whose other values are the drawn ones lie on their side, and those on the boundary on a line."""
    picture_ = drawn(shipped, "drive_acceleration", "v", "a")
    shapes = {
        shape: [one for one in picture_.tests if one[0] == shape]
        for shape in ("boundary", "satisfied", "violated")
    }
    assert all(shapes.values())
    for shape, region in (("satisfied", "holds"), ("violated", "broken")):
        for _, point, said, filled in shapes[shape]:
            if filled and "beyond" not in said:
                assert picture_.region(point) == region, said
    own = [line for other in picture_.others for line in other]
    for _, (x, y), said, filled in shapes["boundary"]:
        lines = picture_.boundary if filled else own
        near = min(
            math.hypot(x - (ax + k * (bx - ax) / 20), y - (ay + k * (by - ay) / 20))
            for line in lines for (ax, ay), (bx, by) in zip(line, line[1:]) for k in range(21)
        )  # fmt: skip
        assert near < 1.5, said


@pytest.fixture(scope="module")
def everything() -> tuple[Spec, list[PreparedTest]]:
    folders = ["fallback", "rulebooks", "supervisor", "tracks", "variants", "vehicles", "watch", "interstate"]
    compiled = compile_paths([REPOSITORY / "specs" / one for one in folders], REPOSITORY)
    return compiled.spec, prepare(compiled)[0]


@pytest.mark.acceptance  # whole drawings do, every day
def test_a_demand_by_itself_says_what_the_rule_says(everything: tuple[Spec, list[PreparedTest]]) -> None:
    """At the place that decides a test, the demand on its inputs alone has the verdict, and the margin, that the test expects of the whole rule."""
    spec, tests = everything
    in_si, compared, drawable = spec_in_si(spec), 0, 0
    for rule in spec.rules:
        try:
            demand = Demand(rule, spec)
        except Undrawable:
            continue
        drawable += 1
        places, evaluator = Places(demand), Evaluator(in_si, [rule.name], "reference")
        for test in tests:
            if test.rule.name != rule.name or test.later:
                continue
            frame = evaluator.read(test.case)
            points = places.of([frame])
            place = points.decisive()
            if place is None:  # `exists` of nothing is violated, at no place
                assert test.verdict in ("undefined", "inactive") or test.margin == -math.inf, test.title
                continue
            values = points.values[:, place]
            codes, margins = demand.judge([np.array([value]) for value in values], frame.settings)
            wanted = HOLDS if test.verdict == "satisfied" else BROKEN
            assert codes[0] == points.codes[place] == wanted, (rule.name, test.title)
            assert demand.reference(list(values), frame.settings) == wanted, (rule.name, test.title)
            if test.margin is not None:
                assert abs(margins[0] - test.margin) <= test.tolerance + 1e-12, (rule.name, test.title)
                compared += 1
    assert drawable >= 25
    assert compared >= 120


UNDEFINED = """
module m
signal p : state { v: m/s in [-10, 30], a: 1 in [-2, 2] }
rule r "below a root, and divided by"
  require sqrt(p.v / 1 m/s) / p.a <= 4
test r "well below"
  given p = { v: 4 m/s, a: 1 }
  expect satisfied
test r "at rest"
  given p = { v: 0 m/s, a: -1 }
  expect satisfied
test r "exactly"
  given p = { v: 16 m/s, a: 1 }
  expect satisfied, margin 0
test r "above"
  given p = { v: 25 m/s, a: 0.5 }
  expect violated
"""


def test_what_is_undefined_is_a_region_of_its_own(tmp_path: Path) -> None:
    (tmp_path / "m.spec").write_text(UNDEFINED)
    compiled = compile_paths([tmp_path])
    compiled.raise_errors()
    picture_ = drawn(compiled, "r", "v", "a")
    evaluator = Evaluator(compiled.spec, ["r"], "reference")
    choose, seen = random.Random(3), dict.fromkeys(SAID.values(), 0)
    for _ in range(1500):
        point = choose.uniform(picture_.left, picture_.right), choose.uniform(picture_.top, picture_.low)
        if picture_.near(point) < BESIDE:
            continue
        v, a = picture_.value(point)
        region = picture_.region(point)
        seen[region] += 1
        assert SAID[evaluator.case({"signals": {"p": {"v": v, "a": a}}}).rules["r"].verdict] == region, (v, a)
    assert min(seen.values()) > 50, seen
    # The line of the boundary does not run along what is undefined: there, nothing is known of a margin.
    for line in picture_.boundary:
        for point in line:
            assert picture_.value(point)[0] > -0.3


@pytest.mark.parametrize("links", [40])
def test_forty_definitions(tmp_path: Path, links: int) -> None:
    """A rule through a chain of definitions, each of which calls the one before it twice."""
    defines = "\n".join(
        f"define d{k}(x: m, y: m) -> m = (d{k - 1}(x, y) + d{k - 1}(y, x)) / 2" for k in range(1, 6)
    )
    chain = "\n".join(f"define e{k}(x: m, y: m) -> m = e{k - 1}(x, y) + 0.1 m" for k in range(1, links))
    text = f"""
module m
signal p : state {{ a: m in [0, 50], b: m in [0, 50] }}
define d0(x: m, y: m) -> m = 2 * x + y
define e0(x: m, y: m) -> m = d5(x, y) / 3
{defines}
{chain}
rule r "a long way round"
  require e{links - 1}(p.a, p.b) <= 20 m
test r "near"
  given p = {{ a: 1 m, b: 1 m }}
  expect satisfied
"""
    (tmp_path / "m.spec").write_text(text)
    compiled = compile_paths([tmp_path])
    compiled.raise_errors()
    picture_ = drawn(compiled, "r")
    # By hand: the mean of 2a + b and 2b + a, a third of it, and 39 steps of 0.1 m.
    for line in picture_.boundary:
        for point in line:
            a, b = picture_.value(point)
            assert abs((a + b) / 2 + 0.1 * (links - 1) - 20) < 0.15, (a, b)
    assert picture_.boundary


def test_the_reference_can_be_asked_by_itself(shipped: Compiled) -> None:
    """`Demand.reference` and `Demand.judge` agree on random numbers, missing ones included."""
    choose = random.Random(5)
    for name in ("friction", "safe_side", "place_match", "acceleration_integrity"):
        rule = shipped.spec.rule(name)
        assert rule is not None
        demand = Demand(rule, shipped.spec)
        values = [
            [math.nan if choose.random() < 0.1 else choose.uniform(-3.0, 3.0) for _ in demand.quantities]
            for _ in range(200)
        ]
        codes, margins = demand.judge([np.array(column) for column in zip(*values)])
        assert codes.tolist() == [demand.reference(one) for one in values]
        assert set(codes.tolist()) == {HOLDS, BROKEN, UNKNOWN}, name
        assert (np.isnan(margins) == (codes == UNKNOWN)).all()


def test_what_was_recorded_is_counted_right(shipped: Compiled) -> None:
    """Of a recording, against what its own columns say; and one that does not fit the rules is named."""
    path = REPOSITORY / "specs" / "scenarios" / "after_spin.tmrec.jsonl.gz"
    recording = load_recording(path)
    rule = shipped.spec.rule("turn_radius")
    assert rule is not None
    evaluator = Evaluator(shipped.spec, ["turn_radius", "friction"])
    unfit = replace(recording, name="unfit", params={"no_such_parameter": 1.0}, because={})
    found = dict(
        drawings([rule], shipped.spec, prepare(shipped)[0], [(recording, evaluator), (unfit, evaluator)])
    )["turn_radius"]
    bends = [
        abs(kappa)
        for cycle in recording.cycles
        for columns in cycle.candidates.values()
        for kappa in columns["kappa"]
    ]
    sharp = sum(kappa > 1.0 / 11.0 for kappa in bends)
    assert sharp > 0
    assert found["recorded"]["seen"] == [len(bends) - sharp, sharp]
    assert (found["runs"], found["unusable"]) == (1, ["unfit"])
    read = Drawn(picture(found, english(), "k").svg)
    assert len(read.broken) == len(found["recorded"]["broken"]) > 0
    assert any("unfit" in words for words in read.words)
    (low, high) = (found["axes"][0][end] for end in ("low", "high"))
    for x, _ in read.broken:
        kappa = low + (x - read.left) / (read.right - read.left) * (high - low)
        assert abs(kappa) > 1.0 / 11.0 - 0.001 * (high - low)
