"""Readers of borders and lines: they are read anew only when a caller's data may be other than last time."""

from __future__ import annotations

import marshal
from collections import OrderedDict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.door.values import number
from trackmarshal.runtime.lines import Line

#: Lines that a reader remembers: more than one run's tracks have, few enough to hold.
KEPT = 32
_FLOAT = np.dtype(np.float64)
Floats = NDArray[np.float64]


def line(points: Any) -> Line:
    """A line of an array or a list of points [x, y] in m, which are copied; raises ValueError for anything else."""
    array = np.array(points, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"a line is a list of points [x, y], not of shape {array.shape}")
    # numpy lets nobody write to memory that is bytes.
    return Line(np.frombuffer(array.tobytes(), dtype=np.float64).reshape(-1, 2))


#: The line of no points, where one is missing.
NOWHERE = line(np.zeros((0, 2)))


class NoLineError(Exception):
    """What was given is no line: the name of the fault, the index of the point, and what is wrong."""

    def __init__(self, name: str, index: int | None, message: str) -> None:
        super().__init__(name, index, message)
        self.name, self.index, self.message = name, index, message


class LineReader:
    """Reads the lines of one place. Equal data gives the same line, so that evaluators prepare it once."""

    def __init__(self) -> None:
        self._last: Line = NOWHERE
        #: The object that the last line was read from, where nothing in it can have changed since.
        self._frozen: object = None
        self._content: bytes = b""
        self._known: OrderedDict[Any, Line] = OrderedDict()

    def read(self, raw: Any) -> Line:
        """The line that data stands for; raises NoLineError."""
        if raw is self._frozen and raw is not None:
            return self._last
        kind = type(raw)
        if kind is Line:
            return self._remember(raw, raw)
        if kind is np.ndarray:
            if raw.dtype == _FLOAT and raw.ndim == 2 and raw.shape[1] == 2:
                content = raw.tobytes()
                if content != self._content:
                    self._last, self._content = self._known_as(("array", content), raw), content
                self._frozen = raw if _frozen(raw) else None
                return self._last
            raw = raw.tolist()
        if not isinstance(raw, list | tuple):
            raise NoLineError("wrong_type", None, "not a list of points")
        self._frozen, self._content = None, b""
        self._last = self._known_as(_content(raw), raw)
        return self._last

    def _remember(self, given: Line, frozen: object) -> Line:
        self._last, self._frozen, self._content = given, frozen, b""
        return given

    def _known_as(self, content: Any, raw: Any) -> Line:
        found = None if content is None else self._known.get(content)
        if found is None:
            found = line(raw if type(raw) is np.ndarray else points_of(raw))
            if content is not None:
                self._known[content] = found
                while len(self._known) > KEPT:
                    self._known.popitem(last=False)
        return found


def points_of(raw: Any) -> Floats:
    """(n, 2) of a list of points; raises NoLineError."""
    rows = np.zeros((len(raw), 2))
    for index, point in enumerate(raw):
        pair = point.tolist() if type(point) is np.ndarray else point
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise NoLineError("wrong_type", index, "not a point [x, y]")
        for axis, value in enumerate(pair):
            coordinate = number(value)
            if coordinate is None:
                raise NoLineError("wrong_type", index, "not a number")
            rows[index, axis] = coordinate
    return rows


def _frozen(array: NDArray[Any]) -> bool:
    """Whether an array's memory is Python's bytes, which nobody can write to."""
    base: Any = array
    while type(base) is np.ndarray:
        base = base.base
    return type(base) is bytes


def _content(raw: Any) -> object:
    """A key for plain lists and tuples of plain numbers, the same only for the same types and bits; None for anything else.

    `marshal` writes each type of plain data in a way of its own, so there is one way only to read it.
    """
    if type(raw) not in (list, tuple) or not all(
        type(row) in (list, tuple) and {float, int}.issuperset(map(type, row)) for row in raw
    ):
        return None
    # Later versions write references: slower, and not in one way only.
    return marshal.dumps(raw, 2)
