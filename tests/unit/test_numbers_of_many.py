"""Sums, counts, least and greatest of many, and the nearest: small enough to work out by hand; by all evaluators."""

from __future__ import annotations

import math
from typing import Any

import pytest

from support.agreement import compiled
from trackmarshal.backends.c import build
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.verdict import RuleResult

HEAD = """module many
signal plan : trajectory { t: s increasing, v: m/s }
signal ego : state { x: m, v: m/s }
signal objects : set of object { x: m, v: m/s, ahead: bool }
signal others : set of object { x: m }
"""
C = pytest.param("c", marks=pytest.mark.skipif(build.compiler() is None, reason="no C compiler"))
BACKENDS = ["reference", "numpy", C]

Object = tuple[float | None, float | None, bool | None]


def spec_of(*requirements: str) -> Spec:
    """A spec with a rule for each requirement, `r0` and so on; a text with `require` has clauses of its own."""
    rules = [text if "require" in text else f"require {text}" for text in requirements]
    return compiled(HEAD + "".join(f"\nrule r{i}\n  {text}\n" for i, text in enumerate(rules)))


def judged(
    spec: Spec, backend: str, *cases: tuple[list[Object], list[float]], v: float = 0.0
) -> list[list[RuleResult]]:
    """The results of all rules, by case: objects with position, speed and whether they are ahead; positions of others."""
    raw: list[dict[str, Any]] = [
        {
            "id": number,
            "signals": {
                "plan": {"t": [0.0, 1.0, 2.0], "v": [3.0, 5.0, 4.0]}, "ego": {"x": 0.0, "v": v},
                "objects": [{"x": x, "v": u, "ahead": ahead} for x, u, ahead in objects],
                "others": [{"x": x} for x in others],
            },
        }
        for number, (objects, others) in enumerate(cases)
    ]  # fmt: skip
    evaluator = Evaluator(spec, None, backend)
    return [
        list(result.rules.values()) for result in evaluator.evaluate([evaluator.read(one) for one in raw])
    ]


def said(results: list[RuleResult]) -> list[tuple[str, float]]:
    return [(result.verdict, result.margin) for result in results]


THREE: list[Object] = [(30.0, 1.0, True), (10.0, 2.0, False), (20.0, 4.0, True)]


@pytest.mark.parametrize("backend", BACKENDS)
def test_of_what_is_in_range_alone(backend: str) -> None:
    spec = spec_of(
        "count(o in objects) <= 5", "count(o in objects where o.v < 3 m/s) <= 5", "sum(o.v for o in objects) <= 9 m/s",
        "sum(o.v for o in objects where o.ahead) <= 9 m/s", "min(o.x for o in objects else 99 m) >= 0 m",
        "min(o.x for o in objects where o.ahead else 99 m) >= 0 m", "max(o.x for o in objects where not o.ahead else 99 m) >= 0 m",
        "max(p.v for p in plan) <= 6 m/s", "min(q.v - p.v for consecutive p, q in plan) >= -2 m/s",
    )  # fmt: skip
    first, none = judged(spec, backend, (THREE, []), ([], []))
    assert [m for _, m in said(first)] == [2.0, 3.0, 2.0, 4.0, 10.0, 20.0, 10.0, 1.0, 1.0]
    assert [m for _, m in said(none)] == [5.0, 5.0, 9.0, 9.0, 99.0, 99.0, 99.0, 1.0, 1.0]


@pytest.mark.parametrize("backend", BACKENDS)
def test_what_is_not_known_of_one_in_range_is_not_known_of_all(backend: str) -> None:
    spec = spec_of(
        "sum(o.v for o in objects where o.ahead) <= 9 m/s", "min(o.v for o in objects where o.ahead else 1 m/s) <= 9 m/s",
        "count(o in objects where o.ahead) <= 9", "count(o in objects where o.v > 0 m/s) >= 0",
    )  # fmt: skip
    unknown_outside: list[Object] = [(1.0, 2.0, True), (2.0, None, False)]
    unknown_inside: list[Object] = [(1.0, 2.0, True), (2.0, None, True)]
    unknown_guard: list[Object] = [(1.0, 2.0, True), (2.0, 3.0, None)]
    outside, inside, guard = judged(
        spec, backend, (unknown_outside, []), (unknown_inside, []), (unknown_guard, [])
    )
    assert [v for v, _ in said(outside)] == ["satisfied"] * 3 + ["undefined"]
    assert [v for v, _ in said(inside)] == ["undefined", "undefined", "satisfied", "undefined"]
    assert [v for v, _ in said(guard)] == ["undefined"] * 3 + ["satisfied"]


@pytest.mark.parametrize("backend", BACKENDS)
def test_sums_are_added_in_the_order_of_the_input(backend: str) -> None:
    """Added in pairs, or from the end, these come to other numbers."""
    speeds = [1e16, 1.0, -1e16, 1.0, 0.1, 0.2, 0.3, 1e-17, 7.0, -0.7] * 3
    total = 0.0
    for speed in speeds:
        total += speed
    spec = spec_of("sum(o.v for o in objects) <= 0 m/s", "1 / sum(o.x for o in objects) <= 0 1/m")
    ((by_sum, of_zeros),) = judged(spec, backend, ([(-0.0, speed, True) for speed in speeds], []))
    assert by_sum.margin == -total != -math.fsum(speeds)
    assert of_zeros.verdict == "undefined"


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_nearest_is_the_one_that_is_meant(backend: str) -> None:
    nearest = "for nearest o in objects by abs(o.x - ego.x) where o.ahead"
    spec = spec_of(
        f"{nearest}\n  require o.v <= 5 m/s", f"{nearest}\n  except o.v > 3 m/s \"it is gone soon\"\n  require o.v <= 5 m/s",
        "exists nearest o in objects by abs(o.x): o.v <= 5 m/s", "for nearest o in objects by -o.x: o.v >= 1 m/s",
        "for nearest p in plan by abs(p.t - 1.2 s): p.v <= 5 m/s",
    )  # fmt: skip
    first, none, tie = judged(
        spec, backend, (THREE, []), ([], []), ([(-5.0, 3.0, True), (5.0, 1.0, True)], [])
    )
    assert [m for _, m in said(first)] == [1.0, 4.0, 3.0, 0.0, 0.0]
    assert [v for v, _ in said(none)] == ["inactive", "inactive", "violated", "satisfied", "satisfied"]
    assert [m for _, m in said(none)][2:] == [-math.inf, math.inf, 0.0]
    assert said(tie)[0] == ("satisfied", 2.0)  # of equally near ones the first


@pytest.mark.parametrize("backend", BACKENDS)
def test_where_it_is_not_known_which_is_nearest_all_in_range_may_be(backend: str) -> None:
    spec = spec_of("for nearest o in objects by o.x where o.ahead: o.v <= 5 m/s")
    lost: list[Object] = [(None, 1.0, True), (3.0, 2.0, True), (4.0, 9.0, False)]
    fast: list[Object] = [(None, 1.0, True), (3.0, 7.0, True), (4.0, 9.0, False)]
    far: list[Object] = [(math.inf, 1.0, True), (3.0, 7.0, True)]
    (all_slow,), (one_fast,), (infinite,) = judged(spec, backend, (lost, []), (fast, []), (far, []))
    assert said([all_slow]) == [("satisfied", 3.0)]
    assert one_fast.verdict == infinite.verdict == "undefined"


@pytest.mark.parametrize("backend", BACKENDS)
def test_inside_each_other_and_for_each_of_another_set(backend: str) -> None:
    spec = spec_of(
        "for all a in others\n  require count(o in objects where abs(o.x - a.x) <= 10 m) <= 2",
        "max(sum(o.v for o in objects where o.x <= a.x) for a in others else 0 m/s) <= 10 m/s",
        "for all a in others: exists nearest o in objects by abs(o.x - a.x): o.v <= 3 m/s",
    )
    first, second = judged(spec, backend, (THREE, [15.0, 25.0]), (THREE, [50.0]))
    assert [m for _, m in said(first)] == [0.0, 4.0, 1.0]
    assert [m for _, m in said(second)] == [2.0, 3.0, 2.0]


def test_why_one_is_undefined() -> None:
    spec = spec_of("sum(o.v for o in objects) <= 9 m/s", "exists nearest o in objects by o.x: o.v <= 5 m/s")
    ((by_sum, nearest),) = judged(spec, "reference", ([(None, 1.0, True), (2.0, None, True)], []))
    assert by_sum.reason == "objects[1].v is missing, or no number"
    assert nearest.verdict == "undefined"


@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_under_an_operator_over_the_run(backend: str) -> None:
    spec = spec_of(
        "require not once[0.5 s, 3 s] count(o in objects where o.v < 2 m/s) >= 2",
        "for nearest o in objects by o.x\n  require not once[0.5 s, 3 s] o.v > 3 m/s",
    )
    evaluator = Evaluator(spec, None, backend)
    run = evaluator.over_run()
    verdicts = []
    for t, xs, speeds in [(0.0, (5.0, 6.0), (1.0, 1.0)), (1.0, (5.0, 6.0), (4.0, 1.0)), (2.0, (6.0, 5.0), (1.0, 9.0)),
                          (3.0, (5.0, 6.0), (1.0, 1.0))]:  # fmt: skip
        objects = [
            {"id": name, "x": x, "v": v, "ahead": True} for name, x, v in zip("ab", xs, speeds, strict=True)
        ]
        signals = {
            "plan": {"t": [0.0, 1.0], "v": [1.0, 1.0]}, "ego": {"x": 0.0, "v": 0.0}, "objects": objects, "others": [],
        }  # fmt: skip
        rules = run.step(evaluator.read({"t": t, "signals": signals})).rules
        verdicts.append((rules["r0"].verdict, rules["r1"].verdict))
    assert verdicts == [
        ("satisfied", "satisfied"), ("violated", "satisfied"), ("violated", "satisfied"), ("violated", "violated"),
    ]  # fmt: skip
