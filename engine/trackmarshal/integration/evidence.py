"""What numbers say about columns: which grows as the path does, which is its speed, direction, curvature."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmarshal.integration.found import Array

#: Timelines by column.
Timelines = Sequence[dict[str, Array]]
#: A heading of 0 that points nearer than this to an axis, in rad, is meant to point along it.
QUARTER = 0.06
#: Numbers of samples.
Steps = NDArray[np.signedinteger[Any]]
#: A step that is shorter, in m, says nothing about directions.
SHORT = 0.05


class Ratio(NamedTuple):
    """A column as a multiple of what it should be: the factor, how far it strays from that (relative, median), from how many steps."""

    factor: float
    stray: float
    steps: int

    @property
    def sure(self) -> float:
        """From 0 to 1."""
        return 0.0 if self.steps < 3 or not math.isfinite(self.stray) else max(0.0, 1.0 - self.stray / 0.1)


NOTHING = Ratio(math.nan, math.inf, 0)


def ratio(measured: list[Array], expected: list[Array]) -> Ratio:
    """measured = factor * expected, at the median."""
    if not measured:
        return NOTHING
    a, b = np.concatenate(measured), np.concatenate(expected)
    keep = np.isfinite(a) & np.isfinite(b) & (np.abs(b) > 1e-9)
    if keep.sum() < 3:
        return NOTHING
    each = a[keep] / b[keep]
    factor = _median(each)
    if factor == 0.0:
        return NOTHING
    return Ratio(factor, _median(np.abs(each - factor)) / abs(factor), len(each))


def _median(numbers: Array) -> float:
    """Of finite numbers: the same as numpy's, which takes most of its time to find out what it is given."""
    ordered, middle = np.sort(numbers), len(numbers) // 2
    return float(ordered[middle] if len(numbers) % 2 else (ordered[middle - 1] + ordered[middle]) / 2)


def chords(timelines: Timelines, x: str, y: str) -> list[Array]:
    """Distances from sample to sample."""
    return [np.hypot(np.diff(one[x]), np.diff(one[y])) for one in timelines]


def grown(timelines: Timelines, column: str) -> list[Array]:
    """By how much a column grows from sample to sample."""
    return [np.diff(one[column]) for one in timelines]


def covered(timelines: Timelines, v: str, t: str) -> list[Array]:
    """How far a speed leads over a time from sample to sample; not known where the time does not go on everywhere."""
    found = []
    for one in timelines:
        dt = np.diff(one[t])
        goes_on = bool(np.all(dt > 0))
        found.append((one[v][:-1] + one[v][1:]) / 2 * dt if goes_on else np.full(len(dt), math.nan))
    return found


def as_distances(measured: list[Array], ds: list[Array]) -> Ratio:
    """Whether numbers from sample to sample are the distances there."""
    if not measured:
        return NOTHING
    a, step = np.concatenate(measured), np.concatenate(ds)
    moves = step > SHORT
    return ratio([a[moves]], [step[moves]])


def grows_with(timelines: Timelines, column: str, ds: list[Array]) -> Ratio:
    """Whether a column grows by the distance from sample to sample."""
    return as_distances(grown(timelines, column), ds)


def speed_and_time(timelines: Timelines, v: str, t: str, ds: list[Array]) -> Ratio:
    """Whether the distance is that of a speed over a time: factor = v dt / ds."""
    return as_distances(covered(timelines, v, t), ds)


def acceleration(timelines: Timelines, a: str, v: str, ds: list[Array]) -> Ratio:
    """Whether a column is the acceleration of a speed, a = d(v^2) / (2 ds), where it is more than 0.3 m/s^2."""
    measured, expected = [], []
    for one, step in zip(timelines, ds):
        keep = step > SHORT
        should = np.diff(one[v] ** 2)[keep] / (2 * step[keep])
        strong = np.abs(should) > 0.3
        measured.append(one[a][:-1][keep][strong])
        expected.append(should[strong])
    return ratio(measured, expected)


def directions(timelines: Timelines, x: str, y: str) -> list[tuple[Steps, Array]]:
    """Of the inner samples that move: their numbers, and the direction of travel there, rad (circle through three samples)."""
    found: list[tuple[Steps, Array]] = []
    for one in timelines:
        dx, dy = np.diff(one[x]), np.diff(one[y])
        step, chord = np.hypot(dx, dy), np.arctan2(dy, dx)
        turn = np.remainder(np.diff(chord) + math.pi, math.tau) - math.pi
        inner = np.flatnonzero((step[:-1] > SHORT) & (step[1:] > SHORT) & (np.abs(turn) < 1.0))
        found.append((inner + 1, chord[inner] + turn[inner] * step[inner] / (step[inner] + step[inner + 1])))
    return found


class Turned(NamedTuple):
    """A heading as the direction of travel: direction = begin + sign * unit * heading, rad; how well, 0 to 1; whether the path turns enough to tell the sign."""

    begin: float
    clockwise: bool
    degrees: bool
    fit: float
    told: bool
    stray: float


def turned(heading: Array, direction: Array) -> Turned | None:
    """The convention that fits best; None where there is nothing to compare."""
    keep = np.isfinite(heading) & np.isfinite(direction)
    heading, direction = heading[keep], direction[keep]
    if len(heading) < 3:
        return None
    told = float(np.abs(np.exp(1j * direction).mean())) < 0.995
    found: list[Turned] = []
    for degrees in (False, True):
        unit = math.pi / 180 if degrees else 1.0
        for clockwise in (False, True):
            apart = direction - (-1 if clockwise else 1) * unit * heading
            mean = np.exp(1j * apart).mean()
            own = float(np.angle(mean))
            quarter = math.pi / 2 * round(own / (math.pi / 2))
            begin = quarter if abs(own - quarter) < QUARTER else own
            stray = float(np.median(np.abs(np.remainder(apart - begin + math.pi, math.tau) - math.pi)))
            found.append(Turned(begin, clockwise, degrees, float(abs(mean)), told, stray))
    # Of conventions that fit as well, on a straight road, one whose 0 lies along an axis; radians and counter-clockwise before others.
    most = max(one.fit for one in found)
    well = [one for one in found if one.fit > most - 1e-3]
    return next((one for one in well if one.begin % (math.pi / 2) == 0.0), well[0])


def heading(timelines: Timelines, column: str, ways: list[tuple[Steps, Array]]) -> Turned | None:
    """A column as the heading of the path."""
    at = [(one[column][inner], direction) for one, (inner, direction) in zip(timelines, ways)]
    return turned(np.concatenate([a for a, _ in at]), np.concatenate([b for _, b in at])) if at else None


def curvature(timelines: Timelines, column: str, x: str, y: str) -> Ratio:
    """Whether a column is the curvature of the path, where it is more than 1/200 m."""
    measured, expected = [], []
    for one in timelines:
        px, py = one[x], one[y]
        if len(px) < 3:
            continue
        ax, ay, bx, by = px[1:-1] - px[:-2], py[1:-1] - py[:-2], px[2:] - px[1:-1], py[2:] - py[1:-1]
        a, b, c = np.hypot(ax, ay), np.hypot(bx, by), np.hypot(ax + bx, ay + by)
        keep = (a > SHORT) & (b > SHORT) & (c > SHORT)
        should = 2 * (ax * by - ay * bx)[keep] / (a * b * c)[keep]
        strong = np.abs(should) > 0.005
        measured.append(one[column][1:-1][keep][strong])
        expected.append(should[strong])
    return ratio(measured, expected)
