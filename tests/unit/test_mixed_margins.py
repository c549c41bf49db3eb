"""Tests in specs of rules whose comparisons have several dimensions: on the boundary, and on either side of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import Outcome, coverage, run_tests

HEAD = """module made
signal ego : state { v: m/s, gap: m }
rule either "Slow, or far away"
  require ego.v <= 5 m/s or ego.gap >= 20 m
rule both "Slow and far away"
  require ego.v <= 5 m/s and ego.gap >= 20 m
"""


def outcomes(
    folder: Path, rule: str, v: float, gap: float, expect: str
) -> tuple[list[Outcome], list[Diagnostic], bool]:
    path = folder / "made.spec"
    path.write_text(
        f'{HEAD}test {rule} "t"\n  given ego = {{ v: {v} m/s, gap: {gap} m }}\n  expect {expect}\n', "utf-8"
    )
    compiled = compile_paths([path], folder)
    assert compiled.found == ()
    tests, found = prepare(compiled)
    boundary = {c.rule.name: c.boundary for c in coverage(compiled.spec, tests)}[rule]
    return list(run_tests(compiled.spec, tests)), found, boundary


@pytest.mark.parametrize(
    ("rule", "v", "gap", "expect"),
    [
        ("either", 9, 20, "satisfied, margin 0"), ("either", 5, 1, "satisfied, margin 0"), ("both", 5, 30, "satisfied, margin about 0"),
        ("either", 9, 20, "satisfied, margin 0 m"), ("either", 5, 1, "satisfied, margin 0 m/s"), ("both", 3, 20, "satisfied, margin 0 km"),
    ],
)  # fmt: skip
def test_zero_is_the_boundary_in_every_unit(
    rule: str, v: float, gap: float, expect: str, tmp_path: Path
) -> None:
    ran, found, boundary = outcomes(tmp_path, rule, v, gap, expect)
    assert found == []
    assert [(o.outcome, o.message) for o in ran] == [("passed", "")]
    assert boundary


@pytest.mark.parametrize(
    ("rule", "v", "gap", "expect", "boundary"),
    [
        ("either", 9, 23, "satisfied, margin 3 m", False), ("either", 2, 1, "satisfied, margin 3 m/s", False),
        ("both", 6, 30, "violated, margin about -3.6 km/h within 0.1 km/h", False),
        ("both", 4.5, 40, "satisfied, margin about 0 within 1 m/s", False),
    ],
)  # fmt: skip
def test_other_margins_have_the_unit_of_what_decides(
    rule: str, v: float, gap: float, expect: str, boundary: bool, tmp_path: Path
) -> None:
    ran, found, on_it = outcomes(tmp_path, rule, v, gap, expect)
    assert found == []
    assert [(o.outcome, o.message) for o in ran] == [("passed", "")]
    assert on_it == boundary


@pytest.mark.parametrize(
    ("v", "gap", "expect", "message"),
    [
        (9, 20, "satisfied, margin 0 m/s", "reference: expected a margin in m/s, the comparison that decides is in m"),
        (9, 23, "satisfied, margin 3 m/s", "reference: expected a margin in m/s, the comparison that decides is in m"),
        (9, 23, "satisfied, margin 0", "reference: expected margin 0 m, got 3 m"),
        (9, 20.5, "satisfied, margin about 0 within 1 m/s", "reference: expected a margin in m/s, the comparison that decides is in m"),
    ],
)  # fmt: skip
def test_another_margin_or_another_unit_fails(
    v: float, gap: float, expect: str, message: str, tmp_path: Path
) -> None:
    ran, found, _ = outcomes(tmp_path, "either", v, gap, expect)
    assert found == []
    assert [(o.outcome, o.message) for o in ran] == [("failed", message)]


def test_a_margin_that_is_another_in_its_last_bits_alone_says_so(tmp_path: Path) -> None:
    """40 km/h less 30 km/h are not 10 km/h, in the last bit: `expected 10 km/h, got 10 km/h` was all that somebody was told."""
    path = tmp_path / "slow.spec"
    path.write_text(
        'module slow\nsignal ego : state { v: km/h }\nrule slow "s"\n  require ego.v <= 40 km/h\n'
        'test slow "t"\n  given ego = { v: 30 km/h }\n  expect satisfied, margin 10 km/h\n'
    )
    compiled = compile_paths([path], tmp_path)
    tests, found = prepare(compiled)
    assert found == []
    (outcome,) = run_tests(compiled.spec, tests)
    assert outcome.message.endswith(": the last bits differ, expect `margin about 10 km/h within ...`")
