"""An emergency trajectory that can be taken up: it drives as the driving one for a while, then brakes. What a planner may hand over instead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from support.dense import curve
from support.dense.car import Car
from support.dense.path import STEP, path
from support.dense.recording import Columns, Cycle


def delayed(cycle: Cycle, car: Car, seconds: float) -> Cycle:
    """The cycle with such an emergency trajectory, on the driving one's path; one that goes nowhere is left as it is.

    seconds: counted from where the car is at the stamp; it brakes from the driving trajectory's next sample on, in each step as hard as the sharper bend
    at its ends leaves. Where the driving trajectory is too short to come to rest on, it ends without.
    """
    driving = cycle.candidates["driving"]
    if curve.chords(driving).max() <= curve.SAME:
        return cycle
    on = path(driving)
    begin, _ = on.nearest(cycle.ego["x"], cycle.ego["y"])
    steps = curve.pieces(driving, curve.points_for(driving, STEP)).lengths
    way = np.concatenate([[0.0], np.cumsum(steps)])
    turn = int(np.searchsorted(way, float(on.after(begin, seconds))))
    columns = {name: list(values[: turn + 1]) for name, values in driving.items()}
    bends = np.abs(driving["kappa"])
    for i in range(turn, len(steps)):
        square = columns["v"][-1] ** 2
        across = square * max(bends[i], bends[i + 1])
        slower = float(np.sqrt(max(0.0, car.grip**2 - across**2)))
        columns["a"][-1] = -slower
        rests = min(1.0, square / (2.0 * slower * steps[i])) if slower > 0.0 else 1.0
        if rests * steps[i] < 1e-3:
            break
        left = max(0.0, square - 2.0 * slower * rests * steps[i]) if rests == 1.0 else 0.0
        mean = (columns["v"][-1] + float(np.sqrt(left))) / 2.0
        columns["t"].append(columns["t"][-1] + rests * steps[i] / mean)
        columns["s"].append(columns["s"][-1] + rests * steps[i])
        columns["v"].append(float(np.sqrt(left)))
        columns["a"].append(0.0)
        for name in ("x", "y", "heading", "kappa"):
            columns[name].append(float(on.at(name, way[i] + rests * steps[i])))
        if left == 0.0:
            break
    emergency: Columns = {name: np.array(values) for name, values in columns.items()}
    return replace(cycle, candidates={**cycle.candidates, "emergency": emergency})
