"""One case of a batch as scalars: what witnesses and results ask for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.numpy import places
from trackmarshal.backends.numpy.logic import Value
from trackmarshal.backends.witness import Sides, unknown_in
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.frame import Columns
from trackmarshal.runtime.verdict import Bound, Truth

if TYPE_CHECKING:
    from trackmarshal.backends.numpy.program import Run


class CaseView:
    """Values of one case of a run."""

    def __init__(self, run: Run, index: int) -> None:
        self._run = run
        self._index = index
        self._case = run.batch.cases[index]

    @property
    def spec(self) -> Spec:
        return self._run.program.spec

    def truth(self, node: ir.Formula, env: dict[int, int]) -> Truth:
        if not env:
            worst_sat, worst, best_sat, best = self._run.closed(node)
            index = self._index
            return Truth(Bound(worst_sat[index], worst[index]), Bound(best_sat[index], best[index]))
        value = self._of(node)
        bound = self._bound(value.worst, env)
        return Truth(bound, bound if value.best is value.worst else self._bound(value.best, env))

    def recalled(self, node: ir.Formula, env: dict[int, int], kept: Mapping[ir.Kept, float]) -> Truth:
        return self._run.recalled(node, kept, self._index).truth(node, env)

    def _of(self, node: ir.Formula) -> Value:
        """The value of a formula, also where the run has only done what its verdict takes."""
        place = self._run.program.code.least.get(node)
        least: places.Least | None = None if place is None else self._run._values[place]
        return self._run.of(node) if least is None else least.value

    def _bound(self, side: Any, env: dict[int, int]) -> Bound:
        return Bound(
            side.sat.item(*self._place(side.sat, env)), side.margin.item(*self._place(side.margin, env))
        )

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
