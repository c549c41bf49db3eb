"""Borders and lines: points that never change."""

from __future__ import annotations

import itertools
from functools import cached_property
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Floats = NDArray[np.float64]
Point = tuple[float, float]
_numbers = itertools.count(1)


class Line:
    """A polyline that nobody can change: `points` (n, 2) in m. Whoever has the same one need not look at its points again.

    Made by `door.lines.line`, from points in memory that nobody can write to. Hand one in as a border of each cycle: a border that is
    the same object as in the last cycle costs nothing.
    """

    __slots__ = ("__dict__", "number", "points")

    points: Floats
    #: What tells lines apart in generated code; no two have the same.
    number: int

    def __init__(self, points: Floats) -> None:
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "number", next(_numbers))

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"a line does not change: `{name}`")

    def __len__(self) -> int:
        return len(self.points)

    def __copy__(self) -> Line:
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Line:
        return self

    @cached_property
    def tuples(self) -> tuple[Point, ...]:
        """The points as pairs of Python's numbers."""
        return tuple(map(tuple, self.points.tolist()))
