"""Readers of signals that are columns: timelines, sets and records become `Columns` of a frame, in SI."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from itertools import chain
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.runtime.contract import RECORD, SET, TIMELINE, Signal
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.values import Floats, WrongTypeError
from trackmarshal.runtime.faults import Fault, fault
from trackmarshal.runtime.frame import Columns, Names
from trackmarshal.units import from_si, parse_unit

_ARRAYS, _LISTS = {np.ndarray}, {list}
_FLOATS = {float, np.float64}


class ColumnsReader:
    """Reads one signal, or one candidate, whose faults carry its `label`.

    spelt: data comes from JSON, which spells numbers that are not finite. What is wrong with the structure (a type, something that is
    missing, columns that differ in length) is a fault; the frame then has NaN in place of what cannot be read.
    """

    def __init__(self, signal: Signal, label: str = "", spelt: bool = False) -> None:
        self.signal = signal
        self.label = label or signal.name
        self._spelt = spelt
        self._numbers = signal.numbers
        self._flags = [field.name for field in signal.flags]
        self.names = Names([field.name for field in signal.numbers], self._flags)
        self._known = signal.declared | ({"id"} if signal.form == SET else set())
        self._scaled = [
            (row, *parse_unit(field.unit)[:2])
            for row, field in enumerate(self._numbers)
            if parse_unit(field.unit)[:2] != (1.0, 1.0)
        ]
        self._spared = {f.name for f in signal.fields_ if not f.needed}
        self._defaults = {f.name: f.default for f in signal.fields_ if f.default is not None}
        #: Whether there is nothing but numbers, of which all are in SI: then they can be taken as they come.
        self._plain = len(self._numbers) > 1 and not self._flags and not self._scaled
        self._pick: Callable[[Any], Any] = itemgetter(*self.names.numbers or ("",))
        self._last_ids: list[Any] = []
        self._ids: tuple[str, ...] = ()

    def read(self, raw: Any, faults: list[Fault]) -> Columns:
        """The signal's columns; what is wrong with their structure is added to the faults."""
        if self._plain and type(raw) is dict and raw.keys() <= self._known:
            found = self._record(raw) if self.signal.form == RECORD else self._quickly(raw)
            if found is not None:
                return found
        before = len(faults)
        try:
            return self._closely(raw, faults)
        except WrongTypeError as error:
            del faults[before:]
            faults.append(fault(error.name, self.label, "", error.index, error.message))
        except Exception:  # what was handed in has a say in how it is read
            del faults[before:]
            faults.append(fault("wrong_type", self.label, "", None, "it cannot be read"))
        return self.nothing()

    def nothing(self) -> Columns:
        """One entry of nothing: whatever reads it is undefined."""
        return self._columns(
            np.full((len(self._numbers), 1), np.nan), np.full((len(self._flags), 1), -1, np.int8), ("?",)
        )

    def _columns(self, numbers: Floats, flags: NDArray[np.int8] | None, ids: tuple[str, ...]) -> Columns:
        return Columns(
            self.names, numbers, flags if self._flags else None, ids if self.signal.form == SET else ()
        )

    # What almost all cycles are made of -------------------------------------------------------------------------

    def _quickly(self, raw: dict[str, Any]) -> Columns | None:
        """Columns that are all arrays of float64, or lists of floats; None for anything that takes a closer look."""
        ids: Any = None
        try:
            columns = self._pick(raw)
            kinds = set(map(type, columns))
            lengths = set(map(len, raw.values()))
            if len(lengths) != 1:
                return None
            if "id" in raw and self.signal.form == SET:
                ids = raw["id"]
                if type(ids) is not list or ids != self._last_ids:
                    return None
            if kinds == _ARRAYS:
                flat = np.concatenate(columns, casting="no", dtype=np.float64)
                if flat.ndim != 1:
                    return None
            elif kinds == _LISTS:
                listed = list(chain.from_iterable(columns))
                if not {float}.issuperset(map(type, listed)):
                    return None
                flat = np.array(listed)
            else:
                return None
        except (KeyError, TypeError, ValueError):
            return None
        (count,) = lengths
        if not count and self.signal.form == TIMELINE:
            return None
        made = flat.reshape(len(columns), count)
        return Columns(self.names, made, None, self._ids if ids is not None else self._counted(count))

    def _record(self, raw: dict[str, Any]) -> Columns | None:
        try:
            found = self._pick(raw)
        except KeyError:
            return None
        if not _FLOATS.issuperset(map(type, found)):
            return None
        return Columns(self.names, np.array(found).reshape(-1, 1))

    def _counted(self, count: int) -> tuple[str, ...]:
        return tuple(map(str, range(count))) if self.signal.form == SET else ()

    # Everything else ----------------------------------------------------------------------------------------------

    def _closely(self, raw: Any, faults: list[Fault]) -> Columns:
        if raw is None:
            faults.append(fault("missing", self.label, "", None, "it is not there"))
            return self.nothing()
        given = (
            self._records(raw, faults) if self.signal.form == SET and isinstance(raw, list | tuple) else None
        )
        data = values.mapping(raw) if given is None else given
        self._refuse_unknown(data, faults)
        if self.signal.form == RECORD:
            data = {key: [value] for key, value in data.items()}
        read: dict[str, NDArray[Any]] = {}
        for name in (*self.names.numbers, *self._flags):
            column = data.get(name)
            if name in self._flags:
                read |= self._one(name, column, faults, values.flags)
            elif name in data or name not in self._defaults:
                read |= self._one(name, column, faults, lambda c: values.numbers(c, self._spelt))
        ids = self._read_ids(data.get("id"), faults) if self.signal.form == SET else None
        lengths = self._lengths(data, read, ids)
        count = self._agree(lengths, faults) if lengths or self.signal.form == SET else 1
        if not count and self.signal.form == TIMELINE:
            faults.append(fault("too_short", self.label, "", None, "0 entries"))
            count = 1  # of nothing: whatever reads a sample is undefined
        rows = [self._row(name, read.get(name), count, data) for name in self.names.numbers]
        numbers = np.array(rows, dtype=np.float64).reshape(len(rows), count)
        with np.errstate(all="ignore"):  # what becomes infinite is a fault
            for row, up, down in self._scaled:
                if self.names.numbers[row] in read:  # a default is in SI
                    numbers[row] = numbers[row] * up / down
        marks = np.full((len(self._flags), count), -1, dtype=np.int8)
        for row, name in enumerate(self._flags):
            if name in read:
                own = read[name][:count]
                marks[row, : len(own)] = own
        made = self._columns(
            numbers, marks, self._counted(count) if ids is None else (*ids, *["?"] * count)[:count]
        )
        made.absent = frozenset(self._spared - read.keys())
        return made

    def _row(self, name: str, column: NDArray[Any] | None, count: int, data: dict[Any, Any]) -> Any:
        if column is None:  # a null is a missing value, not the wish for a default
            missing = name in data or name not in self._defaults
            return np.full(count, np.nan if missing else self._defaults[name])
        return (
            column[:count]
            if len(column) >= count
            else np.append(column, np.full(count - len(column), np.nan))
        )

    def _one(self, name: str, column: Any, faults: list[Fault], read: Callable[[Any], Any]) -> dict[str, Any]:
        """A column by its name, unless it is missing or of the wrong type."""
        record = self.signal.form == RECORD
        if column is None:
            if name not in self._spared:
                faults.append(fault("missing", self.label, name, None, "it is not there"))
            return {}
        if record and column[0] is None and name in self._flags:
            faults.append(fault("missing", self.label, name, None, "it is not there"))
            return {}
        try:
            return {name: read(column)}
        except WrongTypeError as error:
            at = None if record else error.index
            faults.append(fault("wrong_type", self.label, name, at, error.message))
        return {}

    def _read_ids(self, column: Any, faults: list[Fault]) -> tuple[str, ...] | None:
        if column is None:
            return None
        if type(column) is list and column == self._last_ids and all(type(name) is str for name in column):
            return self._ids
        try:
            found = values.ids(column)
        except WrongTypeError as error:
            faults.append(fault(error.name, self.label, "id", error.index, error.message))
            return None
        if type(column) is list and all(type(name) is str for name in column):  # what equals texts is texts
            self._last_ids, self._ids = list(column), found
        return found

    def _lengths(
        self, data: dict[Any, Any], read: dict[str, Any], ids: tuple[str, ...] | None
    ) -> dict[str, int]:
        """Of all columns that are there, also of those that no rule reads: where one is longer, samples of others are missing."""
        lengths = {name: len(column) for name, column in read.items()}
        if ids is not None:
            lengths["id"] = len(ids)
        if self.signal.form != RECORD:
            for name in self.signal.declared - self.names.rows.keys():
                column = data.get(name)
                if isinstance(column, list | tuple | np.ndarray) and getattr(column, "ndim", 1) == 1:
                    lengths[name] = len(column)
        return lengths

    def _agree(self, lengths: dict[str, int], faults: list[Fault]) -> int:
        """The length that all columns have; where they differ, that of the shortest, with a fault for each that is not as most are."""
        if not lengths:
            return 0
        usual = Counter(lengths.values()).most_common(1)[0][0]
        for name, length in lengths.items():
            if length != usual:
                message = f"{length} entries, {usual} elsewhere"
                faults.append(fault("wrong_length", self.label, name, min(length, usual), message))
        return min(lengths.values())

    def _records(self, raw: Any, faults: list[Fault]) -> dict[str, Any] | None:
        """A list of records as columns."""
        records = []
        for index, one in enumerate(values.entries(raw)):
            try:
                records.append(values.mapping(one))
            except WrongTypeError as error:
                raise WrongTypeError(error.message, index) from error
        columns: dict[str, Any] = {}
        for name in self._known & set().union(*records) if records else ():
            default = self._defaults.get(name)
            if default is not None and not any(name in record for record in records):
                continue
            if default is not None:
                field = next(f for f in self._numbers if f.name == name)
                default = from_si(default, field.unit)
            columns[name] = [record.get(name, default) for record in records]
        for record in records:
            self._refuse_unknown(record, faults)
        for name in (*self.names.numbers, *self._flags):
            if name not in self._defaults:
                at = next((i for i, record in enumerate(records) if name not in record), None)
                if at is not None:
                    faults.append(fault("missing", self.label, name, at, "it is not there"))
                columns.setdefault(name, [None] * len(records))
        named = columns.get("id")
        if named is not None:
            columns["id"] = [str(i) if name is None else name for i, name in enumerate(named)]
        elif not columns:
            columns["id"] = [str(i) for i in range(len(records))]
        return columns

    def _refuse_unknown(self, data: dict[Any, Any], faults: list[Fault]) -> None:
        for key in data.keys() - self._known:
            faults.append(unknown(self.label, key, self._known))


def unknown(label: str, key: object, known: Any) -> Fault:
    """The fault of a key that nothing declares."""
    shown = key if type(key) is str else values.worded(key)
    hint = close_matches(str(shown)[:40], sorted(known)) if type(key) is str else None
    message = f"nothing declares `{shown:.40}`" + (f"; {hint}" if hint else "")
    return fault("unknown", label, shown[:40] if type(key) is str else "", None, message)
