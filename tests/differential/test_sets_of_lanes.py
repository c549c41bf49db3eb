"""Lanes of made-up roads in reference, numpy and C, to the bit, and against shapely, which we did not write."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Point, Polygon
from shapely.affinity import rotate, translate

from support.agreement import one_libm, outcomes, said_of
from support.length import amount
from trackmarshal.evaluation import Evaluator, loads

TEXT = """module made.lanes

signal cars : set of object { x: m, y: m, heading: rad, length: m, width: m }
signal lanes : set of lane { left: polyline, right: polyline, number: 1 }

"""
RULES = {
    "inside": "footprint(c) inside l",
    "meets": "footprint(c) meets l",
    "station": "station(c, l) >= 0 m",
    "offset": "offset(c, l.left) >= 0 m",
    "direction": "direction(c, l.right) >= 0",
    "distance": "distance_to(c, l) >= 0 m",
    "stretch": "c in stretch(l, 5 m, 5 m + abs(c.x))",
    "both": "footprint(c) meets l implies footprint(c) inside l or l.number > 1",
}
NEAR = 1e-9


@cache
def evaluators() -> list[Evaluator]:
    each = [
        f'rule {name} "made up"\n  for all c in cars\n  for all l in lanes\n  require {text}\n'
        for name, text in RULES.items()
    ]
    spec = loads(TEXT + "\n".join(each))
    return [Evaluator(spec, backend=backend) for backend in ("reference", "numpy", "c")]


def _floats(low: float, high: float) -> st.SearchStrategy[float]:
    """Generated C refuses coordinates that are all but zero (E473)."""
    return st.floats(low, high).map(lambda x: 0.0 if abs(x) < 1e-30 else x)


NUMBERS = st.one_of(st.integers(-6, 6).map(float), _floats(-12, 12))


@st.composite
def lanes(draw: st.DrawFn) -> dict[str, Any]:
    """A road that goes on to the right, as wide as may be, in a few pieces; sometimes it crosses itself."""
    count = draw(st.integers(2, 5))
    x0, step, bottom = draw(NUMBERS), draw(st.floats(1, 8)), [draw(NUMBERS) for _ in range(count)]
    width = draw(st.one_of(st.floats(0.5, 6), st.just(3.0), st.just(-1.0)))
    bend = draw(_floats(-1, 1))
    right = [[x0 + step * k, bottom[k]] for k in range(count)]
    left = [[x + bend, y + width] for x, y in right]
    if draw(st.integers(0, 9)) == 0:
        left = left[::-1]
    if draw(st.integers(0, 9)) == 0:
        left.insert(1, [x0, bottom[0] + width + 5.0])
    return {"left": left, "right": right, "number": draw(st.integers(0, 3))}


@st.composite
def cars(draw: st.DrawFn) -> dict[str, float]:
    heading = draw(st.one_of(st.just(0.0), st.floats(-4, 4)))
    return {
        "x": draw(NUMBERS),
        "y": draw(NUMBERS),
        "heading": heading,
        "length": draw(st.floats(0.5, 6)),
        "width": draw(st.floats(0.5, 3)),
    }


def results(cases: list[dict[str, Any]]) -> list[dict[str, tuple[str, float]]]:
    """Verdicts and margins of every case; raises AssertionError where evaluators differ, one by one or all together."""
    found = []
    for evaluator in evaluators():
        frames = evaluator.read_all([{"signals": case} for case in cases])
        with one_libm():
            together = outcomes(evaluator, frames)
            apart = [said_of(evaluator, {"signals": case}) for case in cases]
        for made in (together, apart):
            found.append(
                [{name: (verdict, margin.hex()) for name, (verdict, margin) in one.items()} for one in made]
            )
    assert all(each == found[0] for each in found), found
    return [
        {name: (verdict, float.fromhex(margin)) for name, (verdict, margin) in one.items()}
        for one in found[0]
    ]


@settings(max_examples=amount(10, 60), deadline=None)
@given(
    st.lists(
        st.fixed_dictionaries({"cars": st.lists(cars(), max_size=3), "lanes": st.lists(lanes(), max_size=3)}),
        min_size=1,
        max_size=3,
    )
)
def test_evaluators_agree(cases: list[dict[str, Any]]) -> None:
    results(cases)


@settings(max_examples=amount(50, 300), deadline=None)
@given(cars(), lanes())
def test_shapely_agrees(car: dict[str, float], lane: dict[str, Any]) -> None:
    (found,) = results([{"cars": [car], "lanes": [lane]}])
    road = Polygon([*lane["left"], *lane["right"][::-1]])
    crossing = not road.is_valid or not (
        LineString(lane["left"]).is_simple and LineString(lane["right"]).is_simple
    )
    if crossing:
        assert {verdict for verdict, _ in found.values()} == {"undefined"}
        return
    half_length, half_width = car["length"] / 2, car["width"] / 2
    box = Polygon(
        [
            (-half_length, -half_width),
            (half_length, -half_width),
            (half_length, half_width),
            (-half_length, half_width),
        ]
    )
    box = translate(rotate(box, car["heading"], (0, 0), use_radians=True), car["x"], car["y"])
    verdict, margin = found["meets"]
    apart = box.distance(road)
    if apart > NEAR:
        assert verdict == "violated"
        assert math.isclose(-margin, apart, abs_tol=1e-9)
    elif box.intersection(road).area > NEAR:
        assert verdict == "satisfied"
    verdict, margin = found["inside"]
    if road.buffer(-NEAR).contains(box):
        assert verdict == "satisfied"
        assert math.isclose(margin, box.distance(road.exterior), abs_tol=1e-9)
    elif box.difference(road).area > NEAR:
        assert verdict == "violated"
    left = LineString(lane["left"])
    nearest = left.project(Point(car["x"], car["y"]))
    if NEAR < nearest < left.length - NEAR:
        away = left.distance(Point(car["x"], car["y"]))
        assert math.isclose(abs(found["offset"][1]), away, abs_tol=1e-9)


@st.composite
def plans(draw: st.DrawFn) -> dict[str, list[float]]:
    """Poses that a car goes through, along a curve or not."""
    count = draw(st.integers(2, 4))
    columns = {name: [draw(NUMBERS) for _ in range(count)] for name in ("x", "y")}
    columns["t"] = [float(k) for k in range(count)]
    columns["heading"] = [draw(st.floats(-4, 4)) for _ in range(count)]
    columns["kappa"] = [draw(st.floats(-0.2, 0.2)) for _ in range(count)]
    return columns


@cache
def swept() -> list[Evaluator]:
    text = """module made.swept
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m }
signal lanes : set of lane { left: polyline, right: polyline, number: 1 }
rule curve "made up"
  for all p in plan
  for all l in lanes
  require swept_footprint(p, 4 m, 2 m) meets l or swept_footprint(p, 4 m, 2 m) inside l
rule hull "made up"
  for all p in plan
  exists l in lanes
  require swept_hull(p, 4 m, 2 m) meets l and not (swept_hull(p, 4 m, 2 m) inside l)
"""
    return [Evaluator(loads(text), backend=backend) for backend in ("reference", "numpy", "c")]


@settings(max_examples=amount(18, 100), deadline=None)
@given(plans(), st.lists(lanes(), max_size=3))
def test_what_is_swept(plan: dict[str, list[float]], roads: list[dict[str, Any]]) -> None:
    case = {"signals": {"plan": plan, "lanes": roads}}
    with one_libm():
        one, other, third = (made.case(case).rules for made in swept())
    for name, rule in one.items():
        generated = third[name]
        assert (rule.verdict, repr(rule.margin)) == (generated.verdict, repr(generated.margin))
        assert rule.verdict == other[name].verdict
        # Corners of two poses on one line may be corners of their hull, or not (docs/geometry.md).
        assert other[name].margin == pytest.approx(rule.margin, abs=1e-9, nan_ok=True)
