"""Cars that take up an emergency trajectory, driven in time: many at once, each from a state of its own, in small steps.

Nothing here knows a rule. At each station a car accelerates as the trajectory does there; beyond its end it brakes with what the bend leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from support.dense.car import Car
from support.dense.path import STEP, Path
from support.dense.recording import Floats


@dataclass(frozen=True)
class Driven:
    """One entry a car. rest: its station in the end, m. grip: the most that its tyres gave before the trajectory's end, to what they have.

    excess: the most that the square of its speed was above the trajectory's at the same station, m^2/s^2.
    """

    rest: Floats
    grip: Floats
    excess: Floats


def drive(paths: Sequence[Path], begin: Floats, v: Floats, car: Car, step: float = 0.001) -> Driven:
    """paths: of emergency trajectories, prolonged; begin, v: station and speed of each car."""
    longest = max(on.s[-1] for on in paths)
    grid = np.arange(0.0, longest + STEP, STEP)
    end = np.array([on.end for on in paths])
    kappa = np.stack([on.at("kappa", grid) for on in paths])
    # The square of speed falls from grid point to grid point by what the trajectory accelerates there.
    square = np.stack([np.square(on.at("v", grid)) for on in paths])
    gain = np.diff(square, axis=1) / (2.0 * STEP)
    gain = np.concatenate([gain, np.zeros((len(paths), 1))], axis=1)
    rows = np.arange(len(paths))
    s, v = begin.copy(), v.copy()
    grip, excess = np.zeros(len(paths)), np.full(len(paths), -np.inf)
    for _ in range(round(40.0 / step)):
        at = np.clip((s / STEP).astype(int), 0, len(grid) - 1)
        bend = kappa[rows, at]
        left = np.sqrt(np.maximum(0.0, car.grip**2 - np.square(v * v * bend)))
        a = np.where(s < end, gain[rows, at], -left)
        goes = v > 0.0
        excess = np.maximum(excess, v * v - square[rows, at] - gain[rows, at] * 2.0 * (s - at * STEP))
        share = car.tyres(v, a, bend) / car.grip
        grip = np.where(goes & (s < end - STEP), np.maximum(grip, share), grip)
        faster = np.maximum(0.0, v + np.where(goes, a, 0.0) * step)
        s, v = s + (v + faster) / 2.0 * step, faster
        if not goes.any():
            break
    return Driven(s, grip, excess)
