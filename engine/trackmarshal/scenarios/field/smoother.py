"""A vehicle's motion out of noisy positions, headings, speeds and yaw rates: three Rauch-Tung-Striebel smoothers, one after the other.

Each is linear, so each has one best answer and cannot lose its way:

1. *Along*: way s, speed v and acceleration a over time, from the way between positions in the direction of the heading, and from the speed. A
   speed within its noise is none: there the car stands, and all of it is smoothed again.
2. *Turning*: heading psi and curvature k, psi' = k over the way, from the heading and the yaw rate k v.
3. *Place*: the way and the heading make a path; what it is apart from the positions is smoothed over the way, and added.

So the columns of a trajectory that is cut out of the result are one motion, and a car that stands is in one place. A filter runs forward
(Kalman), and a pass backward gives the best estimate from all samples, earlier and later ones: H. Rauch, F. Tung, C. Striebel, Maximum likelihood
estimates of linear dynamic systems, AIAA Journal 3(8), 1965, as in S. Sarkka, Bayesian Filtering and Smoothing, Cambridge 2013, section 8.2. What comes
out is known only afterwards: it is for looking back, never for driving.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from trackmarshal.scenarios.field.log import Log
from trackmarshal.scenarios.field.noise import Noise

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]

NAME = (
    "Rauch-Tung-Striebel smoother (Rauch, Tung, Striebel 1965), along, turning and place one after the other"
)
#: A car that stands moves less than a millimetre in a second; as small as double precision carries through the recursion. m/s
_STANDING = 1e-3
#: s: a standstill that is shorter is none, and so is a start.
_SHORTEST = 1.0
#: What a car can do: acceleration, m/s^2, and curvature, 1/m. Nothing else is known before the first sample, and as a car moves off.
_MOST, _TIGHTEST = 10.0, 0.2
#: m/s: curvature is lateral acceleration / v^2; below this speed it is steering that limits how fast it changes.
_SLOW = 5.0


@dataclass(frozen=True, slots=True)
class Motion:
    """(n,) float64 each, in SI, at the times of the log; the heading is not wrapped. `standing`: (n,) bool.

    innovations: of each smoother, the mean of the squared innovations in units of what its filter expected of them: about 1 where noise is as
    declared, less where it is declared larger than it is.
    """

    t: Floats
    s: Floats
    x: Floats
    y: Floats
    heading: Floats
    v: Floats
    a: Floats
    kappa: Floats
    standing: Flags
    innovations: dict[str, float]


def smooth(log: Log, noise: Noise) -> Motion:
    """The motion that fits the whole log best, as far as its noise is as declared."""
    heading = np.unwrap(log.heading)
    middle = 0.5 * (heading[1:] + heading[:-1])
    steps = np.diff(log.x) * np.cos(middle) + np.diff(log.y) * np.sin(middle)
    way = np.concatenate([[0.0], np.cumsum(steps)])
    nowhere = np.zeros(len(log.t), np.bool_)
    first, _ = _along(log, noise, way, nowhere)
    standing = _until_it_leaves(_for_a_second(np.abs(first[:, 1]) <= noise.speed, log.t), way, noise.place)
    along, fit_along = _along(log, noise, way, standing)
    _hold(along, standing)
    # For less than a second, too, a speed backwards within its noise is none.
    along[:, 1] = np.where((along[:, 1] < 0.0) & (along[:, 1] >= -noise.speed), 0.0, along[:, 1])
    s, v, a = (np.ascontiguousarray(column) for column in along.T)
    ds = np.diff(s)
    turning, fit_turning = _turning(log, noise, heading, v, ds)
    psi, kappa = (np.ascontiguousarray(column) for column in turning.T)
    half = 0.5 * (psi[1:] + psi[:-1])
    # the chord of an arc, which a step of a few centimetres differs from by nothing that counts
    x = log.x[0] + np.concatenate([[0.0], np.cumsum(ds * np.cos(half))])
    y = log.y[0] + np.concatenate([[0.0], np.cumsum(ds * np.sin(half))])
    aside_x, fit_x = _aside(log.x - x, noise, v, ds)
    aside_y, fit_y = _aside(log.y - y, noise, v, ds)
    fits = {"along": fit_along, "turning": fit_turning, "place": 0.5 * (fit_x + fit_y)}
    return Motion(log.t, s, x + aside_x, y + aside_y, psi, v, a, kappa, standing, fits)


def _along(log: Log, noise: Noise, way: Floats, standing: Flags) -> tuple[Floats, float]:
    """(n, 3): way, speed, acceleration."""
    dt = np.diff(log.t)
    step, added = np.tile(np.eye(3), (len(dt), 1, 1)), np.zeros((len(dt), 3, 3))
    step[:, 0, 1] = step[:, 1, 2] = dt
    step[:, 0, 2] = 0.5 * dt * dt
    added[:, 2, 2] = noise.jerk**2 * dt
    # coming to rest and moving off, acceleration jumps
    added[standing[1:] != standing[:-1], 2, 2] += _MOST**2
    observe = np.tile(np.eye(3)[:2], (len(log.t), 1, 1))
    found = np.column_stack([way, np.where(standing, 0.0, log.v)])
    deviation = np.column_stack(
        [np.full(len(log.t), noise.place), np.where(standing, _STANDING, noise.speed)]
    )
    start = np.array([way[0], found[0, 1], 0.0])
    spread = np.diag([noise.place, noise.speed, _MOST]) ** 2
    return _smoothed(start, spread, step, added, observe, found, deviation)


def _turning(log: Log, noise: Noise, heading: Floats, v: Floats, ds: Floats) -> tuple[Floats, float]:
    """(n, 2): heading and curvature."""
    dt = np.diff(log.t)
    step, added = np.tile(np.eye(2), (len(dt), 1, 1)), np.zeros((len(dt), 2, 2))
    step[:, 0, 1] = ds
    sharpness = noise.lateral_jerk / np.maximum(np.abs(v[:-1]), _SLOW) ** 2
    added[:, 1, 1] = sharpness**2 * dt
    observe = np.zeros((len(v), 2, 2))
    observe[:, 0, 0] = 1.0
    observe[:, 1, 1] = v
    rate = log.yaw_rate
    found = np.column_stack([heading, np.zeros(len(v)) if rate is None else rate])
    unseen = 1e6  # no yaw rate: an observation that says nothing
    deviation = np.column_stack(
        [np.full(len(v), noise.heading), np.full(len(v), unseen if rate is None else noise.yaw_rate)]
    )
    spread = np.diag([noise.heading, _TIGHTEST]) ** 2
    return _smoothed(np.array([heading[0], 0.0]), spread, step, added, observe, found, deviation)


def _aside(apart: Floats, noise: Noise, v: Floats, ds: Floats) -> tuple[Floats, float]:
    """(n,): how far, in one coordinate, the place is from where way and heading alone lead; it changes only while the car moves.

    Its slope over the way is what the heading and the speed are off by, and may become another one within a second.
    """
    moving = np.abs(ds) > 0.0
    mean_v = float(np.mean(np.abs(v[1:][moving]))) if moving.any() else 1.0
    slope = float(np.hypot(noise.heading, noise.speed / max(mean_v, noise.speed)))
    step, added = np.tile(np.eye(2), (len(ds), 1, 1)), np.zeros((len(ds), 2, 2))
    step[:, 0, 1] = ds
    added[:, 1, 1] = slope**2 * np.abs(ds) / max(mean_v, noise.speed)
    observe = np.tile(np.array([[1.0, 0.0]]), (len(v), 1, 1))
    deviation = np.full((len(v), 1), noise.place)
    spread = np.diag([noise.place, slope]) ** 2
    result, fit = _smoothed(
        np.array([apart[0], 0.0]), spread, step, added, observe, apart[:, None], deviation
    )
    return np.ascontiguousarray(result[:, 0]), fit


def _smoothed(
    start: Floats,
    spread: Floats,
    step: Floats,
    added: Floats,
    observe: Floats,
    found: Floats,
    deviation: Floats,
) -> tuple[Floats, float]:
    """The states (n, k) of a linear motion, and the mean squared innovation.

    start (k,) and spread (k, k): before the first sample. step, added (n-1, k, k): to the next sample, and the variance that it adds. observe
    (n, m, k), found (n, m), deviation (n, m): what is seen at each sample, independently of each other.
    """
    count, size = len(found), len(start)
    states, predicted = np.empty((count, size)), np.empty((count, size))
    variances, expected = np.empty((count, size, size)), np.empty((count, size, size))
    state, variance, squares = start, spread, 0.0
    for i in range(count):
        if i:
            state = step[i - 1] @ state
            variance = step[i - 1] @ variance @ step[i - 1].T + added[i - 1]
        predicted[i], expected[i] = state, variance
        for row, value, noise in zip(observe[i], found[i], deviation[i]):
            across = variance @ row
            total = float(row @ across) + noise * noise
            innovation = value - float(row @ state)
            squares += innovation * innovation / total
            state = state + across * (innovation / total)
            variance = variance - np.outer(across, across) / total
        states[i], variances[i] = state, 0.5 * (variance + variance.T)
        variance = variances[i]
    for i in range(count - 2, -1, -1):
        gain = np.linalg.solve(expected[i + 1], step[i] @ variances[i]).T
        states[i] += gain @ (states[i + 1] - predicted[i + 1])
    return states, squares / found.size


def _for_a_second(flags: Flags, t: Floats) -> Flags:
    """Flags without gaps, and then without stretches, that are shorter than a second: nothing stops and moves off that fast."""
    result = flags.copy()
    for value in (False, True):
        edges = np.flatnonzero(np.diff(np.concatenate([[0], (result == value).astype(np.int8), [0]])))
        for begin, end in zip(edges[::2], edges[1::2]):
            if begin > 0 and end < len(t) and t[end] - t[begin] < _SHORTEST:
                result[begin:end] = not value
    return result


def _until_it_leaves(standing: Flags, way: Floats, place: float) -> Flags:
    """Standstills that end where the car leaves its place by more than twice the noise of a position: moving off, it creeps for a while
    at a speed within the noise, and would have to catch up at once."""
    result = standing.copy()
    edges = np.flatnonzero(np.diff(np.concatenate([[0], standing.astype(np.int8), [0]])))
    for begin, end in zip(edges[::2], edges[1::2]):
        near = np.flatnonzero(np.abs(way[begin:end] - np.median(way[begin:end])) <= 2.0 * place)
        if end < len(way):
            result[begin + near[-1] + 1 : end] = False
    return result


def _hold(along: Floats, standing: Flags) -> None:
    """Where the car stands, its way does not grow, and speed and acceleration are exactly 0: what is left of them is rounding."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], standing.astype(np.int8), [0]])))
    for begin, end in zip(edges[::2], edges[1::2]):
        along[begin:end, 0] = along[begin:end, 0].mean()
        along[begin:end, 1:] = 0.0
