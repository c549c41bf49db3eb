"""What `explain` finds of a formula over the run is what its margin comes from, whatever the formula and the run."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from support.run_formulas import SIGNALS, formulas, runs
from trackmarshal.backends.over_run.history import History, Past, Settled
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


@settings(deadline=None)
@given(st.one_of(formulas(), formulas(depth=2)), runs())
def test_what_is_settled_of_cycles_holds_whatever_comes_after_them(
    formula: str, cycles: list[dict[str, Any] | None]
) -> None:
    _held_against_each_by_itself(
        f'{SIGNALS}rule f "x"\n  whenever weak previous flag\n  require {formula}\n', cycles
    )


_MACHINES = """state lamp : { off, on } starts off
  becomes on from off when flag
    remember speed = ego.v
  becomes off from on when not flag or ego.v > ego.w
state side : { near, far } for each o in objects starts near
  becomes far from near when o.v > 0 m/s
    remember speed = o.v
  becomes near from far when o.v <= ego.v
"""
_IN_MACHINES = (
    "lamp is on",
    "once[0 s, 0.5 s] lamp is on",
    "ego.v >= lamp.speed",
    "time_in(lamp) <= 0.3 s",
    "for all o in objects: side(o) is near",
    "for all o in objects: o.v >= side(o).speed",
    "exists o in objects: previous side(o) is far",
    "eventually[0 s, 0.5 s] lamp is on",
)


@pytest.mark.parametrize("formula", _IN_MACHINES)
@settings(deadline=None)
@given(runs())
def test_so_is_what_machines_may_be_in(formula: str, cycles: list[dict[str, Any] | None]) -> None:
    """The last cycle, in which candidates differ, leads machines elsewhere than what was driven in it."""
    _held_against_each_by_itself(f'{SIGNALS}{_MACHINES}rule f "x"\n  require {formula}\n', cycles)


def _held_against_each_by_itself(text: str, cycles: list[dict[str, Any] | None]) -> None:
    """Histories of one run, up to each of its cycles, find out together what each finds out by itself; of the last cycle, one candidate has another
    value than what was driven in the end."""
    spec = loads(text)
    evaluator = Evaluator(spec)
    (rule,) = evaluator.rules
    assert rule.formula is not None
    settled, kept, missed = Settled(), list[Past](), 0
    for cycle in cycles:
        if cycle is None:
            missed += bool(kept)
            continue
        for other in (_turned(cycle), cycle):
            until = [*kept, past(spec, evaluator.read(other), missed)]
            together = History(until, common=len(kept), settled=settled)
            alone = History(until)
            for place in reversed(range(len(until))):
                assert repr(together.value(rule.formula, place, {})) == repr(
                    alone.value(rule.formula, place, {})
                )
        kept, missed = until, 0


def _turned(cycle: dict[str, Any]) -> dict[str, Any]:
    """The same cycle with every Boolean turned round, and every number changed."""
    return {**cycle, "signals": {name: _other(value) for name, value in cycle["signals"].items()}}


def _other(value: Any) -> Any:
    match value:
        case bool():
            return not value
        case dict():
            return {name: each if name == "id" else _other(each) for name, each in value.items()}
        case list():
            return [_other(each) for each in value]
        case int() | float():
            return -value
        case str() | None:
            return value
        case _:
            raise AssertionError(f"a cycle has no {type(value).__name__}")
