"""Readers of signals that are columns: timelines, sets and records become `Columns` of a frame, in SI."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Sequence
from functools import partial
from itertools import chain
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.contract import RECORD, SET, TIMELINE, Signal
from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.unknown import refuse_unknown
from trackmarshal.runtime.door.values import Floats, WrongTypeError
from trackmarshal.runtime.door.wording import no_member
from trackmarshal.runtime.faults import Fault, fault
from trackmarshal.runtime.frame import Columns, Names
from trackmarshal.units import LENGTH, is_si, parse_unit

Ints = NDArray[np.intp]

_ARRAYS, _LISTS = {np.ndarray}, {list}
#: What is said of elements without ids that rules over the run ask about.
NAMELESS = "it is not there: rules know elements again by their ids"
_FLOATS = {float, np.float64}


class Layout(NamedTuple):
    """What data of certain names, all of them declared, says of a signal.

    pick: the numbers that are there, in order, of a dict; width: how many; rows: which those are, None for all; fills: the others with what stands for them, in SI;
    scaled: rows that are there with the numbers that bring them to SI, up and down; absent: see `Columns`.
    """

    pick: Callable[[dict[Any, Any]], tuple[Any, ...]]
    width: int
    rows: slice | Ints | None
    fills: list[tuple[int, float]]
    scaled: list[tuple[int, float, float]]
    absent: frozenset[str]


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
        self.known = signal.declared | ({"id"} if signal.form == SET else set())
        # Sets are asked in the order of names: what is said of a signal is the same in every process.
        self._listed = sorted(self.known)
        self._unread = sorted(signal.declared - self.names.rows.keys())
        self._scaled = [
            (row, *parse_unit(field.unit)[:2])
            for row, field in enumerate(self._numbers)
            if not is_si(field.unit)
        ]
        #: The units of lengths, in m.
        self._metres = {
            field.name: up / down
            for field in self._numbers
            for up, down, dimension in (parse_unit(field.unit),)
            if dimension == LENGTH
        }
        self._spared = {f.name for f in signal.fields_ if not f.needed}
        self._members = {f.name: f.members for f in self._numbers if f.members}
        self._defaults = {f.name: f.default for f in signal.fields_ if f.default is not None}
        #: Whether there is nothing but numbers, of which all are in SI: then they can be taken as they come.
        self.plain = len(self._numbers) > 1 and not self._flags and not self._scaled
        self._pick: Callable[[Any], Any] = itemgetter(*self.names.numbers or ("",))
        #: Columns of defaults, of the length that they had last.
        self._kept: dict[tuple[str, int], Floats] = {}
        self._last_ids: list[Any] = []
        self._ids: tuple[str, ...] = ()

    def read(self, raw: Any, faults: list[Fault]) -> Columns:
        """The signal's columns; what is wrong with their structure is added to the faults."""
        before = len(faults)
        if self.plain and type(raw) is dict:
            try:
                found = self._record(raw, faults) if self.signal.form == RECORD else self._quickly(raw)
            except Exception:  # whatever it is, a closer look says what is wrong with it
                del faults[before:]
                found = None
            if found is not None:
                return found
        elif self.plain and type(raw) is list and self.signal.form == SET:
            try:
                found = self._elements(raw)
            except Exception:  # the same
                found = None
            if found is not None:
                return found
        try:
            return self._closely(raw, faults)
        except WrongTypeError as error:
            del faults[before:]
            faults.append(fault(error.name, self.label, "", error.index, error.message))
        except Exception:  # what was handed in has a say in how it is read
            del faults[before:]
            faults.append(fault("wrong_type", self.label, "", None, "it cannot be read"))
        return self.nothing()

    def picked(self, raw: dict[str, Any], count: int) -> Sequence[Any]:
        """What stands for each number of the signal: what is given, or its default; raises KeyError for one that is missing."""
        try:
            found: Sequence[Any] = self._pick(raw)
            return found
        except KeyError:
            return [raw[name] if name in raw else self._default(name, count) for name in self.names.numbers]

    def _default(self, name: str, count: int) -> Any:
        value = self._defaults[name]
        if self.signal.form == RECORD:
            return value
        kept = self._kept.get((name, count))
        if kept is None:
            self._kept.clear()
            kept = self._kept[name, count] = np.full(count, value)
        return kept

    def ids_of(self, raw: dict[str, Any], count: int) -> tuple[str, ...] | None:
        """The ids of a set's elements where they are those of the last time, or where none are given; None for others."""
        if self.signal.form != SET:
            return ()
        if "id" not in raw:
            return None if self.signal.named else self._counted(count)
        ids = raw["id"]
        fits = type(ids) is list and {str}.issuperset(map(type, ids)) and ids == self._last_ids
        return self._ids if fits else None

    @property
    def known_ids(self) -> tuple[str, ...]:
        """Those of the last time that a set's ids were a list of texts; none of anything else."""
        return self._ids

    def layout(self, names: Sequence[Any], each: bool) -> Layout | None:
        """What data of these names says, if its values are as they should be; None where a name is wrong, or a number missing.

        each: they are the names of each element of a set.
        """
        there = [name for name in self.names.numbers if name in names]
        others = [name for name in self.names.numbers if name not in names]
        left_out = self._defaults.keys() if each else self._defaults.keys() | self._spared
        if not there or not self.known.issuperset(names) or not left_out >= set(others):
            return None
        (first, *more), rows = there, self.names.rows
        return Layout(
            itemgetter(*there) if more else lambda data: (data[first],),
            len(there),
            None if not others else rows_of([rows[name] for name in there]),
            [(rows[name], self._defaults.get(name, math.nan)) for name in others],
            [one for one in self._scaled if self.names.numbers[one[0]] in there],
            frozenset(name for name in others if name not in self._defaults),
        )

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
        """Columns that are all arrays of float64, or lists of floats; None, or an error, for anything that takes a closer look."""
        if not raw.keys() <= self.known:
            return None
        columns = self._pick(raw)
        kinds = set(map(type, columns))
        lengths = set(map(len, raw.values()))
        if len(lengths) != 1:
            return None
        (count,) = lengths
        ids = self.ids_of(raw, count)
        if ids is None:
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
        if not count and self.signal.form == TIMELINE:
            return None
        return Columns(self.names, flat.reshape(len(columns), count), None, ids)

    def _record(self, raw: dict[str, Any], faults: list[Fault]) -> Columns | None:
        found = self._pick(raw)
        if not _FLOATS.issuperset(map(type, found)):
            return None
        refuse_unknown(self.label, [raw], self.known, faults)  # recordings have more than some rules read
        return Columns(self.names, np.array(found).reshape(-1, 1))

    def _elements(self, raw: list[Any]) -> Columns | None:
        """Columns of elements that are alike, and have all numbers."""
        width, names = len(self._numbers), tuple(raw[0]) if raw else self.names.numbers
        if not self.known.issuperset(names) or any(
            type(one) is not dict or tuple(one) != names for one in raw
        ):
            return None
        listed = list(chain.from_iterable(map(self._pick, raw)))
        if not {float}.issuperset(map(type, listed)):
            return None
        ids: tuple[str, ...] | None = self._counted(len(raw))
        if "id" in names:
            ids = self.ids_of({"id": [one["id"] for one in raw]}, len(raw))
        elif raw and self.signal.named:
            return None
        if ids is None:
            return None
        numbers = np.array(listed, dtype=np.float64).reshape(len(raw), width).T
        return Columns(self.names, np.ascontiguousarray(numbers), None, ids)

    def _counted(self, count: int) -> tuple[str, ...]:
        return tuple(map(str, range(count))) if self.signal.form == SET else ()

    # Everything else ----------------------------------------------------------------------------------------------

    def _closely(self, raw: Any, faults: list[Fault]) -> Columns:
        if raw is None:
            faults.append(fault("missing", self.label, "", None, "it is not there"))
            return self.nothing()
        left_out: dict[str, list[int]] = {}
        if self.signal.form == SET and values.is_a(raw, (list, tuple)):
            data, left_out = self._records(raw, faults)
        else:
            data = values.mapping(raw)
            refuse_unknown(self.label, [data], self.known, faults)
        if self.signal.form == RECORD:
            data = {key: [value] for key, value in data.items()}
        read: dict[str, NDArray[Any]] = {}
        for name in (*self.names.numbers, *self._flags):
            column = data.get(name)
            needed = name in data or name not in self._spared
            if name not in data and name in self._defaults:
                continue
            if name in self._flags:
                read |= self._one(name, column, needed, faults, values.flags)
            elif name in self._members:
                read |= self._one(name, column, needed, faults, partial(self._places, name, faults))
            else:
                read |= self._one(name, column, needed, faults, partial(self._measured, name))
        ids = self._read_ids(data.get("id"), faults) if self.signal.form == SET else None
        if ids is None and self.signal.named and data.get("id") is None and any(map(_some, data.values())):
            faults.append(fault("missing", self.label, "id", None, NAMELESS))
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
        for name, places in left_out.items():
            if name in self._flags:
                continue
            numbers[self.names.rows[name], [place for place in places if place < count]] = self._defaults[
                name
            ]
        marks = np.full((len(self._flags), count), -1, dtype=np.int8)
        for row, name in enumerate(self._flags):
            if name in read:
                own = read[name][:count]
                marks[row, : len(own)] = own
            elif name not in data and name in self._defaults:
                marks[row] = self._defaults[name]
            marks[row, [place for place in left_out.get(name, ()) if place < count]] = self._defaults.get(
                name, -1
            )
        made = self._columns(
            numbers, marks, self._counted(count) if ids is None else (*ids, *["?"] * count)[:count]
        )
        made.absent = frozenset(name for name in self._spared - read.keys() if name not in self._defaults)
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

    def _one(
        self, name: str, column: Any, needed: bool, faults: list[Fault], read: Callable[[Any], Any]
    ) -> dict[str, Any]:
        """A column by its name, unless it is missing or of the wrong type."""
        record = self.signal.form == RECORD
        if column is None:
            if needed:
                faults.append(fault("missing", self.label, name, None, "it is not there"))
            return {}
        try:
            return {name: read(column)}
        except WrongTypeError as error:
            at = None if record else error.index
            faults.append(fault("wrong_type", self.label, name, at, error.message))
        return {}

    def _measured(self, name: str, column: Any) -> Floats:
        """A column of numbers; raises WrongTypeError, for lengths also where short floats have rounded them."""
        found = values.numbers(column, self._spelt)
        if name in self._metres and (lost := values.rounded(column, self._metres[name])):
            raise WrongTypeError(lost)
        return found

    def _places(self, name: str, faults: list[Fault], column: Any) -> Floats:
        """The places of members; a name that is none of theirs is a fault, and nothing is known of it."""
        members = self._members[name]
        found, unknown = values.places(column, members, self._spelt)
        if unknown:
            faults.append(self.no_member(name, unknown, self.signal.form == RECORD))
        return found

    def no_member(self, name: str, unknown: Sequence[tuple[int, str]], record: bool) -> Fault:
        """What is said of entries of a column, by their places, that are names of no member."""
        index, said = unknown[0]
        more = f", and {len(unknown) - 1} more" if len(unknown) > 1 else ""
        message = no_member(said, self._members[name]) + more
        return fault("no_member", self.label, name, None if record else index, message)

    def no_members(self, name: str, column: Any) -> list[tuple[int, str]]:
        """The entries of a column, by their places, that are names of no member."""
        return values.places(column, self._members[name], self._spelt)[1]

    def _read_ids(self, column: Any, faults: list[Fault]) -> tuple[str, ...] | None:
        if column is None:
            return None
        texts = type(column) is list and {str}.issuperset(
            map(type, column)
        )  # what equals texts may be something else
        if texts and column == self._last_ids:
            return self._ids
        try:
            found = values.ids(column)
        except WrongTypeError as error:
            faults.append(fault(error.name, self.label, "id", error.index, error.message))
            return None
        if texts:
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
            for name in self._unread:
                column: Any = data.get(name)
                if values.is_a(column, (list, tuple, np.ndarray)) and getattr(column, "ndim", 1) == 1:
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

    def _records(self, raw: Any, faults: list[Fault]) -> tuple[dict[str, Any], dict[str, list[int]]]:
        """A list of records as columns, and which records leave a field to its default."""
        records = []
        for index, one in enumerate(values.entries(raw)):
            try:
                records.append(values.mapping(one))
            except WrongTypeError as error:
                raise WrongTypeError(error.message, index) from error
        refuse_unknown(self.label, records, self.known, faults, indexed=True)
        columns: dict[str, Any] = {}
        left_out: dict[str, list[int]] = {}
        for name in self._listed:
            lacking = [index for index, record in enumerate(records) if name not in record]
            if name in self._defaults:
                if len(lacking) == len(records):
                    continue
                left_out[name] = lacking if name in self.names.rows else []
                columns[name] = [record.get(name, name not in self._flags and 0.0) for record in records]
            elif len(lacking) < len(records):
                columns[name] = [record.get(name) for record in records]
            if lacking and name in self.names.rows and name not in self._defaults:
                more = f", and {len(lacking) - 1} more" if len(lacking) > 1 else ""
                faults.append(fault("missing", self.label, name, lacking[0], f"it is not there{more}"))
                columns.setdefault(name, [None] * len(records))
        named = columns.get("id")
        if self.signal.named and named is not None and None in named:
            del columns["id"]
        elif named is not None:
            columns["id"] = [str(i) if name is None else name for i, name in enumerate(named)]
        elif not columns and not self.signal.named:
            columns["id"] = [str(i) for i in range(len(records))]
        for name in (*self.names.numbers, *self._flags):
            if name not in self._defaults:
                columns.setdefault(name, [])  # of no records
        return columns, {name: places for name, places in left_out.items() if places}


def _some(column: Any) -> bool:
    """Whether a column has an entry, or is none."""
    try:
        return len(column) > 0
    except TypeError:
        return True


def rows_of(places: list[int]) -> slice | Ints:
    """Rows of an array, in the way that is read fastest."""
    first, last = places[0], places[-1]
    return slice(first, last + 1) if last - first == len(places) - 1 else np.array(places)
