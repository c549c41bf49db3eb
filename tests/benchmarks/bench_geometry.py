"""How long geometry takes against a border of 2 x 1500 points: median CPU seconds, by question."""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.geometry import Corridor, Polyline, boxes_clear

BODY = (4.7, 2.0)
POINTS = 1500
Floats = NDArray[np.float64]


def track(count: int = POINTS) -> tuple[Floats, Floats, Floats]:
    """Left border, right border and poses (3, count) of a track of some 4.7 km, 10 m wide."""
    angle = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    radius = 700.0 * (1.0 + 0.15 * np.sin(3.0 * angle) + 0.05 * np.sin(7.0 * angle))
    line = np.stack([radius * np.cos(angle), radius * np.sin(angle)])
    ahead = np.roll(line, -1, axis=1) - np.roll(line, 1, axis=1)
    normal = np.stack([-ahead[1], ahead[0]]) / np.sqrt((ahead * ahead).sum(axis=0))
    return (line + 5.0 * normal).T, (line - 5.0 * normal).T, np.stack([*line, np.arctan2(ahead[1], ahead[0])])


def sweeps(poses: Floats, first: int, count: int, aside: float) -> Floats:
    """Pairs of poses (6, count), 2.5 m apart, from a point of the track on, `aside` m left of its middle."""
    step = np.hypot(*np.diff(poses[:2], axis=1))
    station = np.concatenate([[0.0], np.cumsum(step)])
    at = station[first] + 2.5 * np.arange(count + 1)
    x, y, heading = (np.interp(at, station, row) for row in (*poses[:2], np.unwrap(poses[2])))
    x, y = x - aside * np.sin(heading), y + aside * np.cos(heading)
    return np.stack([x[:-1], y[:-1], heading[:-1], x[1:], y[1:], heading[1:]])


def measure(repeats: int = 7) -> dict[str, float]:
    """Median CPU seconds of each question, everything prepared and warm."""
    left, right, poses = track()
    corridor = Corridor(left, right, closed=True)
    line = Polyline(poses[:2].T, closed=True)
    few = sweeps(poses, 100, 60, 1.0)
    over = sweeps(poses, 100, 60, 4.5)
    generator = np.random.default_rng(0)
    starts, asides = generator.integers(0, 1300, 1000), generator.uniform(-1.5, 1.5, 1000)
    many = np.concatenate([sweeps(poses, k, 60, aside) for k, aside in zip(starts, asides)], axis=1)
    midway = np.concatenate([sweeps(poses, k, 60, 0.0) for k in starts], axis=1)
    x, y = few[0, :5] + 1.0, few[1, :5] - 1.0
    boxes = few[0, 20:23], few[1, 20:23], few[2, 20:23]
    # By name: calls that are timed together, parts into which the time of one call is divided, the call.
    cases: dict[str, tuple[int, int, Callable[[], object]]] = {
        "corridor of 2 x 1500 points": (1, 1, lambda: Corridor(left, right, closed=True)),
        "60 swept footprints inside": (50, 1, lambda: corridor.margin_inside(*few, *BODY)),
        "60 swept footprints over the border": (50, 1, lambda: corridor.margin_inside(*over, *BODY)),
        "60000 swept footprints inside, for 30 of them": (
            1,
            2000,
            lambda: corridor.margin_inside(*many, *BODY),
        ),
        "60000 of them, as near to either border, for 30": (
            1,
            2000,
            lambda: corridor.margin_inside(*midway, *BODY),
        ),
        "project 5 points": (50, 1, lambda: line.project(x, y)),
        "60 swept footprints clear of 3 boxes": (
            20,
            1,
            lambda: boxes_clear(*few[:, :, None], *BODY, *boxes, *BODY),
        ),
    }
    return {
        name: _median(question, calls, repeats) / parts for name, (calls, parts, question) in cases.items()
    }


def _median(question: Callable[[], object], calls: int, repeats: int) -> float:
    question()
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        for _ in range(calls):
            question()
        taken.append((time.process_time() - start) / calls)
    return statistics.median(taken)


def main() -> None:
    """Print the medians."""
    for name, seconds in measure().items():
        print(f"{seconds * 1e6:10.1f} us  {name}")


if __name__ == "__main__":
    main()
