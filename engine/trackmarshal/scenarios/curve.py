"""Poses along lines, arcs and clothoids: curves whose curvature changes linearly with arc length."""

from __future__ import annotations

import math

#: Nodes and weights of the Gauss-Legendre quadrature with eight points on [-1, 1], positive half.
_GAUSS = (
    (0.1834346424956498, 0.3626837833783620),
    (0.5255324099163290, 0.3137066458778873),
    (0.7966664774136267, 0.2223810344533745),
    (0.9602898564975363, 0.1012285362903763),
)
#: Largest change of heading in one panel, rad: eight points are then exact to rounding.
_PANEL = 0.5


#: x and y in m, heading in rad.
Pose = tuple[float, float, float]


def advance(pose: Pose, kappa: float, sharpness: float, ds: float) -> Pose:
    """The pose after ds m (negative: before) on a curve with curvature kappa that changes by `sharpness` 1/m^2.

    Lines and arcs in closed form, clothoids by quadrature to rounding. The heading is not normalised.
    """
    x, y, heading = pose
    turn = kappa * ds + 0.5 * sharpness * ds * ds
    if sharpness == 0.0:
        half = 0.5 * turn
        chord = ds if half == 0.0 else ds * (math.sin(half) / half)
        return x + chord * math.cos(heading + half), y + chord * math.sin(heading + half), heading + turn
    panels = 1 + int((abs(kappa) + 0.5 * abs(sharpness * ds)) * abs(ds) / _PANEL)
    half = 0.5 * ds / panels
    along = across = 0.0
    for panel in range(panels):
        middle = (2 * panel + 1) * half
        for node, weight in _GAUSS:
            for s in (middle - node * half, middle + node * half):
                angle = heading + kappa * s + 0.5 * sharpness * s * s
                along += weight * math.cos(angle)
                across += weight * math.sin(angle)
    return x + half * along, y + half * across, heading + turn
