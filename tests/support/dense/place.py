"""Whether a candidate is, at the cycle's stamp, where the car is, points where it points, and moves as fast as it moves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import shapely

from support.dense import curve
from support.dense.recording import Columns, Cycle


@dataclass(frozen=True)
class Near:
    """How far a candidate may be from the car, as specs/supervisor/trajectory.spec declares it: along and across the car, m; rad; m/s; m/s^2; s."""

    along: float = 2.6
    across: float = 1.0
    turned: float = 0.35
    faster: float = 1.0
    gains: float = 13.0
    late: float = 0.01
    #: Of the rules that look for a sample, or for the path, whatever the time: m.
    any_time: float = 2.0


def astray(cycle: Cycle, candidate: Columns, near: Near) -> dict[str, bool]:
    """What does not fit. Times of a candidate count from the stamp."""
    seen = -float(cycle.ego.get("age", 0.0))
    t = candidate["t"]
    facts = {
        "other time": bool(t[0] > near.late or t[-1] < 0.0),
        "off its path": _away(cycle.ego, candidate) > near.any_time,
    }
    seen = max(seen, float(t[0]))
    if not t[0] <= seen <= t[-1]:
        return {**facts, "elsewhere": True, "turned": True, "other speed": True}
    x, y, v = (float(np.interp(seen, t, candidate[name])) for name in ("x", "y", "v"))
    heading = float(np.interp(seen, t, np.unwrap(candidate["heading"])))
    own, speed = cycle.ego["heading"], cycle.ego["v"]
    dx, dy = x - cycle.ego["x"], y - cycle.ego["y"]
    # A candidate that begins later than the pose was seen: the car went straight on until then.
    ahead = np.cos(own) * dx + np.sin(own) * dy - speed * (seen + float(cycle.ego.get("age", 0.0)))
    aside = np.cos(own) * dy - np.sin(own) * dx
    # What the car can gain or lose between the two places.
    gain = 2.0 * near.gains * abs(ahead)
    most = np.sqrt(speed * speed + gain) + near.faster
    least = np.sqrt(max(0.0, speed * speed - gain)) - near.faster
    turn = float(curve.turned(np.asarray(heading - own)))
    return {
        **facts,
        "elsewhere": bool(abs(ahead) > near.along or abs(aside) > near.across),
        "turned": abs(turn) > near.turned,
        "other speed": bool(not least <= v <= most),
    }


def _away(ego: Mapping[str, float], candidate: Columns) -> float:
    """From the nearest sample, m; no path is nearer than its samples by more than half a step."""
    points = shapely.MultiPoint(np.stack([candidate["x"], candidate["y"]], axis=-1))
    return float(points.distance(shapely.Point(ego["x"], ego["y"])))


def apart(driving: Columns, emergency: Columns) -> bool:
    """Whether the candidates start in different places, directions or speeds: 0.1 m, 0.05 rad, 0.5 m/s (docs/supervisor.md, the contract)."""
    dx, dy, turn, faster = (driving[name][0] - emergency[name][0] for name in ("x", "y", "heading", "v"))
    away = float(np.hypot(dx, dy))
    return bool(away > 0.1 or abs(curve.turned(np.asarray(turn))) > 0.05 or abs(faster) > 0.5)
