"""Output that is frozen, at half speed, of another place or of the past is found in the first cycle in which a tolerance is exceeded."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from support.cycles import cycle
from support.length import at_length
from support.stale_plans import BAD_FROM, CYCLES, KINDS, PERIOD, Runs, excess, generate
from support.supervised import Clock, shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator
from trackmarshal.supervision import supervisor

pytestmark = pytest.mark.verifies("S-1-A-3")

COUNT = int(os.environ.get("TRACKMARSHAL_STALE_PLANS", "500"))
RULES = {"stamp_match": "stamp", "place_match": "place", "heading_match": "heading", "speed_match": "speed"}
#: Where a tolerance is exceeded by less than this, rounding decides.
NEAR = 1e-6


def limits() -> dict[str, float]:
    names = ("t_loc", "ds_loc", "side_loc", "psi_loc", "v_loc", "a_loc")
    return {name: shipped().params[f"supervisor.trajectory.{name}"].value for name in names}


@pytest.fixture(scope="module")
def runs() -> Runs:
    return generate(COUNT, 20)


@pytest.fixture(scope="module")
def wanted(runs: Runs) -> dict[str, np.ndarray]:
    return excess(runs, limits())


@pytest.fixture(scope="module")
def verdicts(runs: Runs) -> dict[str, np.ndarray]:
    """By rule: (runs, cycles)."""
    evaluator = Evaluator(shipped(), [*RULES, "pose_match", "pose_on_path"])
    plan = {name: column.reshape(-1, column.shape[2]) for name, column in runs.plan.items()}
    batch = evaluator.batch({"plan": plan, "ego": {name: row.ravel() for name, row in runs.ego.items()}})
    assert not batch.faults
    return {name: np.array(found).reshape(-1, CYCLES) for name, found in batch.verdicts.items()}


def first(found: np.ndarray) -> np.ndarray:
    """The first cycle of each run in which something is found; CYCLES where nothing is."""
    return np.where(found.any(axis=1), found.argmax(axis=1), CYCLES)


def test_found_in_the_first_cycle(
    runs: Runs, wanted: dict[str, np.ndarray], verdicts: dict[str, np.ndarray]
) -> None:
    exceeded = np.logical_or.reduce([value > 0.0 for value in wanted.values()])
    unclear = np.logical_or.reduce([np.abs(value) < NEAR for value in wanted.values()]).any(axis=1)
    fired = np.logical_or.reduce([verdicts[rule] != "satisfied" for rule in RULES])
    assert unclear.sum() <= COUNT / 100
    assert (first(fired) == first(exceeded))[~unclear].all()
    # While the planner is right nothing fires, whatever the rule.
    assert all((found[:, :BAD_FROM] == "satisfied").all() for found in verdicts.values())
    seen = Counter(
        (KINDS[kind], "at once" if when == BAD_FROM else "later" if when < CYCLES else "never")
        for kind, when in zip(runs.kind, first(fired))
    )
    least = COUNT / len(KINDS) / 50
    assert all(seen[kind, "at once"] > least for kind in KINDS), seen
    assert seen["frozen", "later"] > least, seen


def test_each_rule_says_what_is_wrong(wanted: dict[str, np.ndarray], verdicts: dict[str, np.ndarray]) -> None:
    """Each tolerance by itself, in every cycle of every run."""
    for rule, name in RULES.items():
        clear = np.abs(wanted[name]) >= NEAR
        expected = np.where(wanted[name] > 0.0, "violated", "satisfied")
        assert (verdicts[rule] == expected)[clear].all(), rule
        assert clear.mean() > 0.99
    assert {name: bool((value > 0.0).any()) for name, value in wanted.items()} == {
        "stamp": False, "place": True, "heading": True, "speed": True,
    }  # fmt: skip


def test_what_went_unnoticed_before_is_near_the_path(runs: Runs, verdicts: dict[str, np.ndarray]) -> None:
    """Frozen output that `pose_match` alone approves: a sample lies near the car, at another time."""
    frozen = runs.kind == KINDS.index("frozen")
    fast = runs.ego["v"][:, BAD_FROM] > 40.0
    last = verdicts["pose_match"][frozen & fast, BAD_FROM + 1]
    assert (last == "satisfied").any()
    assert (verdicts["place_match"][frozen & fast, BAD_FROM + 1] == "violated").all()
    assert limits()["ds_loc"] < PERIOD * 40.0


@pytest.mark.parametrize("backend", [at_length("reference"), "numpy", "c"])
def test_the_supervisor_falls_back(backend: str) -> None:
    """A car that comes on by 1 m a cycle: of output that is frozen in cycle 3, 2 m are within the tolerance of 2.6 m, and 3 m are not."""
    if backend == "c" and compiler() is None:
        pytest.skip("no C compiler")
    clock = Clock()
    watched = supervisor(shipped(), backend=backend, clock=clock)
    for number in range(8):
        given = cycle(number, at=1.0 * number)
        if number > 3:
            frozen = cycle(3, at=3.0)
            given = replace(given, driving=frozen.driving, emergency=frozen.emergency)
        clock.now = number * PERIOD
        decision = watched.step(given)
        late = {(violation.rule, violation.candidate) for violation in decision.violations}
        both = {("place_match", "driving"), ("place_match", "emergency")}
        assert (decision.state, late) == (("drive", set()) if number < 6 else ("previous_emergency", both))
        if decision.state == "previous_emergency":
            assert decision.driven is not None
            assert decision.driven.number == 5
