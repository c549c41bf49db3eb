"""An evaluator that answers for fewer cases than it was asked about: no test passes by that, and no fault is confirmed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from trackmarshal.evaluation import Evaluator
from trackmarshal.scenarios.faults.judging import Judging
from trackmarshal.semantics.compile import compile_paths
from trackmarshal.testing import run
from trackmarshal.testing.cases import prepare
from trackmarshal.testing.run import run_tests

SPEC = """module few
signal ego : state { v: m/s }
rule slow "slow"
  require ego.v <= 10 m/s
test slow "slower"
  given ego = { v: 5 m/s }
  expect satisfied
test slow "faster"
  given ego = { v: 5 m/s }
  expect violated
"""


@pytest.mark.parametrize("left", [0, 1])
def test_no_test_passes_that_was_not_evaluated(
    left: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "few.spec"
    path.write_text(SPEC, "utf-8")
    compiled = compile_paths([path])
    tests, _ = prepare(compiled)
    assert [one.outcome for one in run_tests(compiled.spec, tests)] == ["passed", "failed"]
    whole = Evaluator.judge_all
    monkeypatch.setattr(Evaluator, "judge_all", lambda self, cases: whole(self, cases)[:left])
    with pytest.raises(ValueError, match="shorter"):
        list(run_tests(compiled.spec, tests))


def test_no_test_passes_by_an_explanation_of_something_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The case is said to be satisfied, and what is explained is the violation that the test expects."""
    path = tmp_path / "few.spec"
    path.write_text(
        SPEC.replace(
            "  given ego = { v: 5 m/s }\n  expect violated", "  given ego = { v: 11 m/s }\n  expect violated"
        ),
        "utf-8",
    )
    compiled = compile_paths([path])
    tests, _ = prepare(compiled)
    assert [one.outcome for one in run_tests(compiled.spec, tests)] == ["passed", "passed"]
    whole = run._said

    def first(evaluator: Evaluator, asked: Any, frames: Any) -> Any:
        said = whole(evaluator, asked, frames)
        return [one._replace(verdict="satisfied", margin=1.0) for one in said]

    monkeypatch.setattr(run, "_said", first)
    found = list(run_tests(compiled.spec, tests))
    assert [one.outcome for one in found] == ["passed", "error"]
    assert "explains violated with -1.0" in found[1].message


def test_nothing_is_confirmed_without_an_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    class Silent:
        spec, rules, identity = None, (), ""

        def judge_all(self, frames: Any) -> list[Any]:
            return []

    judging = Judging(Silent())  # type: ignore[arg-type]
    judging._once["key"] = None  # type: ignore[assignment]
    judging._known["key"] = {}
    with pytest.raises(ValueError, match="shorter"):
        judging.confirmed()
