"""Which tests stand on the boundary of their rule: those that fail as soon as its limits move."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from support.project import command
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import loads
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.boundary import Distances
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import coverage, has_boundary, run_tests

HEAD = """module m
signal ego : state { v: m/s, gap: m, x: m, y: m, on: bool }
signal plan : trajectory { t: s increasing, v: m/s }
zone pit "a square" = polygon (0 m, 0 m) (10 m, 0 m) (10 m, 10 m) (0 m, 10 m)
rule slow "a limit"
  require ego.v <= 10 m/s
rule strict "a limit that is not allowed"
  require ego.v < 10 m/s
rule far "a limit from below"
  require ego.gap >= 5 m
rule free "not both"
  require not (ego.v > 10 m/s and ego.gap > 5 m)
rule alike "both or neither"
  require ego.v <= 10 m/s iff ego.gap <= 5 m
rule parked "in the pit"
  require ego in zone pit
rule chosen "the guard's limit is none of its own"
  whenever ego.v >= 3 m/s
  require ego.gap >= 5 m
rule often "no more than one"
  along plan as p at last
  require count(p.v > 10 m/s) <= 1
"""


def judged(
    folder: Path, rule: str, given: str, expect: str, distances: Distances | None = None
) -> tuple[str, tuple[str, ...], bool]:
    """What came of a test, why it is not on the boundary of its rule, and whether it is."""
    path = folder / "m.spec"
    path.write_text(f'{HEAD}test {rule} "t"\n  given {given}\n  expect {expect}\n', "utf-8")
    compiled = compile_paths([path], folder)
    tests, found = prepare(compiled)
    assert [one.message for one in (*compiled.found, *found) if one.level == "error"] == []
    (outcome,) = run_tests(compiled.spec, tests, distances=distances)
    unmoved = {(rule, "t"): outcome.unmoved}
    covered = {c.rule.name: c for c in coverage(compiled.spec, tests, unmoved, distances)}[rule]
    return outcome.outcome, covered.beside, covered.boundary


STATE = "ego = {{ v: {v} m/s, gap: {gap} m, x: {x} m, y: {y} m, on: true }}"


def ego(v: float = 5, gap: float = 20, x: float = 5, y: float = 5) -> str:
    return STATE.format(v=v, gap=gap, x=x, y=y)


@pytest.mark.parametrize(
    ("rule", "given", "expect"),
    [
        ("slow", ego(v=10), "satisfied, margin 0 m/s"),
        ("slow", ego(v=10), "satisfied, margin about 0 m/s within 0.001 m/s"),
        ("strict", ego(v=10), "violated, margin 0 m/s"),
        ("far", ego(gap=5), "satisfied, margin 0 m"),
        ("free", ego(v=10, gap=9), "satisfied, margin 0"),
        ("alike", ego(v=10, gap=5), "satisfied, margin 0"),
        ("parked", ego(x=10), "satisfied, margin 0 m"),
        ("parked", ego(x=5, y=0), "satisfied, margin 0 m"),
        ("chosen", ego(v=3, gap=5), "satisfied, margin 0 m"),
        ("often", "plan = { t: [0 s, 1 s, 2 s], v: [11 m/s, 5 m/s, 5 m/s] }", "satisfied, margin 0"),
    ],
)  # fmt: skip
def test_on_it(rule: str, given: str, expect: str, tmp_path: Path) -> None:
    assert judged(tmp_path, rule, given, expect) == ("passed", (), True)


@pytest.mark.parametrize(
    ("demand", "there"),
    [
        ("require ego.v <= 10 m/s", True),
        ("require ego.on or ego.v <= 10 m/s", True),
        ("require count(rising(ego.on), last: 10 s) <= 2", True),  # nothing but a number of cycles is a limit
        ("whenever ego.v > 3 m/s\n  require ego.on", False),
        ("whenever rising(ego.v > 3 m/s)\n  require once[0 s, 5 s] ego.on", False),
        ("for all p in plan where p.v > 3 m/s\n  require ego.on", False),
    ],
)
def test_whether_there_is_one(demand: str, there: bool) -> None:
    """Of a rule of which guards alone compare numbers no test has a margin of 0: one was asked for, and none of a count of Booleans."""
    (rule,) = loads(f'{HEAD.split("rule", 1)[0]}rule asked "a demand"\n  {demand}\n').rules
    assert has_boundary(rule) == there


def test_any_margin_is_none(tmp_path: Path) -> None:
    """The fault that a review planted: a tolerance within which everything is on the boundary."""
    came = judged(tmp_path, "slow", ego(v=2), "satisfied, margin about 0 m/s within 1000000 m/s")
    why = '"t" takes any margin within 1e+06 m/s for 0, which is not small against 0.01 m/s'
    assert came == ("passed", (why,), False)


def test_the_distance_counts(tmp_path: Path) -> None:
    expect = "satisfied, margin about 0 m/s within 0.05 m/s"
    assert judged(tmp_path, "slow", ego(v=9.97), expect)[2] is False
    wider = Distances({"0.5 m/s": ("", 0)})
    assert judged(tmp_path, "slow", ego(v=9.97), expect, wider) == ("passed", (), True)


@pytest.mark.parametrize("text", ["0 m", "1 parsec", "inf m", "-1 m", "m"])
def test_distances_that_are_none(text: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        Distances({text: ("requirements/v-model.yaml", 7)})
    assert (caught.value.code, caught.value.line) == ("T347", 7)


def test_two_of_a_dimension() -> None:
    with pytest.raises(TrackmarshalError, match="second one of its dimension"):
        Distances({"1 cm": ("", 0), "2 mm": ("", 0)})


PROJECT = """document: v-model
title: small
project:
  name: small
  specs: [specs]
  default_spec: specs/m.spec
  baseline: requirements/baseline.json
{more}stages:
  - {{id: S-3-B, title: tests, shows: That it passes., applies_to: [R-*], counts: [test]}}
"""
REQUIREMENTS = """document: requirements
title: small
requirements:
  - {id: R-1, title: Slow, statement: The car shall be slow., status: approved, asil: QM, rationale: So that it stops in time., verification: [test], adopted: A law., source: A law.}
"""
SPEC = """module m

signal ego : state {{ v: m/s in [0, 100] }}

rule slow "Slow"
  satisfies R-1
  require   ego.v <= 10 m/s

test slow "slow"
  given  ego = {{ v: 5 m/s }}
  expect satisfied

test slow "fast"
  given  ego = {{ v: 15 m/s }}
  expect violated

test slow "at it"
  given  ego = {{ v: {v} m/s }}
  expect satisfied, margin about 0 m/s within {within} m/s
"""


def project(root: Path, v: str = "10", within: str = "0", more: str = "") -> Path:
    (root / "requirements").mkdir(parents=True, exist_ok=True)
    (root / "specs").mkdir(exist_ok=True)
    (root / "requirements" / "v-model.yaml").write_text(PROJECT.format(more=more), "utf-8")
    (root / "requirements" / "r.yaml").write_text(REQUIREMENTS, "utf-8")
    (root / "specs" / "m.spec").write_text(SPEC.format(v=v, within=within), "utf-8")
    return root


def test_the_gate_asks_for_it(tmp_path: Path) -> None:
    assert command(project(tmp_path), "trace", "--accept-baseline")[0] == 0
    assert command(tmp_path, "trace", "--gate")[0] == 0
    project(tmp_path, v="8", within="1000")
    status, out, _ = command(tmp_path, "trace", "--gate", "--verbose")
    assert status == 1
    assert '`slow` has no test exactly on its boundary; "at it" takes any margin within 1000 m/s' in out
    assert command(tmp_path, "test")[1].splitlines()[-2].startswith('slow: "at it" takes any margin')


@pytest.mark.parametrize(
    ("asked", "status", "said", "lacking"),
    [
        ("{boundary: 0}", 0, "", []),
        ("{boundary: 1}", 1, "slow  3      yes     yes      NO", ["boundary"]),
        ("{boundary: 0, violated: 2}", 1, "slow  3      yes     NO       n/a", ["violated"]),
    ],
)
def test_as_many_tests_are_asked_for_as_the_project_says(
    asked: str, status: int, said: str, lacking: list[str], tmp_path: Path
) -> None:
    """`test` asked for one each, so that it failed where the gate was content, and was content where that failed."""
    project(tmp_path, v="8", within="1000", more=f"  tests_per_rule: {asked}\n")
    made, out, _ = command(tmp_path, "test")
    assert made == status
    assert not said or said in [line.rstrip() for line in out.splitlines()], out
    assert ("T212" in command(tmp_path, "trace", "--gate")[1]) == bool(status)
    _, annotated, _ = command(tmp_path, "test", "--format", "github")
    assert ("fewer tests than `tests_per_rule` asks for outside of its boundary" in annotated) == (
        "2" in asked
    )
    cases = command(tmp_path, "test", "--format", "junit")[1]
    assert cases.count("<failure") == status
    (covered,) = json.loads(command(tmp_path, "test", "--format", "json")[1])["coverage"]
    assert covered["lacking"] == lacking


@pytest.mark.parametrize(("speed", "enough"), [("15 m/s", False), ("54 km/h", False), ("16 m/s", True)])
def test_a_copy_of_a_test_is_no_second_one(speed: str, enough: bool, tmp_path: Path) -> None:
    """`tests_per_rule` was content with one test under two titles, however its number was written."""
    path = project(tmp_path, more="  tests_per_rule: {violated: 2}\n") / "specs" / "m.spec"
    copy = f'\ntest slow "faster"\n  given  ego = {{ v: {speed} }}\n  expect violated\n'
    path.write_text(path.read_text("utf-8") + copy, "utf-8")
    said = '"faster" is "fast" under another title'
    status, out, _ = command(tmp_path, "test")
    assert (status, said in out) == (int(not enough), not enough)
    out = command(tmp_path, "trace", "--gate")[1]
    assert (f"`slow` has 1 of 2 tests that expect `violated`; {said}" in out) != enough


def test_another_distance_makes_results_anew(tmp_path: Path) -> None:
    assert command(project(tmp_path, v="9.98", within="0.03"), "trace", "--accept-baseline")[0] == 0
    assert "T212" in command(tmp_path, "trace", "--gate")[1]
    project(tmp_path, v="9.98", within="0.03", more="  boundary_distance: [0.5 m/s]\n")
    said = ("--accept-baseline", "--by", "Ann", "--reason", "measured so")
    assert command(tmp_path, "trace", *said)[0] == 0
    assert command(tmp_path, "trace", "--gate")[0] == 0


def test_a_bad_distance_says_where_it_stands(tmp_path: Path) -> None:
    project(tmp_path, more="  boundary_distance: [1 furlong]\n")
    for verb in ("trace", "test"):
        status, _, err = command(tmp_path, verb)
        assert (status, "requirements/v-model.yaml:8" in err, "T347" in err) == (2, True, True)


def test_a_distance_that_moves_nothing(tmp_path: Path) -> None:
    """Less than from one double to the next is no move: the test passes as before, and shows nothing."""
    tiny = Distances({"1e-16 m/s": ("", 0)})
    outcome, beside, on_it = judged(tmp_path, "slow", ego(v=10), "satisfied, margin 0 m/s", tiny)
    assert (outcome, on_it) == ("passed", False)
    assert beside == ('"t" passes as well where the limits are 1e-16 m/s looser or stricter',)
