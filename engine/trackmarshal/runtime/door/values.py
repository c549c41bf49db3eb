"""What Python's objects are taken for: the table of types in docs/supervisor.md. Whatever is not in it is of the wrong type.

Evaluators never see a caller's objects: what is read here is copied, so what is judged is what was checked.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.doubles import double

Floats = NDArray[np.float64]
#: Numbers that JSON has no word for, where data comes from it.
SPELT = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
#: Kinds of numpy's types whose values are numbers, and whole ones.
NUMBERS, WHOLE = "iuf", "iu"
#: How far apart [m] the numbers of a short float may be where lengths are: the northing of a survey is rounded to 0.5 m in a `float32`.
COARSE = 0.01
#: Kinds of arrays that are taken, beside masked ones. Others may mean something else by their numbers.
_ARRAYS = (np.ndarray, np.memmap)


class WrongTypeError(Exception):
    """Something else than what belongs there; `index`: the entry that it is, where it is one of a column."""

    def __init__(self, message: str, index: int | None = None, name: str = "wrong_type") -> None:
        super().__init__(message)
        self.message, self.index, self.name = message, index, name


def is_a(value: object, kinds: type | tuple[type, ...]) -> bool:
    """Whether an object is of one of these classes, whatever it says of itself."""
    return issubclass(type(value), kinds)


def is_array(value: object) -> bool:
    """Whether an object is an array that is taken for one."""
    return type(value) in _ARRAYS or is_masked(value)


def is_masked(value: object) -> bool:
    """Whether an object is a masked array: of what takes long to import, and need not be asked before somebody has imported it."""
    # None where nobody has imported it, or somebody is just doing so.
    return type(value) is getattr(sys.modules.get("numpy.ma"), "MaskedArray", None)


def number(value: Any, spelt: bool = False) -> float | None:
    """A number as a float, a missing one (None) as NaN; None for what is no number.

    Python's and numpy's whole and real numbers are numbers, and arrays of one of them without axes; Booleans are none, and neither are
    times and dates, of which numpy makes whole numbers. What is too large for a float is infinite. spelt: "nan", "inf" and "-inf" are
    numbers too.
    """
    kind = type(value)
    if kind is float:
        return value  # type: ignore[no-any-return]
    if value is None:
        return math.nan
    if is_a(value, np.generic) or (kind is np.ndarray and value.ndim == 0):
        return double(item(value)) if value.dtype.kind in NUMBERS else None
    if is_a(value, float):
        return float.__pos__(value)
    if is_a(value, int) and not is_a(value, bool):
        return double(int.__pos__(value))
    if spelt and kind is str:
        return SPELT.get(value)
    return None


def whole(value: Any) -> int | None:
    """A whole number of Python or numpy, or an array of one without axes; None for anything else."""
    if type(value) is int:
        return value
    if is_a(value, np.generic) or (type(value) is np.ndarray and value.ndim == 0):
        return int(item(value)) if value.dtype.kind in WHOLE else None
    if is_a(value, bool) or not is_a(value, int):
        return None
    return int.__pos__(value)


def item(value: Any) -> Any:
    """What a number of numpy is in Python, whatever a derived class makes of that."""
    return np.generic.item(value) if is_a(value, np.generic) else value.item()


def flag(value: Any) -> int | None:
    """A Boolean as 1 or 0, a missing one (None) as -1; None for what is none."""
    if value is None:
        return -1
    if type(value) is np.ndarray and value.ndim == 0 and value.dtype == bool:
        return int(value.item())
    return int(value) if type(value) in (bool, np.bool_) else None


def numbers(column: Any, spelt: bool = False) -> Floats:
    """A column of numbers, as a new array of one axis; raises WrongTypeError.

    Lists, tuples, and arrays of one axis: of whole or real numbers of any size and byte order, or of objects that are numbers. What a
    masked array hides is missing (NaN).
    """
    if is_array(column):
        made = floats(column)
        if made is not None:
            return made
        column = objects(column)
    values = entries(column)
    if not {float}.issuperset(map(type, values)):
        found = [number(value, spelt) for value in values]
        if None in found:
            index = found.index(None)
            raise WrongTypeError(f"{worded(values[index])} is no number", index)
        values = found
    return np.array(values, dtype=np.float64)


def places(
    column: Any, members: tuple[str, ...], spelt: bool = False
) -> tuple[Floats, list[tuple[int, str]]]:
    """A column of members of an enumeration as their places, and the entries that are names of none, which are NaN; raises WrongTypeError.

    Members by name: lists, tuples, and arrays of texts or of objects; by place: what is a column of numbers. Both may be in one list.
    """
    if is_array(column) and column.dtype.kind != "U":
        made = floats(column)
        if made is not None:
            return made, []
        column = objects(column)
    elif is_array(column):
        if column.ndim != 1 or is_masked(column):
            raise WrongTypeError("something else is no column")
        column = column.tolist()
    known = {name: float(place) for place, name in enumerate(members)}
    found: list[float] = []
    unknown: list[tuple[int, str]] = []
    for index, value in enumerate(entries(column)):
        name = _text(value)
        if name is None or (spelt and name in SPELT and name not in known):
            place = number(value, spelt)
            if place is None:
                raise WrongTypeError(f"{worded(value)} is no member", index)
        else:
            place = known.get(name, math.nan)
            if name not in known:
                unknown.append((index, name))
        found.append(place)
    return np.array(found, dtype=np.float64), unknown


def _text(value: Any) -> str | None:
    """A text of Python or numpy, also in an array without axes; None for anything else."""
    if type(value) is np.ndarray and value.ndim == 0 and value.dtype.kind == "U":
        value = value.item()
    return str.__str__(value) if is_a(value, str) else None


def floats(array: Any, axes: int = 1) -> Floats | None:
    """A copy of an array of whole or real numbers, with NaN for what is masked; None for an array of anything else.

    Raises WrongTypeError where it has another number of axes.
    """
    if array.ndim != axes:
        raise WrongTypeError("something else is no column")
    if array.dtype.kind not in NUMBERS:
        return None
    with np.errstate(all="ignore"):
        made: Floats = np.array(np.ma.getdata(array) if is_masked(array) else array, dtype=np.float64)
    if is_masked(array):
        made[np.ma.getmaskarray(array)] = math.nan
    return made


def rounded(column: Any, unit: float = 1.0) -> str:
    """What a column of lengths, or a point, has lost by floats of less than 64 bits, whatever holds them; empty where that is nothing of weight.

    unit: theirs, in m.
    """
    if is_array(column) and column.dtype != object:
        return _apart(column, unit)
    short: dict[Any, list[Any]] = {}
    for value in column if is_array(column) else entries(column):
        if (is_a(value, np.floating) or (type(value) is np.ndarray and value.ndim == 0)) and _short(value):
            short.setdefault(value.dtype, []).append(value)
    return next(filter(None, (_apart(np.array(each, kind), unit) for kind, each in short.items())), "")


def _short(held: Any) -> bool:
    """Whether an array, or a number of numpy, is of floats of less than 64 bits."""
    return bool(held.dtype.kind == "f" and held.dtype.itemsize < np.dtype(np.float64).itemsize)


def _apart(array: NDArray[Any], unit: float) -> str:
    if not _short(array):
        return ""
    with np.errstate(all="ignore"):
        largest = np.abs(np.asarray(array).astype(array.dtype.newbyteorder("=")))
    apart = unit * float(np.spacing(largest[np.isfinite(largest)].max(initial=0)))
    return f"{array.dtype.name} has no two numbers nearer than {apart:g} m there" if apart > COARSE else ""


def objects(array: Any) -> list[Any]:
    """What an array of objects holds; raises WrongTypeError for any other."""
    if array.dtype != object or is_masked(array):
        raise WrongTypeError("something else is no column")
    held: list[Any] = array.tolist()
    return held


def flags(column: Any) -> NDArray[np.int8]:
    """A column of Booleans as 1, 0 and -1 for a missing one; raises WrongTypeError. Lists, tuples, and arrays of bool or objects.

    An array without entries is a column of any kind: numpy makes one of floats of an empty list.
    """
    if is_array(column):
        if column.ndim != 1:
            raise WrongTypeError("something else is no column")
        if column.dtype == bool:
            made = np.array(np.ma.getdata(column) if is_masked(column) else column, dtype=np.int8)
            if is_masked(column):
                made[np.ma.getmaskarray(column)] = -1
            return made
        column = column.tolist() if column.dtype.kind in NUMBERS else objects(column)
    values = entries(column)
    found = [flag(value) for value in values]
    if None in found:
        index = found.index(None)
        raise WrongTypeError(f"{worded(values[index])} is neither true nor false", index)
    return np.array(found, dtype=np.int8)


def entries(column: Any) -> list[Any]:
    """The entries of a list or tuple, of any derived type, as they are stored; raises WrongTypeError."""
    if is_a(column, list):
        return list.__getitem__(column, slice(None))
    if is_a(column, tuple):
        return list(tuple.__getitem__(column, slice(None)))
    raise WrongTypeError(f"{worded(column)} is no column")


def listed(raw: Any) -> list[Any]:
    """The entries of a list or tuple, or those along the first axis of an array of numbers or objects; raises WrongTypeError."""
    if is_array(raw) and raw.ndim and (raw.dtype.kind in NUMBERS or raw.dtype == object):
        return list(raw)
    return entries(raw)


def mapping(raw: Any) -> dict[Any, Any]:
    """What a dict or any other Mapping holds; raises WrongTypeError.

    What is not a plain dict may make its values in the same memory again and again: each is copied before the next is asked for.
    """
    if type(raw) is dict:
        return raw
    if is_a(raw, Mapping):
        return {key: _held(raw[key]) for key in raw}
    raise WrongTypeError(f"{worded(raw)} has no fields")


def _held(value: Any) -> Any:
    """Lists, tuples, arrays and Mappings with all that they hold, for good; anything else as it is."""
    if is_array(value):
        return value.copy()
    if is_a(value, (list, tuple)):
        own = list if is_a(value, list) else tuple
        return own(map(_held, entries(value)))
    if is_a(value, Mapping):
        return {key: _held(value[key]) for key in value}
    return value


def ids(column: Any) -> tuple[str, ...]:
    """Ids of elements, texts or numbers, as texts; raises WrongTypeError, with the name `duplicate` for one that stands twice."""
    if type(column) is np.ndarray:
        if column.ndim != 1 or column.dtype.kind not in "iufUO":
            raise WrongTypeError("something else is no column")
        column = column.tolist()
    found: dict[str, int] = {}
    for index, name in enumerate(entries(column)):
        spoken = _spoken(name)
        if spoken is None:
            raise WrongTypeError(_no_id(name), index)
        if found.setdefault(spoken, index) != index:
            raise WrongTypeError(f"`{spoken[:40]}` stands twice", index, "duplicate")
    return tuple(found)


def _spoken(name: Any) -> str | None:
    """An id as a text; None for what is none."""
    if is_a(name, str):
        return str.__str__(name)
    number = item(name) if is_a(name, np.generic) and name.dtype.kind in NUMBERS else name
    if is_a(number, (float, np.longdouble)):
        real = float.__pos__(float(number) if is_a(number, np.longdouble) else number)
        if not math.isfinite(real):
            return None
        # Who has all numbers as floats means the same element by 1.0 as by 1.
        whole = real.is_integer() and not _long(int(real))
        return repr(int(real)) if whole else repr(real)
    if is_a(number, bool) or not is_a(number, int) or _long(number):
        return None
    return int.__repr__(number)


def _no_id(name: Any) -> str:
    """Why something is no id: of a number, which one is."""
    if not is_a(name, bool) and is_a(name, (int, float)):
        return f"a number {'of more than 64 bits' if _long(name) else 'that is not finite'} is no id"
    return f"{worded(name)} is neither a text nor a number"


def _long(value: Any) -> bool:
    """Whether a number is too long to be an id; its digits alone would take long to write."""
    return is_a(value, int) and not -(2**63) <= value < 2**63


def worded(raw: object) -> str:
    """What an object is, for a message: of JSON's words, since a record of the run has no others; never the object's own text."""
    names = {dict: "an object", list: "a list", str: "a text", bool: "a Boolean", type(None): "null"}
    return names.get(type(raw), "a number" if type(raw) in (int, float) else "something else")
