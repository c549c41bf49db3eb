"""Cycles that are made up: bends driven up to their limit, and emergency trajectories that brake more or less late and hard."""

from __future__ import annotations

import numpy as np

from support.dense.car import Car
from support.dense.recording import Columns, Cycle, Floats

CAR = Car(4.7, 2.8, 1160.0, 7.0, 13.0, 0.854, np.array([[0.0, 6.0], [80.0, 6.0]]), 80.0)
STEP = 2.5


def bend(length: float, first: float, last: float) -> Columns:
    """A clothoid from the origin along +x, with samples every 2.5 m."""
    fine = np.linspace(0.0, length, 1 + 50 * int(length / STEP))
    kappa = first + (last - first) * fine / length
    heading = np.concatenate([[0.0], np.cumsum((kappa[1:] + kappa[:-1]) / 2.0 * np.diff(fine))])
    middle = (heading[1:] + heading[:-1]) / 2.0
    x = np.concatenate([[0.0], np.cumsum(np.cos(middle) * np.diff(fine))])
    y = np.concatenate([[0.0], np.cumsum(np.sin(middle) * np.diff(fine))])
    return {"s": fine[::50], "x": x[::50], "y": y[::50], "heading": heading[::50], "kappa": kappa[::50]}


def timed(path: Columns, square: Floats) -> Columns:
    """With the squares of speed at the samples; accelerations hold until the next one."""
    v = np.sqrt(square)
    a = np.append(np.diff(square) / (2.0 * np.diff(path["s"])), 0.0)
    lasts = 2.0 * np.diff(path["s"]) / np.maximum(v[1:] + v[:-1], 1e-3)
    return {**path, "v": v, "a": a, "t": np.concatenate([[0.0], np.cumsum(lasts)])}


def generated(chance: np.random.Generator) -> Cycle:
    """A bend that is driven up to its limit; an emergency trajectory that brakes more or less late, and more or less hard."""
    path = bend(250.0, *chance.uniform(-0.02, 0.02, 2))
    sharpest = float(np.abs(path["kappa"]).max())
    v = min(chance.uniform(10.0, 60.0), chance.uniform(0.6, 0.98) * np.sqrt(CAR.grip / sharpest))
    driving = timed(
        path, np.maximum(0.0, v * v + 2.0 * chance.uniform(-3.0, 3.0) * path["s"] * (path["s"] < 50.0))
    )
    turn = int(chance.integers(0, 8))
    square = [*np.square(driving["v"][: turn + 1])]
    share = chance.uniform(0.5, 1.0)
    for kappa in path["kappa"][turn + 1 :]:
        along = share * np.sqrt(max(0.0, CAR.grip**2 - (square[-1] * kappa) ** 2))
        square.append(max(0.0, square[-1] - 2.0 * STEP * along))
        if square[-1] == 0.0:
            break
    rest = len(square)
    emergency = timed({name: column[:rest] for name, column in path.items()}, np.array(square))
    at = chance.uniform(0.0, 2.5)
    ego = {name: float(np.interp(at, path["s"], driving[name])) for name in ("x", "y", "heading", "v")}
    return Cycle(0, 0.0, ego, [], {"driving": driving, "emergency": emergency}, "", "")
