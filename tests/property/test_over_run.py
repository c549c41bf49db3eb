"""Rules over the run: the engine that keeps every cycle and the one whose memory does not grow say the same of every cycle."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.evaluation import Evaluator, loads

Said = list[Any]


def said(text: str, backend: str, cycles: list[dict[str, Any] | None]) -> Said:
    """Everything that a rule says in every cycle, and after the last one."""
    evaluator = Evaluator(loads(text), backend=backend)
    run, found = evaluator.over_run(), []
    for cycle in cycles:
        if cycle is None:
            run.missed()
            continue
        result = run.step(evaluator.read(cycle)).rules["f"]
        found.append((result.verdict, exact(result.margin), [_about(one) for one in result.about]))
    found.append({name: [_about(one) for one in each] for name, each in run.end().items()})
    return found


def _about(one: Any) -> Any:
    return one.cycle, one.verdict, exact(one.margin), one.final


def exact(margin: float) -> str:
    return "nan" if math.isnan(margin) else float(margin).hex()


def rule(clauses: str) -> str:
    return f'{SIGNALS}rule f "x"\n  {clauses}\n'


@given(formulas(), runs())
@settings(max_examples=600, deadline=None)
def test_both_engines_say_the_same(formula: str, cycles: list[dict[str, Any] | None]) -> None:
    text = rule(f"require {formula}")
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@given(
    formulas(depth=2),
    formulas(True, depth=1),
    formulas(True, depth=2),
    formulas(True, depth=1),
    st.booleans(),
    runs(),
)
@settings(max_examples=400, deadline=None)
def test_and_with_all_clauses(
    whenever: str, guard: str, body: str, but: str, within: bool, cycles: list[dict[str, Any] | None]
) -> None:
    deadline = "within 0.3 s\n  " if within else ""
    text = rule(
        f'whenever {whenever}\n  {deadline}for all o in objects where {guard}\n  except {but} "why"\n  require {body}'
    )
    assert said(text, "reference", cycles) == said(text, "numpy", cycles)


@given(formulas(ahead=False), runs())
@settings(max_examples=50, deadline=None)
def test_what_looks_back_is_decided_at_once(formula: str, cycles: list[dict[str, Any] | None]) -> None:
    for one in said(rule(f"require {formula}"), "numpy", cycles)[:-1]:
        verdict, margin, about = one
        assert verdict != "open"
        assert [each[1:] for each in about] in ([], [(verdict, margin, True)])
