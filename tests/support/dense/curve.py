"""The curve that a trajectory says, between its samples too.

Between two samples, the curve is the one polynomial of degree five that has position, heading and curvature of both (geometric Hermite
interpolation). It is the same curve to whoever computes it: nothing but the columns enters. Between samples in one place it is that place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.dense.recording import Columns, Floats

#: Distance of the points of a curve, in m.
STEP = 0.02
#: Samples that are closer than this are in one place, in m.
SAME = 1e-6


@dataclass(frozen=True)
class Pieces:
    """Curves from samples to the next ones: points at shares of each way, 0 and 1 included. Arrays (steps, points); share: (points,)."""

    share: Floats
    x: Floats
    y: Floats
    heading: Floats
    kappa: Floats

    @property
    def lengths(self) -> Floats:
        """Of the polygons through their points, m: (steps,)."""
        return np.asarray(np.hypot(np.diff(self.x), np.diff(self.y)).sum(axis=1))


def chords(columns: Columns) -> Floats:
    """Straight distances from sample to sample, m."""
    return np.asarray(np.hypot(np.diff(columns["x"]), np.diff(columns["y"])))


def points_for(columns: Columns, step: float = STEP) -> int:
    """How many points each piece needs so that none is further than `step` from the next, with 5 % for what is bent."""
    return 2 + int(np.ceil(1.05 * chords(columns).max(initial=0.0) / step))


def turned(angle: Floats) -> Floats:
    """An angle in [-pi, pi)."""
    return np.asarray(np.remainder(angle + np.pi, 2.0 * np.pi) - np.pi)


def pieces(columns: Columns, points: int, steps: Floats | None = None) -> Pieces:
    """The curves from the samples `steps` (a mask over all but the last one; default: all) to the next ones."""
    count = len(columns["x"]) - 1
    first = np.arange(count) if steps is None else np.flatnonzero(steps)
    ends = np.stack([first, first + 1])
    x, y, psi, kappa = (columns[name][ends] for name in ("x", "y", "heading", "kappa"))
    chord = np.hypot(x[1] - x[0], y[1] - y[0])
    # The parameter runs as fast as the arc that turns by as much is long.
    half = np.abs(turned(psi[1] - psi[0])) / 2.0
    arc = chord / np.sinc(np.minimum(half, 1.5) / np.pi)
    u = np.linspace(0.0, 1.0, points)
    powers = np.stack([u**n for n in range(6)])
    value = _POWERS @ powers
    slope = (_POWERS[:, 1:] * np.arange(1, 6)) @ powers[:5]
    bend = (_POWERS[:, 2:] * np.array([2, 6, 12, 20])) @ powers[:4]
    east = np.stack([*x, *(arc * np.cos(psi)), *(-arc * arc * kappa * np.sin(psi))], axis=-1)
    north = np.stack([*y, *(arc * np.sin(psi)), *(arc * arc * kappa * np.cos(psi))], axis=-1)
    dx, dy, cx, cy = east @ slope, north @ slope, east @ bend, north @ bend
    pace = np.hypot(dx, dy)
    there = (chord > SAME)[:, None]
    even = (1.0 - u) * kappa[0][:, None] + u * kappa[1][:, None]
    turning = psi[0][:, None] + u * turned(psi[1] - psi[0])[:, None]
    return Pieces(
        u,
        east @ value,
        north @ value,
        np.where(there, np.arctan2(dy, dx), turning),
        np.where(there, (dx * cy - dy * cx) / np.where(there, pace, 1.0) ** 3, even),
    )


#: Coefficients by power of the share, for: first and last position, first and last tangent, first and last second derivative.
_POWERS = np.array(
    [
        [1.0, 0.0, 0.0, -10.0, 15.0, -6.0],
        [0.0, 0.0, 0.0, 10.0, -15.0, 6.0],
        [0.0, 1.0, 0.0, -6.0, 8.0, -3.0],
        [0.0, 0.0, 0.0, -4.0, 7.0, -3.0],
        [0.0, 0.0, 0.5, -1.5, 1.5, -0.5],
        [0.0, 0.0, 0.0, 0.5, -1.0, 0.5],
    ]
)
