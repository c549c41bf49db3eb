"""What the tyres, the drive train and the steering have to give along a trajectory, at its samples and between them."""

from __future__ import annotations

import numpy as np

from support.dense import curve
from support.dense.car import Car
from support.dense.recording import Columns, Floats

#: Points from sample to sample.
POINTS = 26


def at_samples(columns: Columns, car: Car) -> dict[str, bool]:
    """Which limits a sample exceeds."""
    v, a, kappa = (columns[name] for name in ("v", "a", "kappa"))
    return _exceeded(v, a, kappa, car)


def between(columns: Columns, car: Car) -> dict[str, bool]:
    """Which limits the curve exceeds: the square of speed and acceleration linear over the way, curvature that of the curve."""
    part = curve.pieces(columns, POINTS)
    v, a = (columns[name] for name in ("v", "a"))
    square = _linear(np.square(v) * np.sign(v), part.share)
    speed = np.sign(square) * np.sqrt(np.abs(square))
    found = _exceeded(speed, _linear(a, part.share), part.kappa, car)
    # Of steps that hardly go anywhere, a centimetre counts.
    needed = np.abs(np.diff(np.square(v))) / (2.0 * np.maximum(curve.chords(columns), 0.01))
    most = car.grip + car.air(np.maximum(np.abs(v[:-1]), np.abs(v[1:])))
    # Whoever leaves drag out of what brakes do is more cautious.
    return {
        **found,
        "brakes": bool((a < -car.brakes).any()),
        "speed jumps": bool((needed > most).any()),
        "path turns": bool((_swings(columns) > car.grip).any()),
        "headings turn": bool((_bends(columns) * car.radius > 1.0).any()),
    }


def _linear(values: Floats, share: Floats) -> Floats:
    """(steps, points)."""
    return np.asarray((1.0 - share) * values[:-1, None] + share * values[1:, None])


def _swings(columns: Columns) -> Floats:
    """From step to step, what a change of the direction between positions takes across it, m/s^2; a centimetre counts, as above."""
    way = np.maximum(curve.chords(columns), 0.01)
    bearing = np.arctan2(np.diff(columns["y"]), np.diff(columns["x"]))
    return np.asarray(
        np.square(columns["v"][1:-1]) * np.abs(curve.turned(np.diff(bearing))) * 2.0 / (way[1:] + way[:-1])
    )


def _bends(columns: Columns) -> Floats:
    """Curvature of each step as its headings say, 1/m; a centimetre counts, as above."""
    way = np.maximum(curve.chords(columns), 0.01)
    return np.asarray(np.abs(curve.turned(np.diff(columns["heading"]))) / way)


def _exceeded(v: Floats, a: Floats, kappa: Floats, car: Car) -> dict[str, bool]:
    wheels = a + car.air(v)
    return {
        "friction": bool((car.tyres(v, a, kappa) > car.grip).any()),
        "drive": bool((wheels > car.most_drive(v)).any()),
        "brakes": bool((wheels < -car.brakes).any()),
        "radius": bool((np.abs(kappa) * car.radius > 1.0).any()),
        "fast": bool((v > car.v_max).any()),
        "backwards": bool((v < 0.0).any()),
    }


def ends_moving(columns: Columns, slow: float = 0.01) -> bool:
    """Whether the trajectory ends with a speed above `slow`, m/s."""
    return bool(abs(columns["v"][-1]) > slow)
