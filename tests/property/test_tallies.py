"""Counts of samples along a timeline, against a loop; both evaluators, several cases at once, and for each element of a set."""

from __future__ import annotations

from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from support.length import amount
from trackmarshal.evaluation import Evaluator, loads

SPEC = """module m
signal plan : trajectory { t: s increasing, v: m/s, on: bool }
signal objects : set of object { v: m/s }
param most : 1 = 2

rule ever ""
  along plan as p at last
  require count(p.v > 1 m/s) <= most
rule last ""
  along plan as p at last
  require count(p.v > 1 m/s, last: 0.5 s) < 3
rule anew ""
  along plan as p at last
  require 1 != count(p.v > 1 m/s, reset: p.on)
rule inside ""
  along plan as p
  require always count(p.v > 1 m/s, last: 0.25 s) <= 2
rule each ""
  along plan as p at last
  for all o in objects where o.v > 0 m/s
  require count(p.v > o.v) == 2
"""
samples = st.lists(
    st.tuples(st.integers(1, 4), st.sampled_from([0.0, 1.0, 2.0, 3.0]), st.booleans()),
    min_size=2,
    max_size=12,
)
cases = st.lists(
    st.tuples(samples, st.lists(st.sampled_from([-1.0, 0.5, 2.0]), max_size=3)), min_size=1, max_size=4
)


def expected(rows: list[tuple[int, float, bool]], others: list[float]) -> dict[str, tuple[str, float]]:
    times, t = [], 0
    for step, _, _ in rows:
        t += step
        times.append(t)
    fast = [v > 1.0 for _, v, _ in rows]
    window = sum(f for f, at in zip(fast, times) if times[-1] - at <= 4)
    start = max((k for k, (_, _, on) in enumerate(rows) if on), default=0)
    worst = max(sum(f for f, at in zip(fast[: k + 1], times) if times[k] - at <= 2) for k in range(len(rows)))
    seen = [-abs(sum(v > o for _, v, _ in rows) - 2.0) + 0.0 for o in others if o > 0.0]
    margins = {
        "ever": 2.0 - sum(fast),
        "last": 3.0 - window,
        "anew": abs(1.0 - sum(fast[start:])),
        "inside": 2.0 - worst,
        "each": min(seen, default=float("inf")),
    }
    strict = {"last", "anew"}
    found = {
        name: ("satisfied" if margin > 0.0 or (margin == 0.0 and name not in strict) else "violated", margin)
        for name, margin in margins.items()
    }
    if not seen:
        found["each"] = ("inactive", float("inf"))
    return found


def raw(rows: list[tuple[int, float, bool]], others: list[float]) -> dict[str, Any]:
    steps, v, on = zip(*rows)
    t = [sum(steps[: k + 1]) / 8 for k in range(len(steps))]  # eighths are exact
    return {"signals": {"plan": {"t": t, "v": v, "on": on}, "objects": {"v": others}}}


@given(cases)
@settings(max_examples=amount(10, 300), deadline=None)
def test_counts_are_those_of_a_loop(given_: list[tuple[list[tuple[int, float, bool]], list[float]]]) -> None:
    for backend in ("reference", "numpy", "c"):
        evaluator = Evaluator(loads(SPEC), backend=backend)
        frames = [evaluator.read(raw(*case)) for case in given_]
        for case, result in zip(given_, evaluator.evaluate(frames)):
            assert {name: (one.verdict, one.margin) for name, one in result.rules.items()} == expected(*case)
            assert all(str(one.margin) != "-0.0" for one in result.rules.values())


def test_what_is_not_known_widens_the_count() -> None:
    text = """module m
signal plan : trajectory { t: s increasing, v: m/s, w: m/s }
rule f ""
  along plan as p at last
  require count(p.v > sqrt(p.w / 1 m/s) * 1 m/s) <= 2
"""
    for backend in ("reference", "numpy", "c"):
        evaluator = Evaluator(loads(text), backend=backend)

        def verdict(w: list[float], evaluator: Evaluator = evaluator) -> str:
            plan = {"t": [0.0, 1.0, 2.0], "v": [5.0] * 3, "w": w}
            return evaluator.case({"signals": {"plan": plan}}).rules["f"].verdict

        # The root of a negative number is none.
        assert verdict([-1.0, 1.0, 1.0]) == "undefined"
        assert verdict([-1.0, 100.0, 1.0]) == "satisfied"
        assert verdict([1.0, 1.0, 1.0]) == "violated"
