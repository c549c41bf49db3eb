"""The ground truth about falling back: does a car that followed the driving trajectory still come to rest on the emergency one?

By what the tyres give, not by what any rule asks for. Unsafe is what cannot be saved by braking as hard as they allow; safe is what
can be with a good deal less.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from trackmarshal.scenarios.generate.knots import linear
from trackmarshal.scenarios.generate.limits import Vehicle
from trackmarshal.scenarios.recording import Columns

#: Who brakes with this share of grip and brakes at most, and comes to rest on the path, is safe beyond doubt.
EASY = 0.85
#: Step in which the braking is integrated, s.
STEP = 0.01


class Takeup(NamedTuple):
    """How long the car follows the driving trajectory, s, and how far it may come to rest beyond the emergency one, m."""

    window: float
    beyond: float


def takeup_truth(driving: Columns, emergency: Columns, vehicle: Vehicle, given: Takeup) -> bool | None:
    """True (safe), False (unsafe) or None (free) of a cycle's trajectories, which have one path, with many samples of each."""
    if _saved(driving, emergency, vehicle, given.window, EASY, 0.0):
        return True
    return None if _saved(driving, emergency, vehicle, given.window, 1.0, given.beyond) else False


def _saved(
    driving: Columns, emergency: Columns, vehicle: Vehicle, window: float, share: float, beyond: float
) -> bool:
    """Does the car come to rest at most `beyond` m after the end of the path, with this share of grip and brakes, and does it
    keep to the bend meanwhile?"""
    way = linear([list(row) for row in zip(driving["t"], driving["s"])], window)
    v = linear([list(row) for row in zip(driving["t"], driving["v"])], window)
    bend = [list(row) for row in zip(emergency["s"], emergency["kappa"])]
    while v > 0.0:
        left = (share * vehicle.grip) ** 2 - (v * v * linear(bend, way)) ** 2
        if left <= 0.0:
            return False
        a = min(share * vehicle.brake, math.sqrt(left) + vehicle.drag * v * v)
        h = min(STEP, v / a)
        way += h * (v - a * h / 2.0)
        v = v - a * h if h == STEP else 0.0
    return way <= emergency["s"][-1] + beyond
