"""Columns as callers have them, as equally long lists of float."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Set
from typing import TYPE_CHECKING, Any

from trackmarshal.doubles import double
from trackmarshal.errors import TrackmarshalError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

#: Columns by name.
Lists = dict[str, list[float]]
#: Columns of lengths [m].
_LENGTHS = ("s", "x", "y")


def numbers(name: str, values: Any) -> list[float]:
    """One column; None is NaN. Raises D191 for what is no column of numbers."""
    if isinstance(values, str | bytes | bytearray | Mapping | Set) or not isinstance(values, Iterable):
        raise _unusable(f"`{name}` is {type(values).__name__}, not a column of numbers")
    listed = list(values) if _timed(values) or not hasattr(values, "tolist") else values.tolist()
    if not isinstance(listed, list):
        raise _unusable(f"`{name}` is one number, not a column")
    found: list[float] = []
    short = _short(values)
    for index, value in enumerate(listed):
        if value is None:
            value = math.nan
        elif hasattr(value, "item") and not hasattr(value, "__len__") and not _timed(value):
            short, value = short or _short(value), value.item()
        if type(value) is not float:
            if isinstance(value, bool) or not isinstance(value, int | float):
                raise _unusable(f"`{name}[{index}]` is {type(value).__name__}, not a number")
            value = double(value)
        found.append(value)
    if (
        name in _LENGTHS
        and short is not None
        and max(map(abs, filter(math.isfinite, found)), default=0.0) >= _far(short)
    ):
        raise _unusable(
            f"`{name}` is of {short.name}, which has no two numbers nearer than 1 cm there: give it as float64"
        )
    return found


def _short(values: Any) -> Any:
    """The type of numpy of a column, or a number, that is of floats of less than 64 bits; None for anything else."""
    dtype: Any = getattr(values, "dtype", None)
    return dtype if getattr(dtype, "kind", "") == "f" and dtype.itemsize < 8 else None


def _far(short: Any) -> float:
    """From where on [m] numbers of a type of short floats lie more than 1 cm apart, which the door of a Supervisor refuses of lengths."""
    import numpy as np

    far = 1.0
    while np.spacing(np.array(far, short)) <= 0.01:
        far *= 2.0
    return far


def _timed(values: Any) -> bool:
    """Whether something of numpy is times or durations, of which it makes whole numbers of whatever unit they have, such as nanoseconds."""
    return getattr(getattr(values, "dtype", None), "kind", "") in ("m", "M")


def lists(columns: Mapping[str, Any], needed: Iterable[str] = ()) -> Lists:
    """Equally long columns of one sample at least; raises D191 where they are not, and D192 where a needed one is missing."""
    if not isinstance(columns, Mapping):
        raise _unusable(f"columns are a mapping by name, not {type(columns).__name__}")
    found = {str(name): numbers(str(name), values) for name, values in columns.items()}
    missing = [name for name in needed if name not in found]
    if missing:
        there = ", ".join(found) or "no column"
        raise TrackmarshalError("D192", f"`{missing[0]}` is missing", help=f"there: {there}")
    equally_long(found)
    return found


def equally_long(columns: Mapping[str, list[float]]) -> None:
    """Raise D191 unless columns are equally long and not empty."""
    if len({len(values) for values in columns.values()}) != 1 or not next(iter(columns.values())):
        counts = ", ".join(f"{name} {len(values)}" for name, values in columns.items()) or "there is none"
        raise _unusable(f"columns have to be equally long, one sample at least ({counts})")


def arrays(columns: Lists) -> dict[str, Array]:
    """The same as arrays of float64."""
    import numpy as np

    return {name: np.array(values, dtype=np.float64) for name, values in columns.items()}


def _unusable(message: str) -> TrackmarshalError:
    return TrackmarshalError("D191", message, help="a column is a list or an array of numbers, one a sample")
