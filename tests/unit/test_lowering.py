"""What is written in other words than those of the core is rewritten by its definition: values, and what is said of them, stay."""

from __future__ import annotations

import math

import pytest

from support.agreement import compiled, read, results
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.evaluation import Evaluator
from trackmarshal.explaining.numbers import numbers
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.verdict import RuleResult

HEAD = """module made
signal plan : trajectory { t: s increasing, u: m, hot: bool }
signal ego : state { a: m, b: m }
"""
BACKENDS = ("reference", "numpy")
INF = math.inf


def rule_of(condition: str, along: str = "  along plan as p\n", more: str = "") -> RuleInfo:
    return compiled(f'{HEAD}{more}rule r "r"\n{along}  require {condition}\n').rules[0]


def formula(condition: str, more: str = "") -> ir.Formula:
    """The core of a formula that has no timeline."""
    found = rule_of(condition, "", more).formula
    assert found is not None
    return found


def run(condition: str, backend: str, u: list[float], hot: list[bool | None] | None = None) -> RuleResult:
    """A rule along a plan, a sample a second."""
    spec = compiled(f'{HEAD}rule r "r"\n  along plan as p\n  require {condition}\n')
    plan = {"t": [float(k) for k in range(len(u))], "u": u, "hot": hot or [False] * len(u)}
    (case,) = read(spec, ({"id": 0, "signals": {"plan": plan, "ego": {"a": 2.0, "b": 1.0}}},))
    return results(spec, [case], backend)[0].rules["r"]


def test_implies_is_a_disjunction() -> None:
    found = formula("ego.a < 1 m implies ego.b < 2 m")
    assert isinstance(found, ir.Connective)
    assert found.op == "or"
    assert isinstance(found.left, ir.Not)
    assert isinstance(found.right, ir.Compare)


@pytest.mark.parametrize(("written", "core"), [(">", "<"), (">=", "<=")])
def test_greater_is_less_the_other_way_round(written: str, core: str) -> None:
    found = formula(f"ego.a {written} ego.b")
    assert isinstance(found, ir.Compare)
    assert (found.op, found.turned, found.span.text) == (core, True, f"ego.a {written} ego.b")
    assert isinstance(found.left, ir.Scalar)
    assert isinstance(found.right, ir.Scalar)
    assert (found.left.field, found.right.field) == ("b", "a")


def test_the_limit_keeps_its_unit_on_either_side() -> None:
    shown = [
        getattr(formula(text), "shown", None) for text in ("ego.a > 5 cm", "5 cm < ego.a", "5 cm > ego.a")
    ]
    assert shown == ["cm"] * 3


def test_explain_shows_the_sides_as_they_are_written() -> None:
    spec = compiled(f'{HEAD}rule r "r"\n  require ego.a > ego.b\nrule s "s"\n  require ego.b < ego.a\n')
    evaluator = Evaluator(spec, None, "reference")
    case = evaluator.read(
        {"signals": {"ego": {"a": 2.0, "b": 1.0}, "plan": {"t": [0.0], "u": [0.0], "hot": [True]}}}
    )
    values = Reference(spec, case)
    turned, straight = (
        numbers(rule.formula, {}, values)[:2] for rule in spec.rules if rule.formula is not None
    )
    assert turned == [("left side", "2 m"), ("right side", "1 m")]
    assert straight == [("left side", "1 m"), ("right side", "2 m")]


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("condition", "holds", "margins"),
    [
        # Before the first sample, what rises counts as false, and what falls as true.
        ("rising(p.u > 0 m)", [True, False, False, True], [2.0, -2.0, -1.0, 1.0]),
        ("falling(p.u > 0 m)", [False, True, False, False], [-2.0, 0.0, 0.0, -3.0]),
    ],
)
def test_edges_by_hand(backend: str, condition: str, holds: list[bool], margins: list[float]) -> None:
    found = run(condition, backend, [2.0, 0.0, -1.0, 3.0]).series
    assert found is not None
    assert found == (["satisfied" if one else "violated" for one in holds], margins)
    assert all(math.copysign(1.0, margin) == 1.0 for margin in found[1] if margin == 0.0)


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_edge_is_claimed_of_what_is_undefined(backend: str) -> None:
    """The middle sample may hold or not: rising may be there or after it; falling neither, as nothing held before."""
    rises, falls = (
        run(f"{edge}(p.u > 0 m)", backend, [-1.0, math.nan, 1.0]).series for edge in ("rising", "falling")
    )
    assert rises is not None
    assert falls is not None
    assert rises[0] == ["violated", "undefined", "undefined"]
    assert falls == (["satisfied", "violated", "violated"], [1.0, -1.0, -1.0])


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(
    ("condition", "hot", "at"),
    [
        ("rising(p.hot)", [True, True], 0),  # there is nothing before it
        ("falling(p.hot)", [False, True], 0),
        (
            "eventually[1 s, 1 s] rising(p.hot)",
            [False, True],
            0,
        ),  # both decide, and the sample before comes first
        ("eventually[1 s, 1 s] rising(p.hot)", [True, True], 0),
        ("eventually[1 s, 1 s] rising(p.hot)", [False, False], 1),
        ("eventually[1 s, 1 s] falling(p.hot)", [True, True], 1),
    ],
)
def test_what_decides_an_edge(backend: str, condition: str, hot: list[bool | None], at: int) -> None:
    witness = run(condition, backend, [0.0, 0.0], hot).witness
    assert witness is not None
    assert witness.span is not None
    assert (witness.binders, witness.span.text) == ({"p": at}, "p.hot")


def test_chains_and_ranges_are_conjunctions_of_comparisons_where_they_are_written() -> None:
    chained, within = formula("0 m <= ego.a < ego.b"), formula("ego.a in [1 m, 2 m]")
    spans = [[n.span.text for n in ir.below(f) if isinstance(n, ir.Compare)] for f in (chained, within)]
    assert sorted(spans[0]) == ["0 m <= ego.a", "ego.a < ego.b"]
    assert spans[1] == ["ego.a in [1 m, 2 m]"] * 2


def test_powers_are_products_and_what_is_no_whole_number_is_pow() -> None:
    cube, root = formula("ego.a^3 < 1 m^3"), formula("(ego.a / ego.b)^0.5 < 1")
    assert [n.op for n in ir.below(cube) if isinstance(n, ir.Arith)] == ["*", "*"]
    assert [n.name for n in ir.below(root) if isinstance(n, ir.Func)] == ["pow"]


def test_inside_a_definition_messages_point_to_the_call_and_to_arguments_where_they_stand() -> None:
    more = "predicate far(d: m) = (if d > 1 m then d else 2 * d) > 5 m\n"
    found = formula("far(if ego.a > 3 m then ego.a else ego.b)", more)
    spans = {n.span.text for n in ir.below(found) if isinstance(n, ir.Compare)}
    assert spans == {"far(if ego.a > 3 m then ego.a else ego.b)", "ego.a > 3 m"}


def test_a_name_is_one_number_however_often_it_is_used() -> None:
    spec = compiled(f'{HEAD}rule r "r"\n  let d = ego.a - ego.b\n  require d > 1 m or d < -1 m\n')
    found = spec.rules[0].formula
    assert found is not None
    assert len([n for n in ir.below(found) if isinstance(n, ir.Arith)]) == 1


def test_a_fingerprint_changes_with_the_meaning_and_not_with_the_words_of_a_definition() -> None:
    def fingerprint(body: str) -> str:
        return rule_of("far(ego.a)", "", f"predicate far(d: m) = {body}\n").fingerprint

    assert fingerprint("d < 5 m and true") == fingerprint("(d < 5 m)   and true -- so")
    assert fingerprint("true implies d < 5 m") == fingerprint("not true or d < 5 m")
    assert len({fingerprint(f"d {op} 5 m") for op in ("<", "<=", ">", ">=", "==", "!=")}) == 6
    assert fingerprint("d > 5 m") != fingerprint("5 m > d")


def test_rules_keep_what_they_were_made_of() -> None:
    rule = rule_of("rising(p.u > 0 m)")
    assert rule.typed is not None
    assert rule.typed.condition.span.text == "rising(p.u > 0 m)"
    monitorless = compiled(HEAD + 'assume A "nothing to see"\n  because "why"\n  owner "me"\n').rules
    assert [(found.typed, found.formula) for found in monitorless] == [(None, None)]
