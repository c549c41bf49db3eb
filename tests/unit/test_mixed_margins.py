"""Tests in specs of rules whose comparisons have several dimensions: on the boundary, and on either side of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.backends.c import build
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.evaluation import Evaluator, loads
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


RUN_HEAD = """rule remembers "Slow and far away, and never fast"
  require ego.v <= 5 m/s and ego.gap >= 20 m and not once[0 s, 1 s] ego.v > 50 m/s
"""


@pytest.mark.parametrize(
    ("expect", "outcome"),
    [
        ("satisfied, margin 3 m/s", "passed"), ("satisfied, margin 3 m", "passed"), ("satisfied, margin 4 m/s", "failed"),
        ("violated, margin 3 m/s", "failed"),
    ],
)  # fmt: skip
def test_of_a_rule_over_the_run_the_number_counts(expect: str, outcome: str, tmp_path: Path) -> None:
    """Nobody keeps which of its comparisons decided: every unit of theirs was said to be another one, and none to be needed."""
    path = tmp_path / "made.spec"
    path.write_text(
        f'{HEAD}{RUN_HEAD}test remembers "t"\n  given ego = {{ v: 2 m/s, gap: 30 m }}\n  expect {expect}\n',
        "utf-8",
    )
    compiled = compile_paths([path], tmp_path)
    tests, found = prepare(compiled)
    assert not found
    assert [ran.outcome for ran in run_tests(compiled.spec, tests)] == [outcome]


COUNTS = """module counts
signal ego : state { v: m/s }
signal plan : trajectory { t: s increasing, v: m/s }
event braking "the brake light is on"
rule over_run "Seldom, and slow"
  require count(rising(braking), last: 10 s) <= 3 and ego.v <= 50 km/h
rule along_plan "Seldom, and slow"
  along plan as p
  require always (count(p.v > 10 m/s, last: 10 s) <= 3 and p.v <= 50 km/h)
rule alone "Seldom"
  require count(rising(braking), last: 10 s) <= 3
"""


@pytest.mark.parametrize(
    "backend",
    [
        "reference",
        "numpy",
        pytest.param("c", marks=pytest.mark.skipif(build.compiler() is None, reason="no C compiler")),
    ],
)
def test_a_count_is_no_speed(backend: str) -> None:
    """What is counted has no unit, whatever it is compared beside: three times were 3 m/s."""
    evaluator = Evaluator(loads(COUNTS), None, backend)
    case = {"ego": {"v": 1.0}, "plan": {"t": [0.0, 1.0], "v": [1.0, 1.0]}, "braking": True}
    said = evaluator.over_run().step(evaluator.read({"t": 0.0, "signals": case}))
    assert {name: (one.margin, one.unit) for name, one in said.rules.items()} == {
        "over_run": (2.0, "1"), "along_plan": (3.0, "1"), "alone": (2.0, "1"),
    }  # fmt: skip


def test_a_scale_beside_a_count_changes_no_number() -> None:
    """Counts have no scale, so that one speed beside a count is in its own unit, whatever is declared."""
    scaled = Evaluator(loads(COUNTS.replace("event", "scale m/s = 5 m/s\nevent")))
    case = {"ego": {"v": 13.0}, "plan": {"t": [0.0, 1.0], "v": [1.0, 1.0]}, "braking": True}
    said = scaled.over_run().step(scaled.read({"t": 0.0, "signals": case})).rules["over_run"]
    assert said.margin == 50 * 5 / 18 - 13.0


@pytest.mark.parametrize("scale", ["", "scale m = 10 m\n"])
@pytest.mark.parametrize("backend", ["numpy", "reference", "c"])
def test_where_nothing_decided_the_margin_has_no_unit(scale: str, backend: str) -> None:
    """`mixed` and `scaled` are words of the inside; what is not there, or does not apply, is in no unit, in every evaluator alike."""
    if backend == "c" and build.compiler() is None:
        pytest.skip("no C compiler")
    spec = loads(
        f"{HEAD}{scale}event on\n"
        'rule now "n"\n  whenever on\n  require ego.v <= 5 m/s and ego.gap >= 20 m\n'
        'rule past "t"\n  whenever on\n  require previous (ego.v <= 5 m/s and ego.gap >= 20 m)\n'
        'rule near "o"\n  whenever on\n  require ego.gap <= 20 m\n'
    )
    run, units = Evaluator(spec, ["now", "past", "near"], backend).over_run(), list[list[str]]()
    for t, ego in enumerate([{"v": 1.0}, {"v": 1.0, "gap": 3.0}]):
        result = run.step(Evaluator(spec).read({"t": t, "signals": {"ego": ego, "on": False}}))
        assert {one.verdict for one in result.rules.values()} == {"inactive" if "gap" in ego else "undefined"}
        units.append([one.unit for one in result.rules.values()])
    assert units == [["1", "1", "m"]] * 2
