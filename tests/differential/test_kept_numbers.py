"""Numbers that a state machine keeps, two of one machine in one formula: each is its own, with every evaluator, and held against plain Python."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler

C = pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
BACKENDS = pytest.mark.parametrize("backend", ["reference", "numpy", C])

TEXT = """
module kept
signal ego : state { v: m/s, x: m, on: bool }
signal objects : set of object { v: m/s, w: m/s, on: bool }

state lap : { waiting, running } starts waiting
  becomes running when ego.on
    remember speed = ego.v
    remember limit = ego.x / 1 s
  becomes waiting when not ego.on

state role : { far, close } for each o in objects starts far
  becomes close when o.on
    remember first = o.v
    remember second = o.w
  becomes far when not o.on

rule less "one against the other"
  require lap.speed >= lap.limit

rule apart "their difference"
  require lap.limit - lap.speed <= 5 m/s

rule with_time "one and the duration"
  require lap.speed + time_in(lap) * 1 m/s^2 <= 8 m/s

rule of_each "of each element"
  for all o in objects
  require role(o).first <= role(o).second

rule in_a_range "in the range of a quantifier"
  for all o in objects where role(o).first + role(o).second > 6 m/s
  require o.v <= 3 m/s
"""
SPEC = tm.loads(TEXT)
#: By rule the margin in a cycle in which the numbers are known.
NUMBERS = st.integers(0, 9).map(float)
CYCLE = st.tuples(
    NUMBERS,
    NUMBERS,
    st.booleans(),
    st.lists(st.tuples(NUMBERS, NUMBERS, st.booleans()), min_size=2, max_size=2),
)


def expected(
    cycles: list[tuple[float, float, bool, list[tuple[float, float, bool]]]],
) -> list[dict[str, float]]:
    """The margins of all rules, by hand: NaN where a number is not known, infinite where there is nothing to demand."""
    found: list[dict[str, float]] = []
    lap: tuple[float, float] | None = None
    since, was_on = 0, False
    roles: dict[int, tuple[float, float] | None] = {0: None, 1: None}
    were: dict[int, bool] = {0: False, 1: False}
    for t, (v, x, on, objects) in enumerate(cycles):
        if on != was_on:
            since, was_on = t, on
            lap = (v, x) if on else lap
        for k, (ov, ow, oon) in enumerate(objects):
            if oon != were[k]:
                were[k] = oon
                roles[k] = (ov, ow) if oon else roles[k]
        said = dict.fromkeys(("less", "apart", "with_time"), math.nan)
        if lap is not None:
            speed, limit = lap
            said = {
                "less": speed - limit,
                "apart": 5.0 - (limit - speed),
                "with_time": 8.0 - (speed + (t - since)),
            }
        known = [pair for pair in roles.values() if pair is not None]
        said["of_each"] = min(second - first for first, second in known) if len(known) == 2 else math.nan
        if len(known) == 2:
            within = [
                3.0 - objects[k][0] for k, pair in roles.items() if pair is not None and sum(pair) > 6.0
            ]
            said["in_a_range"] = min(within, default=math.inf)
        found.append(said)
    return found


@BACKENDS
@settings(deadline=None)
@given(cycles=st.lists(CYCLE, min_size=1, max_size=8))
def test_each_number_is_its_own(
    backend: str, cycles: list[tuple[float, float, bool, list[tuple[float, float, bool]]]]
) -> None:
    evaluator = tm.Evaluator(SPEC, None, backend)
    run = evaluator.over_run()
    for t, ((v, x, on, objects), margins) in enumerate(zip(cycles, expected(cycles), strict=True)):
        signals: dict[str, Any] = {
            "ego": {"v": v, "x": x, "on": on},
            "objects": [
                {"id": str(k), "v": ov, "w": ow, "on": oon} for k, (ov, ow, oon) in enumerate(objects)
            ],
        }
        rules = run.step(evaluator.read({"id": t, "t": float(t), "signals": signals})).rules
        for name, margin in margins.items():
            if math.isnan(margin):
                # Of one element alone the demand may fail for sure.
                assert rules[name].verdict != "satisfied"
            else:
                assert rules[name].margin == margin, (name, t)


@BACKENDS
def test_the_shortest_one(backend: str) -> None:
    evaluator = tm.Evaluator(SPEC, ["less"], backend)
    case = evaluator.read({"id": 0, "t": 0.0, "signals": {"ego": {"v": 7.0, "x": 11.0, "on": True}}})
    said = evaluator.over_run().step(case).rules["less"]
    assert (said.verdict, said.margin) == ("violated", -4.0)
