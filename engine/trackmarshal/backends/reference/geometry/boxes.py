"""Boxes around stretches of a line: what is far away is left out at once. They decide no number, only which are worked out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from trackmarshal.points import Point

#: So many segments of a line that follow each other are looked at as one, where they are far away.
STRETCH = 16


class Box(NamedTuple):
    """The least and the greatest x and y of some points."""

    left: float
    right: float
    low: float
    high: float

    def wider(self, by: float) -> Box:
        """The box with so much more on every side."""
        return Box(self.left - by, self.right + by, self.low - by, self.high + by)

    def apart(self, other: Box, x: float = 0.0, y: float = 0.0) -> float:
        """How far the box, seen from an origin, and another one are apart in x or in y, which is no farther than they are; 0 where they overlap.

        Rounding keeps the order of points, so seen from there it is exactly the box of what is in it.
        """
        left, right, low, high = self
        its_left, its_right, its_low, its_high = other
        return max(
            left - x - its_right, its_left - (right - x), low - y - its_high, its_low - (high - y), 0.0
        )

    @property
    def size(self) -> float:
        """How far two points of it may be apart, or more."""
        return (self.right - self.left) + (self.high - self.low)


def box_of(points: Sequence[Point]) -> Box:
    """The box of points."""
    xs, ys = zip(*points)
    return Box(min(xs), max(xs), min(ys), max(ys))
