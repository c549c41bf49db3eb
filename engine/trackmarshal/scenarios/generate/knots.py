"""Piecewise linear functions given by their knots."""

from __future__ import annotations

from bisect import bisect_right


def linear(knots: list[list[float]], x: float) -> float:
    """The value at x: linear between knots [x, y] (x strictly increasing), constant beyond their ends."""
    i = bisect_right(knots, x, key=lambda knot: knot[0])
    if i == 0:
        return knots[0][1]
    if i == len(knots):
        return knots[-1][1]
    (x0, y0), (x1, y1) = knots[i - 1], knots[i]
    return y0 + (y1 - y0) * (x - x0) / (x1 - x0)
