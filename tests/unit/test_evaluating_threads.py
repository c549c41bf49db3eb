"""One evaluator for several threads: each gets the verdicts of what it handed in."""

from __future__ import annotations

import copy
import sys
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler

SPEC = """module threads
signal plan : trajectory { t: s increasing, v: m/s, a: m/s^2 }
rule slow "Slow"
  for all   p in plan
  require   p.v <= 50 m/s
"""
BACKENDS = ["numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))]


@pytest.fixture
def hasty() -> Iterator[None]:
    """Threads take turns as often as they can."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    yield
    sys.setswitchinterval(before)


def case(v: float, samples: int) -> dict[str, Any]:
    columns = {"t": np.arange(samples) * 0.1, "v": np.full(samples, v), "a": np.zeros(samples)}
    return {"signals": {"plan": columns}}


@pytest.mark.parametrize("backend", BACKENDS)
def test_cases_of_several_threads(backend: str, hasty: None) -> None:
    evaluator = tm.Evaluator(tm.loads(SPEC), None, backend)
    wrong: list[object] = []

    def evaluate(v: float) -> None:
        given = case(v, 200)
        try:
            for _ in range(400):
                margin = evaluator.case(given).rules["slow"].margin
                if margin != 50.0 - v:
                    wrong.append((v, margin))
        except Exception as error:
            wrong.append(error)

    threads = [threading.Thread(target=evaluate, args=(v,)) for v in (10.0, 90.0, 49.0, 51.0)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert wrong == []


def test_a_copy_is_evaluated_by_itself() -> None:
    evaluator = tm.Evaluator(tm.loads(SPEC))
    other = copy.deepcopy(evaluator)
    with evaluator.alone:
        results: list[bool] = []
        thread = threading.Thread(target=lambda: results.append(other.case(case(10.0, 3)).safe))
        thread.start()
        thread.join(30)
    assert results == [True]
