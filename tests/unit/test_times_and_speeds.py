"""Trajectories whose times, positions and speeds say different things are driven by nobody, whichever evaluator looks at them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import cycle
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.runtime.cycle import Cycle


def as_planned(given: Cycle) -> None:
    """Nothing is wrong with it."""


def never_brakes(given: Cycle) -> None:
    speeds = given.emergency["v"]
    speeds[:-1], given.emergency["a"][:] = speeds[0], 0.0


def in_a_tenth_of_the_time(given: Cycle) -> None:
    given.driving["t"] = given.driving["t"] * 0.1


def in_ten_times_the_time(given: Cycle) -> None:
    given.emergency["t"] = given.emergency["t"] * 10.0


def brakes_on_the_spot(given: Cycle) -> None:
    for name in ("x", "y", "s"):
        given.emergency[name][-5:] = given.emergency[name][-5]
    given.emergency["v"][-5:] = np.linspace(4.0, 0.0, 5)


@pytest.mark.parametrize(
    "backend", ["reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))]
)  # fmt: skip
@pytest.mark.parametrize(
    ("change", "safe"),
    [(as_planned, True), (never_brakes, False), (in_a_tenth_of_the_time, False), (in_ten_times_the_time, False), (brakes_on_the_spot, False)],
)  # fmt: skip
def test_it_is_driven_only_as_planned(change: Callable[[Cycle], None], safe: bool, backend: str) -> None:
    given = cycle(0)
    change(given)
    decision = tm.supervisor(shipped(), backend=backend, clock=lambda: 0.0).step(given)
    assert (decision.safe, decision.faults) == (safe, ())
    assert safe or {"pace_integrity", "speed_integrity"} & {one.rule for one in decision.violations}
