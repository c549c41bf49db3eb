"""What there is in a planner's cycles: timelines, records, sets and lines, each by its path, whatever it is called."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.doubles import double

Array = NDArray[np.float64]
#: How deep objects are looked into.
DEPTH = 6


@dataclass(slots=True)
class Found:
    """The parts of one cycle by path (`trajectories.straight`; "" is the cycle itself).

    timelines: columns by name; of rows without names, `0`, `1`, ... records: their numbers. sets: lists of records. lines: (points, 2).
    uneven: columns of another length than their timeline's, as (path, column, its length, the timeline's).
    """

    timelines: dict[str, dict[str, Array]] = field(default_factory=dict)
    records: dict[str, dict[str, float]] = field(default_factory=dict)
    sets: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    lines: dict[str, Array] = field(default_factory=dict)
    uneven: list[tuple[str, str, int, int]] = field(default_factory=list)
    #: Paths of sets that are mappings of records by their ids.
    keyed: dict[str, None] = field(default_factory=dict)
    #: Paths of lists without an entry.
    empty: dict[str, None] = field(default_factory=dict)


def look(cycle: Mapping[str, Any]) -> Found:
    """Everything in one cycle."""
    found = Found()
    _look(cycle, "", found, 0)
    return found


def _look(value: Any, path: str, found: Found, depth: int) -> None:
    if depth > DEPTH:
        return
    if isinstance(value, Mapping):
        _mapping(value, path, found, depth)
    elif hasattr(value, "tolist") and not isinstance(value, float | int):
        _look(value.tolist(), path, found, depth)
    elif isinstance(value, list | tuple):
        if value:
            _list(list(value), path, found)
        else:
            found.empty[path] = None


def _mapping(value: Mapping[Any, Any], path: str, found: Found, depth: int) -> None:
    columns = {str(name): column for name, item in value.items() if (column := _column(item)) is not None}
    if len(columns) >= 3:
        count = Counter(len(column) for column in columns.values()).most_common(1)[0][0]
        found.uneven += [(path, n, len(c), count) for n, c in columns.items() if len(c) != count]
        found.timelines[path] = {name: column for name, column in columns.items() if len(column) == count}
    record = {str(name): number for name, item in value.items() if (number := _number(item)) is not None}
    if record:
        found.records[path] = record
    children = [(name, item) for name, item in value.items() if isinstance(item, Mapping)]
    if len(children) >= 1 and all(_is_object(item) for _, item in children) and _plural(path):
        found.sets[path] = [{"id": str(name), **item} for name, item in children]
        found.keyed[path] = None
        return
    for name, item in value.items():
        if str(name) not in columns or len(columns) < 3:
            _look(item, f"{path}.{name}" if path else str(name), found, depth + 1)


def _list(value: list[Any], path: str, found: Found) -> None:
    if all(isinstance(item, Mapping) for item in value):
        if any(isinstance(part, str) for item in value for part in item.values()) or _plural(path):
            found.sets[path] = [dict(item) for item in value]
            return
        names = [name for name in value[0] if all(_number(item.get(name)) is not None for item in value)]
        if len(value) >= 2 and len(names) >= 3:
            found.timelines[path] = {str(n): np.array([_number(item[n]) for item in value]) for n in names}
        return
    rows = [item.tolist() if hasattr(item, "tolist") else item for item in value]
    if len(rows) >= 2 and all(isinstance(row, list | tuple) for row in rows):
        width = len(rows[0])
        if width < 2 or any(len(row) != width or any(_number(z) is None for z in row) for row in rows):
            return
        table = np.array([[_number(z) for z in row] for row in rows], dtype=np.float64)
        if width == 2:
            found.lines[path] = table
        else:
            found.timelines[path] = {str(i): table[:, i] for i in range(width)}


def _plural(path: str) -> bool:
    last = path.rpartition(".")[2].lower()
    return any(
        word in last for word in ("object", "obstacle", "vehicle", "others", "opponent", "agent", "cars")
    )


def _is_object(item: Mapping[Any, Any]) -> bool:
    return sum(_number(value) is not None for value in item.values()) >= 3


def _column(item: Any) -> Array | None:
    """A column of two numbers or more; None where it is none. None in it is NaN."""
    if hasattr(item, "tolist") and not isinstance(item, float | int):
        item = item.tolist()
    if not isinstance(item, list | tuple) or len(item) < 2:
        return None
    numbers = [math.nan if z is None else _number(z) for z in item]
    return None if any(z is None for z in numbers) else np.array(numbers, dtype=np.float64)


def _number(value: Any) -> float | None:
    if hasattr(value, "item") and not hasattr(value, "__len__"):
        value = value.item()
    if isinstance(value, bool) or not isinstance(value, int | float):
        return (
            {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}.get(value)
            if isinstance(value, str)
            else None
        )
    return double(value)


def paths(cycles: list[Found], kind: str) -> Iterator[tuple[str, int]]:
    """The paths of a kind of part, the most frequent first, with in how many cycles they are."""
    counts = Counter(path for cycle in cycles for path in getattr(cycle, kind))
    yield from counts.most_common()
