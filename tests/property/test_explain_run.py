"""What `explain` finds of a formula over the run is what its margin comes from, whatever the formula and the run."""

from __future__ import annotations

import math
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.backends.over_run.history import History, Past
from trackmarshal.backends.over_run.keeping import past
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.explaining.telling import told_over_run
from trackmarshal.explaining.trail import Trail


@settings(deadline=None)
@given(st.one_of(formulas(), formulas(depth=2)), runs())
def test_the_comparison_that_is_found_has_the_margin(
    formula: str, cycles: list[dict[str, Any] | None]
) -> None:
    evaluator = Evaluator(loads(f'{SIGNALS}rule f "x"\n  whenever weak previous flag\n  require {formula}\n'))
    run, kept, missed = evaluator.over_run(), list[Past](), 0
    rule = evaluator.rules[0]
    assert rule.formula is not None
    for cycle in cycles:
        if cycle is None:
            run.missed()
            missed += bool(kept)
            continue
        frame = evaluator.read(cycle)
        result = run.step(frame).rules["f"]
        kept.append(past(evaluator.spec, frame, missed))
        missed = 0
        history = History(kept)
        place = len(kept) - 1
        here = history.value(rule.formula, place, {}).value
        assert told_over_run(rule, result, history)[0] == "f: x"
        trail = Trail(history)
        found = trail.find(rule.formula, place, {})
        # What is counted is told cycle by cycle, and the margin of `iff` and `xor` is a distance of two: one of both is followed.
        if not math.isfinite(here.margin) or any(word in formula for word in ("count", "iff", "xor")):
            continue
        assert found is not None, trail.said
        assert abs(found.witness.margin) == abs(here.margin)
