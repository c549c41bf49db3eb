"""One case of a batch as scalars: what witnesses and results ask for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from trackmarshal.backends.numpy import places
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.verdict import Bound, Truth

if TYPE_CHECKING:
    from trackmarshal.backends.numpy.program import Run


class CaseView:
    """Values of one case of a run."""

    def __init__(self, run: Run, index: int) -> None:
        self._run = run
        self._index = index
        self._case = run.batch.cases[index]

    def truth(self, node: ir.Formula, env: dict[int, int]) -> Truth:
        value = self._run.of(node)
        worst = self._bound(value.worst, env)
        return Truth(worst, worst if value.best is value.worst else self._bound(value.best, env))

    def _bound(self, side: Any, env: dict[int, int]) -> Bound:
        return Bound(bool(self._at(side.sat, env)), float(self._at(side.margin, env)))

    def _at(self, array: Any, env: dict[int, int]) -> Any:
        if array.ndim == 0:
            return array
        place = [0] * array.ndim
        if array.shape[0] != 1:
            place[0] = self._index
        for level, position in env.items():
            if array.shape[1 + level] != 1:
                place[1 + level] = position
        return array[tuple(place)]

    def count(self, axis: ir.Axis) -> int:
        return max(0, self._case.counts[axis.signal] - axis.width + 1)

    def times(self, axis: ir.Axis) -> Sequence[float]:
        return self._case.columns[axis.signal]["t"]

    def name(self, axis: ir.Axis, index: int) -> int | str:
        return self._case.names[axis.signal][index] if axis.kind == "elements" else index

    def along(self, node: ir.Formula, axis: ir.Axis, env: dict[int, int]) -> list[Truth]:
        return [self.truth(node, {**env, axis.level: k}) for k in range(self.count(axis))]

    def geometry_fault(self, formula: ir.Formula) -> str | None:
        for node in ir.below(formula):
            if isinstance(node, ir.Area):
                fault = places.fault(self._run.batch, self._index, node)
                if fault is not None:
                    return fault
        return None
