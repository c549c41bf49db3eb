"""`a <= b < c` is `a <= b and b < c`, for every evaluator, and b is one number."""

from __future__ import annotations

import math
from itertools import product
from pathlib import Path

import pytest

from trackmarshal.evaluation import BACKENDS, Evaluator
from trackmarshal.ir import nodes as ir
from trackmarshal.semantics.compile import Compiled, compile_paths
from trackmarshal.source import SourceFile
from trackmarshal.syntax.format import format_text

SIGNAL = "signal ego : state { a: m, b: m, c: m, d: m }\n"
CHAINS = {
    "ego.a <= ego.b <= ego.c": "ego.a <= ego.b and ego.b <= ego.c",
    "ego.a < ego.b <= ego.c": "ego.a < ego.b and ego.b <= ego.c",
    "ego.a >= ego.b > ego.c": "ego.a >= ego.b and ego.b > ego.c",
    "0 m <= sqrt(ego.a^2) < ego.b + ego.c <= ego.d": "0 m <= sqrt(ego.a^2) and sqrt(ego.a^2) < ego.b + ego.c and ego.b + ego.c <= ego.d",
    "not 1 m < ego.a < 3 m": "not (1 m < ego.a and ego.a < 3 m)",
    "ego.a < ego.b < ego.c or ego.d > ego.c > ego.b": "(ego.a < ego.b and ego.b < ego.c) or (ego.d > ego.c and ego.c > ego.b)",
}


def compiled(folder: Path, content: str) -> Compiled:
    path = folder / "made.spec"
    path.write_text(f"module made\n{SIGNAL}{content}", "utf-8")
    return compile_paths([path], folder)


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_chain_is_its_comparisons_joined(backend: str, tmp_path: Path) -> None:
    rules = "".join(
        f'rule chain_{i} "r"\n  require {chain}\nrule plain_{i} "r"\n  require {plain}\n'
        for i, (chain, plain) in enumerate(CHAINS.items())
    )
    made = compiled(tmp_path, rules)
    assert made.found == ()
    evaluator = Evaluator(made.spec, None, backend)
    values = (0.0, 1.0, 2.0, math.nan)
    cases = evaluator.read_all(
        [
            {"signals": {"ego": dict(zip("abcd", some))}}
            for some in product(values, values, values, (1.0, 3.0))
        ]
    )
    verdicts = set()
    for result in evaluator.evaluate(cases):
        for i in range(len(CHAINS)):
            chain, plain = result.rules[f"chain_{i}"], result.rules[f"plain_{i}"]
            assert (chain.verdict, chain.unit) == (plain.verdict, plain.unit)
            assert chain.margin == plain.margin or (math.isnan(chain.margin) and math.isnan(plain.margin))
            verdicts.add(chain.verdict)
    assert verdicts == {"satisfied", "violated", "undefined"}


def test_the_comparison_that_decides_is_named(tmp_path: Path) -> None:
    made = compiled(tmp_path, 'rule r "r"\n  require 0 m <= ego.a <= ego.b\n')
    evaluator = Evaluator(made.spec, None, "reference")
    cases = [
        evaluator.read({"signals": {"ego": {"a": a, "b": 4.0, "c": 0.0, "d": 0.0}}}) for a in (1.0, 3.0, -1.0)
    ]
    spans = []
    for result in evaluator.evaluate(cases):
        witness = result.rules["r"].witness
        assert witness is not None
        assert witness.span is not None
        spans.append((witness.span.text, witness.margin))
    assert spans == [("0 m <= ego.a", 1.0), ("ego.a <= ego.b", 1.0), ("0 m <= ego.a", -1.0)]


def test_the_operand_in_the_middle_is_one_number(tmp_path: Path) -> None:
    made = compiled(tmp_path, 'rule r "r"\n  require 0 m < sqrt(ego.a * ego.b) < ego.c\n')
    rule = made.spec.rule("r")
    assert rule is not None
    assert rule.formula is not None
    both = [node for node in ir.below(rule.formula) if isinstance(node, ir.Compare)]
    sides = [{id(node.left), id(node.right)} for node in both]
    assert len(both) == 2
    assert len(sides[0] & sides[1]) == 1


def test_an_error_in_the_middle_is_one_error(tmp_path: Path) -> None:
    assert [f.code for f in compiled(tmp_path, 'rule r "r"\n  require 0 m < missing < 3 m\n').found] == [
        "E201"
    ]
    made = compiled(tmp_path, 'rule r "r"\n  require 0 s < ego.a < 3 s\n')
    assert [(f.code, f.span.text) for f in made.found] == [("E301", "0 s"), ("E301", "ego.a")]


def test_the_formatter_keeps_a_row_together() -> None:
    operands = [f"a_rather_long_name_{i} + another_one_{i}" for i in range(4)]
    text = f"rule r\n  require   {' < '.join(operands)}\n"
    laid = format_text(SourceFile("t.spec", text))
    assert laid == "rule r\n  require   " + "\n              < ".join(operands) + "\n"
    assert format_text(SourceFile("t.spec", laid)) == laid
    assert format_text(SourceFile("t.spec", "rule r\n  require a < b iff (0 m<= c ) <d\n")).endswith(
        "require   a < b iff (0 m <= c) < d\n"
    )
