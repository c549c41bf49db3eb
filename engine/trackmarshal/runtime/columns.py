"""The door's own memory for the columns of one signal: filled from what a caller hands in, checked all at once.

Copying comes first, so what is judged is what was checked, whatever the caller does with its arrays meanwhile.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.ir.spec import FieldType, SignalType
from trackmarshal.runtime.case import Fault
from trackmarshal.runtime.faults import fault
from trackmarshal.units import from_si, parse_unit

Floats = NDArray[np.float64]
_FLOAT = np.dtype(np.float64)
_NUMBERS = {float, int}
_ABSENT = object()


@dataclass(frozen=True, slots=True)
class View:
    """The first `n` entries of every column, and working memory of the same shape."""

    columns: dict[str, Any]
    matrix: Floats
    low: NDArray[np.bool_]
    high: NDArray[np.bool_]
    #: Pairs (later, earlier) of columns that are declared increasing.
    steps: list[tuple[str, Floats, Floats]]


class Block:
    """Columns of a timeline or a set; `signal.name` may differ from `name`, which faults carry."""

    def __init__(self, name: str, signal: SignalType, capacity: int) -> None:
        self.name = name
        self.many = signal.many
        self.capacity = capacity
        self.least = 0 if signal.many else 2 if signal.kind == "trajectory" else 1
        numeric = [field for field in signal.fields_ if field.kind == "number"]
        self.names = tuple(field.name for field in numeric)
        self._flags = [field.name for field in signal.fields_ if field.kind == "bool"]
        self._kinds = numeric
        self._matrix = np.zeros((len(numeric), capacity))
        self._flag_rows = {name: np.zeros(capacity, dtype=np.int8) for name in self._flags}
        self._fields = [
            (f.name, self._matrix[i], f.default is not None, scaling(f)) for i, f in enumerate(numeric)
        ]
        self._lower, self._upper = bounds(numeric)
        self._defaults = {f.name: f.default for f in numeric if f.default is not None}
        #: Columns that hold their default all along.
        self._defaulted: set[str] = set()
        self._views: dict[int, View] = {}
        self.count = 0
        self.ids: tuple[str, ...] = ()
        #: The last ids that were texts: most cycles have those of the cycle before.
        self._names: list[str] = []
        self._kept_ids: tuple[str, ...] = ()

    def fill(self, raw: object, faults: list[Fault]) -> None:
        """Take a signal in; whatever is wrong with it is added to the faults."""
        before = len(faults)
        data = self._records(raw, faults) if self.many and type(raw) in (list, tuple) else raw
        if type(data) is not dict:
            if len(faults) == before:
                faults.append(fault("missing" if raw is None else "wrong_type", self.name))
            return
        lengths: dict[str, int] = {}
        n = -1
        agree = True
        left_out = []
        for name, row, optional, scale in self._fields:
            column = data.get(name, _ABSENT)
            if type(column) is not np.ndarray or column.dtype is not _FLOAT or column.ndim != 1:
                if column is _ABSENT and optional:
                    left_out.append((name, row))
                    continue
                column = self._converted(name, column, faults)
                if column is None:
                    continue
            m = len(column)
            lengths[name] = m
            if m != n:
                if n >= 0:
                    agree = False
                    continue
                n = m
                if n > self.capacity:
                    faults.append(self._over(name, n))
                    return
            row[:n] = column if scale is None else _scaled(column, *scale)
            if optional:
                self._defaulted.discard(name)
        for name in self._flags:
            flags = self._booleans(name, data.get(name, _ABSENT), faults)
            if flags is not None:
                lengths[name] = len(flags)
                agree = agree and n in (-1, len(flags))
                n = len(flags) if n < 0 else n
                if len(flags) <= self.capacity:
                    self._flag_rows[name][: len(flags)] = flags
        if self.many:
            self.take_ids(data.get("id", _ABSENT), lengths, faults)
            agree = agree and len(set(lengths.values())) < 2
            n = lengths.get("id", 0) if n < 0 else n
        if not agree:
            faults += self._unequal(lengths)
        if len(faults) > before:
            return
        for name, row in left_out:
            if name not in self._defaulted:
                row[:] = self._defaults[name]
                self._defaulted.add(name)
        if n < self.least:
            field = next(iter(lengths), "")
            faults.append(
                fault("too_short", self.name, field, None, f"{n} samples, at least {self.least} are needed")
            )
            return
        self.count = n
        if n:
            self._check(faults)

    def view(self) -> View:
        """The columns as they are now; the arrays are this block's own memory."""
        view = self._views.get(self.count)
        if view is None:
            n = self.count
            matrix = self._matrix[:, :n]
            columns: dict[str, Any] = {name: row[:n] for name, row, _, _ in self._fields}
            columns |= {name: row[:n] for name, row in self._flag_rows.items()}
            steps = [
                (f.name, matrix[i, 1:], matrix[i, :-1]) for i, f in enumerate(self._kinds) if f.increasing
            ]
            masks = np.zeros((2, *matrix.shape), dtype=bool)
            view = self._views[n] = View(columns, matrix, masks[0], masks[1], steps)
        return view

    def _check(self, faults: list[Fault]) -> None:
        """Ranges and order of all columns. A comparison with NaN does not hold, so NaN is in no range."""
        view = self.view()
        np.greater_equal(view.matrix, self._lower, out=view.low)
        np.less_equal(view.matrix, self._upper, out=view.high)
        if b"\0" in view.low.tobytes() or b"\0" in view.high.tobytes():
            for kind, row, fine in zip(self._kinds, view.matrix, view.low & view.high):
                if not fine.all():
                    faults += out_of_bounds(self.name, kind, row)
        for name, after, before in view.steps:
            fine = after > before
            if b"\0" in fine.tobytes():
                index = int(np.flatnonzero(~fine)[0])
                message = f"{after[index]!r} follows {before[index]!r}"
                faults.append(fault("not_increasing", self.name, name, index + 1, message))

    # What is not simply an array of numbers ---------------------------------------------------------------------

    def _converted(self, name: str, column: object, faults: list[Fault]) -> Floats | None:
        if column is _ABSENT or column is None:
            faults.append(fault("missing", self.name, name))
            return None
        result = numbers(column)
        if isinstance(result, int):
            index = None if result < 0 else result
            faults.append(fault("wrong_type", self.name, name, index, "not a column of numbers"))
            return None
        return result

    def _booleans(self, name: str, column: Any, faults: list[Fault]) -> list[bool] | None:
        if column is _ABSENT or column is None:
            faults.append(fault("missing", self.name, name))
            return None
        values = column.tolist() if type(column) is np.ndarray else column
        if type(values) not in (list, tuple):
            faults.append(fault("wrong_type", self.name, name, None, "not a column of true and false"))
            return None
        for index, value in enumerate(values):
            if type(value) is not bool:
                kind = "not_finite" if value is None else "wrong_type"
                faults.append(fault(kind, self.name, name, index, "neither true nor false"))
                return None
        return list(values)

    def _records(self, raw: Any, faults: list[Fault]) -> dict[str, list[Any]] | None:
        """Records as columns; None where one lacks a field or is none."""
        if len(raw) > self.capacity:
            faults.append(self._over("", len(raw)))
            return None
        for index, record in enumerate(raw):
            if type(record) is not dict:
                faults.append(fault("wrong_type", self.name, "", index, "not a record"))
                return None
        columns = {}
        for kind in (*self.names, *self._flags):
            default = self._defaults.get(kind)
            if default is not None:
                default = from_si(default, next(f.unit for f in self._kinds if f.name == kind))
            column = [record.get(kind, _ABSENT if default is None else default) for record in raw]
            if _ABSENT in column:
                faults.append(fault("missing", self.name, kind, column.index(_ABSENT)))
            columns[kind] = column
        columns["id"] = [str(i) if r.get("id") is None else r["id"] for i, r in enumerate(raw)]
        return None if any(_ABSENT in column for column in columns.values()) else columns

    def take_ids(self, column: Any, lengths: dict[str, int], faults: list[Fault]) -> None:
        """The ids of a set's elements; without any, they are counted. Adds their number to the lengths."""
        if type(column) is list and column == self._names:
            self.ids = self._kept_ids
            lengths["id"] = len(column)
            return
        if type(column) is np.ndarray:
            column = column.tolist()
        if column is _ABSENT or column is None:
            self.ids = tuple(map(str, range(max(lengths.values(), default=0))))
            return
        if type(column) not in (list, tuple):
            faults.append(fault("wrong_type", self.name, "id", None, "not a list of ids"))
            return
        seen = set()
        for index, name in enumerate(column):
            if type(name) not in (str, int, float) or (type(name) is int and abs(name) >= 2**63):
                faults.append(fault("wrong_type", self.name, "id", index, "neither a text nor a number"))
                return
            if str(name) in seen:
                faults.append(fault("duplicate", self.name, "id", index, f"`{str(name)[:40]}` stands twice"))
                return
            seen.add(str(name))
        self.ids = tuple(map(str, column))
        lengths["id"] = len(self.ids)
        if all(type(name) is str for name in column):  # what equals texts is texts
            self._names, self._kept_ids = list(column), self.ids

    def _unequal(self, lengths: dict[str, int]) -> list[Fault]:
        """Columns whose length is not that of most."""
        usual = Counter(lengths.values()).most_common(1)[0][0]
        return [
            self._over(name, length)
            if length > self.capacity
            else fault("wrong_length", self.name, name, min(length, usual), f"{length} entries, {usual} elsewhere")
            for name, length in lengths.items()
            if length != usual
        ]  # fmt: skip

    def _over(self, field: str, n: int) -> Fault:
        return fault("over_capacity", self.name, field, self.capacity, f"{n}, the most is {self.capacity}")


def numbers(column: Any) -> Floats | int:
    """A one-dimensional array of floats; else the index of what is no number, -1 where it is the whole.

    None is NaN. Numbers beyond the range of floats are infinite.
    """
    if type(column) is np.ndarray:
        if column.ndim != 1:
            return -1
        if column.dtype.kind in "iuf":
            with np.errstate(all="ignore"):
                floats: Floats = column.astype(np.float64)
            return floats
        column = column.tolist()
    if type(column) not in (list, tuple):
        return -1
    if not set(map(type, column)) <= _NUMBERS:
        column = [number(value) for value in column]
        if None in column:
            return int(column.index(None))
    try:
        return np.array(column, dtype=np.float64)
    except OverflowError:
        return np.array([number(value) for value in column], dtype=np.float64)


def number(value: object) -> float | None:
    """A number as a float, None as NaN; the result None for what is no number."""
    if type(value) is float:
        return value
    if value is None:
        return math.nan
    if type(value) is not int and not isinstance(value, np.integer | np.floating):
        return None
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def bounds(kinds: list[FieldType]) -> tuple[Floats, Floats]:
    """(fields, 1) lower and upper bounds in SI; what is not bounded has to be finite all the same."""
    most = sys.float_info.max
    lower = [-most if kind.lower is None else kind.lower for kind in kinds]
    upper = [most if kind.upper is None else kind.upper for kind in kinds]
    return np.array(lower).reshape(-1, 1), np.array(upper).reshape(-1, 1)


def scaling(kind: FieldType) -> tuple[float, float] | None:
    """Multiplier and divisor of a field's unit; None where it is SI."""
    up, down, _ = parse_unit(kind.unit)
    return None if (up, down) == (1.0, 1.0) else (up, down)


def _scaled(column: Floats, up: float, down: float) -> Floats:
    with np.errstate(all="ignore"):  # what becomes infinite is a fault
        return column * up / down


def out_of_bounds(signal: str, kind: FieldType, values: Floats) -> list[Fault]:
    """What is wrong with the values, in SI, of one field: the first that is not finite, the first outside its range."""
    found = []
    finite = np.isfinite(values)
    if not finite.all():
        bad = np.flatnonzero(~finite)
        found.append(
            fault("not_finite", signal, kind.name, int(bad[0]), _also(f"{values[bad[0]]}", len(bad)))
        )
    low = -math.inf if kind.lower is None else kind.lower
    high = math.inf if kind.upper is None else kind.upper
    bad = np.flatnonzero(finite & ~((values >= low) & (values <= high)))
    if len(bad):
        message = f"{values[bad[0]]} is outside [{low:g}, {high:g}] in SI units"
        found.append(fault("out_of_range", signal, kind.name, int(bad[0]), _also(message, len(bad))))
    return found


def _also(message: str, count: int) -> str:
    return message if count == 1 else f"{message}, and {count - 1} more"
