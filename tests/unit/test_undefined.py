"""Why a rule has no verdict is said of whatever can be in one, variables that are bound inside a comparison too."""

from __future__ import annotations

import math
from typing import Any

import pytest

import trackmarshal as tm
from support.command import BACKENDS
from trackmarshal.evaluation import Evaluator

SPEC = """
module inner
signal plan : trajectory { t: s increasing, v: m/s, wet: bool }
signal objects : set of object { x: m, seen: bool }
param slow : m/s = 10 m/s
rule own "A limit that hangs on flags of objects"
  for all p in plan
  require p.v <= (if exists o in objects: (o.seen) then slow else 3 * slow)
rule alone "The same of one number"
  require slow <= (if exists o in objects: (o.seen and o.x > 0 m) then slow else 3 * slow)
rule nested "And below a variable of its own"
  for all o in objects
  require o.x <= (if exists p in plan: (p.wet and p.v > slow) then 1 m else 2 m)
"""
PLAN = {"t": [0.0, 1.0], "v": [20.0, 20.0], "wet": [False, True]}
OBJECTS = [{"x": 1.5, "seen": False}, {"x": 1.0, "seen": False}]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("rule", "signals"),
    [
        ("own", {"objects": [{"x": 1.0, "seen": None}]}),
        ("alone", {"objects": [{"x": 1.0, "seen": None}]}),
        ("nested", {"plan": {**PLAN, "wet": [False, None]}}),
    ],
)
def test_flags_of_inner_variables(rule: str, signals: dict[str, Any], backend: str) -> None:
    evaluator = Evaluator(tm.loads(SPEC), [rule], backend)
    given = {"plan": PLAN, "objects": OBJECTS, **signals}
    found = evaluator.case({"signals": given}).rules[rule]
    assert found.verdict == "undefined"
    assert found.reason
    assert evaluator.case({"signals": {"plan": PLAN, "objects": OBJECTS}}).rules[rule].verdict != "undefined"


BESIDE = """
module beside
signal plan : trajectory { t: s increasing, v: m/s }
signal objects : set of object { v: m/s }
signal ego : state { v: m/s }
rule beside "A variable of its own in a guard, which is asked beside a timeline"
  whenever ego.v >= (if exists o in objects: o.v > 1 m/s then 1 m/s else sqrt(-1 m^2/s^2))
  along plan as p
  require p.v > 2 m/s
"""


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("objects", "reason"),
    [
        ([], "`sqrt(-1)` has no value"),
        ([{"v": 0.5}], "`sqrt(-1)` has no value"),
        ([{"v": 0.5}, {"v": None}], "objects[1].v is missing, or no number"),
    ],
)
def test_a_variable_in_a_guard_is_not_the_sample_at_which_the_rule_is_asked(
    objects: list[Any], reason: str, backend: str
) -> None:
    signals = {"plan": {"t": [0.0, 1.0], "v": [1.0, 1.0]}, "objects": objects, "ego": {"v": 5.0}}
    found = Evaluator(tm.loads(BESIDE), None, backend).case({"signals": signals}).rules["beside"]
    assert (found.verdict, found.reason) == ("undefined", reason)


RANGES = """
module ranges
signal plan : trajectory { t: s increasing, v: m/s }
signal objects : set of object { v: m/s, near: bool }
rule least "Of those in range"
  for all p in plan
  require p.v <= min(o.v for o in objects where o.near else 0 m/s)
rule some "Also of a condition"
  require (if exists o in objects where o.near: o.v > 9 m/s then 1 m/s else 2 m/s) >= plan.last.v
rule nested "And of many of each"
  require min(max(p.v + o.v for p in plan where p.v > 1 m/s else 0 m/s) for o in objects where o.near else 0 m/s) <= 0 m/s
"""


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("rule", ["least", "some", "nested"])
@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ([(None, False), (3.0, True), (None, True)], "objects[2].v is missing, or no number"),
        ([(None, False), (99.0, None)], "objects[1].near is missing, or no number"),
    ],
)
def test_the_input_of_who_is_surely_out_of_range_leaves_nothing_undefined(
    rule: str, given: list[tuple[float | None, bool | None]], reason: str, backend: str
) -> None:
    signals = {
        "plan": {"t": [0.0, 1.0], "v": [1.0, 2.0]},
        "objects": [{"v": v, "near": near} for v, near in given],
    }
    found = Evaluator(tm.loads(RANGES), [rule], backend).case({"signals": signals}).rules[rule]
    assert (found.verdict, found.reason) == ("undefined", reason)


ROUND = """
module round
signal track : corridor { left: polyline, right: polyline }
signal ego : state { s: m, ahead: m }
rule behind "Not far behind, on a closed track"
  require station_gap(track, ego.s, ego.ahead) <= 5 m
rule sign "Whichever way round it is"
  require sign(station_gap(track, ego.s, ego.ahead)) <= 1
"""
RING = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("s", "ahead", "size"), [(-1e308, 1e308, 9.0), (1e308, -1e308, 9.0), (0.0, 1e308, 0.01)]
)
def test_stations_beyond_all_doubles_apart_are_no_way_apart(
    s: float, ahead: float, size: float, backend: str
) -> None:
    track = {side: [[x * k, y * k] for x, y in RING] for side, k in (("left", size), ("right", 2 * size))}
    signals = {"track": {**track, "closed": True}, "ego": {"s": s, "ahead": ahead}}
    rules = Evaluator(tm.loads(ROUND), None, backend).case({"signals": signals}).rules
    assert rules["behind"].verdict == "undefined"
    assert "station_gap along the middle of track" in rules["behind"].reason
    reference = Evaluator(tm.loads(ROUND), None, "reference").case({"signals": signals}).rules
    assert rules["sign"].verdict == reference["sign"].verdict


NAMED = """
module named
signal plan : trajectory { t: s increasing, v: m/s }
signal objects : set of object { v: m/s }
rule samples "What a `let` names stands outside `for all`"
  let least = min(o.v for o in objects else 0 m/s)
  for all p in plan
  require p.v <= least
rule elements "And may be about the same set"
  let least = min(o.v for o in objects else 0 m/s)
  for all o in objects
  require o.v <= least + 1 m/s
rule nested "Or hold others"
  let least = min(max(abs(p.v - o.v) for p in plan) for o in objects else 0 m/s)
  for all p in plan
  require p.v <= least
rule roots "Of what has no value for one of them"
  let least = min(sqrt(o.v * 1 m/s) for o in objects else 0 m/s)
  for all p in plan
  require p.v <= least
"""


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("rule", "speeds", "objects", "reason"),
    [
        ("samples", [4.0, None], [5.0, 4.0], "plan[1].v is missing, or no number"),
        ("samples", [4.0, 3.0], [5.0, None], "objects[1].v is missing, or no number"),
        ("elements", [4.0, 3.0], [5.0, None], "objects[1].v is missing, or no number"),
        ("nested", [4.0, None], [5.0, 4.0], "plan[1].v is missing, or no number"),
        ("nested", [4.0, 3.0], [5.0, None], "objects[1].v is missing, or no number"),
        (
            "roots",
            [4.0, 3.0],
            [5.0, -4.0],
            "`(least of sqrt((objects[..].v * 1)) over objects)` has no value",
        ),
    ],
)
def test_a_variable_beside_a_number_of_many_that_is_named_outside(
    rule: str, speeds: list[Any], objects: list[Any], reason: str, backend: str
) -> None:
    """Both are one level deep, and the one is no value of the other."""
    signals = {"plan": {"t": [0.0, 1.0], "v": speeds}, "objects": [{"v": v} for v in objects]}
    found = Evaluator(tm.loads(NAMED), [rule], backend).case({"signals": signals}).rules[rule]
    assert (found.verdict, found.reason) == ("undefined", reason)


GAPS = """
module gaps
signal ego : state { v: m/s }
signal plan : trajectory { t: s increasing, v: m/s }
signal objects : set of object { v: m/s }
event flag
course driven = ego for 5 s then plan
rule own "Of what was driven"
  along driven as c
  require historically[0 s, 2 s] c.v <= 20 m/s
rule now "Of what is no part of it"
  along driven as c
  require historically[0 s, 2 s] flag
rule counted "Of how often it was so"
  along driven as c
  require count(c.v > 0 m/s, last: 2 s) <= 2
rule everybody "Of many"
  along driven as c
  require historically[0 s, 2 s] (for all o in objects: o.v > c.v)
rule before "Of the one before it"
  along driven as c
  require historically[0 s, 2 s] (weak previous (c.v > 0 m/s))
"""


@pytest.mark.parametrize("backend", ["reference", "numpy"])
@pytest.mark.parametrize("rule", ["own", "now", "counted", "everybody", "before"])
def test_missing_cycles_are_no_missing_input(rule: str, backend: str) -> None:
    evaluator = Evaluator(tm.loads(GAPS), [rule], backend)
    run = evaluator.over_run()
    plan = {"t": [0.0, 1.0], "v": [1.0, 1.0]}
    signals = {"ego": {"v": 1.0}, "plan": plan, "flag": True, "objects": [{"v": 2.0}]}
    assert run.step(evaluator.read({"t": 0.0, "signals": signals})).safe
    run.missed()
    run.missed()
    found = run.step(evaluator.read({"t": 1.0, "signals": signals})).rules[rule]
    assert found.verdict == "undefined"
    assert found.reason == "driven[-1]: 2 cycles are missing there, and nothing is known of them"
    if rule != "everybody":
        assert found.witness is not None
        assert (found.witness.binders, math.isnan(found.witness.margin)) == ({"c": -1}, True)


COUNTS = """
module counts
signal trace : series { t: s increasing, v: m/s, w: m/s }
rule roots "Of what has no value"
  along trace as s at last
  require count(sqrt(s.v * 1 m/s) > 0 m/s, last: 1 s) <= 1
rule anew "Of where it starts anew"
  along trace as s at last
  require count(s.v > -9 m/s, reset: s.w / s.w > 2) <= 2
rule nested "Of many counts"
  along trace as s
  require always count(sqrt(s.w * 1 m/s) > 1 m/s) <= 1
"""


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("rule", "v", "w", "sample", "reason"),
    [
        # The sample at 0 s is out of the window.
        ("roots", [-1.0, 4.0, -4.0, 4.0], [1.0] * 4, 2, "`sqrt((trace[2].v * 1))` with trace[2].v = -4 has no value"),
        # 0 / 0 is undefined.
        ("anew", [1.0] * 4, [1.0, 1.0, 0.0, 1.0], 2, "`trace[2].w / trace[2].w` with trace[2].w = 0 has no value"),
        ("nested", [1.0] * 4, [4.0, -1.0, 1.0, 1.0], 1, "`sqrt((trace[1].w * 1))` with trace[1].w = -1 has no value"),
    ],
)  # fmt: skip
def test_the_sample_that_leaves_a_count_unknown(
    rule: str, v: list[float], w: list[float], sample: int, reason: str, backend: str
) -> None:
    signals = {"trace": {"t": [0.0, 1.0, 2.0, 3.0], "v": v, "w": w}}
    found = Evaluator(tm.loads(COUNTS), [rule], backend).case({"signals": signals}).rules[rule]
    assert found.verdict == "undefined"
    assert found.witness is not None
    assert found.witness.binders == {"s": sample}
    assert found.reason == reason
