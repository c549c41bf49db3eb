"""Limits solved: what is claimed is so, what is not so is not claimed, and the rest is found on the evaluator."""

from __future__ import annotations

import math
import random
from functools import cache
from pathlib import Path

import pytest

sympy = pytest.importorskip("sympy")

from support.length import amount, at_length  # noqa: E402
from support.reading import rule_of  # noqa: E402
from trackmarshal.evaluation import Evaluator, load, loads  # noqa: E402
from trackmarshal.ir.spec import RuleInfo, Spec  # noqa: E402
from trackmarshal.reading.solving import claims, solve  # noqa: E402
from trackmarshal.reading.solving.algebra import Place, Unsolvable, zeros  # noqa: E402
from trackmarshal.reading.solving.boundaries import boundary  # noqa: E402
from trackmarshal.reading.solving.inputs import limits  # noqa: E402
from trackmarshal.reading.terminal import text  # noqa: E402
from trackmarshal.reading.words.english import ENGLISH  # noqa: E402
from trackmarshal.semantics.compile import compile_paths, compile_text  # noqa: E402
from trackmarshal.testing.cases import PreparedTest, prepare  # noqa: E402

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(autouse=True)
def _fewer_inputs(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every day, a claim is held against fewer inputs than ship: as many tell a bound a thousandth beside the right one. Of friction with drag, what is
    so on few inputs is not so on all."""
    if "friction" not in request.node.name:
        monkeypatch.setattr(claims, "CHECKED", amount(100, claims.CHECKED))


@cache
def shipped() -> tuple[Spec, list[PreparedTest]]:
    compiled = compile_paths([ROOT / "specs"], ROOT)
    return compiled.spec, prepare(compiled)[0]


def shipped_rule(name: str) -> RuleInfo:
    rule = shipped()[0].rule(name)
    assert rule is not None
    return rule


def said(name: str, number: str) -> list[str]:
    return [
        " | ".join(map(text, one.formulas)) or one.said
        for one in solve(shipped_rule(name), shipped()[0], shipped()[1], number, ENGLISH)
    ]


@pytest.mark.parametrize(
    ("rule", "number", "wanted"),
    [
        ("speed_limit", "v", ["v_p ≤ min(v_event, v_max)"]),
        at_length("no_reversing", "v", ["v_p ≥ 0"]),
        at_length("turn_radius", "kappa", ["|κ_p| ≤ 1/R_min"]),
        at_length("braking_limit", "a", ["a_p ≥ −b_max"]),
        at_length("drive_acceleration", "a", ["a_p ≤ ax_max(v_p) · drive_factor − (drag · v_p²)/mass", "a_p ≤ ax_max(v_p) · drive_factor | where drag = 0"]),
        ("A-PERCEPTION", "oldest_object", ["oldest_object ≥ age_o"]),
    ],
)  # fmt: skip
def test_shipped_limits(rule: str, number: str, wanted: list[str]) -> None:
    assert said(rule, number) == wanted


@pytest.mark.acceptance  # every day, docs/show.md has both solutions, word for word (test_show.py)
def test_the_friction_circle_solved_for_speed() -> None:
    """Without drag the limit of the paper, ((mu g)^2 - a^2)^(1/4) / sqrt(|kappa|); with drag where braking at rest is possible at all."""
    whole, simple = said("friction", "v")
    assert simple == "|v_p| ≤ ((μ² · grip_p² · g² − a_p²)/κ_p²)^(1/4) | where drag = 0"
    assert whole.startswith("|v_p| ≤ √")
    assert whole.endswith(" | where μ · grip_p · g ≥ |a_p|")


def test_the_solution_is_the_evaluators_own() -> None:
    """By other inputs than those that the claim was held against, and by a formula that is written here."""
    evaluator = Evaluator(shipped()[0], ["friction"], "reference")
    choose = random.Random(5)
    for _ in range(50):
        a, kappa, grip = (
            choose.uniform(-10.0, 10.0),
            choose.choice((-1, 1)) * choose.uniform(0.002, 0.2),
            choose.uniform(0.9, 1.2),
        )
        limit = ((13.0 * grip) ** 2 - a * a) ** 0.25 / math.sqrt(abs(kappa))
        for factor, verdict in ((1.0 - 1e-9, "satisfied"), (1.0 + 1e-9, "violated")):
            plan = {"a": [a, a], "kappa": [kappa, kappa], "grip": [grip, grip], "v": [limit * factor] * 2}
            case = {"signals": {"plan": plan}, "params": {"vehicles.devbot.drag": 0.0}}
            if limit < 150.0:
                assert evaluator.case(case).rules["friction"].verdict == verdict


def test_a_wrong_solution_is_not_claimed(monkeypatch: pytest.MonkeyPatch) -> None:
    """What algebra says a thousandth beside the boundary, the reference denies."""
    monkeypatch.setattr(
        claims,
        "zeros",
        lambda difference, x: [root * sympy.Rational(1001, 1000) for root in zeros(difference, x)],
    )
    solver = claims.Solver(shipped_rule("braking_limit"), shipped()[0], Place("p", "plan", 0, "a"))
    assert list(solver.claims()) == []
    (first, *_) = said("braking_limit", "a")
    assert first.startswith(
        "For p.a: not solved, because of a formula that the reference evaluator does not confirm"
    )


def test_a_claim_on_part_of_the_inputs_says_which(tmp_path: Path) -> None:
    rule, spec = rule_of(
        tmp_path, 'rule r "r"\n  for all p in plan\n  require (p.v - 20 m/s)^2 <= 10 m * p.a\n'
    )
    (made,) = solve(rule, spec, (), "v", ENGLISH)
    assert "wherever it applies and is not undefined, and both sides are real numbers" in made.said
    (demand,) = made.formulas
    assert text(demand).count("v_p") == 1


@pytest.mark.parametrize(
    ("condition", "wanted"),
    [
        ("p.v < p.a * 1 s", "v_p < a_p"), at_length("p.a * 1 s > p.v", "v_p < a_p"), at_length("p.v > p.a * 1 s", "v_p > a_p"),
        ("1 m/s < p.v <= p.a * 1 s", "1 < v_p ≤ a_p"), at_length("p.v^2 < 10 m * p.a", "|v_p| < √(10) · √(a_p)"),
        at_length("p.v <= p.a * 1 s and p.v < p.a * 1 s", "v_p < a_p"),
    ],
)  # fmt: skip
def test_a_demand_that_does_not_hold_on_its_boundary(condition: str, wanted: str, tmp_path: Path) -> None:
    rule, spec = rule_of(tmp_path, f'rule r "r"\n  for all p in plan\n  require {condition}\n')
    (made,) = solve(rule, spec, (), "v", ENGLISH)
    assert [text(one) for one in made.formulas] == [wanted]
    if "^2" in condition:
        return  # there is no root of 40 whose square is 40
    on = {name: [4.0, 4.0] for name in ("a", "v")}
    verdict = Evaluator(spec, ["r"], "reference").case({"signals": {"plan": on}}).rules["r"].verdict
    assert verdict == ("satisfied" if "≤ a_p" in wanted else "violated")


@pytest.mark.parametrize(
    ("condition", "wanted"),
    [
        ("twice(p, p.a * 1 s) <= top", "v_p ≤ top/2 − a_p/2"),
        ("twice(ego, 1 m/s) + twice(p, 2 m/s) <= top", "v_p ≤ top/2 − twice(ego, 1 m/s)/2 − 1"),
        ("slow(p, ego)", "v_p ≤ top/2 − twice(ego, 0 m/s)/2"),
        ("slower(3 m/s, p)", "v_p ≤ top − 3"),
    ],
)
def test_a_solution_names_what_is_given_to_definitions(condition: str, wanted: str) -> None:
    """Their own names, as of `o`, are nothing that the rule knows, and one stood for two cars."""
    spec = loads(f"""module m
signal plan : trajectory {{ v: m/s, a: m/s^2 }}
signal ego : state {{ v: m/s }}
shape moved = {{ v: m/s }}
param top : m/s = 50 km/h in [1, 200]
define twice(o: moved, u: m/s) -> m/s = 2 * o.v + u
predicate slow(a: moved, b: moved) = 2 * a.v + twice(b, 0 m/s) <= top
predicate slower(than: m/s, q: moved) = q.v + than <= top
rule r "r"
  for all p in plan
  require {condition}
""")
    (made, *_) = solve(spec.rules[0], spec, (), "p.v", ENGLISH)
    assert [text(one) for one in made.formulas] == [wanted]


def test_a_rule_that_asks_for_a_member_is_solved() -> None:
    """Inputs had numbers for members, of which none is green, and the reference "did not confirm" what it was never asked."""
    spec = loads(
        "module m\nenum flag { green, red }\nsignal ego : state { v: m/s, flag: flag }\nparam top : m/s = 9 m/s\n"
        'rule r "r"\n  whenever ego.flag is green\n  require 2 * ego.v <= top\n'
    )
    (made,) = solve(spec.rules[0], spec, (), "v", ENGLISH)
    assert [text(one) for one in made.formulas] == ["v_ego ≤ top/2"]


def test_where_a_solution_says_nothing_of_a_rule_is_said(tmp_path: Path) -> None:
    """Below 0 m/s the demand is undefined, which is not safe, and what was solved for is kept there."""
    rule, spec = rule_of(tmp_path, 'rule r "r"\n  for all p in plan\n  require sqrt(p.v / (1 m/s)) <= 3\n')
    below = {"v": [-4.0, -4.0]}
    verdict = Evaluator(spec, ["r"], "reference").case({"signals": {"plan": below}}).rules["r"].verdict
    (made,) = solve(rule, spec, (), "v", ENGLISH)
    assert ([text(one) for one in made.formulas], verdict) == (["v_p ≤ 9"], "undefined")
    assert "wherever it applies and is not undefined" in made.said


def test_numbers_of_a_solution_are_said_to_be_in_si() -> None:
    """Whatever units the spec is written in: `top` is 50 km/h, and is not to be read as 50 here."""
    spec = loads("""module m
param top : km/h = 50 km/h in [1, 200]
signal cars : set of object { v: km/h in [-100, 100], h: deg in [-180, 180] }
rule r "r"
  for all o in cars
  require o.v + 36 km/h <= top
rule turned "t"
  for all o in cars
  require abs(o.h) <= 90 deg
""")
    for name, number, wanted in (("r", "v", "v_o ≤ top − 10"), ("turned", "h", "|h_o| ≤ 1.5707963267948966")):
        rule = spec.rule(name)
        assert rule is not None
        (made,) = solve(rule, spec, (), number, ENGLISH)
        assert [text(one) for one in made.formulas] == [wanted]
        assert made.said.endswith("All numbers in it are in SI units.")


@pytest.mark.parametrize(
    ("condition", "wanted"),
    [
        ("p.v <= floor(p.v0) * top", "v_p ≤ top · ⌊v0_p⌋"), at_length("p.v <= exp(-p.v0) * top", "v_p ≤ top/exp(v0_p)"),
        at_length("p.v <= exp(1) * top", "v_p ≤ exp(1) · top"), at_length("p.v <= log(p.v0) * top", "v_p ≤ top · log(v0_p)"),
        at_length("p.v <= tanh(p.v0) * top", "v_p ≤ top · tanh(v0_p)"), ("p.v <= (acos(p.v0) + asin(p.v0)) * top", "v_p ≤ top · (acos(v0_p) + asin(v0_p))"),
        ("p.v <= sqrt(p.v0)^3 * top", "v_p ≤ v0_p^(3/2) · top"),
    ],
)  # fmt: skip
def test_functions_beside_the_number_are_written_as_in_formulas(condition: str, wanted: str) -> None:
    spec = loads(f"""module m
signal plan : trajectory {{ t: s increasing, v: m/s in [-100, 100], v0: 1 in [-1, 1] }}
param top : m/s = 20 m/s in [1, 50]
rule r "r"
  for all p in plan
  require {condition}
""")
    (made,) = solve(spec.rules[0], spec, (), "v", ENGLISH)
    assert [text(one) for one in made.formulas] == [wanted]


def test_what_sympy_writes_as_cases_is_not_claimed() -> None:
    spec = loads(
        'module m\nsignal ego : state { v: 1 }\nparam g : 1 = 2\nrule r "r" require 2 * ego.v + 2 >= sign(g)\n'
    )
    (made,) = solve(spec.rules[0], spec, (), "v", ENGLISH)
    assert made.formulas == ()
    assert made.said.startswith("For ego.v: not solved, because of ")


@pytest.mark.parametrize(
    ("condition", "reason"),
    [
        ("p.v * sin(p.v / top) < top", "polynomial"), ("(p.v / top)^5 + p.v / top < 2", "degree"), ("min(p.v, top) < 3 m/s", "polynomial"),
        ("p.v == top", "equality"), ("p.v < top or p.hot", "comparison"), ("ax_max(p.v) < 3 m/s^2", "table"),
        ("p.v < top and p.a < 1 m/s^2", "beside"), ("(if p.hot then p.v else top) < top", "choice"), ("p.v < plan.last.v", "sample"),
        ("distance_to(p, border) < p.v * 1 s", "line"), ("sqrt(p.v / top) + sqrt(p.v / top + 1) < 3", "roots"),
    ],
)  # fmt: skip
def test_what_is_not_solved_says_why(condition: str, reason: str, tmp_path: Path) -> None:
    rule, spec = rule_of(tmp_path, f'rule r "r"\n  for all p in plan\n  require {condition}\n')
    with pytest.raises(Unsolvable) as caught:
        list(claims.Solver(rule, spec, Place("p", "plan", 0, "v")).claims())
    assert caught.value.reason in (reason, "lines")
    assert caught.value.reason in ENGLISH.reasons


@pytest.mark.parametrize("condition", ["always c.v <= top", "ego.v <= top"])
def test_a_rule_along_a_course_has_several_samples(condition: str) -> None:
    spec = loads(
        "module made\nsignal ego : state { v: m/s }\nsignal plan : trajectory { t: s increasing, v: m/s }\nparam top : m/s = 20 m/s\n"
        f'course lived = ego for 2 s then plan\nrule r "r"\n  along lived as c\n  require {condition}\n'
    )
    (made,) = solve(spec.rules[0], spec, (), "top", ENGLISH)
    assert made.said.startswith(f"For top: not solved, because of {ENGLISH.reasons['samples']}")


def test_a_timeline_in_a_let_that_nothing_asks_for_is_no_input() -> None:
    spec = loads(
        "module made\nsignal ego : state { v: m/s }\nsignal plan : trajectory { t: s increasing, v: m/s }\nparam top : m/s = 20 m/s\n"
        'rule r "r"\n  let most = max(p.v for p in plan)\n  require ego.v <= top\n'
    )
    (made,) = solve(spec.rules[0], spec, (), "ego.v", ENGLISH)
    assert list(map(text, made.formulas)) == ["v_ego ≤ top"]


def test_every_reason_has_words() -> None:
    from typing import get_args

    from trackmarshal.reading.solving.algebra import Reason

    assert set(ENGLISH.reasons) == set(get_args(Reason))


def test_a_boundary_is_found_where_a_test_puts_it() -> None:
    """The test of a track exactly as wide as the car: there the width is at its boundary, 2.8 m."""
    spec, tests = shipped()
    (exact,) = (
        one
        for one in tests
        if one.rule.name == "static_collision" and one.title == "a track exactly as wide as the car"
    )
    found = boundary(exact.rule, spec, exact, Place("", "", 0, "vehicles.devbot.width"), (0.5, 5.0))
    assert found is not None
    ((low, high),) = found.holds
    assert low == 0.5
    assert high == pytest.approx(2.8, abs=1e-9)


@pytest.mark.parametrize(
    ("declared", "wanted"),
    [
        ("[20000, 100000]", (20000.0, 100000.0)), ("[0, 400000]", (0.0, 4e5)), ("[-1e10, 1e10]", (-1e4, 1e4)),
        ("[0, 1e10]", (0.0, 1e4)), ("[5e6, 1e10]", (5e6, 1e10)),
    ],
)  # fmt: skip
def test_a_number_is_looked_at_in_its_declared_range(declared: str, wanted: tuple[float, float]) -> None:
    """What is heavy is beyond 10 t: its range was cut there, which left none, or nothing of what the tests were about."""
    spec = loads(
        f'module m\nsignal ego : state {{ m: kg in {declared} }}\nrule r "r" require ego.m >= 30000 kg\n'
    )
    assert limits(spec, Place("ego", "ego", 0, "m")) == wanted


def test_a_limit_of_what_is_heavy_is_found(tmp_path: Path) -> None:
    (tmp_path / "m.spec").write_text(
        "module m\nsignal ego : state { m: kg in [20000, 100000] }\n"
        'rule r "r" require sin(ego.m / 100000 kg) <= sin(0.5)\n'
        'test r "on the limit" given ego = { m: 50000 kg } expect satisfied\n'
    )
    compiled = compile_paths([tmp_path / "m.spec"])
    spec, (tests, _) = compiled.spec, prepare(compiled)
    target = Place("ego", "ego", 0, "m")
    found = boundary(spec.rules[0], spec, tests[0], target, limits(spec, target))
    assert found is not None
    ((low, high),) = found.holds
    assert (low, high) == pytest.approx((20000.0, 50000.0), abs=1e-3)


def test_what_was_found_says_at_how_many_values_it_was_looked_for() -> None:
    """Between 30 m/s and 31 m/s the rule is violated; that it is kept everywhere was more than anybody had seen."""
    compiled = compile_text(
        'module m\nsignal ego : state { v: m/s in [0, 60] }\nrule r "r"\n'
        "  require (if ego.v > 20 m/s then abs(ego.v - 30.5 m/s) else 1 m/s) >= 0.4 m/s\n"
        'test r "slow"\n  given ego = { v: 10 m/s }\n  expect satisfied\n'
    )
    evaluator = Evaluator(compiled.spec, backend="reference")
    assert evaluator.case({"signals": {"ego": {"v": 30.5}}}).rules["r"].verdict == "violated"
    _, found = solve(compiled.spec.rules[0], compiled.spec, prepare(compiled)[0], "v", ENGLISH)
    assert found.said.endswith(": as far as 61 values show, the limit is kept everywhere.")


def test_what_a_rule_does_not_have_is_refused() -> None:
    from trackmarshal.errors import TrackmarshalError

    with pytest.raises(TrackmarshalError) as caught:
        list(solve(shipped_rule("friction"), shipped()[0], (), "y", ENGLISH))
    assert caught.value.code == "E491"


def test_the_spec_is_loaded_as_others_load_it() -> None:
    assert load([ROOT / "specs"], [], ROOT).fingerprint == shipped()[0].fingerprint
