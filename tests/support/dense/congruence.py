"""When a car is on a stored emergency trajectory: along its path and in speed, whatever the time. The reference of docs/takeup.md, "The state machine"."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.dense.path import Path
from support.dense.takeup import TakeUp, Terms


@dataclass(frozen=True)
class Seen:
    """Where a car is on a path: station and distance to the left of it [m], turn [rad], and the square of its speed above the path's [m^2/s^2]."""

    station: float
    beside: float
    turned: float
    excess: float


def seen(on: Path, x: float, y: float, heading: float, v: float) -> Seen:
    """On a path that was prolonged; beyond its end the trajectory's speed is 0."""
    station, beside = on.nearest(x, y)
    turn = heading - float(on.at("heading", station))
    planned = float(on.at("v", station)) if station <= on.end else 0.0
    return Seen(station, beside, float(np.remainder(turn + np.pi, 2.0 * np.pi) - np.pi), v * v - planned**2)


def apart(
    on: Path, car: Seen, approved: TakeUp, terms: Terms, measured: float = 0.05, rounding: float = 1.0
) -> str:
    """Why the trajectory is not what the car can drive: `beside`, `turned`, `faster`, `beyond`; "" where it is.

    approved: what the cycle that stored it was approved with. measured, rounding: what localisation may add, m and m^2/s^2.
    """
    if not abs(car.beside) <= terms.beside + measured:
        return "beside"
    if not abs(car.turned) <= terms.turned:
        return "turned"
    if not car.station <= on.end + approved.overrun + measured:
        return "beyond"
    # Beyond the end, what is left of the excess falls to nothing where the car may rest.
    over = max(0.0, car.station - on.end)
    left = 1.0 - min(1.0, over / approved.overrun) if over > 0.0 and approved.overrun > 0.0 else 1.0
    if not car.excess <= approved.excess * left + rounding:
        return "faster"
    return ""
