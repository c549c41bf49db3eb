"""One case of a batch as scalars: what witnesses and results ask for."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from trackmarshal.backends.numpy import places
from trackmarshal.backends.numpy.logic import AT_LEAST, NEITHER, Side, Value
from trackmarshal.backends.witness import Sides, unknown_in
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.frame import Columns
from trackmarshal.runtime.verdict import Bound, Truth

if TYPE_CHECKING:
    from trackmarshal.backends.numpy.program import Run


#: Of so many values a case they are all made Python's at once, where one of as many has been asked for: asking an array for one takes as long
#: as making some dozens of them.
LISTED = 32


class Reading:
    """A formula's value, by case and by what variables stand for: one entry of arrays of one shape, as Python's numbers."""

    __slots__ = ("_best", "_left", "_lengths", "_sides", "_steps", "_worst")

    def __init__(self, value: Value, size: int) -> None:
        sides = [value.worst] if value.best is value.worst else [value.worst, value.best]
        given = [side.margin for side in sides] + [side.sat for side in sides if side.says == NEITHER]
        self._lengths = np.broadcast_shapes(*(array.shape for array in given))
        self._sides = sides
        count = math.prod(self._lengths)
        #: How many entries are asked of the arrays, before all are made Python's.
        self._left = 1 + count // LISTED if count <= LISTED * size else 0
        self._worst, self._best = self._of(_asked)
        #: By axis how many values further the next entry is: none where all have the same one.
        self._steps: list[int] = []
        step = 1
        for length in reversed(self._lengths):
            self._steps.insert(0, 0 if length == 1 else step)
            step *= length

    def _of(self, bounds: Bounds) -> tuple[Callable[[int], Bound], Callable[[int], Bound] | None]:
        made = [bounds(side, self._lengths) for side in self._sides]
        return made[0], made[1] if len(made) > 1 else None

    def at(self, index: int, env: Mapping[int, int]) -> Truth:
        if self._left:
            self._left -= 1
            if not self._left:
                self._worst, self._best = self._of(_listed)
        steps, place = self._steps, 0
        if steps:
            place = index * steps[0]
            for level, position in env.items():
                step = steps[1 + level]
                if step and not 0 <= position < self._lengths[1 + level]:  # there is another one's value
                    raise IndexError(f"entry {position} of {self._lengths[1 + level]}")
                place += position * step
        worst = self._worst(place)
        return Truth(worst, worst if self._best is None else self._best(place))


#: What gives a side by the place of an entry in arrays of a shape.
Bounds = Callable[[Side, tuple[int, ...]], Callable[[int], Bound]]


def _listed(side: Side, shape: tuple[int, ...]) -> Callable[[int], Bound]:
    """Of entries that are all made Python's."""
    margin_at = np.broadcast_to(side.margin, shape).ravel().tolist().__getitem__
    sat_at = np.broadcast_to(side.sat, shape).ravel().tolist().__getitem__
    return lambda place: Bound(sat_at(place), margin_at(place))


def _asked(side: Side, shape: tuple[int, ...]) -> Callable[[int], Bound]:
    """Of entries that are each asked of an array."""
    margin_at: Callable[[int], float] = np.broadcast_to(side.margin, shape).item
    if side.says == NEITHER:
        sat_at: Callable[[int], bool] = np.broadcast_to(side.sat, shape).item
        return lambda place: Bound(sat_at(place), margin_at(place))
    at_zero = bool(side.says & AT_LEAST)

    def bound(place: int) -> Bound:
        margin = margin_at(place)
        return Bound(margin > 0.0 or (at_zero and margin == 0.0), margin)

    return bound


class CaseView:
    """Values of one case of a run."""

    def __init__(self, run: Run, index: int) -> None:
        self._run = run
        self._index = index
        self._case = run.batch.cases[index]
        #: What has been asked of this case alone.
        self._readings: dict[ir.IR, Reading] = {}

    @property
    def spec(self) -> Spec:
        return self._run.program.spec

    def truth(self, node: ir.Formula, env: dict[int, int]) -> Truth:
        made = self._run.readings.get(node) or self._readings.get(node)
        if made is None:
            whole = self._run.whole(node, self._index)
            if whole is not None:
                return whole.truth(node, env)
            made = Reading(self._of(node), self._run.batch.size)
            least = self._least(node)
            alone = least is not None and least.is_of_one(self._index)
            (self._readings if alone else self._run.readings)[node] = made
        return made.at(self._index, env)

    def recalled(self, node: ir.Formula, env: dict[int, int], kept: Mapping[ir.Kept, float]) -> Truth:
        return self._run.recalled(node, kept, self._index).truth(node, env)

    def _of(self, node: ir.Formula) -> Value:
        """The value of a formula, also where the run has only done what its verdict takes: of this case, or of all."""
        least = self._least(node)
        return self._run.of(node) if least is None else least.about(self._index)

    def _least(self, node: ir.Formula) -> places.Least | None:
        """What knows all margins of a formula, where the run has only worked out the least."""
        place = self._run.program.code.least.get(node)
        return None if place is None else self._run._values[place]

    def _place(self, array: Any, env: dict[int, int]) -> list[Any]:
        """Where in an array the case has its value; empty for an array without axes, which has one value for all."""
        shape = array.shape
        if not shape:
            return []
        place = [0] * len(shape)
        if shape[0] != 1:
            place[0] = self._index
        for level, position in env.items():
            if shape[1 + level] != 1:
                place[1 + level] = position
        return place

    def sides(self, node: ir.Formula, axis: ir.Axis, env: dict[int, int]) -> Sides:
        whole = self._run.whole(node, self._index)
        if whole is not None:
            return whole.sides(node, axis, env)
        value = self._of(node)
        worst = self._rows(value.worst, axis, env)
        found = Sides(*worst, *(worst if value.best is value.worst else self._rows(value.best, axis, env)))
        joined = self.columns(axis).joined
        return found if joined is None else unknown_in(found, joined.gaps)

    def _rows(self, side: Any, axis: ir.Axis, env: dict[int, int]) -> tuple[list[bool], list[float]]:
        return self._row(side.sat, axis, env), self._row(side.margin, axis, env)

    def _row(self, array: Any, axis: ir.Axis, env: dict[int, int]) -> list[Any]:
        """The values along an axis."""
        count, place = self.count(axis), self._place(array, env)
        if not place or array.shape[1 + axis.level] == 1:
            return [array.item(*place)] * count if count else []
        place[1 + axis.level] = slice(0, count)
        row: list[Any] = array[tuple(place)].tolist()
        return row

    def count(self, axis: ir.Axis) -> int:
        return max(0, self._case.count(axis.signal) - axis.width + 1)

    def columns(self, axis: ir.Axis) -> Columns:
        return self._case.columns[axis.signal]

    def name(self, axis: ir.Axis, index: int) -> int | str:
        return self._case.columns[axis.signal].name(index)

    def along(self, node: ir.Formula, axis: ir.Axis, env: dict[int, int]) -> list[Truth]:
        sides = self.sides(node, axis, env)
        return [Truth(Bound(*row[:2]), Bound(*row[2:])) for row in zip(*sides)]

    def geometry_fault(self, formula: ir.Formula) -> str | None:
        for node in ir.below(formula):
            if isinstance(node, ir.Area):
                fault = places.fault(self._run.batch, self._index, node)
                if fault is not None:
                    return fault
        return None
