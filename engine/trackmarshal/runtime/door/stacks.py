"""What most cases are made of, plain floats under names that are declared, of many cases at once: one array for a signal.

Numbers are copied when a case is read, and become an array when all cases are: what a caller does to its objects meanwhile is of
no account. Anything else is left to the signal's reader, which says what is wrong with it, if anything is.
"""

from __future__ import annotations

import marshal
from collections.abc import Iterable, Iterator, Sequence, Set
from typing import Any, NamedTuple

import numpy as np

from trackmarshal.runtime.contract import RECORD, SET, TIMELINE
from trackmarshal.runtime.door.columns import ColumnsReader, Layout
from trackmarshal.runtime.door.values import Floats
from trackmarshal.runtime.frame import Columns

#: How Python's own serialisation puts a float: a byte that says so, and the number; and what it puts before the items of a list or
#: tuple. Its version 2 has no references.
_FLOAT = np.dtype([("type", "u1"), ("value", "<f8")])
_VERSION, _MARK, _HEAD = 2, b"g", 5
_FLOATS = {float, np.float64}
_LISTS, _ARRAYS, _DICTS, _TEXTS = {list}, {np.ndarray}, {dict}, {str}
#: Sets of names that are remembered; data whose names differ again and again is read all the same.
_KEPT = 64


def floats(rows: list[Any] | tuple[Any, ...], count: int) -> bytes | None:
    """Lists or tuples of `count` values that are all Python's floats as bytes, for `numbers`; None where one is anything else.

    No pass over the values is in Python, and none counts references to them: they lie all over the memory.
    """
    try:
        data = marshal.dumps(rows, _VERSION)
    except ValueError:  # something that cannot be put
        return None
    size, marks, head = _FLOAT.itemsize, _MARK * count, count.to_bytes(_HEAD - 1, "little")
    length = _HEAD + size * count
    if len(data) != _HEAD + length * len(rows):
        return None
    for first in range(2 * _HEAD, len(data) + 1, length):
        # A row that is as long as it should be, of which each item begins where a float would: so the next row does too.
        if data[first - len(head) : first] != head or data[first : first + size * count : size] != marks:
            return None
    return data[_HEAD:]


def numbers(data: Sequence[bytes], count: int) -> Floats:
    """(.., count): the numbers of `floats`, those of many calls one after the other."""
    row = np.dtype([("head", "V", _HEAD), ("values", _FLOAT, (count,))])
    found: Floats = np.frombuffer(b"".join(data), row)["values"]["value"]
    return found


class Stack(NamedTuple):
    """Cases, by place, whose numbers of a signal are one array, (cases, numbers, count); and their columns, which are parts of it."""

    values: Floats
    places: Sequence[int]
    columns: Sequence[Columns]


class _Alike(NamedTuple):
    """Cases whose data is alike. order: how their numbers stand in it: by column, by element, in arrays, in a record, or nowhere.

    data, ids, places: of each case its numbers, what its elements are called, and its place.
    """

    layout: Layout
    order: str
    size: int
    data: list[Any]
    ids: list[tuple[str, ...]]
    places: list[int]


#: A layout, how numbers stand, how many in a column, the numbers, and ids: see `_Alike`.
_Copied = tuple[Layout, str, int, Any, tuple[str, ...]]


class Stacks:
    """The numbers of one signal of many cases. spare: names that it may have besides those of the spec, which say nothing."""

    def __init__(self, reader: ColumnsReader, spare: Set[str] = frozenset()) -> None:
        self._reader = reader
        self._spare = spare - reader.known
        self._form = reader.signal.form
        self._fits = bool(reader.names.numbers) and not reader.names.flags
        #: By whether the names are those of each element, and by names.
        self._layouts: dict[tuple[Any, ...], Layout | None] = {}
        self._empty = reader.layout(reader.names.numbers, False) if self._fits else None
        self._last_ids: list[Any] = []
        self._ids: tuple[str, ...] = ()
        self._waiting: dict[tuple[int, str, int], _Alike] = {}

    def clear(self) -> None:
        """Forget all cases."""
        self._waiting.clear()

    def take(self, raw: Any, place: int) -> bool:
        """Copy the numbers of a case; whether nothing in it takes a closer look."""
        if not self._fits:
            return False
        try:
            copied = self._copied(raw)
        except Exception:  # whatever it is, a closer look says what is wrong with it
            return False
        if copied is None:
            return False
        layout, order, size, data, ids = copied
        key = id(layout), order, size
        alike = self._waiting.get(key)
        if alike is None:
            alike = self._waiting[key] = _Alike(layout, order, size, [], [], [])
        alike.data.append(data)
        alike.ids.append(ids)
        alike.places.append(place)
        return True

    def finish(self) -> Iterator[Stack]:
        """The cases that were taken, and forget them."""
        names = self._reader.names
        for alike in self._waiting.values():
            stack = self._stacked(alike)
            stack.flags.writeable = False
            absent, columns = alike.layout.absent, []
            for index, (values, ids) in enumerate(zip(stack, alike.ids)):
                made = Columns(names, values, None, ids)
                made.absent = absent
                made.stack, made.row = stack, index
                columns.append(made)
            yield Stack(stack, alike.places, columns)
        self._waiting = {}

    # Copies ---------------------------------------------------------------------------------------------------------

    def _copied(self, raw: Any) -> _Copied | None:
        if type(raw) is dict:
            layout = self._layout(False, raw)
            if layout is None:
                return None
            return self._record(raw, layout) if self._form == RECORD else self._columns(raw, layout)
        return self._elements(raw) if type(raw) is list and self._form == SET else None

    def _record(self, raw: dict[Any, Any], layout: Layout) -> _Copied | None:
        found = layout.pick(raw)
        return (layout, "record", 1, found, ()) if _FLOATS.issuperset(map(type, found)) else None

    def _columns(self, raw: dict[Any, Any], layout: Layout) -> _Copied | None:
        found = layout.pick(raw)
        (count,) = set(map(len, raw.values()))
        if not count and self._form == TIMELINE:
            return None
        kinds = set(map(type, found))
        ids = self._ids_of(raw.get("id"), count)
        if ids is None:
            return None
        if kinds == _LISTS:
            data = floats(found, count)
            return None if data is None else (layout, "columns", count, data, ids)
        if kinds != _ARRAYS:
            return None
        joined = np.concatenate(found, casting="no", dtype=np.float64)
        return (layout, "arrays", count, joined, ids) if joined.ndim == 1 else None

    def _elements(self, raw: list[Any]) -> _Copied | None:
        if not raw:
            return None if self._empty is None else (self._empty, "nothing", 0, None, ())
        if set(map(type, raw)) != _DICTS:
            return None
        names = tuple(raw[0])
        layout = self._layout(True, names)
        if layout is None or any(tuple(one) != names for one in raw):
            return None
        ids = self._ids_of([one["id"] for one in raw] if "id" in names else None, len(raw))
        data = floats([layout.pick(one) for one in raw], layout.width)
        return None if ids is None or data is None else (layout, "elements", len(raw), data, ids)

    def _ids_of(self, given: Any, count: int) -> tuple[str, ...] | None:
        """What elements are called; None where something may be wrong with that."""
        if self._form != SET:
            return ()
        if given is None:
            return None if self._reader.signal.named and count else tuple(map(str, range(count)))
        if type(given) is not list or not _TEXTS.issuperset(map(type, given)):
            return None
        if given != self._last_ids:
            if len(set(given)) < len(given):
                return None
            self._last_ids, self._ids = list(given), tuple(given)
        return self._ids

    def _layout(self, each: bool, names: Iterable[Any]) -> Layout | None:
        """What data of these names says; None where something is wrong with them. each: they are those of each element."""
        key = (each, *names)
        try:
            return self._layouts[key]
        except KeyError:
            if len(self._layouts) >= _KEPT:
                self._layouts.clear()
            known = [name for name in key[1:] if name not in self._spare]
            made = self._layouts[key] = self._reader.layout(known, each)
            return made

    # Arrays ---------------------------------------------------------------------------------------------------------

    def _stacked(self, alike: _Alike) -> Floats:
        """(cases, numbers, count), in SI, of cases that are alike."""
        layout, order, size, data = alike[:4]
        cases, width = len(data), layout.width
        values: Floats
        match order:
            case "nothing":
                values = np.empty((cases, width, 0))
            case "columns":
                values = numbers(data, size).reshape(cases, width, size)
            case "elements":
                values = numbers(data, width).reshape(cases, size, width).transpose(0, 2, 1)
            case "arrays" | "record":
                values = np.array(data).reshape(cases, width, size)
            case _:
                raise AssertionError(f"numbers do not stand in {order}")
        if layout.rows is None:
            stack = np.array(values)
        else:
            stack = np.empty((cases, len(self._reader.names.numbers), size))
            stack[:, layout.rows] = values
            for row, value in layout.fills:
                stack[:, row] = value
        if layout.scaled:
            with np.errstate(all="ignore"):  # what becomes infinite is a fault
                for row, up, down in layout.scaled:
                    stack[:, row] = stack[:, row] * up / down
        return stack
