"""Ways to drive into others that no rule on gaps speaks of are driven by nobody, whichever evaluator looks at them."""

from __future__ import annotations

import numpy as np
import pytest

from support.cycles import SPEED, cycle, plan
from support.supervised import BACKENDS, against
from trackmarshal.runtime.cycle import Cycle


def among(x: float, v: float) -> Cycle:
    """A cycle with one other car in the same line, at x m, which drives along the track at v m/s."""
    given = cycle(0, objects=1)
    given.signals["objects"].update(x=np.array([x]), y=np.array([0.0]), v=np.array([v]))
    return given


@BACKENDS
@pytest.mark.parametrize("gap", [60.0, 6.0])
def test_nobody_drives_the_wrong_way_towards_others(gap: float, backend: str) -> None:
    """They count as behind."""
    given = among(100.0 - gap, 25.0)
    for candidate in (given.driving, given.emergency):
        candidate["x"], candidate["heading"] = 100.0 - candidate["x"], np.full(len(candidate["x"]), np.pi)
    given.signals["ego"].update(x=100.0, heading=np.pi)
    assert against(given, backend) == {("race_direction", "driving"), ("race_direction", "emergency")}


@BACKENDS
@pytest.mark.parametrize(("braking", "safe"), [(12.0, True), (8.0, True), (6.0, False), (1.0, False)])
def test_a_fallback_ends_before_it_reaches_who_stands_ahead(braking: float, safe: bool, backend: str) -> None:
    """RSS asks for 21.4 m at 20 m/s, if the car brakes with 13 m/s^2 then; the other one is 30 m ahead."""
    given = among(30.0 + 4.7 / 2 + 4.5 / 2, 0.0)
    given.emergency.clear()
    given.emergency.update(plan(0.0, braking, 60))
    assert given.emergency["s"][-1] == pytest.approx(SPEED**2 / 2 / braking)
    rules = ("safe_fallback", "fallback_collision", *(["fallback_brakes"] if braking < 2.5 else []))
    found = {(rule, "emergency") for rule in rules}
    assert against(given, backend) == (set() if safe else found)


def aside(given: Cycle, way: float, to: float) -> None:
    """Let the emergency trajectory brake within 40 m, and change to another line, y = to, within so many of them."""
    along = np.linspace(0.0, 45.0, 20_001)
    share = np.clip(along / way, 0.0, 1.0)
    across = to * (10 * share**3 - 15 * share**4 + 6 * share**5)
    heading = np.arctan(np.gradient(across, along))
    arc = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(along), np.diff(across)))])
    columns = plan(0.0, 5.0, 120)
    places = {"x": along, "y": across, "heading": heading, "kappa": np.gradient(heading, arc)}
    columns |= {name: np.interp(columns["s"], arc, values) for name, values in places.items()}
    given.emergency.clear()
    given.emergency.update(columns)


@BACKENDS
@pytest.mark.parametrize(
    ("x", "y", "found"),
    [
        (38.0, 3.5, {"fallback_collision"}),  # it would end in that car
        (38.0, -3.5, set()),  # on the other side
        (47.0, 3.5, set()),  # further on than it goes
        (25.0, 4.6, {"fallback_collision"}),  # and grazes this one on its way
    ],
)
def test_a_fallback_moves_aside_into_nobody(x: float, y: float, found: set[str], backend: str) -> None:
    """RSS asks who is too near sideways now: nobody is."""
    given = among(x, 0.0)
    given.signals["objects"]["y"][:] = y
    aside(given, 34.0, 3.5)
    assert against(given, backend) == {(rule, "emergency") for rule in found}
