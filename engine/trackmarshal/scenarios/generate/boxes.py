"""Rectangles in the plane: how far apart two of them are."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple


class Box(NamedTuple):
    """A rectangle by its centre, m, its heading, rad, and its extents, m."""

    x: float
    y: float
    heading: float
    length: float
    width: float

    @classmethod
    def of(cls, fields: Mapping[str, float]) -> Box:
        """From a map with these names, and possibly others."""
        return cls(*(fields[name] for name in cls._fields))

    def corners(self) -> Iterable[tuple[float, float]]:
        c, s = math.cos(self.heading), math.sin(self.heading)
        for u, w in ((0.5, 0.5), (0.5, -0.5), (-0.5, -0.5), (-0.5, 0.5)):
            along, across = u * self.length, w * self.width
            yield self.x + along * c - across * s, self.y + along * s + across * c


def separation(one: Box, other: Box) -> float:
    """The widest gap along the directions of their sides, m: negative where they overlap, by how deep."""
    widest = -math.inf
    for box in (one, other):
        for angle in (box.heading, box.heading + 0.5 * math.pi):
            c, s = math.cos(angle), math.sin(angle)
            first, second = ([x * c + y * s for x, y in each.corners()] for each in (one, other))
            widest = max(widest, min(first) - max(second), min(second) - max(first))
    return widest
