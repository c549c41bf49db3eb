"""All rules of specs/supervisor with the numpy evaluator: one cycle by itself, and a batch of 1000 cycles.

A cycle is a driving and an emergency trajectory of 30 points each, 3 objects, borders of 1500 points each, which are arrays, as
whoever drives has them, or lists, as they come out of a file. Median CPU seconds: of a cycle read, evaluated and its verdicts
taken; of the same with witnesses; of a batch, by trajectory. Spec, program and track are prepared before, as they are for a run.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from measuring import THEN, WHEN_LIMITED

from trackmarshal.evaluation import Evaluator, load

SPECS = Path(__file__).resolve().parents[2] / "specs" / "supervisor"
#: m; a round course, on which the car is somewhere else in every cycle.
RADIUS, WIDTH = 300.0, 12.0
POINTS, BORDER, CYCLES = 30, 1500, 1000
ROUNDS = 5

ONE = "numpy: one cycle, verdicts"
BATCH = "numpy: batch of 1000 cycles, a trajectory"
LIMITS = {ONE: 1.5e-3, f"{ONE}, {THEN}": 1.5e-3, BATCH: 100e-6, f"{BATCH}, {THEN}": 100e-6}


def border(radius: float) -> list[list[float]]:
    """A ring of points, counter-clockwise."""
    angles = [2 * math.pi * k / BORDER for k in range(BORDER)]
    return [[radius * math.cos(a), radius * math.sin(a)] for a in angles]


def track() -> dict[str, Any]:
    return {"left": border(RADIUS - WIDTH / 2), "right": border(RADIUS + WIDTH / 2), "closed": True}


def trajectory(angle: float, speed: float, acceleration: float) -> dict[str, list[float]]:
    """Along the middle of the course from an angle on, at a constant acceleration until standstill."""
    columns: dict[str, list[float]] = {
        name: [] for name in ("t", "s", "x", "y", "heading", "kappa", "v", "a")
    }
    step = 0.1
    t = s = 0.0
    for _ in range(POINTS):
        at = angle + s / RADIUS
        heading = math.remainder(at + math.pi / 2, 2 * math.pi)
        row = (t, s, RADIUS * math.cos(at), RADIUS * math.sin(at), heading, 1 / RADIUS, speed, acceleration)
        for column, value in zip(columns.values(), row):
            column.append(value)
        s += max(0.0, speed * step + acceleration * step * step / 2)
        speed = max(0.0, speed + acceleration * step)
        t += step
    return columns


def cycle(number: int, course: dict[str, Any]) -> list[dict[str, Any]]:
    """The driving and the emergency case of one cycle."""
    angle = 2 * math.pi * number / CYCLES
    ahead = [trajectory(angle + gap / RADIUS, 20.0, 0.0) for gap in (40.0, 80.0, -30.0)]
    objects = [
        {"id": f"o{k}", **{name: column[0] for name, column in plan.items() if name in ("x", "y", "heading", "v")}, "length": 4.7, "width": 2.0}
        for k, plan in enumerate(ahead)
    ]  # fmt: skip
    driving, emergency = trajectory(angle, 20.0, 0.5), trajectory(angle, 20.0, -8.0)
    ego = {name: driving[name][0] for name in ("x", "y", "heading", "v")}
    shared = {"ego": ego, "objects": objects, "obstacles": [], "track": course}
    return [
        {"id": f"{number} driving", "signals": {"plan": driving, "emergency": False, **shared}},
        {"id": f"{number} emergency", "signals": {"plan": emergency, "emergency": True, **shared}},
    ]


def measure(repeats: int = 15) -> dict[str, float]:
    """Median CPU seconds, and the shares of a cycle that reading and running take."""
    spec = load([SPECS])
    evaluator, then = Evaluator(spec), Evaluator(spec, WHEN_LIMITED)
    course = track()
    listed = [cycle(number, course) for number in range(repeats * 10 + 10)]
    arrays = course | {side: np.array(course[side]) for side in ("left", "right")}
    cycles = [cycle(number, arrays) for number in range(CYCLES)]
    batch = [raw for one in cycles for raw in one]

    def verdicts(raw: list[dict[str, Any]], by: Evaluator = evaluator) -> None:
        for judged in by.program.judge_all(by.read_all(raw)):
            for rated in judged.rated.values():
                assert len(rated.verdicts) == len(by.rules)

    def witnesses(raw: list[dict[str, Any]]) -> None:
        list(evaluator.evaluate(evaluator.read_all(raw)))

    def read(raw: list[dict[str, Any]]) -> None:
        evaluator.read_all(raw)

    ready = [evaluator.read_all(raw) for raw in cycles[: repeats * 10 + 10]]
    one = repeats * 10 // ROUNDS
    return medians(
        {
            ONE: (lambda k: verdicts(cycles[k]), one, 1),
            f"{ONE}, {THEN}": (lambda k: verdicts(cycles[k], then), one, 1),
            "numpy: one cycle, borders as lists, verdicts": (lambda k: verdicts(listed[k]), one, 1),
            "numpy: one cycle, reading alone": (lambda k: read(cycles[k]), one, 1),
            "numpy: one cycle, program alone": (lambda k: evaluator.program.judge_all(ready[k]), one, 1),
            "numpy: one cycle, with witnesses": (lambda k: witnesses(cycles[k]), one, 1),
            BATCH: (lambda k: verdicts(batch), 1, len(batch)),
            f"{BATCH}, {THEN}": (lambda k: verdicts(batch, then), 1, len(batch)),
            "numpy: batch of 1000 cycles with witnesses, a trajectory": (
                lambda k: witnesses(batch),
                1,
                len(batch),
            ),
        }
    )


def medians(works: dict[str, tuple[Callable[[int], object], int, int]]) -> dict[str, float]:
    """Median CPU seconds of works, each by the share that is asked about, with so many repetitions a round.

    They take turns, so that what slows the machine for a while does not fall on one of them alone; the first round warms up.
    """
    spent: dict[str, list[float]] = {name: [] for name in works}
    for turn in range(ROUNDS + 1):
        for name, (work, repeats, _) in works.items():
            for k in range(max(0, turn - 1) * repeats, max(1, turn) * repeats):
                begin = time.process_time()
                work(k)
                if turn:
                    spent[name].append(time.process_time() - begin)
    return {name: statistics.median(spent[name]) / share for name, (_, _, share) in works.items()}


if __name__ == "__main__":
    for name, seconds in measure().items():
        print(f"{seconds * 1e3:9.3f} ms  {name}")
