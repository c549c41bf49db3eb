"""Distances of Responsibility-Sensitive Safety, from the papers' equations.

S. Shalev-Shwartz, S. Shammah, A. Shashua, arXiv 1708.06374, definitions 1 (same direction), 2 (opposite) and 6 (sideways); eq. (1) of T. Stahl et
al., ITSC 2020. Speeds m/s, decelerations positive, m/s^2. The numbers are those of specs/supervisor/collision.spec. What is driven during
the response is integrated in small steps here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Response:
    """What everybody may do: respond for so long, accelerating; then brake. Sideways likewise, and sway by so much."""

    time: float = 0.2
    accelerate: float = 6.0
    brake: float = 13.0
    cap: float = 150.0
    accelerate_aside: float = 0.5
    brake_aside: float = 8.0
    sway: float = 0.1


def stopping(v: float, r: Response) -> float:
    """Way to standstill: response, then braking, m."""
    times = np.linspace(0.0, r.time, 2001)
    speeds = np.maximum(np.minimum(v + r.accelerate * times, r.cap), min(v, r.cap) if v <= r.cap else v)
    way = float(np.sum((speeds[1:] + speeds[:-1]) * np.diff(times))) / 2.0
    return way + float(speeds[-1]) ** 2 / (2.0 * r.brake)


def same_direction(rear: float, front: float, r: Response) -> float:
    """Definition 1."""
    return max(0.0, stopping(rear, r) - front * front / (2.0 * r.brake))


def opposite(one: float, other: float, r: Response) -> float:
    """Definition 2; speeds as magnitudes."""
    return stopping(one, r) + stopping(other, r)


def aside(approach: float, other: float, r: Response) -> float:
    """Definition 6; speeds towards each other. Whoever still moves away after the response gets nothing for it."""

    def way(v: float) -> float:
        later = v + r.accelerate_aside * r.time
        return (v + later) / 2.0 * r.time + max(0.0, later) ** 2 / (2.0 * r.brake_aside)

    return max(0.0, r.sway + way(approach) + way(other))


def as_printed(gap: float, rear: float, front: float, r: Response) -> float:
    """The left side of eq. (1) of Stahl et al., minus its right side: to be positive, m."""
    later = rear + r.time * r.accelerate
    ego = rear * r.time + r.accelerate * r.time**2 / 2.0 + later * later / (2.0 * r.brake)
    return gap + front * front / (2.0 * r.brake) - ego
