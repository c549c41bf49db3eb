"""Readers of borders and lines: they are read anew only when a caller's data may be other than last time."""

from __future__ import annotations

import copyreg
import marshal
from collections import OrderedDict
from itertools import chain
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.door import values
from trackmarshal.runtime.door.values import WrongTypeError
from trackmarshal.runtime.lines import Line

#: Lines that a reader remembers: more than one run's tracks have, few enough to hold.
KEPT = 32
_FLOAT = np.dtype(np.float64)
_ROWS, _NUMBERS = {list, tuple}, {float, int}
Floats = NDArray[np.float64]


def line(points: Any) -> Line:
    """A line of an array or a list of points [x, y] in m, which are copied, as the door reads one; raises ValueError for what it refuses, and for an
    empty list, which somebody forgot to fill."""
    if values.is_a(points, (list, tuple)) and not points:
        raise ValueError("a line is a list of points [x, y], and this one is empty")
    try:
        return LineReader().read(points)
    except NoLineError as error:
        place = "" if error.index is None else f"point {error.index}: "
        raise ValueError(f"a line is a list of points [x, y] of numbers; {place}{error.message}") from None


def _made(points: Floats) -> Line:
    """A line of points, (n, 2) [m], which are copied."""
    # numpy lets nobody write to memory that is bytes.
    return Line(np.frombuffer(points.tobytes(), dtype=np.float64).reshape(-1, 2))


#: The line of no points, where one is missing.
NOWHERE = _made(np.zeros((0, 2)))


def _pickled(made: Line) -> tuple[Any, ...]:
    return line, (made.points,)


# What comes from a pickle is read anew: into memory that nobody can write to, under a number of its own.
copyreg.pickle(Line, _pickled)


class NoLineError(Exception):
    """What was given is no line: the name of the fault, the index of the point, and what is wrong."""

    def __init__(self, name: str, index: int | None, message: str) -> None:
        super().__init__(name, index, message)
        self.name, self.index, self.message = name, index, message


class LineReader:
    """Reads the lines of one place. Equal data gives the same line, so that evaluators prepare it once."""

    def __init__(self) -> None:
        #: The line that was handed in as one last; None where that was something else.
        self.same: Line | None = None
        self._last: Line = NOWHERE
        #: The object that the last line was read from, where nothing in it can have changed since, and how that was seen.
        self._frozen: object = None
        self._view: object = None
        #: The bytes of the array that the last line was read from, if it was one; of a type that compares itself to an array's memory
        #: without a copy of that.
        self._content: bytearray | None = None
        self._known: OrderedDict[Any, Line] = OrderedDict()

    def read(self, raw: Any) -> Line:
        """The line that data stands for; raises NoLineError."""
        if raw is self._frozen and raw is not None and _view(raw) == self._view:
            return self._last
        kind = type(raw)
        if kind is Line:
            if not _whole(raw.points):
                raise NoLineError("wrong_type", None, "not a list of points")
            return self._remember(raw, raw, None)
        if values.is_array(raw):
            array = raw if kind is np.ndarray and raw.dtype == _FLOAT else _numbers(raw)
            if array is not None:
                if array.ndim != 2 or array.shape[1] != 2:
                    raise NoLineError("wrong_type", None, "not a list of points")
                frozen = raw if kind is np.ndarray and _frozen(raw) else None
                if self._content is not None and array.flags.c_contiguous and self._content == array.data:
                    return self._remember(self._last, frozen, self._content)
                content = array.tobytes()
                return self._remember(self._known_as(("array", content)), frozen, bytearray(content))
            raw = raw.tolist()
        if not values.is_a(raw, (list, tuple)):
            raise NoLineError("wrong_type", None, "not a list of points")
        return self._remember(self._known_as(_content(raw), raw), None, None)

    def _remember(self, given: Line, frozen: Any, content: bytearray | None) -> Line:
        self._last, self._frozen, self._content = given, frozen, content
        self.same = given if given is frozen else None
        self._view = None if frozen is None else _view(frozen)
        return given

    def _known_as(self, content: Any, raw: Any = None) -> Line:
        """The line of this content; None for data without one. What is kept is read from the content: data may change meanwhile."""
        if content is None:
            return _made(points_of(raw))
        found = self._known.get(content)
        if found is None:
            found = self._known[content] = _made(_points(content))
            while len(self._known) > KEPT:
                self._known.popitem(last=False)
        return found


def _points(content: Any) -> Floats:
    if type(content) is bytes:
        raw = marshal.loads(content)
        # Pairs of floats, mostly: there is nothing more to be read, or wrong, than their numbers.
        if set(map(len, raw)) == {2} and set(map(type, chain.from_iterable(raw))) == {float}:
            return np.array(raw)
        return points_of(raw)
    return np.frombuffer(content[1], dtype=np.float64).reshape(-1, 2)


def points_of(raw: Any) -> Floats:
    """(n, 2) of a list of points; raises NoLineError."""
    points = values.entries(raw)
    rows = np.full((len(points), 2), np.nan)
    for index, point in enumerate(points):
        try:
            pair = values.entries(point) if not values.is_array(point) else values.numbers(point)
        except WrongTypeError as error:
            raise NoLineError("wrong_type", index, "not a point [x, y]") from error
        if len(pair) != 2:
            raise NoLineError("wrong_type", index, "not a point [x, y]")
        if lost := values.rounded(point):
            raise NoLineError("wrong_type", index, lost)
        for axis, value in enumerate(pair):
            coordinate = values.number(value)
            if coordinate is None:
                raise NoLineError("wrong_type", index, "not a number")
            rows[index, axis] = coordinate
    return rows


def _numbers(array: Any) -> Floats | None:
    """An array as one of numbers, None for one of objects; raises NoLineError for any other."""
    if array.dtype == object and type(array) is np.ndarray:
        return None
    try:
        found = values.floats(array, 2)
    except WrongTypeError:
        found = None
    if found is None:
        raise NoLineError("wrong_type", None, "not a list of points")
    if lost := values.rounded(array):
        raise NoLineError("wrong_type", None, lost)
    return found


def _view(raw: Any) -> object:
    """How an array looks at its memory."""
    return (raw.shape, raw.strides, raw.dtype) if type(raw) is np.ndarray else None


def _whole(points: Any) -> bool:
    """Whether points are as a line has them."""
    whole = (
        type(points) is np.ndarray and points.dtype == _FLOAT and points.ndim == 2 and points.shape[1] == 2
    )
    return whole and _frozen(points)


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
    if type(raw) not in _ROWS or not _ROWS.issuperset(map(type, raw)):
        return None
    if not _NUMBERS.issuperset(map(type, chain.from_iterable(raw))):
        return None
    # Later versions write references: slower, and not in one way only.
    return marshal.dumps(raw, 2)
