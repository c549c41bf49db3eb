"""Numeric columns of cases that are read together, as arrays: checked in a few operations, and kept for evaluation."""

from __future__ import annotations

import marshal
import operator
from collections.abc import Mapping, Sequence
from itertools import accumulate, chain, islice
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from trackmarshal.runtime.cases import Field

Floats = NDArray[np.float64]
#: How Python's own serialisation puts a float: a byte that says so, and the number. Its version 2 has no references.
_FLOAT = np.dtype([("type", "u1"), ("value", "<f8")])
_VERSION, _MARK, _HEAD = 2, ord("g"), 5


def floats(values: list[object]) -> Floats | None:
    """An array of values that are all Python floats and nothing else; else None. Two passes, neither in Python."""
    try:
        data = marshal.dumps(values, _VERSION)
    except ValueError:  # something that cannot be put
        return None
    if len(data) != _HEAD + _FLOAT.itemsize * len(values):
        return None
    records = np.frombuffer(data, _FLOAT, offset=_HEAD)
    if not (records["type"] == _MARK).all():
        return None
    return np.ascontiguousarray(records["value"])


class Together:
    """Columns of cases that were read together, by signal and field, one for each case, and all their values in one array.

    Columns are tuples: whoever holds the same one knows that nothing in it has changed.
    """

    __slots__ = ("_places", "_values")

    def __init__(self, values: Floats, places: Mapping[tuple[str, str], tuple[Sequence[Any], int]]) -> None:
        """`places`: columns that are equally long, and where in `values` they begin."""
        self._values, self._places = values, places

    def array(self, field: tuple[str, str], columns: Sequence[object], first: int) -> Floats | None:
        """Columns from the first one on as an array (cases, values), if they are those that were read; else None."""
        read, begin = self._places.get(field, ((), 0))
        count = len(read)
        if not count or not all(map(operator.is_, read, columns[first : first + count])):
            return None
        width = len(read[0])
        return self._values[begin : begin + width * count].reshape(count, width)


def checked(fields: Sequence[tuple[Field, Sequence[Any]]]) -> Together | None:
    """The columns of fields, one for each case, unless something may be wrong with one.

    Wrong is a value that is no float, not finite, or out of its field's range, and times that do not increase.
    """
    every = list(chain.from_iterable(columns for _, columns in fields))
    values = floats(list(chain.from_iterable(every)))
    if values is None:
        return None
    lengths = list(map(len, every))
    offsets = list(accumulate(lengths, initial=0))
    places: dict[tuple[str, str], tuple[Sequence[Any], int]] = {}
    begins, lower, upper = [], [], []
    first = 0
    for field, columns in fields:
        last = first + len(columns)
        begin, end, own = offsets[first], offsets[last], lengths[first:last]
        first = last
        if begin < end:
            begins.append(begin)
            lower.append(field.lower)
            upper.append(field.upper)
            if field.increasing and not _increasing(values[begin:end], own):
                return None
        if own.count(own[0]) == len(own):
            places[field.place] = columns, begin
    if begins:
        least, greatest = np.minimum.reduceat(values, begins), np.maximum.reduceat(values, begins)
        if not ((least >= lower).all() and (greatest <= upper).all()):  # NaN is neither
            return None
    values.flags.writeable = False
    return Together(values, places)


def array(
    together: Sequence[Together | None], field: tuple[str, str], columns: Sequence[object]
) -> Floats | None:
    """The array (cases, values) of a field's columns, given what each case was read with.

    None where the columns are not those that were read, all and in order, or differ in length.
    """
    found: list[Floats] = []
    first = 0
    while first < len(columns):
        part = together[first]
        values = None if part is None else part.array(field, columns, first)
        if values is None:
            return None
        found.append(values)
        first += len(values)
    if first > len(columns) or any(values.shape[1] != found[0].shape[1] for values in found):
        return None
    return found[0] if len(found) == 1 else np.concatenate(found)


def _increasing(values: Floats, lengths: Sequence[int]) -> bool:
    """Whether columns of some lengths, one after the other, increase, each in itself."""
    later = values[1:] > values[:-1]
    for end in islice(accumulate(lengths), len(lengths) - 1):
        if 0 < end < values.size:
            later[end - 1] = True  # from the end of one to the beginning of the next
    return bool(later.all())
