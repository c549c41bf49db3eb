"""Moving over while braking: no fallback is safe that asks for more than tyres have, whatever its headings say, and none is refused that does not.

Made up, on a wide road. What tyres have to do is worked out of the way that was driven, which the rules do not see: they get samples of it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import trackmarshal as tm
from support.cycles import cycle
from support.length import amount
from support.supervised import BACKENDS, shipped
from trackmarshal.runtime.cycle import Cycle

pytestmark = pytest.mark.verifies("S-1-A-5")

Floats = NDArray[np.float64]
#: m/s^2, of the shipped vehicle.
GRIP = 13.0
#: 1/m, by the square of speed.
DRAG = 0.854 / 1160.0
TICK = 1e-3
TRACK = {side: np.array([[-50.0, y], [400.0, y], [900.0, y]]) for side, y in (("left", 40.0), ("right", -40.0))}  # fmt: skip


class Swerve(NamedTuple):
    """Straight on to begin with, and to and fro while braking: m/s; m/s^2 along and across; how far to either side it leads, rad."""

    v: float
    brakes: float
    turns: float
    most: float

    def driven(self) -> tuple[Floats, Floats, Floats]:
        """Where it leads, rad, and how fast it is, in equal times; and what tyres do then, m/s^2."""
        v = np.arange(self.v, 0.0, -self.brakes * TICK)
        leads, side, slopes = 0.0, 1.0, np.zeros(len(v))
        for k in range(1, len(v)):
            leads += side * self.turns / v[k] * TICK if v[k] > 15.0 else 0.0
            side = -side if leads * side >= self.most else side
            slopes[k] = leads
        return slopes, v, np.hypot(self.brakes, v * np.gradient(slopes, TICK))

    def columns(self, step: float, told: bool) -> dict[str, Floats]:
        """Samples so many metres apart; told: with the headings and curvatures of the way, and not of the straight line beside it."""
        slopes, v, _ = self.driven()
        s, x, y = (np.concatenate([[0.0], np.cumsum(each[:-1] * TICK)]) for each in (v, v * np.cos(slopes), v * np.sin(slopes)))  # fmt: skip
        own = np.linspace(0.0, s[-1], max(8, min(120, int(s[-1] / step))))
        heading = np.interp(own, s, slopes) if told else np.zeros(len(own))
        bends = np.gradient(slopes, s) if told else np.zeros(len(s))
        speed = np.sqrt(np.maximum(self.v**2 - 2 * self.brakes * own, 0.0))
        speed[-1] = 0.0
        return {
            "t": np.interp(own, s, np.arange(len(s)) * TICK), "s": own, "x": np.interp(own, s, x), "y": np.interp(own, s, y),
            "heading": heading, "kappa": np.interp(own, s, bends), "v": speed, "a": np.full(len(own), -self.brakes),
        }  # fmt: skip


def made(columns: dict[str, Floats]) -> Cycle:
    given = cycle(0, objects=0, obstacles=0, v=float(columns["v"][0]))
    for candidate in (given.driving, given.emergency):
        candidate.clear()
        candidate.update(columns)
    given.signals["track"] = TRACK
    return given


def objections(columns: dict[str, Floats], backend: str = "numpy") -> set[str]:
    decision = tm.supervisor(shipped(), backend=backend, clock=lambda: 0.0).step(made(columns))
    assert decision.faults == ()
    return {one.rule for one in decision.violations}


@BACKENDS
@pytest.mark.parametrize("v", [40.0, 60.0, 75.0])
def test_headings_of_the_line_beside_it_hide_no_swerve(v: float, backend: str) -> None:
    """12 m/s^2 along and 9 across, each of which tyres can do."""
    found = objections(Swerve(v, 12.0, 9.0, 0.09).columns(1.5, told=False), backend)
    assert found == {"swerve_integrity"}


def test_what_tyres_cannot_do_is_not_safe() -> None:
    rng, seen = np.random.default_rng(20), 0
    for _ in range(amount(20, 400)):
        v, along = rng.uniform(35.0, 65.0), rng.uniform(9.0, 12.9)
        # Drag takes part of what is asked along the road.
        left = max(along - DRAG * v**2, 0.0)
        across = rng.uniform(0.8, 1.0) * 12.9
        swerve = Swerve(v, along, across, 0.09)
        if np.hypot(left, across) > 1.08 * GRIP:
            assert np.median(swerve.driven()[2][:1000]) > GRIP
            assert objections(swerve.columns(rng.uniform(0.8, 2.5), told=False)), swerve
            seen += 1
    assert seen > 10


def test_what_tyres_can_do_is_safe() -> None:
    rng = np.random.default_rng(21)
    for _ in range(amount(20, 400)):
        across = rng.uniform(1.0, 12.0)
        swerve = Swerve(rng.uniform(20.0, 80.0), np.sqrt((0.97 * GRIP) ** 2 - across**2), across, 0.09)
        assert "swerve_integrity" not in objections(swerve.columns(rng.uniform(0.8, 2.5), told=True)), swerve


@BACKENDS
@pytest.mark.parametrize("samples", [3, 4, 7])
def test_no_corner_is_too_late_to_be_looked_at(samples: int, backend: str) -> None:
    """Braking at 12 m/s^2 from 60 m/s, and moving over in the last step alone, by what asks for 11.7 across."""
    step, v = 9.0, np.sqrt(60.0**2 - 2 * 12.0 * 9.0 * np.arange(samples))
    for aside, allowed in ((0.031 * v[1] ** 2 / v[-2] ** 2, False), (0.0, True)):
        x = np.append(step * np.arange(samples - 1), step * (samples - 2 + np.cos(aside)))
        y = np.append(np.zeros(samples - 1), step * np.sin(aside))
        flat = np.zeros(samples)
        given = made(Swerve(60.0, 12.0, 0.5, 0.09).columns(2.0, told=True))
        given.driving.clear()
        given.driving.update({
            "t": np.concatenate([[0.0], np.cumsum(2 * step / (v[1:] + v[:-1]))]), "s": step * np.arange(samples), "x": x, "y": y,
            "heading": flat, "kappa": flat, "v": v, "a": flat - 12.0, "grip": flat + 1.0,
        })  # fmt: skip
        decision = tm.supervisor(shipped(), backend=backend, clock=lambda: 0.0).step(given)
        found = {one.rule for one in decision.violations if one.candidate == "driving"}
        assert decision.faults == ()
        assert found == (set() if allowed else {"swerve_integrity"})
