"""Times of trajectories count from the stamp of their cycle: what begins 50 ms before it is driven, and over, 50 ms earlier."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from support.cycles import BRAKING, SPEED, cycle
from support.length import at_length
from support.supervised import Clock, shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.supervision import supervisor

BEFORE = 0.05
STOPS = SPEED / BRAKING
BACKENDS = (at_length("reference"), "numpy", "c")


def shifted(columns: Any, by: float) -> dict[str, Any]:
    return {**columns, "t": columns["t"] + by}


def begun_before(number: int) -> Cycle:
    """A planner that counts from a stamp of its own, 50 ms older, when the car was 1 m further back."""
    given, then = cycle(number), cycle(number, at=SPEED * (0.1 * number - BEFORE))
    return replace(given, driving=shifted(then.driving, -BEFORE), emergency=shifted(then.emergency, -BEFORE))


def made(backend: str, clock: Clock, limits: Limits | None = None) -> Any:
    if backend == "c" and compiler() is None:
        pytest.skip("no C compiler")
    return supervisor(shipped(), backend=backend, clock=clock, limits=limits)


@pytest.mark.parametrize("backend", BACKENDS)
def test_it_is_driven_from_its_own_time_on(backend: str) -> None:
    clock = Clock()
    watched = made(backend, clock)
    for number in range(3):
        given = begun_before(number)
        clock.now = given.t + 0.06
        decision = watched.step(given)
        assert (decision.state, decision.violations) == ("drive", ())
        # The samples are 0.1 s apart: 0.06 s after the stamp, the second one is due, as it is not without the 50 ms.
        assert decision.samples["t"][0] == pytest.approx(0.05)
        assert decision.samples["x"][0] == pytest.approx(SPEED * (given.t + 0.05))


@pytest.mark.parametrize("backend", BACKENDS)
def test_it_is_over_when_its_own_time_is(backend: str) -> None:
    clock = Clock()
    free = Limits(blind=100.0)
    for at, state in (
        (STOPS - BEFORE - 0.01, "previous_emergency"),
        (STOPS - BEFORE + 0.01, "no_safe_trajectory"),
    ):
        clock.now = 0.0
        watched = made(backend, clock, free)
        assert watched.step(begun_before(0)).state == "drive"
        clock.now = at
        decision = watched.step(None)
        assert (decision.state, decision.lost) == (state, "" if state == "previous_emergency" else "expired")


@pytest.mark.parametrize("backend", BACKENDS)
def test_the_car_is_looked_for_where_it_is_then(backend: str) -> None:
    """The stored trajectory 0.3 s later, 0.35 s after its begin; half a metre is all that it may be away."""
    clock = Clock()
    s = SPEED * 0.35 - BRAKING * 0.35**2 / 2 - SPEED * BEFORE
    for off, lost in ((0.45, ""), (0.55, "apart"), (-0.45, ""), (-0.55, "apart")):
        clock.now = 0.0
        watched = made(backend, clock, Limits(apart=0.4, beside=0.1, longest_gap=math.inf))
        assert watched.step(begun_before(0)).state == "drive"
        clock.now = 0.3
        given = replace(cycle(1, at=s + off), t=0.3)
        broken = {**given.driving, "v": np.full(30, 140.0)}
        decision = watched.step(replace(given, driving=broken))
        assert (decision.safe, decision.lost) == (False, lost)


@pytest.mark.parametrize("backend", BACKENDS)
def test_times_of_another_clock_are_refused(backend: str) -> None:
    clock = Clock()
    for by in (0.02, 1000.0, -1000.0):
        watched = made(backend, clock)
        given = cycle(0)
        decision = watched.step(
            replace(given, driving=shifted(given.driving, by), emergency=shifted(given.emergency, by))
        )
        assert decision.state == "no_emergency_yet"
        assert {v.candidate for v in decision.violations if v.rule == "stamp_match"} == {
            "driving", "emergency",
        }  # fmt: skip
