"""Many cases as arrays: the case axis first, then one axis for each nested variable."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.curves import Curve, Curves, reader
from trackmarshal.backends.numpy.grids import Grid, Steps
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.frame import Columns, Frame

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
#: Where arrays hold fewer cases than this on average, these are read one by one.
FEW_TOGETHER = 2


class Tables:
    """A spec's own tables as functions of arrays."""

    def __init__(self, spec: Spec) -> None:
        one = {name: table for name, table in spec.tables.items() if table.across is None}
        self.curves = {name: reader(table.knots, table.values, table.way) for name, table in one.items()}
        self.grids = {name: Grid(table) for name, table in spec.tables.items() if table.across is not None}


class Batch:
    """Frames that are evaluated together; arrays have `rank` axes, padded where lengths differ."""

    def __init__(self, spec: Spec, cases: Sequence[Frame], rank: int, tables: Tables) -> None:
        self.spec = spec
        self.cases = cases
        self.size = len(cases)
        self.rank = rank
        #: What is taken for the numbers that state machines keep.
        self.remembered: Mapping[ir.Kept, float] = {}
        self._tables = tables
        self._own: dict[str, list[Columns]] = {}
        self._counts: dict[str, list[int]] = {}
        self._sizes: dict[ir.Axis, int] = {}
        #: By signal: which row each field is, and (rows, cases, longest) all of them.
        self._rows: dict[str, tuple[Mapping[str, int], Floats]] = {}
        self._masks: dict[ir.Axis, Bools | None] = {}
        #: Borders and lines prepared for this batch, each with the data that it was made from.
        self.prepared: dict[tuple[Any, ...], tuple[Any, Any]] = {}
        #: What every case has that the road between two borders is made from, by signal: its area and its middle ask for it.
        self.roads: dict[str, list[Any]] = {}
        #: The prepared object of every case, or one that all share, by the place that it is for.
        self.owners: dict[ir.IR, list[Any]] = {}
        settings = list({id(case.settings): case.settings for case in cases}.values())
        #: Whether any case overrides a parameter; a table.
        self.overridden = any(one.params for one in settings)
        self._tabled = any(one.tables for one in settings)

    @property
    def faulty(self) -> list[int]:
        """The places of cases in which something is wrong."""
        return [place for place, case in enumerate(self.cases) if case.faults]

    @cached_property
    def by_case(self) -> tuple[int, ...]:
        """The shape of a number of every case."""
        return (self.size, *(1,) * (self.rank - 1))

    # Values of cases ------------------------------------------------------------------------------------------

    def per_case(self, values: Sequence[Any]) -> NDArray[Any]:
        """(cases,) shaped for broadcasting."""
        return np.array(values, dtype=np.float64).reshape(self.by_case)

    def numbers(self, values: list[float]) -> Any:
        """A number of every case: one for all where they have the same, which is cheaper."""
        first = values[0]
        one = first != 0.0 and values.count(first) == len(values)  # 0.0 equals -0.0, but is not the same
        return np.array(first) if one else self.per_case(values)  # numpy takes that faster than a number

    def param(self, name: str) -> Any:
        """A parameter."""
        own = self.spec.params[name].value
        if not self.overridden:
            return np.float64(own)
        return self.numbers([case.settings.params.get(name, own) for case in self.cases])

    def kept(self, node: ir.Kept) -> Any:
        """A number that a state machine keeps, which one cycle does not say: as it was given."""
        return np.array(self.remembered[node])

    def sample(self, signal: str, field: str, index: int) -> Any:
        """A field of one sample of every case's timeline."""
        return self.per_case([columns.column(field)[index] for columns in self.own(signal)])

    def scalar(self, signal: str, field: str) -> Any:
        """A field of every case's record."""
        return self.numbers(self.table(signal, field)[:, 0].tolist())

    def event(self, signal: str, field: str, index: int) -> Any:
        """A Boolean of every case, of one sample where it is that of a timeline, as 1, 0 and NaN for a missing value."""
        return self.per_case(_codes([case.flag(signal, field, index) for case in self.cases]))

    def curve(self, name: str) -> Callable[[Any], Any]:
        """A table: one function where all cases have the same."""
        own = self._tables.curves[name]
        if not self._tabled:
            return own
        made: dict[Any, Curve | Steps] = {None: own}
        rows = []
        for case in self.cases:
            table = case.settings.tables.get(name)
            key = (
                table if table is None or 0.0 not in (*table[0], *table[1]) else repr(table)
            )  # tells -0.0 from 0.0
            if key not in made:
                assert table is not None
                made[key] = reader(*table, self.spec.tables[name].way)
            rows.append(made[key])
        return rows[0] if all(row is rows[0] for row in rows) else Curves(rows, self.rank)

    def grid(self, name: str) -> Grid:
        """A table of two arguments, which is the same in all cases."""
        return self._tables.grids[name]

    # Columns --------------------------------------------------------------------------------------------------

    def own(self, signal: str) -> list[Columns]:
        """The columns of every case."""
        own = self._own.get(signal)
        if own is None:
            own = self._own[signal] = [case.columns[signal] for case in self.cases]
        return own

    def counts(self, signal: str) -> list[int]:
        """How many samples or elements each case has."""
        counts = self._counts.get(signal)
        if counts is None:
            counts = self._counts[signal] = [columns.count for columns in self.own(signal)]
        return counts

    def lengths(self, signal: str) -> NDArray[np.intp]:
        """(cases,): how many samples or elements each case has."""
        return np.array(self.counts(signal), dtype=np.intp)

    def table(self, signal: str, field: str) -> Floats:
        """(cases, longest): a column of every case, its last value repeated as padding; in one piece, on which numpy works faster."""
        known = self._rows.get(signal)
        if known is None:
            columns = np.ascontiguousarray(self._stacked(signal).swapaxes(0, 1))
            known = self._rows[signal] = self.own(signal)[0].names.rows, columns
        rows, columns = known
        return columns[rows[field], :]

    def _stacked(self, signal: str) -> Floats:
        """(cases, numbers, longest): all columns of every case, padded; a view where these stand in one array already."""
        own = self.own(signal)
        found: dict[int, tuple[Floats, list[int], list[int]]] = {}
        last: Floats | None = None
        for case, columns in enumerate(own):
            if columns.stack is None:
                return self._padded([columns.values for columns in own], signal)
            if columns.stack is not last:  # mostly that of the case before
                last = columns.stack
                stack, cases, places = found.setdefault(id(last), (last, [], []))
            cases.append(case)
            places.append(columns.row)
        if len(found) == 1:
            return _rows(stack, places)
        if (
            FEW_TOGETHER * len(found) > len(own)
            or len({stack.shape[1:] for stack, _, _ in found.values()}) > 1
        ):
            return self._padded([columns.values for columns in own], signal)
        made = np.empty((self.size, *stack.shape[1:]))
        for stack, cases, places in found.values():
            made[cases] = _rows(stack, places)
        return made

    def _padded(self, rows: list[NDArray[Any]], signal: str) -> Floats:
        """(cases, .., longest)."""
        counts = self.counts(signal)
        longest = max(counts)
        if min(counts) == longest:
            return np.array(rows, dtype=np.float64)
        made = np.zeros((self.size, *rows[0].shape[:-1], longest))
        for target, given, count in zip(made, rows, counts):
            target[..., :count] = given
            target[..., count:] = given[..., -1:] if count else 0.0
        return made

    def flags(self, signal: str, field: str) -> Floats:
        """(cases, longest): a column of Booleans as 1, 0 and NaN for a missing value, padded."""
        rows = [np.array(_codes(columns.listed(field))) for columns in self.own(signal)]
        return self._padded(rows, signal)

    # Axes -----------------------------------------------------------------------------------------------------

    def count(self, axis: ir.Axis) -> int:
        """The size of an axis: the longest case's number of values of its variable."""
        size = self._sizes.get(axis)
        if size is None:
            size = self._sizes[axis] = max(0, max(self.counts(axis.signal)) - axis.width + 1)
        return size

    def mask(self, axis: ir.Axis) -> Bools | None:
        """Which entries of an axis are there, shaped for broadcasting; None when all are, and there is at least one."""
        if axis not in self._masks:
            counts = self.counts(axis.signal)
            there = None
            if counts.count(counts[0]) < len(counts):
                own = np.array(counts)[:, None] - (axis.width - 1)
                there = self.on_axis(np.arange(self.count(axis)) < own, axis)
            elif counts[0] < axis.width:
                there = self.on_axis(np.zeros((self.size, 0), dtype=np.bool_), axis)
            self._masks[axis] = there
        return self._masks[axis]

    def gaps(self, axis: ir.Axis) -> Bools | None:
        """Of which samples nothing is known, shaped for broadcasting; None where there are none of them."""
        own = [() if columns.joined is None else columns.joined.gaps for columns in self.own(axis.signal)]
        if not any(own):
            return None
        there = np.zeros((self.size, self.count(axis)), dtype=bool)
        for row, gaps in zip(there, own):
            row[list(gaps)] = True
        return self.on_axis(there, axis)

    def places(self, signal: str, judged: ir.JudgedAt) -> NDArray[np.intp]:
        """(cases,): the sample at which a rule is judged."""
        return np.array([columns.place(judged) for columns in self.own(signal)], dtype=np.intp)

    def on_axis(self, table: NDArray[Any], axis: ir.Axis) -> NDArray[Any]:
        """(cases, n) shaped so that n lies on the axis's place and the others are 1."""
        before = axis.level
        return table.reshape(self.size, *(1,) * before, table.shape[1], *(1,) * (self.rank - 2 - before))


def _rows(stack: Floats, places: list[int]) -> Floats:
    """What stands at some places of a stack: a view where they follow each other."""
    first, end = places[0], places[0] + len(places)
    return stack[first:end] if places == list(range(first, end)) else stack.take(places, axis=0)


def _codes(values: Sequence[bool | None]) -> list[float]:
    return [np.nan if value is None else float(value) for value in values]


@lru_cache(maxsize=1024)
def column_index(axis: ir.Axis, offset: int, rank: int) -> tuple[slice | None, ...]:
    """Where a table (cases, n) has the values of the variable of an axis, `offset` samples on, shaped for broadcasting."""
    behind = axis.width - 1 - offset
    own = slice(offset, -behind or None)
    return (slice(None), *(None,) * axis.level, own, *(None,) * (rank - 2 - axis.level))


def before(table: NDArray[Any], steps: int) -> NDArray[Any]:
    """A table in which every column stands so many places later, the first one repeated at the start."""
    late = min(steps, table.shape[1])
    made = np.empty_like(table)
    made[:, :late] = table[:, :1]
    made[:, late:] = table[:, : table.shape[1] - late]
    return made
