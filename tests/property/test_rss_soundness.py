"""The safe distances of prelude/rss.spec against the motion that they speak of, worked out by sympy.

Speeds are integrated symbolically and in rationals, so that nothing of the closed formulas in the prelude is used twice.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from property.strategies.specs import repeatable
from support.length import amount
from trackmarshal.evaluation import Evaluator, load

pytestmark = pytest.mark.verifies("S-1-A-2")

T = sympy.Symbol("t", nonnegative=True)
some = settings(repeatable, max_examples=amount(10, 60))
speeds = st.floats(0.0, 90.0)
times = st.floats(0.0, 3.0)
accelerations = st.floats(0.0, 10.0)
decelerations = st.floats(0.5, 15.0)

SPEC = """module distances
use prelude.rss
signal q : state { v: m/s, u: m/s, rho: s, a: m/s^2, b: m/s^2, c: m/s^2, cap: m/s, w: m/s, rho_w: s, a_w: m/s^2 }
rule stopping "" require rss_stopping_distance(q.v, q.rho, q.a, q.b, q.cap) <= 0 m
rule following "" require rss_longitudinal(q.v, q.u, q.rho, q.a, q.b, q.c, q.cap, 0 m) <= 0 m
rule oncoming "" require rss_opposite(q.v, q.rho, q.a, q.b, q.cap, q.u, q.rho_w, q.a_w, q.c, q.cap, 0 m) <= 0 m
rule sideways "" require rss_lateral(q.w, q.rho, q.a, q.b, 0 m, -q.w, q.rho_w, q.a_w, q.c, 0 m) <= 0 m
"""
FIELDS = ("v", "u", "rho", "a", "b", "c", "cap", "w", "rho_w", "a_w")


@pytest.fixture(scope="module")
def distances(tmp_path_factory: pytest.TempPathFactory) -> Evaluator:
    path = tmp_path_factory.mktemp("rss") / "distances.spec"
    path.write_text(SPEC, "utf-8")
    return Evaluator(load([path]), backend="reference")


def needed(evaluator: Evaluator, rule: str, **values: float) -> float:
    """The safe distance in m that the prelude asks for."""
    state = {field: values.get(field, 1.0) for field in FIELDS}
    [result] = evaluator.evaluate([evaluator.read({"signals": {"q": state}})])
    return -result.rules[rule].margin


Segment = tuple[Any, Any]  # duration (None: for ever), acceleration


class Motion:
    """A motion along a line from place 0: constant acceleration a segment; all numbers are sympy's rationals."""

    def __init__(self, speed: Any, segments: Iterable[Segment]) -> None:
        self.pieces: list[tuple[Any, Any, Any]] = []  # from when on, place and speed as polynomials of t
        start, place = sympy.Integer(0), sympy.Integer(0)
        for duration, acceleration in segments:
            v = speed + acceleration * (T - start)
            x = place + sympy.integrate(v, (T, start, T))
            self.pieces.append((start, sympy.expand(x), v))
            if duration is None:
                break
            start = start + duration
            place, speed = x.subs(T, start), v.subs(T, start)

    def place(self, t: Any) -> Any:
        """The polynomial of the place that holds from time t on."""
        return [x for start, x, _ in self.pieces if start <= t][-1]

    @property
    def rest(self) -> Any:
        """Where the motion ends; its last segment stands still."""
        assert self.pieces[-1][2] == 0
        return self.pieces[-1][1]


def braking(speed: float, deceleration: float) -> Motion:
    v, b = sympy.Rational(speed), sympy.Rational(deceleration)
    return Motion(v, [(v / b, -b), (None, 0)])


def responding(speed: float, response: float, acceleration: float, deceleration: float, cap: float) -> Motion:
    """Full acceleration during the response, at most up to the cap; then the least braking that is promised."""
    v, rho, a, b, top = map(sympy.Rational, (speed, response, acceleration, deceleration, cap))
    pushing = sympy.Integer(0) if v >= top else rho if a == 0 else sympy.Min(rho, (top - v) / a)
    reached = v + a * pushing
    return Motion(v, [(pushing, a), (rho - pushing, 0), (reached / b, -b), (None, 0)])


def least_gap(gap: float, rear: Motion, front: Motion) -> Any:
    """The smallest distance over all time, in m: at ends of segments, or where the speeds are equal."""
    ends = sorted({start for start, _, _ in [*rear.pieces, *front.pieces]})
    smallest = []
    for start, end in zip(ends, [*ends[1:], None]):
        difference = sympy.Rational(gap) + front.place(start) - rear.place(start)
        equal = sympy.Poly(sympy.diff(difference, T), T).nroots() if difference.has(T) else []
        inside = [t for t in equal if t.is_real and t >= start and (end is None or t <= end)]
        smallest += [difference.subs(T, t) for t in [start, *inside]]
    return min(smallest)


@some
@given(v=speeds, rho=times, a=accelerations, b=decelerations, cap=speeds)
def test_stopping_distance_is_the_integral_of_the_speed(
    distances: Evaluator, v: float, rho: float, a: float, b: float, cap: float
) -> None:
    found = needed(distances, "stopping", v=v, rho=rho, a=a, b=b, cap=cap)
    assert found == pytest.approx(float(responding(v, rho, a, b, cap).rest), rel=1e-9, abs=1e-9)


@some
@given(v=speeds, u=speeds, rho=times, a=accelerations, b=decelerations, more=st.floats(0, 10), cap=speeds)
def test_whoever_keeps_the_safe_distance_does_not_touch(
    distances: Evaluator, v: float, u: float, rho: float, a: float, b: float, more: float, cap: float
) -> None:
    """At no time, not only at standstill; provided that the rear brakes at most as hard as the front (`constrain`)."""
    gap = needed(distances, "following", v=v, u=u, rho=rho, a=a, b=b, c=b + more, cap=cap)
    assert least_gap(gap, responding(v, rho, a, b, cap), braking(u, b + more)) >= -1e-9


@some
@given(v=speeds, u=speeds, rho=times, a=accelerations, b=decelerations, more=st.floats(0, 10), cap=speeds)
def test_the_safe_distance_is_not_longer_than_needed(
    distances: Evaluator, v: float, u: float, rho: float, a: float, b: float, more: float, cap: float
) -> None:
    gap = needed(distances, "following", v=v, u=u, rho=rho, a=a, b=b, c=b + more, cap=cap)
    if gap > 0.0:
        shorter = gap * (1.0 - 1e-6) - 1e-6
        assert least_gap(shorter, responding(v, rho, a, b, cap), braking(u, b + more)) < 0


def test_a_rear_car_that_brakes_harder_may_touch_in_between(distances: Evaluator) -> None:
    """Why the shipped specs have `constrain b_rear <= b_front`: the gaps at standstill do not tell."""
    gap = needed(distances, "following", v=40.0, u=30.0, rho=0.5, a=5.0, b=12.0, c=6.0, cap=90.0)
    rear, front = responding(40.0, 0.5, 5.0, 12.0, 90.0), braking(30.0, 6.0)
    assert sympy.Rational(gap) + front.rest - rear.rest >= -1e-9
    assert least_gap(gap, rear, front) < -1


@some
@given(v=speeds, u=speeds, rho=times, rho_w=times, a=accelerations, a_w=accelerations, b=decelerations)
def test_oncoming_cars_stop_before_they_meet(
    distances: Evaluator, v: float, u: float, rho: float, rho_w: float, a: float, a_w: float, b: float
) -> None:
    gap = needed(distances, "oncoming", v=v, u=u, rho=rho, rho_w=rho_w, a=a, a_w=a_w, b=b, c=b, cap=90.0)
    both = responding(v, rho, a, b, 90.0).rest + responding(u, rho_w, a_w, b, 90.0).rest
    assert gap == pytest.approx(float(both), rel=1e-9, abs=1e-9)


@some
@given(w=st.floats(-5.0, 5.0), rho=times, rho_w=times, a=accelerations, a_w=accelerations, b=decelerations)
def test_sideways_both_end_beside_each_other(
    distances: Evaluator, w: float, rho: float, rho_w: float, a: float, a_w: float, b: float
) -> None:
    """Each drifts towards the other for its response; it then brakes what is left of that, and gets no credit for less."""
    gap = needed(distances, "sideways", w=w, rho=rho, rho_w=rho_w, a=a, a_w=a_w, b=b, c=b)
    drifts = []
    for approach, response, push in ((w, rho, a), (-w, rho_w, a_w)):
        first, time, step, stop = map(sympy.Rational, (approach, response, push, b))
        v = first + step * T
        drift, left = sympy.integrate(v, (T, 0, time)), v.subs(T, time)
        if left > 0:
            drift += sympy.integrate(left - stop * T, (T, 0, left / stop))
        drifts.append(drift)
    assert gap == pytest.approx(max(0.0, float(sum(drifts))), rel=1e-9, abs=1e-9)
    assert math.isfinite(gap)
