"""Generated source: what is computed once, what is not computed, and what is refused."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from support.agreement import compiled, differences, read, results
from trackmarshal.backends.numpy.code import Code
from trackmarshal.backends.numpy.program import NumpyProgram
from trackmarshal.ir import nodes as ir

SPEC = """
module code
signal ego : state { x: m, y: m, v: m/s }
signal plan : trajectory { t: s increasing, x: m, y: m, v: m/s }
signal objects : set of object { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
param most : m/s = 3 m/s
zone pit = polygon (0 m, -1 m) (9 m, -1 m) (9 m, 1 m) (0 m, 1 m)
"""


def source(rules: str) -> str:
    spec = compiled(SPEC + rules)
    return NumpyProgram(spec, spec.rules).code.source


def count(text: str, call: str) -> int:
    return len(re.findall(rf"\b{call}\(", text))


def test_formulas_that_are_alike_are_computed_once() -> None:
    text = source("""
rule a "moving cars"
  for all p in plan where p.v > 1 m/s
  require p.x <= 5 m
rule b "moving cars again"
  for all p in plan where p.v > 1 m/s
  require p.x <= 6 m
rule c "not quite alike"
  for all p in plan where p.v >= 1 m/s
  require p.x <= 6 m
""")
    assert count(text, "compared") == 4  # two guards and two conditions


def test_choices_that_are_alike_and_all_made_of_them_are_computed_once() -> None:
    chosen = "sqrt(if p.v > 1 m/s then p.x / 1 m else p.y / 1 m)"
    text = source(f"""
rule a "chosen"
  for all p in plan
  require {chosen} <= 5
rule b "chosen again"
  for all p in plan
  require {chosen} <= 6
rule c "chosen otherwise, by another condition and by another number"
  for all p in plan
  require {chosen.replace("1 m/s", "2 m/s")} + {chosen.replace("p.y", "p.v * 1 s")} <= 6
""")
    assert count(text, "sqrt_") == 3


def test_choices_of_opposite_zeros_are_not_alike() -> None:
    spec = compiled(
        SPEC
        + """
rule a "half a turn to the left"
  for all p in plan
  require atan2(if p.v > 1 m/s then 0 else 1, -1) > 0
rule b "half a turn to the right"
  for all p in plan
  require atan2(if p.v > 1 m/s then -0 else 1, -1) > 0
"""
    )
    cases = read(spec, [{"signals": {"plan": {"t": [0.0, 1.0], "v": [2.0, 2.0]}}}])
    (found,) = results(spec, cases, "numpy")
    assert [rule.verdict for rule in found.rules.values()] == ["satisfied", "violated"]


def test_points_are_projected_once_onto_a_line() -> None:
    text = source("""
rule a "beside"
  for all o in objects
  require abs(offset(o, track) - offset(ego, track)) >= 1 m
rule b "before"
  for all o in objects
  require abs(station(o, track) - station(ego, track)) >= 1 m
""")
    assert count(text, "project") == 1


ALONG = """
rule a "each sample"
  for all p in plan
  require abs(offset(p, track)) <= 3 m
rule b "from one to the next, where it is fast"
  for all consecutive p, q in plan where p.v > 1 m/s and offset(p, track) < 2 m
  require abs(offset(p, track) - offset(q, track)) + direction(q, track) * 1 m <= 1 m
rule c "from the first one to the last"
  require station(plan.last, track) - station(plan.first, track) >= 4 m
rule d "each object"
  for all o in objects
  require abs(offset(o, track)) <= 9 m
rule e "each with each, where somebody is ahead"
  for all o in objects where o.x > ego.x
  require (for all other in objects: abs(offset(o, track) - offset(other, track)) + (o.x - other.x) * 0.1 + o.y * 0.1 + other.y * 0.1 <= 2 m)
"""


def test_samples_and_elements_are_projected_once_however_they_are_bound() -> None:
    (line,) = [line for line in source(ALONG).splitlines() if "project(" in line]
    assert len(re.findall(r"\(t\d+, t\d+, \)", line)) == 2  # of the plan, and of objects


def test_projections_of_samples_are_those_of_the_reference() -> None:
    spec = compiled(SPEC + ALONG)
    track = {
        "left": [[k, 4.0 + k * k / 9.0] for k in range(12)],
        "right": [[k, -3.0 + k * k / 9.0] for k in range(12)],
    }
    cases = []
    for count, gone in ((3, None), (5, 2), (2, None), (5, None)):
        x = [math.nan if k == gone else 0.7 + 1.9 * k for k in range(count)]
        plan = {
            "t": [*map(float, range(count))],
            "x": x,
            "y": [0.3 * k * k for k in range(count)],
            "v": [0.8 * k for k in range(count)],
        }
        objects = [{"x": 2.0 * k, "y": 1.0 - k} for k in range(count - 2)]
        ego = {"x": 1.0, "y": 0.5, "v": 3.0}
        cases.append({"signals": {"plan": plan, "objects": objects, "ego": ego, "track": track}})
    ready = read(spec, cases)
    found, expected = results(spec, ready, "numpy"), results(spec, ready, "reference")
    assert [differences(one, other) for one, other in zip(found, expected)] == [[]] * len(cases)
    assert {rule.verdict for one in expected for rule in one.rules.values()} >= {
        "satisfied",
        "violated",
        "undefined",
    }


def test_only_whether_a_guard_holds_is_asked() -> None:
    text = source("""
rule a "slow in the pit"
  for all p in plan where p in zone pit
  require p.v <= most
""")
    assert (count(text, "within"), count(text, "in_area")) == (1, 0)
    text = source("""
rule a "to the pit"
  for all p in plan where p.v <= most
  require p in zone pit
""")
    assert (count(text, "within"), count(text, "in_area")) == (0, 1)


def test_variables_are_used_again() -> None:
    """The memory of a number is free once nobody needs it."""
    long = " + ".join(f"sin({k}) * p.x" for k in range(1, 40))
    text = source(f"""
rule a "a long sum"
  for all p in plan
  require {long} <= 5 m
""")
    assert count(text, "sin_") == 39
    assert len(set(re.findall(r"^\s+(x\d+) = ", text.split("def varying")[1], re.MULTILINE))) < 10


@pytest.mark.parametrize("speed", [2.0, 5.0])
@pytest.mark.parametrize("x", [4.0, 9.0, 9.0005, 9.1, 1e6, -0.5, float("nan")])
def test_in_a_zone_near_it_and_nowhere_near(x: float, speed: float) -> None:
    spec = compiled(SPEC + """
rule a "slow in the pit"
  for all p in plan where p in zone pit
  require p.v <= most
""")  # fmt: skip
    plan = {"t": [0.0, 1.0], "x": [-50.0, x], "y": [0.0, 0.5], "v": [9.0, speed]}
    cases = read(spec, [{"signals": {"plan": plan}}])
    (one,), (expected,) = results(spec, cases, "numpy"), results(spec, cases, "reference")
    assert not differences(one, expected)
    assert (expected.rules["a"].verdict == "inactive") == (x > 9.0 or x < 0.0)


class Unknown(ir.IR):
    """A node that nobody has taught the generator."""


class UnknownFormula(ir.IR):
    pass


def spec_node(kind: type[ir.IR]) -> ir.Formula:
    known = compiled(SPEC + 'rule a "b"\n  require ego.v <= 5 m/s\n').rules[0].formula
    assert isinstance(known, ir.Compare)
    if kind is Unknown:
        return ir.Compare("<=", Unknown(), known.right, "m/s", known.span)  # type: ignore[arg-type]
    if kind is UnknownFormula:
        return UnknownFormula()  # type: ignore[return-value]
    return ir.Connective("nand", known, known)  # type: ignore[arg-type]


@pytest.mark.parametrize("kind", [Unknown, UnknownFormula, ir.Connective])
def test_what_is_unknown_is_refused(kind: type[ir.IR]) -> None:
    with pytest.raises(AssertionError, match=r"Unknown|nand"):
        Code([spec_node(kind)], [])


def test_a_rule_of_the_spec_can_be_read_in_the_source() -> None:
    text = source('rule a "b"\n  require ego.v + most <= 5 m/s\n')
    assert "b.param('code.most')" in text.split("def varying")[0]
    assert "b.scalar('ego', 'v')" in text.split("def varying")[1]
    np.testing.assert_array_equal(
        [line.strip() for line in text.splitlines() if "compared" in line],
        ["w0, b0 = compared(x3 - x2, x2, x3)"],
    )
