"""What Python's objects are taken for: the table of types in docs/supervisor.md. Whatever is not in it is of the wrong type.

Evaluators never see a caller's objects: what is read here is copied, so what is judged is what was checked.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
#: Numbers that JSON has no word for, where data comes from it.
SPELT = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}


class WrongTypeError(Exception):
    """Something else than what belongs there; `index`: the entry that it is, where it is one of a column."""

    def __init__(self, message: str, index: int | None = None, name: str = "wrong_type") -> None:
        super().__init__(message)
        self.message, self.index, self.name = message, index, name


def number(value: object, spelt: bool = False) -> float | None:
    """A number as a float, a missing one (None) as NaN; None for what is no number.

    Python's and numpy's whole and real numbers are numbers, and arrays of one of them without axes; Booleans are none. What is too
    large for a float is infinite. spelt: "nan", "inf" and "-inf" are numbers too.
    """
    kind = type(value)
    if kind is float:
        return value  # type: ignore[return-value]
    if value is None:
        return math.nan
    if kind is np.ndarray and value.ndim == 0 and value.dtype.kind in "iuf":  # type: ignore[attr-defined]
        return _float(value.item())  # type: ignore[attr-defined]
    if isinstance(value, bool | np.bool_):
        return None
    if isinstance(value, np.integer | np.floating):
        return _float(value.item() if value.dtype.itemsize <= 8 else value)
    if isinstance(value, float):
        return float.__pos__(value)
    if isinstance(value, int):
        return _float(int.__pos__(value))
    if spelt and kind is str:
        return SPELT.get(value)  # type: ignore[call-overload, no-any-return]
    return None


def _float(value: Any) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def flag(value: object) -> int | None:
    """A Boolean as 1 or 0, a missing one (None) as -1; None for what is none."""
    if value is None:
        return -1
    return int(value) if isinstance(value, bool | np.bool_) else None


def numbers(column: Any, spelt: bool = False) -> Floats:
    """A column of numbers, as a new array of one axis; raises WrongTypeError.

    Lists, tuples, and arrays of one axis: of whole or real numbers of any size and byte order, or of objects that are numbers. What a
    masked array hides is missing (NaN). Other kinds of arrays may mean something else by their numbers, and are refused.
    """
    kind = type(column)
    if kind in (np.ndarray, np.memmap, np.ma.MaskedArray):
        if column.ndim != 1:
            raise WrongTypeError("something else is no column")
        if column.dtype.kind in "iuf":
            with np.errstate(all="ignore"):
                made: Floats = np.array(np.ma.getdata(column), dtype=np.float64)
            if kind is np.ma.MaskedArray:
                made[np.ma.getmaskarray(column)] = math.nan
            return made
        if column.dtype != object or kind is np.ma.MaskedArray:
            raise WrongTypeError("something else is no column")
        column = column.tolist()
    values = entries(column)
    if not {float}.issuperset(map(type, values)):
        found = [number(value, spelt) for value in values]
        if None in found:
            index = found.index(None)
            raise WrongTypeError(f"{worded(values[index])} is no number", index)
        values = found
    return np.array(values, dtype=np.float64)


def flags(column: Any) -> NDArray[np.int8]:
    """A column of Booleans as 1, 0 and -1 for a missing one; raises WrongTypeError. Lists, tuples, and arrays of bool or objects."""
    kind = type(column)
    if kind in (np.ndarray, np.ma.MaskedArray):
        if column.ndim != 1:
            raise WrongTypeError("something else is no column")
        if column.dtype == bool:
            made = np.array(np.ma.getdata(column), dtype=np.int8)
            if kind is np.ma.MaskedArray:
                made[np.ma.getmaskarray(column)] = -1
            return made
        if column.dtype != object or kind is np.ma.MaskedArray:
            raise WrongTypeError("something else is no column")
        column = column.tolist()
    values = entries(column)
    found = [flag(value) for value in values]
    if None in found:
        index = found.index(None)
        raise WrongTypeError(f"{worded(values[index])} is neither true nor false", index)
    return np.array(found, dtype=np.int8)


def entries(column: Any) -> list[Any]:
    """The entries of a list or tuple, of any derived type, as they are stored; raises WrongTypeError."""
    if isinstance(column, list):
        return list.__getitem__(column, slice(None))
    if isinstance(column, tuple):
        return list(tuple.__getitem__(column, slice(None)))
    raise WrongTypeError(f"{worded(column)} is no column")


def mapping(raw: Any) -> dict[Any, Any]:
    """What a dict or any other Mapping holds; raises WrongTypeError."""
    if type(raw) is dict:
        return raw
    if isinstance(raw, Mapping):
        return {key: raw[key] for key in raw}
    raise WrongTypeError(f"{worded(raw)} has no fields")


def ids(column: Any) -> tuple[str, ...]:
    """Ids of elements, texts or numbers, as texts; raises WrongTypeError, with the name `duplicate` for one that stands twice."""
    if type(column) is np.ndarray:
        if column.ndim != 1:
            raise WrongTypeError("something else is no column")
        column = column.tolist()
    found: dict[str, int] = {}
    for index, name in enumerate(entries(column)):
        if isinstance(name, bool) or not isinstance(name, str | int | float) or _long(name):
            raise WrongTypeError(f"{worded(name)} is neither a text nor a number", index)
        spoken = str.__str__(name) if isinstance(name, str) else repr(name)
        if found.setdefault(spoken, index) != index:
            raise WrongTypeError(f"`{spoken[:40]}` stands twice", index, "duplicate")
    return tuple(found)


def _long(value: object) -> bool:
    """Whether a number is too long to be an id; its digits alone would take long to write."""
    return isinstance(value, int) and not -(2**63) <= value < 2**63


def worded(raw: object) -> str:
    """What an object is, for a message: of JSON's words, since a record of the run has no others; never the object's own text."""
    names = {dict: "an object", list: "a list", str: "a text", bool: "a Boolean", type(None): "null"}
    return names.get(type(raw), "a number" if type(raw) in (int, float) else "something else")
