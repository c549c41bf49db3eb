"""Scales of margins: what decides where dimensions meet, in every evaluator, on either side of where the order changes."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import trackmarshal as tm
from property.strategies.specs import repeatable
from support.length import amount
from support.project import run_command
from trackmarshal.backends.c.source import generate
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.verdict import RuleResult
from trackmarshal.semantics.compile import compile_text
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

HEAD = "module made\n\nsignal ego : state { v: m/s, gap: m, ok: bool default true }\n\n"
BOTH = '\nrule both "Slow and far away"\n  require   ego.v <= 5 m/s and ego.gap >= 20 m\n'
BACKENDS = ("reference", "numpy", "c")


def results(spec: Spec, v: float, gap: float, rule: str = "both") -> list[RuleResult]:
    case = {"signals": {"ego": {"v": v, "gap": gap}}}
    return [Evaluator(spec, backend=backend).case(case).rules[rule] for backend in BACKENDS]


@pytest.mark.parametrize(
    ("scales", "v", "gap", "margin", "unit"),
    [
        ("", 2.0, 24.0, 3.0, "m/s"), ("", 2.0, 22.0, 2.0, "m"),
        ("scale m = 10 m", 2.0, 24.0, 0.4, "m"), ("scale m = 10 m", 2.0, 51.0, 3.0, "m/s"),
        ("scale m = 10 m\nscale m/s = 6 m/s", 2.0, 24.0, 0.4, "m"), ("scale m = 10 m\nscale m/s = 6 m/s", 2.0, 26.0, 0.5, "m/s"),
        ("scale m = 10 m\nscale m/s = 6 m/s", 8.0, 16.0, -0.5, "m/s"), ("scale m = 10 m\nscale m/s = 6 m/s", 8.0, 14.0, -0.6, "m"),
        ("scale m/s = 18 km/h", 4.0, 20.5, 0.2, "m/s"),
    ],
)  # fmt: skip
def test_what_decides(scales: str, v: float, gap: float, margin: float, unit: str) -> None:
    for result in results(loads(HEAD + scales + "\n" + BOTH), v, gap):
        assert result.margin == margin
        assert result.witness is not None
        assert result.witness.unit == unit
        assert result.unit == ("1" if scales else unit)
        assert result.witness.margin == (5.0 - v if unit == "m/s" else gap - 20.0)


def test_a_rule_of_one_dimension_keeps_its_number() -> None:
    spec = loads(HEAD + "scale m = 10 m\n" + '\nrule far "far"\n  require   ego.gap >= 20 m and ego.ok\n')
    plain = loads(HEAD + '\nrule far "far"\n  require   ego.gap >= 20 m and ego.ok\n')
    assert [(r.margin, r.unit) for r in results(spec, 0.0, 23.0, "far")] == [(3.0, "m")] * 3
    assert spec.rules[0].fingerprint == plain.rules[0].fingerprint
    assert spec.fingerprint != plain.fingerprint


PLACES = """module placed
scale m = 10 m
scale m/s = 5 m/s
signal ego : state { x: m, y: m, heading: rad, v: m/s, length: m, width: m }
signal track : corridor { left: polyline, right: polyline }
signal lanes : set of lane { left: polyline, right: polyline }
zone box = polygon (0 m, -5 m) (100 m, -5 m) (100 m, 5 m) (0 m, 5 m)
rule zoned "5 m" require ego in zone box and ego.v <= 20 m/s
rule on_track "5 m" require ego in stretch(track, 10 m, 90 m) and ego.v <= 20 m/s
rule on_lane "5 m" for all l in lanes require ego in stretch(l, 10 m, 90 m) and ego.v <= 20 m/s
rule contained "4 m" require footprint(ego) inside track and ego.v <= 20 m/s
rule beside "2.5 m" for all l in lanes require not (footprint(ego) meets l) and ego.v <= 20 m/s
"""


@pytest.mark.parametrize("backend", BACKENDS)
def test_all_that_lies_somewhere_is_divided_alike(backend: str) -> None:
    """By 10 m; the speed is 4 of its scale below its limit."""
    ego = {"x": 15.0, "y": 0.0, "heading": 0.0, "v": 0.0, "length": 4.0, "width": 2.0}
    track = {"left": [[0.0, 5.0], [100.0, 5.0]], "right": [[0.0, -5.0], [100.0, -5.0]]}
    lane = {"left": [[0.0, 9.0], [100.0, 9.0]], "right": [[0.0, 3.5], [100.0, 3.5]]}
    case = {"signals": {"ego": ego, "track": track, "lanes": [lane]}}
    rules = Evaluator(loads(PLACES), backend=backend).case(case).rules
    wanted = {"zoned": 0.5, "on_track": 0.5, "on_lane": 0.5, "contained": 0.4, "beside": 0.25}
    assert {name: result.margin for name, result in rules.items()} == wanted
    assert {result.witness.unit for result in rules.values() if result.witness is not None} == {"m"}


def test_one_is_as_none() -> None:
    spec, plain = loads(HEAD + "scale m = 1 m\n" + BOTH), loads(HEAD + "-- none\n" + BOTH)
    assert spec.rules[0].fingerprint == plain.rules[0].fingerprint
    assert (
        generate(spec, spec.rules).source.split("\n", 1)[1]
        == generate(plain, plain.rules).source.split("\n", 1)[1]
    )


def test_a_margin_that_is_rounded_to_nothing_changes_no_verdict() -> None:
    text = HEAD + 'scale m = 1e300 m\n\nrule both "b"\n  require   ego.v <= 5 m/s and ego.gap > 0 m\n'
    for gap, verdict in ((5e-324, "satisfied"), (0.0, "violated"), (-5e-324, "violated")):
        for result in results(loads(text), 0.0, gap):
            assert (result.verdict, result.margin, math.copysign(1.0, result.margin)) == (verdict, 0.0, 1.0)


RULES = (
    "ego.v <= 5 m/s and ego.gap >= 20 m", "ego.v <= 5 m/s or not ego.gap >= 20 m", "ego.v <= 5 m/s xor ego.gap >= 20 m",
    "ego.v == 5 m/s implies ego.gap != 20 m", "(if ego.gap > 3 m then ego.v else 2 m/s) < 5 m/s and ego.gap < 7 m and ego.ok",
)  # fmt: skip
#: Numbers of which neighbours are compared.
SHARP = st.sampled_from([0.0, 3.0, 5.0, 20.0, 7.0, 1e308, -1e308, 5e-324, math.nan, math.inf]) | st.floats(
    -50, 50
)


@settings(repeatable, max_examples=amount(4, 8))
@given(
    st.sampled_from([0.1, 3.0, 7.5]),
    st.sampled_from([0.3, 10.0]),
    st.lists(st.tuples(SHARP, SHARP), min_size=8, max_size=30),
)
def test_evaluators_agree_and_verdicts_are_those_without(
    speed: float, length: float, points: list[tuple[float, float]]
) -> None:
    rules = "".join(
        f'\nrule r{n} "r"\n  allow     W301 because "sharp"\n  require   {text}\n'
        for n, text in enumerate(RULES)
    )
    spec = loads(HEAD + f"scale m/s = {speed} m/s\nscale m = {length} m\n" + rules)
    plain = loads(HEAD + rules)
    for v, gap in points:
        case = {"signals": {"ego": {"v": v, "gap": gap, "ok": True}}}
        said = [
            {
                name: (r.verdict, repr(r.margin))
                for name, r in Evaluator(spec, backend=b).case(case).rules.items()
            }
            for b in BACKENDS
        ]
        assert said[0] == said[1] == said[2]
        before = Evaluator(plain).case(case).rules
        assert {name: verdict for name, (verdict, _) in said[0].items()} == {
            name: result.verdict for name, result in before.items()
        }
        first, wanted = before["r0"], min((5.0 - v) / speed, (gap - 20.0) / length)
        if first.verdict != "undefined" and math.isfinite(v) and math.isfinite(gap):
            assert float(said[0]["r0"][1]) == wanted + 0.0


@pytest.mark.parametrize(
    ("expect", "message"),
    [
        ("satisfied, margin 0.5", ""), ("satisfied, margin 3 m/s", ""), ("satisfied, margin about 2.9 m/s within 0.2 m/s", ""),
        ("satisfied, margin 5 m", "reference: expected a margin in m, the comparison that decides is in m/s"),
        ("satisfied, margin 2 m/s", "reference: expected margin 0.333333333, got 0.5"),
    ],
)  # fmt: skip
def test_tests_expect_a_number_of_scales_or_a_margin_of_what_decides(expect: str, message: str) -> None:
    text = HEAD + "scale m = 10 m\nscale m/s = 6 m/s\n" + BOTH
    compiled = compile_text(
        f'{text}\ntest both "t"\n  given ego = {{ v: 2 m/s, gap: 26 m }}\n  expect {expect}\n'
    )
    assert compiled.found == ()
    tests, found = prepare(compiled)
    assert found == []
    assert [outcome.message for outcome in run_tests(compiled.spec, tests)] == [message]


def test_reports_name_the_comparison_with_its_own_unit(tmp_path: Path) -> None:
    (tmp_path / "made.spec").write_text(
        HEAD + "scale m = 10 m\nscale km/h = 18 km/h\n" + BOTH.replace("5 m/s", "18 km/h"), "utf-8"
    )
    (tmp_path / "case.jsonl").write_text(json.dumps({"signals": {"ego": {"v": 8, "gap": 26}}}), "utf-8")
    _, out, _ = run_command("eval", str(tmp_path / "made.spec"), "--data", str(tmp_path / "case.jsonl"))
    assert "-0.6 of a scale, by -10.8 km/h (-3 m/s)" in out


BOOK = """
rule slow "slow"
  require   ego.v <= 5 m/s

rule far "far"
  require   ego.gap >= 20 m

rulebook one "counts as one"
  slow & far
"""


def test_violations_that_count_as_one_meet_by_their_scales() -> None:
    fast, near = (
        {"slow": ("violated", -3.0), "far": ("satisfied", 1.0)},
        {"slow": ("satisfied", 1.0), "far": ("violated", -5.0)},
    )
    plain, scaled = loads(HEAD + BOOK), loads(HEAD + "scale m = 10 m\nscale m/s = 5 m/s\n" + BOOK)
    assert tm.compare(tm.rulebook(plain, "one"), fast, near).outcome == "better"
    assert tm.compare(tm.rulebook(scaled, "one"), fast, near).outcome == "worse"
    assert "tm_compare_one" in generate(plain, plain.rules).header
    assert "tm_compare_one" not in generate(scaled, scaled.rules).header  # results in C know no scales


RUN = """
event braking "brakes"

state pace : { fast, slow } starts fast
  becomes slow when braking
    remember entry = ego.v
  becomes fast when not braking

rule lately "slow and far in the last second"
  require   once[0 s, 1 s] (ego.v <= 5 m/s and ego.gap >= 20 m)

rule kept "slower than when it began to brake, and far"
  whenever  pace is slow
  require   ego.v <= pace.entry and ego.gap >= 20 m
"""


def test_rules_over_the_run() -> None:
    spec = loads(HEAD + "scale m = 10 m\nscale m/s = 6 m/s\n" + RUN)
    cycles = [(8.0, 14.0, False), (8.0, 16.0, True), (6.0, 26.0, True), (5.5, 21.0, True), (9.0, 26.0, True)]
    found = []
    for backend in BACKENDS:
        evaluator = Evaluator(spec, backend=backend)
        run, said = evaluator.over_run(), []
        for number, (v, gap, braking) in enumerate(cycles):
            case = {"t": number / 2, "signals": {"ego": {"v": v, "gap": gap}, "braking": braking}}
            rules = run.step(evaluator.read(case)).rules
            said.append(
                [(rules[name].verdict, rules[name].margin, rules[name].unit) for name in ("lately", "kept")]
            )
        found.append(said)
    assert found[0] == found[1] == found[2]
    own = [min((5.0 - v) / 6.0, (gap - 20.0) / 10.0) for v, gap, _ in cycles]
    assert [said[0][1] for said in found[0]] == [max(own[max(0, k - 2) : k + 1]) for k in range(len(cycles))]
    assert [said[1][1] for said in found[0]][1:] == [
        min((8.0 - v) / 6.0, (gap - 20.0) / 10.0) + 0.0 for v, gap, _ in cycles[1:]
    ]
