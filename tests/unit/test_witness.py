"""Which comparison decides, and where: by hand, for both evaluators."""

from __future__ import annotations

from typing import Any

import pytest

from support.agreement import compiled, read, results
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.explaining.numbers import numbers
from trackmarshal.runtime.verdict import RuleResult

HEAD = """
module made
signal trace : series { t: s increasing, u: 1, w: 1 }
signal objects : set of object { v: m/s, near: bool }
"""
both = pytest.mark.parametrize("backend", ["reference", "numpy"])


def decided(rule: str, backend: str, u: Any = (), w: Any = (), objects: Any = ()) -> RuleResult:
    """The result of a rule on a trace with one sample a second, and objects."""
    spec = compiled(f'{HEAD}\nrule r "made up"\n{rule}\n')
    trace = {"t": [float(k) for k in range(len(u))], "u": list(u), "w": list(w or u)}
    made = [{"id": f"car{k}", "v": v, "near": near} for k, (v, near) in enumerate(objects)]
    return results(spec, read(spec, [{"signals": {"trace": trace, "objects": made}}]), backend)[0].rules["r"]


def at(result: RuleResult) -> tuple[str, dict[str, int | str], str]:
    """The verdict, the binders of the witness, and the text of the deciding comparison."""
    assert result.witness is not None
    assert result.witness.span is not None
    return result.verdict, result.witness.binders, result.witness.span.text


@both
def test_the_worst_element_decides_for_all_and_the_best_one_exists(backend: str) -> None:
    objects = [(3.0, True), (1.0, True), (1.0, True), (2.0, True)]
    result = decided("  for all o in objects\n  require o.v > 0 m/s", backend, [0.0], objects=objects)
    assert at(result) == ("satisfied", {"o": "car1"}, "o.v > 0 m/s")
    assert result.witness is not None
    assert result.witness.margin == result.margin == 1.0
    result = decided("  exists o in objects\n  require o.v > 2.5 m/s", backend, [0.0], objects=objects)
    assert at(result) == ("satisfied", {"o": "car0"}, "o.v > 2.5 m/s")
    result = decided("  exists o in objects\n  require o.v > 5 m/s", backend, [0.0], objects=objects)
    assert at(result) == ("violated", {"o": "car0"}, "o.v > 5 m/s")


@both
def test_elements_out_of_range_do_not_decide(backend: str) -> None:
    objects = [(-3.0, False), (4.0, True), (2.0, True)]
    result = decided(
        "  for all o in objects where o.near\n  require o.v > 0 m/s", backend, [0.0], objects=objects
    )
    assert at(result) == ("satisfied", {"o": "car2"}, "o.v > 0 m/s")


@both
def test_a_doubtful_range_is_named_where_the_demand_itself_is_decided(backend: str) -> None:
    objects = [(3.0, True), (-1.0, None)]
    result = decided(
        "  for all o in objects where o.near\n  require o.v > 0 m/s", backend, [0.0], objects=objects
    )
    assert at(result) == ("undefined", {"o": "car1"}, "o.near")


@both
@pytest.mark.parametrize(
    ("quantifier", "objects", "verdict", "element"),
    [
        ("for all", [(-9.0, None), (-1.0, True)], "violated", "car1"),
        ("for all", [(1.0, None), (2.0, True)], "satisfied", "car0"),
        ("exists", [(9.0, None), (1.0, True)], "satisfied", "car1"),
        ("exists", [(-1.0, None), (-2.0, True)], "violated", "car0"),
    ],
)
def test_who_may_be_in_range_decides_only_where_that_is_enough(
    quantifier: str, objects: Any, verdict: str, element: str, backend: str
) -> None:
    rule = f"  {quantifier} o in objects where o.near\n  require o.v > 0 m/s"
    result = decided(rule, backend, [0.0], objects=objects)
    assert at(result) == (verdict, {"o": element}, "o.v > 0 m/s")
    assert result.witness is not None
    assert result.witness.margin == result.margin


@both
@pytest.mark.parametrize(("quantifier", "sign"), [("for all", 1.0), ("exists", -1.0)])
def test_a_doubtful_range_is_named_only_of_whom_it_matters(
    quantifier: str, sign: float, backend: str
) -> None:
    rule = f"  {quantifier} o in objects where o.near\n  require o.v > 0 m/s"
    result = decided(rule, backend, [0.0], objects=[(3.0 * sign, None), (-3.0 * sign, None)])
    assert at(result) == ("undefined", {"o": "car1"}, "o.near")
    assert result.reason == "objects[car1].near is missing, or no number"


@both
def test_an_undefined_element_decides_only_when_no_other_one_fails(backend: str) -> None:
    rule = "  for all o in objects\n  require o.v > 0 m/s"
    assert at(decided(rule, backend, [0.0], objects=[(1.0, True), (None, True)]))[:2] == (
        "undefined",
        {"o": "car1"},
    )
    assert at(decided(rule, backend, [0.0], objects=[(None, True), (-1.0, True)]))[:2] == (
        "violated",
        {"o": "car1"},
    )


@both
def test_of_a_window_the_first_extreme_sample_decides(backend: str) -> None:
    rule = "  along trace as s\n  require {}[1 s, 3 s] s.u > 0"
    u = [-9.0, 5.0, 2.0, 2.0, -7.0]
    assert at(decided(rule.format("always"), backend, u)) == ("satisfied", {"s": 2}, "s.u > 0")
    assert at(decided(rule.format("eventually"), backend, u)) == ("satisfied", {"s": 1}, "s.u > 0")


@both
@pytest.mark.parametrize(
    ("u", "w", "verdict", "sample", "text"),
    [
        ([3.0, 2.0, 9.0, 9.0], [-1.0, -1.0, 4.0, -1.0], "satisfied", 1, "s.u > 0"),  # held until w, but hardly
        ([3.0, 2.0, 9.0, 9.0], [-1.0, -1.0, 1.0, -1.0], "satisfied", 2, "s.w > 0"),  # w itself is nearer to failing
        ([3.0, -2.0, 9.0, 9.0], [-5.0, -5.0, 4.0, 4.0], "violated", 1, "s.u > 0"),  # not held
        ([3.0, 2.0, 9.0, 9.0], [-4.0, -3.0, -1.0, -2.0], "violated", 2, "s.w > 0"),  # never w
        ([3.0, None, 9.0, 9.0], [-5.0, -5.0, 4.0, -1.0], "undefined", 1, "s.u > 0"),
        ([3.0, 2.0, 9.0, 9.0], [-5.0, None, -4.0, -1.0], "undefined", 1, "s.w > 0"),
        ([3.0, 2.0, 9.0, 9.0], [7.0, 8.0, 8.0, 1.0], "satisfied", 0, "s.w > 0"),
    ],
)  # fmt: skip
def test_until_is_decided_by_what_ends_it_or_by_what_has_to_hold(
    backend: str, u: list[Any], w: list[Any], verdict: str, sample: int, text: str
) -> None:
    result = decided("  along trace as s\n  require s.u > 0 until s.w > 0", backend, u, w)
    assert at(result) == (verdict, {"s": sample}, text)


@both
def test_since_looks_back_from_the_last_sample(backend: str) -> None:
    rule = "  along trace as s\n  require eventually[3 s, 3 s] (s.u > 0 since s.w > 0)"
    result = decided(rule, backend, [9.0, 9.0, 2.0, 3.0], [-1.0, 4.0, -1.0, -1.0])
    assert at(result) == ("satisfied", {"s": 2}, "s.u > 0")
    result = decided(rule, backend, [9.0, 9.0, -2.0, 3.0], [-5.0, 4.0, -5.0, -5.0])
    assert at(result) == ("violated", {"s": 2}, "s.u > 0")
    result = decided(rule, backend, [9.0, 9.0, 9.0, 9.0], [1.0, 5.0, 5.0, -1.0])
    assert at(result) == ("satisfied", {"s": 1}, "s.w > 0")


@both
def test_an_empty_window_decides_nothing(backend: str) -> None:
    result = decided("  along trace as s\n  require s.u > 0 until[9 s, 10 s] s.w > 0", backend, [1.0, 1.0])
    assert (result.verdict, result.witness) == ("violated", None)
    result = decided("  along trace as s\n  require always[9 s, 10 s] s.u > 0", backend, [1.0, 1.0])
    assert (result.verdict, result.witness) == ("satisfied", None)


NAMED = """
module made
signal plan : trajectory { t: s increasing, v: m/s }
signal objects : set of object { v: m/s }
define most(limit: m/s, more: m/s = 1 m/s) -> m/s = max(p.v for p in plan where p.v <= limit else 0 m/s) + more
rule samples "What a `let` names stands outside `for all`"
  let least = min(o.v for o in objects else 0 m/s)
  for all p in plan
  require p.v <= least
rule elements "And may be about the same set"
  let least = min(o.v for o in objects else 0 m/s)
  for all o in objects
  require o.v <= least + 1 m/s
rule called "So does what is given to a definition"
  for all o in objects
  require o.v <= most(min(a.v for a in objects else 0 m/s))
"""


@both
@pytest.mark.parametrize(
    ("rule", "place", "told"),
    [
        ("samples", ("plan", 1), [("left side", "9 m/s"), ("right side", "4 m/s"), ("plan[1].v", "9 m/s")]),
        ("elements", ("objects", 2), [("left side", "6 m/s"), ("right side", "5 m/s"), ("objects[2].v", "6 m/s")]),
        ("called", ("objects", 2), [("left side", "6 m/s"), ("right side", "5 m/s"), ("objects[2].v", "6 m/s")]),
    ],
)  # fmt: skip
def test_a_variable_is_known_beside_a_number_of_many(
    rule: str, place: tuple[str, int], told: list[tuple[str, str]], backend: str
) -> None:
    spec = compiled(NAMED)
    signals = {"plan": {"t": [0.0, 1.0], "v": [4.0, 9.0]}, "objects": [{"v": 5.0}, {"v": 4.0}, {"v": 6.0}]}
    cases = read(spec, [{"signals": signals}])
    witness = results(spec, cases, backend)[0].rules[rule].witness
    assert witness is not None
    assert witness.at is not None
    assert witness.places == (place,)
    node, env = witness.at
    shown = numbers(node, dict(env), Reference(spec, cases[0]))
    assert [row for row in shown if not row[0].startswith("made.")] == told
