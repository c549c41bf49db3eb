"""Rules along a course, and counts of samples, in generated C: what they say in every cycle is what the other evaluators say, to the last bit."""

from __future__ import annotations

import ctypes
import math
import os
from typing import Any

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from property.test_course import PLACES, SIGNALS, Cycle, cycles, formulas, text
from support.length import AT_LENGTH
from trackmarshal.backends.c import program
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.library import Library
from trackmarshal.evaluation import Evaluator, loads

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

#: Rules of one program, so that not each needs a compiler.
RULES = 10
EXAMPLES = int(os.environ.get("TRACKMARSHAL_EXAMPLES", "3"))
OTHERS = ("reference", "numpy")
_SETTINGS = settings(
    derandomize=not AT_LENGTH, max_examples=EXAMPLES, deadline=None, suppress_health_check=list(HealthCheck), phases=[Phase.explicit, Phase.generate],
)  # fmt: skip


class Used(Library):
    """A context in memory that is full of something."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        ctypes.memset(self.context, 1, self.dll.tmg_size())
        self.status = self.dll.tmg_init(self.context)


def exact(margin: float) -> str:
    return "nan" if math.isnan(margin) else float(margin).hex()


def case(number: int, cycle: Cycle) -> dict[str, Any]:
    due, v, on = zip(*cycle.plan)
    plan = {"t": [one / 1000 for one in due], "v": v, "on": on, "k": [0.0] * len(v)}
    ego = {"v": math.nan if cycle.v is None else cycle.v, "on": cycle.on, "w": 0.0}
    signals = {"ego": ego, "plan": plan, "flag": cycle.flag}
    return {"id": number, "t": cycle.at / 1000, "signals": signals}


def said(evaluator: Evaluator, run: list[Cycle]) -> list[Any]:
    going, found = evaluator.over_run(), list[Any]()
    for number, cycle in enumerate(run):
        for _ in range(cycle.missed):
            going.missed()
        result = going.step(evaluator.read(case(number, cycle)))
        found.append({name: (one.verdict, exact(one.margin)) for name, one in result.rules.items()})
    return found


def spec_of(drawn: list[tuple[str, Any]]) -> str:
    rules = (
        f'rule f{n} "x"\n  along driven as c{place}\n  whenever c.v > -9 m/s\n  require {text(one)}\n'
        for n, (place, one) in enumerate(drawn)
    )
    return SIGNALS + "".join(rules)


@given(
    st.lists(st.tuples(st.sampled_from(sorted(PLACES)), formulas(3)), min_size=RULES, max_size=RULES),
    st.lists(cycles(), min_size=10, max_size=10),
)
@_SETTINGS
def test_along_a_course(drawn: list[tuple[str, Any]], runs: list[list[Cycle]]) -> None:
    spec = loads(spec_of(drawn))
    generated = Evaluator(spec, backend="c")
    for other in OTHERS:
        evaluator = Evaluator(spec, backend=other)
        for run in runs:
            assert said(evaluator, run) == said(generated, run), other


def test_a_context_of_whatever_begins_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """`tm_init` begins a run in memory that another one has used, or that was never zeroed: nothing of it is part of the course."""
    spec = loads(
        f'{SIGNALS}rule f "x"\n  along driven as c\n  whenever c.v > -9 m/s\n  require once[0 s, 0.4 s] c.v > 1 m/s\n'
    )
    plan = ((0, 0.0, True), (200, 2.0, True), (400, 0.0, True))
    run = [Cycle(at, 0, 0.0, True, True, plan) for at in (0, 100, 200)]
    fresh = said(Evaluator(spec, backend="c"), run)
    monkeypatch.setattr(program, "Library", Used)
    assert said(Evaluator(spec, backend="c"), run) == fresh == said(Evaluator(spec, backend="numpy"), run)


@pytest.mark.acceptance  # the other one draws as many specs
@given(
    st.lists(st.tuples(st.sampled_from(["", " at last"]), formulas(3)), min_size=RULES, max_size=RULES),
    st.lists(cycles(), min_size=10, max_size=10),
)
@_SETTINGS
def test_counts_along_a_trajectory(drawn: list[tuple[str, Any]], runs: list[list[Cycle]]) -> None:
    """The same formulas of a plan alone: samples are moments, and times are in s."""
    spec = loads(
        spec_of(drawn)
        .replace("along driven", "along plan")
        .replace("course driven = ego for 0.5 s then plan\n", "")
    )
    generated = Evaluator(spec, backend="c")
    for other in OTHERS:
        evaluator = Evaluator(spec, backend=other)
        for run in runs:
            frames = [evaluator.read(case(number, cycle)) for number, cycle in enumerate(run)]
            found = [
                [
                    {name: (one.verdict, exact(one.margin)) for name, one in result.rules.items()}
                    for result in each.evaluate(frames)
                ]
                for each in (evaluator, generated)
            ]
            assert found[0] == found[1], other
