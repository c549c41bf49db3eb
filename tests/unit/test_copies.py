"""Copies of what the Supervisor takes and says: what nobody can change is its own copy; what its evaluator explains is not pickled."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import PERIOD, SPEED, cycle
from support.supervised import shipped
from trackmarshal.runtime.decision import Decision

BORDER = [[0.0, 1.0], [10.0, 1.0], [20.0, 2.0]]


def decisions(backend: str) -> list[Decision]:
    """One that drives, one in which the driving trajectory is too fast, and one of a cycle that did not come; rules read the borders."""
    now = 0.0
    supervisor = tm.supervisor(
        shipped(),
        ["speed_limit", "static_collision"],
        clock=lambda: now,
        params={"v_max": 30.0},
        limits={"budget": 60.0},
        backend=backend,
    )
    fast = cycle(1)
    fast.driving["v"][9] = 3 * SPEED
    found = []
    for number, given in enumerate((cycle(0), fast, None)):
        now = number * PERIOD
        found.append(supervisor.step(given))
    assert [one.safe for one in found] == [True, False, False]
    assert [v.rule for v in found[1].violations] == ["speed_limit"]
    return found


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_a_copy_of_a_decision_says_the_same(backend: str) -> None:
    for decision in decisions(backend):
        for copied in (
            copy.copy(decision),
            copy.deepcopy(decision),
            copy.deepcopy({"said": [decision]})["said"][0],
        ):
            assert copied == decision
            assert copied.reasons == decision.reasons
            assert copied.feedback == decision.feedback
            assert (copied.samples is None) == (decision.samples is None)
        for part in (decision.driven, decision.judged, decision.violations, decision.faults):
            copy.deepcopy(part)
        for violation in copy.deepcopy(decision.violations):
            assert violation.witness is not None


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
def test_a_decision_is_not_pickled_and_says_what_to_keep(backend: str) -> None:
    _, unsafe, none = decisions(backend)
    for what in (unsafe, none, unsafe.violations[0]):
        with pytest.raises(TypeError, match=r"decision\.feedback"):
            pickle.dumps(what)
    assert pickle.loads(pickle.dumps(unsafe.feedback)) == unsafe.feedback


def test_a_copy_of_a_line_is_itself() -> None:
    line = tm.line(BORDER)
    assert copy.copy(line) is line
    assert copy.deepcopy({"left": line})["left"] is line


def test_a_pickled_line_has_a_number_of_its_own_and_does_not_change_either() -> None:
    line = tm.line(BORDER)
    assert line.tuples[2] == (20.0, 2.0)
    again = pickle.loads(pickle.dumps(line))
    assert np.array_equal(again.points, line.points)
    assert again.tuples == line.tuples
    assert again.number != line.number
    assert not again.points.flags.writeable
    with pytest.raises(AttributeError):
        again.points = line.points


@pytest.mark.parametrize("backend", ["reference", "numpy", "c"])
@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_supervisor_is_not_copied(copied: Any, backend: str) -> None:
    """A copy took what rules remember away from the run that it was made in, or found nothing of what it looked for."""
    now = 0.0
    spec = tm.loads("""
module copied
signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, v: m/s }
signal ego : state { x: m, y: m, heading: rad, v: m/s }

rule steady "Not faster than 1 m/s more than in the last second"
  require historically[0 s, 1 s] ego.v <= 21 m/s
""")
    supervisor = tm.supervisor(spec, backend=backend, limits={"budget": 60.0}, clock=lambda: now)
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": SPEED}
    plan = {
        name: column for name, column in cycle(0).emergency.items() if name in ("t", "x", "y", "heading", "v")
    }
    for number in range(3):
        now = number * PERIOD
        assert supervisor.step(tm.Cycle(number, now, plan, plan, {"ego": ego})).safe
        with pytest.raises(TypeError, match="goes on from where it is"):
            copied(supervisor)
