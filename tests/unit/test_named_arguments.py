"""Arguments by name and by default are the same as all of them in order: the verdict, the margin and the layout."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.agreement import compiled
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator
from trackmarshal.source import SourceFile
from trackmarshal.syntax.format import format_text

HEAD = """module made

signal ego : state { x: m, v: m/s }

param cap : m = 7 m

define f(a: m, b: m = cap, c: m = 3 m, o: m = ego.x) -> m = 2 * a - 3 * b + 5 * c - 7 * o
predicate amid(x: m, low: m = 0 m, high: m = cap) = low <= x and x <= high
"""
BACKENDS = ["reference", "numpy", *(["c"] if compiler() else [])]
NAMES = ("a", "b", "c", "o")
DEFAULTS = {"b": "cap", "c": "3 m", "o": "ego.x"}


def rules(*calls: str) -> str:
    return HEAD + "".join(f'\nrule r{n} "x"\n  require {call}\n' for n, call in enumerate(calls))


def margins(text: str, backend: str) -> list[tuple[str, str]]:
    evaluator = Evaluator(compiled(text), backend=backend)
    case = evaluator.read({"signals": {"ego": {"x": 1.25, "v": 2.0}}})
    (result,) = evaluator.evaluate([case])
    return [(one.verdict, float(one.margin).hex()) for one in result.rules.values()]


@settings(deadline=None, max_examples=25)
@given(st.permutations(NAMES), st.integers(0, 4), st.sets(st.sampled_from(NAMES[1:])))
def test_any_order_by_name(order: list[str], placed: int, left_out: set[str]) -> None:
    given_ = {name: f"{n + 1}.5 m" for n, name in enumerate(NAMES)}
    first = NAMES[:placed]
    named = [name for name in order if name not in first and name not in left_out]
    arguments = [given_[name] for name in first] + [f"{name}: {given_[name]}" for name in named]
    whole = [DEFAULTS[n] if n in left_out and n not in first else given_[n] for n in NAMES]
    text = rules(f"f({', '.join(arguments)}) <= 0 m", f"f({', '.join(whole)}) <= 0 m")
    one, other = margins(text, "reference")
    assert one == other


@pytest.mark.parametrize("backend", BACKENDS)
def test_every_evaluator(backend: str) -> None:
    text = rules("f(1 m, c: 2 m) <= 0 m", "amid(x: ego.x)", "amid(ego.x, high: 1 m)", "ego.x amid 1 m")
    worth = 2 * 1 - 3 * 7 + 5 * 2 - 7 * 1.25
    assert margins(text, backend) == [
        ("satisfied", (-worth).hex()),
        ("satisfied", (1.25).hex()),
        ("violated", (-0.25).hex()),
        ("satisfied", (0.25).hex()),
    ]


def test_a_default_sees_its_own_module_and_no_parameter(tmp_path: object) -> None:
    text = HEAD.replace("b: m = cap", "b: m = a") + '\nrule r "x"\n  require f(1 m) <= 0 m\n'
    with pytest.raises(Exception, match="`a`"):
        compiled(text)


def test_layout_keeps_names_and_defaults() -> None:
    text = rules("f(1 m, o: 2 m, c: cap + 1 m) <= 0 m")
    laid_out = format_text(SourceFile("made.spec", text))
    assert "b: m = cap, c: m = 3 m, o: m = ego.x" in laid_out
    assert "f(1 m, o: 2 m, c: cap + 1 m)" in laid_out
    assert format_text(SourceFile("made.spec", laid_out)) == laid_out
    assert not math.isnan(float.fromhex(margins(laid_out, "reference")[0][1]))
