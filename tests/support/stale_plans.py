"""Generated runs of a car and a planner that goes wrong in one of four ways; and, worked out apart from any rule, when that shows.

A run is a car that drives along a bend of changing radius at a changing speed, and in each cycle what its planner says: samples of what
is driven next. From one cycle on the planner's output is frozen, at half speed, of another place, or of the past. Complex numbers stand
for points of the plane; arrays are by run, cycle and sample.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
PERIOD, CYCLES, BAD_FROM, SAMPLES = 0.1, 14, 4, 16
KINDS = ("frozen", "half speed", "elsewhere", "of the past")
#: Steps of the motion, s, and when it begins: the planner's past is there, too.
STEP, BEGIN, END = 0.01, -2.0, CYCLES * PERIOD + 5.0


@dataclass(frozen=True)
class Runs:
    """kind: (runs,), index into KINDS. plan: columns (runs, cycles, samples); ego: fields (runs, cycles)."""

    kind: NDArray[np.int64]
    plan: dict[str, Floats]
    ego: dict[str, Floats]


def generate(count: int, seed: int) -> Runs:
    """So many runs, of all kinds by turns."""
    rng = np.random.default_rng(seed)
    kind = np.arange(count) % len(KINDS)
    made = [_run(rng, KINDS[k]) for k in kind]
    join = {name: np.stack([plan[name] for plan, _ in made]) for name in made[0][0]}
    return Runs(kind, join, {name: np.stack([ego[name] for _, ego in made]) for name in made[0][1]})


def _run(rng: np.random.Generator, kind: str) -> tuple[dict[str, Floats], dict[str, Floats]]:
    time = np.arange(BEGIN, END, STEP)
    knots = np.linspace(BEGIN, END, 8)
    a = np.interp(time, knots, rng.uniform(-8.0, 6.0, knots.size))
    v = np.clip(rng.uniform(0.0, 75.0) + np.cumsum(a) * STEP, 0.0, 80.0)
    lateral = np.interp(time, knots, rng.uniform(-9.0, 9.0, knots.size))
    kappa = np.clip(lateral / np.maximum(v, 3.0) ** 2, -0.09, 0.09)
    heading = rng.uniform(-3.0, 3.0) + np.cumsum(v * kappa) * STEP
    place = complex(*rng.uniform(-500.0, 500.0, 2)) + np.cumsum(v * np.exp(1j * heading)) * STEP

    def at(when: Floats) -> tuple[NDArray[np.complex128], Floats, Floats]:
        x, y = (np.interp(when, time, part) for part in (place.real, place.imag))
        return x + 1j * y, np.interp(when, time, heading), np.interp(when, time, v)

    age = float(rng.choice([0.0, 0.0, rng.uniform(0.0, 0.1)]))
    # A planner that begins at the stamp, at the place and time of an older stamp of its own, or with the sample behind the car.
    since = float(rng.choice([0.0, 0.0, rng.uniform(0.0, 0.3)]))
    ahead = np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.25, SAMPLES - 1))]) - since
    plan: dict[str, list[Floats]] = {name: [] for name in ("t", "x", "y", "heading", "v")}
    ego: dict[str, list[float]] = {name: [] for name in ("x", "y", "heading", "v", "age")}
    aside = complex(*rng.normal(0.0, 0.1, 2))
    moved = rng.uniform(0.0, 6.0) * np.exp(1j * rng.uniform(-math.pi, math.pi))
    turned, late = rng.choice([0.0, rng.uniform(-1.0, 1.0)]), rng.uniform(0.02, 1.5)
    before: list[Floats] = []
    for cycle in range(CYCLES):
        stamp, bad = cycle * PERIOD, cycle >= BAD_FROM
        way, pointing, speed = at(stamp + ahead - (late if bad and kind == "of the past" else 0.0))
        t = ahead
        if bad and kind == "half speed":
            speed, t = speed / 2.0, ahead[0] + 2.0 * (ahead - ahead[0])
        if bad and kind == "elsewhere":
            way = way[0] + moved + (way - way[0]) * np.exp(1j * turned)
            pointing = pointing + turned
        row = [t, (way + aside).real, (way + aside).imag, pointing, speed]
        row = before if bad and kind == "frozen" else row
        for name, column in zip(plan, row, strict=True):
            plan[name].append(column)
        before = row
        seen = at(np.array([stamp - age]))
        # Another turn round says the same.
        values = (
            seen[0][0].real,
            seen[0][0].imag,
            seen[1][0] + math.tau * int(rng.integers(-1, 2)),
            seen[2][0],
            age,
        )
        for name, value in zip(ego, values, strict=True):
            ego[name].append(float(value))
    return {n: np.stack(rows) for n, rows in plan.items()}, {n: np.array(row) for n, row in ego.items()}


def excess(runs: Runs, limits: dict[str, float]) -> dict[str, Floats]:
    """By how much each tolerance is exceeded, (runs, cycles); at most 0 where it is kept to."""
    shape = runs.ego["x"].shape
    found: dict[str, Floats] = {name: np.empty(shape) for name in ("stamp", "place", "heading", "speed")}
    for index in np.ndindex(shape):
        plan: dict[str, Any] = {name: column[index] for name, column in runs.plan.items()}
        car = {name: float(column[index]) for name, column in runs.ego.items()}
        for name, value in _excess(plan, car, limits).items():
            found[name][index] = value
    return found


def _excess(plan: dict[str, Floats], car: dict[str, float], limits: dict[str, float]) -> dict[str, float]:
    t = plan["t"]
    begun = max(t[0] - limits["t_loc"], -t[-1])
    when = max(-car["age"], t[0])
    if when > t[-1]:
        return {"stamp": begun, "place": math.inf, "heading": math.inf, "speed": math.inf}
    x, y, v = (float(np.interp(when, t, plan[name])) for name in ("x", "y", "v"))
    heading = float(np.interp(when, t, np.unwrap(plan["heading"])))
    facing = np.exp(1j * car["heading"])
    away = complex(x - car["x"], y - car["y"]) * facing.conjugate()
    driven = car["v"] * (when + car["age"])
    turn = abs(np.angle(np.exp(1j * heading) * facing.conjugate()))
    # The plan's speed, give or take the tolerance, and the car's, give or take what it gains on the way, have to meet.
    energy, gain = car["v"] * abs(car["v"]), 2.0 * limits["a_loc"] * abs(away.real)
    low, high = v - limits["v_loc"], v + limits["v_loc"]
    return {
        "stamp": begun,
        "place": max(abs(away.real - driven) - limits["ds_loc"], abs(away.imag) - limits["side_loc"]),
        "heading": float(turn) - limits["psi_loc"],
        "speed": max(low * abs(low) - (energy + gain), (energy - gain) - high * abs(high)),
    }
