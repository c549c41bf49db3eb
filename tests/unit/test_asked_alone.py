"""Of predicates whose least margin alone was worked out, single cases say the same by themselves as all of them together."""

from __future__ import annotations

from pathlib import Path

import pytest

from trackmarshal.backends.numpy import places
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.verdict import RuleResult
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.si import spec_in_si

ROOT = Path(__file__).parents[2]


def explained(asked: int, monkeypatch: pytest.MonkeyPatch) -> tuple[list[RuleResult], int]:
    """What decided in each of many cases, where so many may be asked alone, and how many were."""
    alone: list[int] = []
    about = places.Least.about

    def listening(least: places.Least, case: int) -> object:
        found = about(least, case)
        alone.append(case if found is not vars(least).get("value") else -1)
        return found

    monkeypatch.setattr(places, "ASKED", asked)
    monkeypatch.setattr(places.Least, "about", listening)
    compiled = compile_paths([ROOT / "specs" / "supervisor"], ROOT)
    tests = [test for test in prepare(compiled)[0] if test.rule.name == "static_collision"]
    case = max((test.case for test in tests), key=lambda case: len(case["signals"]["plan"]["x"]))
    plan = case["signals"]["plan"]
    given = [
        {**case, "signals": {**case["signals"], "plan": {**plan, "y": [y + 0.01 * k for y in plan["y"]]}}}
        for k in range(1 + places.MANY // len(plan["x"]))
    ]
    evaluator = Evaluator(spec_in_si(compiled.spec), ["static_collision"])
    frames = evaluator.read_all(given)
    judged = evaluator.judge_all(frames)
    results = [rated.explain(0, False) for each in judged for rated in each.rated.values()]
    monkeypatch.undo()
    return results, len({case for case in alone if case >= 0})


def test_a_case_says_the_same_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    together, none = explained(0, monkeypatch)
    few, some = explained(2, monkeypatch)
    each, every = explained(1000, monkeypatch)
    assert (none, some, every) == (0, 2, len(each))
    assert len({result.margin for result in each}) > 1
    assert list(map(repr, together)) == list(map(repr, few)) == list(map(repr, each))
