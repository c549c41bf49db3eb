"""Braking along a path as hard as the tyres allow, and what the road is worth beyond its end: what physics gives, whatever a rule says."""

from __future__ import annotations

import numpy as np
import shapely

from support.dense.car import Car
from support.dense.path import Path
from support.dense.recording import Floats
from support.dense.sweep import Road, corners


def brake(on: Path, at: float, v: float, car: Car, step: float = 0.25) -> tuple[Floats, Floats, float]:
    """Stations and speeds from a station on, to rest or to the path's end; and the most that the tyres give across, to their grip.

    What the bend leaves of the grip brakes, and drag does. Midpoint steps of the square of speed over the way.
    """
    stations, squares, asks = [at], [v * v], 0.0
    while squares[-1] > 0.0 and stations[-1] < on.s[-1]:
        s, square = stations[-1], squares[-1]
        here, there = on.at("kappa", np.array([s, s + step / 2.0]))
        half = square - step * deceleration(square, float(here), car)
        slower = 2.0 * deceleration(max(half, 0.0), float(there), car)
        asks = max(asks, square * abs(float(here)) / car.grip)
        rests = slower * step >= square
        stations.append(s + (square / slower if rests else step))
        squares.append(0.0 if rests else square - slower * step)
    return np.array(stations), np.sqrt(np.array(squares)), asks


def deceleration(square: float, kappa: float, car: Car) -> float:
    """What a bend leaves, and drag, by the square of speed, m/s^2."""
    across = square * kappa
    return float(np.sqrt(max(0.0, car.grip**2 - across**2)) + car.drag * square / car.mass)


def on_road(on: Path, begin: float, end: float, road: Road, car: Car) -> bool:
    """Whether every footprint from station to station is, 10 cm apart."""
    s = np.append(np.arange(begin, end, 0.1), end)
    prints = shapely.polygons(
        corners(on.at("x", s), on.at("y", s), on.at("heading", s), car.length, car.width)
    )
    return bool(shapely.covers(road.area, prints).all())
