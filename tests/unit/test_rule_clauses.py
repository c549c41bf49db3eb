"""How the clauses of a rule make one formula: timelines, guards, ranges; and numbers that no rule may be made of."""

from __future__ import annotations

from typing import Any

import pytest

from support.agreement import compiled, read, results
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.runtime.verdict import CaseResult

HEAD = """
module made
signal trace : series { t: s increasing, u: 1 }
signal objects : set of object { v: m/s }
event go
"""
TRACE = {"t": [0.0, 1.0], "u": [1.0, -1.0]}
both = pytest.mark.parametrize("backend", ["reference", "numpy"])


def result(rules: str, backend: str, **signals: Any) -> CaseResult:
    spec = compiled(HEAD + rules)
    given = {"trace": TRACE, "objects": [], "go": True} | signals
    return results(spec, read(spec, [{"signals": given}]), backend)[0]


def codes(text: str) -> set[str]:
    with pytest.raises(Diagnostics) as caught:
        compiled(text)
    return {diagnostic.code for diagnostic in caught.value.items}


@both
def test_a_guard_may_stand_before_the_timeline(backend: str) -> None:
    """It knows nothing of the sample, so its place makes no difference, to the series neither."""
    before = result("rule r\n  whenever go\n  along trace as s\n  require s.u > 0\n", backend).rules["r"]
    after = result("rule r\n  along trace as s\n  whenever go\n  require s.u > 0\n", backend).rules["r"]
    assert before.series == after.series == (["satisfied", "violated"], [1.0, -1.0])
    idle = result("rule r\n  whenever go\n  along trace as s\n  require s.u > 0\n", backend, go=False).rules[
        "r"
    ]
    assert idle.verdict == "inactive"


@both
def test_a_quantifier_of_a_guard_before_the_timeline_is_its_own(backend: str) -> None:
    rule = (
        "rule r\n  whenever exists o in objects: o.v > 0 m/s\n  along trace as s\n  require always s.u > 0\n"
    )
    assert result(rule, backend).rules["r"].verdict == "inactive"
    assert result(rule, backend, objects=[{"v": -1.0}, {"v": 1.0}]).rules["r"].verdict == "violated"


@pytest.mark.parametrize("column", ["t: s", "t: m increasing", "t: bool", "time: s increasing"])
def test_a_timeline_has_increasing_times(column: str) -> None:
    """Else windows would mean nothing, and every evaluation would have to refuse the data."""
    text = f"module made\nsignal odd : series {{ {column}, u: 1 }}\nrule r\n  along odd as s\n  require always s.u > 0\n"
    assert codes(text) == {"E213"}


@both
@pytest.mark.parametrize("time", [None, float("nan"), float("inf")])
def test_a_single_sample_needs_a_time_too(backend: str, time: float | None) -> None:
    found = result(
        "rule r\n  along trace as s\n  require always s.u > 0\n", backend, trace={"t": [time], "u": [1.0]}
    )
    assert found.rules["r"].verdict == "undefined"
    assert not found.safe


@both
def test_nothing_below_an_exists_is_idle(backend: str) -> None:
    """Whether a rule applies is asked of what stands outside of all `exists`."""
    rule = (
        "rule r\n  exists s in trace\n  for all o in objects where o.v > s.u * 1 m/s\n  require o.v > 2 m/s\n"
    )
    assert result(rule, backend).rules["r"].verdict == "satisfied"
    assert result(rule, backend, objects=[{"v": 1.5}]).rules["r"].verdict == "violated"
    assert result(rule, backend, objects=[{"v": 0.5}]).rules["r"].verdict == "satisfied"
    outer = "rule r\n  for all o in objects\n  exists s in trace\n  require o.v > s.u * 1 m/s\n"
    assert result(outer, backend).rules["r"].verdict == "inactive"


@both
def test_steps_along_a_timeline_need_no_times(backend: str) -> None:
    """`next` counts samples; only windows are measured in time."""
    without = {"u": [1.0, 2.0, -3.0]}
    found = result("rule r\n  along trace as s\n  require next s.u > 1\n", backend, trace=without)
    assert (found.rules["r"].verdict, found.rules["r"].margin) == ("satisfied", 1.0)
    found = result("rule r\n  along trace as s\n  require always s.u > 1\n", backend, trace=without)
    assert found.rules["r"].verdict == "undefined"


@pytest.mark.parametrize(
    "line",
    [
        "param p : 1 = 1e999",
        "param p : m = 1e308 km",
        "param p : 1 = 1 / 0",
        "param p : 1 = 0 / 0",
        "param p : 1 = log(-1)",
        "table f(x: 1) -> 1 = linear clamp | 0: 1e999 |",
        "table f(x: 1) -> 1 = linear clamp | inf: 1 |",
        "zone z = polygon (0, 0) (1, 0) (1, inf)",
        "signal odd : state { x: 1 default inf }",
        "rule r\n  require 1 < 2 ^ 1e999",
    ],
)
def test_a_number_that_is_not_finite_is_no_number_of_a_spec(line: str) -> None:
    assert codes(f"module made\n{line}\n") == {"E306"}


def test_a_range_may_be_open() -> None:
    spec = compiled("module made\nparam p : 1 = 5 in [0, inf]\nsignal e : state { x: 1 in [-inf, 3] }\n")
    assert spec.params["made.p"].upper == float("inf")


def test_a_rule_comes_from_all_of_its_sources() -> None:
    spec = compiled(
        'module made\nreference paper = "A paper"\nsignal ego : state { v: m/s }\n'
        'rule r\n  source    paper eq 2, 3\n  source    "a regulation"\n  require   ego.v <= 3 m/s\n'
    )
    assert spec.rules[0].source == "A paper, eq 2, 3; a regulation"
