"""Cycles of a run of which nothing is asked: what is said of the others is what it is where all are asked."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from differential.test_c_over_run import exact, spec_of, told
from support.run_formulas import formulas, runs
from trackmarshal.backends.over_run.program import Remembering
from trackmarshal.evaluation import Evaluator, loads


@pytest.mark.parametrize("backend", ["reference", "numpy"])
@given(st.lists(formulas(), min_size=4, max_size=4), runs(), st.randoms(use_true_random=False))
@settings(max_examples=25, deadline=None, suppress_health_check=list(HealthCheck))
def test_it_is_as_if_all_had_been_asked(
    backend: str, drawn: list[str], cycles: list[dict[str, Any] | None], dice: Any
) -> None:
    evaluator = Evaluator(loads(spec_of(drawn)), backend=backend)
    all_asked, some_asked = evaluator.over_run(), evaluator.over_run()
    frames = [None if cycle is None else evaluator.read(cycle) for cycle in cycles]
    program = evaluator.program
    first = next(filter(None, frames), None)
    for cycle, frame in zip(cycles, frames):
        if cycle is None or frame is None:
            all_asked.missed()
            some_asked.missed()
            continue
        wanted = all_asked.step(evaluator.read(cycle)).rules
        if frame is first and isinstance(program, Remembering):
            # What most of the cycles say by themselves is there from here on.
            program.ahead([one for one in frames if one is not None and dice.random() < 0.7])
        if dice.random() < 0.7:
            some_asked.remember(frame)
            continue
        found = some_asked.step(frame).rules
        for name, one in wanted.items():
            said = found[name]
            assert (said.verdict, exact(said.margin)) == (one.verdict, exact(one.margin)), (name, drawn)
            assert told(said.about) == told(one.about), (name, drawn)
    wanted_end, found_end = all_asked.end(), some_asked.end()
    assert {n: told(a) for n, a in found_end.items()} == {n: told(a) for n, a in wanted_end.items()}
