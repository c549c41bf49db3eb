"""Whether a candidate is where the car is: in place, direction and speed."""

from __future__ import annotations

import numpy as np
import shapely

from support.dense import curve
from support.dense.recording import Columns, Cycle


def along_path(cycle: Cycle, candidate: Columns) -> tuple[float, float, float, float]:
    """Where the candidate's path is nearest to the car: distance from it, way along it [m], turn [rad], and how much faster the car is [m/s].

    Points of the curve, 2 cm apart; the square of speed is linear over the way from sample to sample.
    """
    part = curve.pieces(candidate, curve.points_for(candidate))
    away = np.hypot(part.x - cycle.ego["x"], part.y - cycle.ego["y"])
    i, j = np.unravel_index(int(away.argmin()), away.shape)
    square = np.square(candidate["v"])
    speed = np.sqrt(square[i] + part.share[j] * (square[i + 1] - square[i]))
    way = part.lengths[:i].sum() + part.share[j] * part.lengths[i]
    turn = float(curve.turned(np.asarray(cycle.ego["heading"] - part.heading[i, j])))
    return float(away[i, j]), float(way), turn, float(cycle.ego["v"] - speed)


def in_time(cycle: Cycle, candidate: Columns, after: float = 0.0) -> tuple[float, float, float]:
    """The same at a time after the first sample, counted as the columns do: distance [m], turn [rad], how much faster the car is [m/s]."""
    t = candidate["t"] - candidate["t"][0]
    x, y, v = (float(np.interp(after, t, candidate[name])) for name in ("x", "y", "v"))
    heading = float(np.interp(after, t, np.unwrap(candidate["heading"])))
    away = float(np.hypot(x - cycle.ego["x"], y - cycle.ego["y"]))
    turn = float(curve.turned(np.asarray(cycle.ego["heading"] - heading)))
    return away, turn, float(cycle.ego["v"] - v)


def astray(cycle: Cycle, candidate: Columns, near: float = 2.0, turned: float = 0.35) -> set[str]:
    """What the car is not: `elsewhere` (further than `near` from every sample, from the path, or from the first sample), `turned`."""
    line = shapely.LineString(np.stack([candidate["x"], candidate["y"]], axis=-1))
    away, _, turn, _ = along_path(cycle, candidate)
    samples = shapely.MultiPoint(line.coords).distance(shapely.Point(cycle.ego["x"], cycle.ego["y"]))
    first, _, _ = in_time(cycle, candidate)
    found = set()
    if max(away, samples, first) > near:
        found.add("elsewhere")
    if abs(turn) > turned:
        found.add("turned")
    return found
