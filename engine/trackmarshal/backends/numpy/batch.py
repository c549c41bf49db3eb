"""Many cases as arrays: the case axis first, then one axis for each nested variable."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.case import Case

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]


class Batch:
    """Cases that are evaluated together; arrays have `rank` axes, padded where lengths differ."""

    def __init__(self, spec: Spec, cases: Sequence[Case], rank: int) -> None:
        self.spec = spec
        self.cases = cases
        self.size = len(cases)
        self.rank = rank
        self._lengths: dict[str, NDArray[np.intp]] = {}
        self._columns: dict[tuple[str, str], Floats] = {}
        self._masks: dict[ir.Axis, Bools | None] = {}
        #: Projections onto lines that were made already, with the arguments they belong to.
        self.projections: dict[tuple[Any, ...], Any] = {}
        #: Borders and lines prepared for this batch, each with the data that it was made from.
        self.prepared: dict[tuple[Any, ...], tuple[Any, Any]] = {}

    def lengths(self, signal: str) -> NDArray[np.intp]:
        """(cases,): how many samples or elements each case has."""
        if signal not in self._lengths:
            self._lengths[signal] = np.array([case.counts[signal] for case in self.cases], dtype=np.intp)
        return self._lengths[signal]

    def table(self, signal: str, field: str) -> Floats:
        """(cases, longest): a column of every case, its last value repeated as padding."""
        key = (signal, field)
        if key not in self._columns:
            self._columns[key] = self._stack([case.columns[signal][field] for case in self.cases], self.lengths(signal))
        return self._columns[key]

    @staticmethod
    def _stack(columns: list[Sequence[Any]], lengths: NDArray[np.intp]) -> Floats:
        longest = int(lengths.max(initial=0))
        if longest and bool((lengths == longest).all()):
            return np.array(columns, dtype=np.float64)
        result = np.zeros((len(columns), longest))
        for row, column in zip(result, columns):
            row[: len(column)] = column
            if len(column):
                row[len(column) :] = column[-1]
        return result

    def flags(self, signal: str, field: str) -> Floats:
        """(cases, longest): a Boolean column as 1, 0 and NaN for a missing value."""
        key = (signal, field)
        if key not in self._columns:
            columns: list[Sequence[Any]] = [[np.nan if v is None else float(v) for v in case.columns[signal][field]] for case in self.cases]
            self._columns[key] = self._stack(columns, self.lengths(signal))
        return self._columns[key]

    def count(self, axis: ir.Axis) -> int:
        """The size of an axis: the longest case's number of values of its variable."""
        return max(0, int(self.lengths(axis.signal).max(initial=0)) - axis.width + 1)

    def mask(self, axis: ir.Axis) -> Bools | None:
        """Which entries of an axis are there, shaped for broadcasting; None when all are, and there is at least one."""
        if axis not in self._masks:
            counts = np.maximum(0, self.lengths(axis.signal) - axis.width + 1)
            size = self.count(axis)
            full = size > 0 and bool((counts == size).all())
            self._masks[axis] = None if full else self.on_axis(np.arange(size) < counts[:, None], axis)
        return self._masks[axis]

    def on_axis(self, table: NDArray[Any], axis: ir.Axis) -> NDArray[Any]:
        """(cases, n) shaped so that n lies on the axis's place and the others are 1."""
        shape = [1] * self.rank
        shape[0], shape[1 + axis.level] = table.shape
        return table.reshape(shape)

    def per_case(self, values: Sequence[Any], dtype: type = np.float64) -> NDArray[Any]:
        """(cases,) shaped for broadcasting."""
        return np.array(values, dtype=dtype).reshape((self.size,) + (1,) * (self.rank - 1))

    def column(self, axis: ir.Axis, field: str, offset: int) -> Floats:
        """A field of the variable of an axis, `offset` samples on, clamped at the start."""
        return self.on_axis(shifted(self.table(axis.signal, field), offset, self.count(axis)), axis)

    def shared(self, read: Callable[[Case], Any]) -> tuple[bool, list[Any]]:
        """A value of every case, and whether it is one and the same object for all of them."""
        values = [read(case) for case in self.cases]
        return all(value is values[0] for value in values), values


def shifted(table: NDArray[Any], offset: int, count: int) -> NDArray[Any]:
    """Columns offset .. offset + count of a table, the first one repeated for those before the start."""
    if offset >= 0:
        return table[:, offset : offset + count]
    kept = table[:, : max(0, count + offset)]
    return np.concatenate([np.repeat(table[:, :1], min(-offset, count), axis=1), kept], axis=1)
