"""A Boolean of the first or the last sample of a trajectory is that sample's, in every evaluator."""

from __future__ import annotations

import pytest

from support.command import BACKENDS
from trackmarshal.evaluation import Evaluator, loads

SPEC = """module m
signal plan : trajectory { t: s increasing, v: m/s, hot: bool }
rule first "" require plan.first.hot
rule last "" require plan.last.hot
rule both "" require plan.first.hot and not plan.last.hot
"""
VERDICTS = {True: "satisfied", False: "violated", None: "undefined"}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("hot", [(True, False), (False, True), (True, True), (None, True), (True, None)])
def test_each_is_its_own(backend: str, hot: tuple[bool | None, bool | None]) -> None:
    plan = {"t": [0.0, 1.0, 2.0], "v": [1.0, 1.0, 1.0], "hot": [hot[0], True, hot[1]]}
    evaluator = Evaluator(loads(SPEC), backend=backend)
    rules = evaluator.case({"signals": {"plan": plan}}).rules
    assert (rules["first"].verdict, rules["last"].verdict) == (VERDICTS[hot[0]], VERDICTS[hot[1]])
    if None in hot:
        name = "first" if hot[0] is None else "last"
        assert rules[name].reason == f"plan.{name}.hot is missing, or no number"
