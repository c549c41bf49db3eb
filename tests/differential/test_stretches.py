"""Stretches in the three evaluators, to the bit, and against a walk round the ring in exact fractions."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache
from typing import Any

import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads

TEXT = """module made.stretches

signal at : state { s: m, from: m, to: m }
signal way : polyline
signal track : corridor { left: polyline, right: polyline }

rule ring "on a closed line"
  require at.s in stretch(track, at.from, at.to)

rule line "on an open one"
  require at.s in stretch(way, at.from, at.to)
"""
LENGTH, ROUNDING = 40, Fraction(1, 10**9)
#: The centre is a square with sides of 10 m.
TRACK = {
    "left": [[1, 1], [9, 1], [9, 9], [1, 9]],
    "right": [[-1, -1], [11, -1], [11, 11], [-1, 11]],
    "closed": True,
}
STATIONS = st.one_of(
    st.integers(-50, 90).map(float),
    st.floats(-1e4, 1e4),
    st.sampled_from([0.0, -0.0, 40.0, 1e-300, -1e-300, 5e-324]),
    st.integers(-2, 3).flatmap(
        lambda k: st.sampled_from([math.nextafter(40.0 * k, side) for side in (-1e9, 1e9)])
    ),
)


@cache
def evaluators() -> dict[str, Evaluator]:
    spec = loads(TEXT)
    names = ["reference", "numpy", *(["c"] if compiler() is not None else [])]
    return {name: Evaluator(spec, backend=name) for name in names}


def results(s: float, start: float, end: float) -> dict[str, Any]:
    """Verdict and margin of both rules; raises AssertionError where evaluators differ."""
    case = {
        "signals": {
            "at": {"s": s, "from": start, "to": end},
            "track": TRACK,
            "way": [[0, 0], [3, 0], [3, 20]],
        }
    }
    found = {
        name: {rule: (r.verdict, r.margin.hex()) for rule, r in made.case(case).rules.items()}
        for name, made in evaluators().items()
    }
    assert all(each == found["reference"] for each in found.values()), found
    return {rule: (verdict, float.fromhex(margin)) for rule, (verdict, margin) in found["reference"].items()}


def walked(s: float, start: float, end: float) -> tuple[bool, Fraction]:
    """Whether one meets the station when walking from the start to the end, and how far it is from the nearer of both."""
    at, begin, finish = Fraction(s), Fraction(start), Fraction(end)
    while finish <= begin:
        finish += LENGTH * max(1, (begin - finish) // LENGTH)
    while finish - begin > LENGTH:
        finish -= LENGTH * max(1, (finish - begin - 1) // LENGTH)
    first = at + LENGTH * math.ceil((begin - at) / LENGTH)  # the first time at or after the start
    away = [abs((at - each + LENGTH // 2) % LENGTH - LENGTH // 2) for each in (begin, finish)]
    return first <= finish, min(away)


@settings(max_examples=amount(50, 300), deadline=None)
@given(STATIONS, STATIONS, STATIONS)
@example(-1e-300, 0.0, 10.0)
@example(35.0, 30.0, 5.0)
@example(20.0, 30.0, 30.0)
@example(30.0, 30.0, 30.0)
def test_the_ring_is_walked(s: float, start: float, end: float) -> None:
    verdict, margin = results(s, start, end)["ring"]
    inside, away = walked(s, start, end)
    apart = abs((Fraction(start) - Fraction(end) + LENGTH // 2) % LENGTH - LENGTH // 2)
    assume(apart == 0 or apart > ROUNDING)  # stations are rounded when they are brought onto the lap
    if apart == 0:  # the whole lap
        assert verdict == "satisfied"
    elif away > ROUNDING:
        assert (verdict == "satisfied") == inside
    assert abs(abs(Fraction(margin)) - away) <= ROUNDING


@settings(max_examples=amount(35, 200), deadline=None)
@given(st.integers(0, 39), st.integers(0, 39), st.integers(0, 39))
def test_on_a_lap_it_is_exact(s: int, start: int, end: int) -> None:
    verdict, margin = results(float(s), float(start), float(end))["ring"]
    inside, away = walked(s, start, end)
    assert (verdict == "satisfied", abs(margin)) == (inside, away)


@settings(max_examples=amount(35, 200), deadline=None)
@given(STATIONS, STATIONS, STATIONS)
def test_an_open_line_has_ends(s: float, start: float, end: float) -> None:
    verdict, margin = results(s, start, end)["line"]
    if start > end:
        assert verdict == "undefined"
    else:
        assert (verdict == "satisfied") == (start <= s <= end)
        assert margin == min(s - start, end - s)


@pytest.mark.parametrize("one", range(3))
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_undefined(one: int, value: float) -> None:
    numbers = [1.0, 0.0, 2.0]
    numbers[one] = value
    assert {verdict for verdict, _ in results(*numbers).values()} == {"undefined"}
