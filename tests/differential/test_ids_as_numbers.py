"""Ids that are numbers: an element is the same one from cycle to cycle, whichever type its number comes in."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler

C = pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
SPEC = tm.loads("""
module ids
signal objects : set of object { v: m/s }
rule never_fast "Whoever was fast once is not welcome"
  for all o in objects
  require not once o.v > 5 m/s
""")


def verdicts(backend: str, *ids: Any) -> list[str]:
    """Of cycles with one object each, which is fast in the first one."""
    evaluator = tm.Evaluator(SPEC, None, backend)
    run = evaluator.over_run()
    found = []
    for cycle, one in enumerate(ids):
        objects = [{"id": one, "v": 1.0 if cycle else 9.0}]
        case = evaluator.read({"id": cycle, "t": float(cycle), "signals": {"objects": objects}})
        found.append(run.step(case).rules["never_fast"].verdict)
    return found


@pytest.mark.parametrize("backend", ["reference", "numpy", C])
@pytest.mark.parametrize(
    ("first", "then"),
    [(1, 1.0), (1, "1"), (1.0, "1"), (np.float64(1), 1), (np.float32(1), np.int8(1)), (-0.0, 0), (2**53, 2.0**53), (2.5, "2.5"), (1e300, 1e300)],
)  # fmt: skip
def test_the_same_element(backend: str, first: Any, then: Any) -> None:
    assert verdicts(backend, first, then) == ["violated", "violated"]
    assert verdicts(backend, then, first) == ["violated", "violated"]


@pytest.mark.parametrize("backend", ["reference", "numpy", C])
@pytest.mark.parametrize(("first", "then"), [(1.0, "1.0"), (1, "01"), (1, 1.5), (2.0**63, 2**62)])
def test_another_element(backend: str, first: Any, then: Any) -> None:
    assert verdicts(backend, first, then) == ["violated", "satisfied"]


def test_one_of_them_twice_is_a_fault() -> None:
    evaluator = tm.Evaluator(SPEC)
    case = {"signals": {"objects": {"id": [1, 1.0], "v": [1.0, 1.0]}}}
    assert not evaluator.case(case).safe
    assert ["stands twice" in str(fault) for fault in evaluator.case(case).faults] == [True]
