"""One cycle at a time through the generated door and rules, from numpy arrays."""

from __future__ import annotations

import ctypes
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.c.door import FAULTS, LIMITS
from trackmarshal.backends.c.layout import Input
from trackmarshal.backends.c.places import sources
from trackmarshal.backends.c.program import CProgram
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.case import Case, Fault
from trackmarshal.runtime.contract import IS_EMERGENCY, PLAN
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.faults import fault

Floats = NDArray[np.float64]
Points = Sequence[tuple[float, float]]
_DOUBLE = np.dtype(np.float64)
_DOUBLES = {_DOUBLE}


class _CFault(ctypes.Structure):
    """A `tm_fault`."""

    _fields_ = [
        ("name", ctypes.c_int),
        ("signal", ctypes.c_char_p),
        ("field", ctypes.c_char_p),
        ("index", ctypes.c_size_t),
    ]


class Refused(Exception):
    """Data that is none: a column is missing, no array of numbers, or not as long as the others."""

    def __init__(self, name: str, signal: str, field: str = "", index: int | None = None) -> None:
        super().__init__(name, signal, field, index)
        self.fault = _fault(name, signal, field, index)


class Stepper:
    """One context and one set of buffers: `step` takes a cycle through the door and, where it passes, all rules on both candidates.

    program: made with `doored=True`. samples, elements, border: the declared capacities. limits: those of the door by name.
    Parameters and tables are the spec's own, or those of `settings`, a case as its reader makes them.
    """

    def __init__(
        self, program: CProgram, samples: int = 64, elements: int = 32, border: int = 2048, settings: Case | None = None,
        **limits: float,
    ) -> None:  # fmt: skip
        if not program.source.doored:
            raise ValueError("the program has no door")
        self._program = program
        self._library = program.new_library(samples, elements, border, settings)
        self._dll, self._context = self._library.dll, self._library.context
        self._tracks = list(sources(program.source.plan))
        order = program.order
        inputs = program.source.plan.inputs
        places = {(name, field): i for i, (name, field, _) in enumerate(order.columns)}
        width = len(order.columns)
        # Everything twice: the driving trajectory's input, then the emergency one's, which shares all but the candidate.
        self._counts = np.zeros((2, max(1, len(order.counts))), dtype=np.uint64)
        self._pointers = np.zeros((2, max(1, width)), dtype=np.uint64)
        self._numbers = np.full(max(1, len(order.numbers)), np.nan)
        self._flags = np.full((2, max(1, len(order.flags))), -1, dtype=np.int8)
        self._candidates: list[_Block] = []
        self._shared: list[_Block] = []
        for number, name in enumerate(order.counts):
            capacity = samples if program.spec.signals[name].sequence else elements
            sides = ((0,), (1,)) if name == PLAN else ((0, 1),)
            for own in sides:
                label = (DRIVING, EMERGENCY)[own[0]] if name == PLAN else name
                block = _Block(
                    inputs[name], label, capacity, places, self._pointers, self._counts, number, own
                )
                (self._candidates if name == PLAN else self._shared).append(block)
        self._records = [
            (inputs[name], name, _picker([f for n, f in order.numbers if n == name]))
            for name in dict.fromkeys(n for n, _ in order.numbers)
        ]
        self._defaults = {
            (name, info.name): info.default
            for name, item in inputs.items()
            for info, _ in item.fields
            if info.default is not None
        }
        self._events = [
            (i, name, field) for i, (name, field) in enumerate(order.flags) if name != IS_EMERGENCY
        ]
        for i, (name, _) in enumerate(order.flags):
            if name == IS_EMERGENCY:
                self._flags[:, i] = (0, 1)
        count = len(program.rules)
        #: (2, rules) margins and verdict codes (places in runtime.verdict.VERDICTS) of the last step; driving first.
        self.margins = np.full((2, count), np.nan)
        self.verdicts = np.full((2, count), 2, dtype=np.int8)
        self._number = np.zeros(1, dtype=np.int64)
        self._times = np.zeros(2)
        self._found = _CFault()
        self._run = self._dll.tmg_step
        self._arguments = (
            self._context, self._number.ctypes.data, self._times.ctypes.data, self._counts.ctypes.data, self._pointers.ctypes.data,
            self._numbers.ctypes.data, self._flags.ctypes.data, self.margins.ctypes.data, self.verdicts.ctypes.data,
            ctypes.addressof(self._found),
        )  # fmt: skip
        known = {name: default for name, default, _ in LIMITS}
        if limits.keys() - known.keys():
            raise ValueError(f"unknown limits: {', '.join(sorted(limits.keys() - known.keys()))}")
        values = np.array([limits.get(name, default) for name, default in known.items()])
        self._dll.tmg_limits(self._context, values.ctypes.data)

    def track(self, signal: str, left: Points, right: Points = (), closed: bool = False) -> Fault | None:
        """Set the borders of a corridor, or the points of a line, once for many steps; what breaks the contract, if anything.

        A border that crosses itself is for the rules to find: they are undefined. Raises TrackmarshalError E473 for one that
        generated code does not hold.
        """
        a, b = (np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 2) for points in (left, right))
        place = (self._tracks.index(signal), a.ctypes.data, len(a), b.ctypes.data, len(b))
        if self._dll.tmg_admit_place(self._context, *place, ctypes.addressof(self._found)) != 1:
            return self._said()
        if self._dll.tmg_set_place(self._context, *place, int(closed)) == _UNSUPPORTED:
            raise TrackmarshalError(
                "E473", f"the C geometry refuses `{signal}`", help="choose another backend"
            )
        return None

    def refuse(self, number: int, t: float) -> None:
        """Let the door know of a cycle, with a stamp in order, that is refused for what it cannot be shown."""
        self._number[0] = number
        self._times[:] = t
        self._dll.tmg_refuse(self._context, *self._arguments[1:3], self._arguments[-1])

    def candidate(self, side: int) -> tuple[tuple[str, ...], Floats]:
        """Names and a copy of the columns (fields, samples) of a candidate as the last step took it in: 0 driving, 1 emergency."""
        return self._candidates[side].columns()

    def step(
        self, number: int, t: float, now: float, driving: Mapping[str, Any], emergency: Mapping[str, Any], signals: Mapping[str, Any]
    ) -> Fault | None:  # fmt: skip
        """One cycle: None, with `verdicts` and `margins` of all rules; or the fault for which it is refused, all rules undefined.

        number, t: the cycle's number and stamp, now: when it arrived, in s. driving, emergency: columns by field; signals: what
        they have in common: columns by field for timelines and sets, numbers by field for records, True or False for events.
        All in SI; arrays of float64 are fastest.
        """
        try:
            self._number[0] = number
            self._times[0], self._times[1] = t, now
        except (TypeError, ValueError, OverflowError):
            return self._none(Refused("wrong_type", "cycle"))
        try:
            for block, given in zip(self._candidates, (driving, emergency)):
                block.fill(given)
            if not isinstance(signals, Mapping):
                raise Refused("missing" if signals is None else "wrong_type", "signals")
            for block in self._shared:
                block.fill(signals.get(block.label))
            self._fill_records(signals)
            for place, name, field in self._events:
                self._flags[:, place] = self._flag(signals, name, field)
        except Refused as refused:
            self._dll.tmg_refuse(self._context, *self._arguments[1:3], self._arguments[-1])
            return self._said() or self._none(refused)
        self._run(*self._arguments)
        return self._said() if self._found.name else None

    def _fill_records(self, signals: Mapping[str, Any]) -> None:
        values: list[Any] = []
        for item, name, pick in self._records:
            given = signals.get(name)
            if type(given) is dict:
                try:
                    numbers = pick(given)
                    if set(map(type, numbers)) == _FLOATS:
                        values += numbers
                        continue
                except KeyError:
                    pass
            if not isinstance(given, Mapping):
                raise Refused("missing" if given is None else "wrong_type", name)
            for info, _ in item.fields:
                if info.kind == "number":
                    value = given.get(info.name, self._defaults.get((name, info.name)))
                    if value is None and info.name not in given:
                        raise Refused("missing", name, info.name)
                    values.append(math.nan if value is None else _number(value, name, info.name))
        self._numbers[: len(values)] = values

    @staticmethod
    def _flag(signals: Mapping[str, Any], name: str, field: str) -> int:
        given = signals.get(name)
        if field:
            if not isinstance(given, Mapping):
                raise Refused("missing" if given is None else "wrong_type", name)
            given = given.get(field)
        if given is None:
            raise Refused("missing", name, field)
        if not isinstance(given, bool | np.bool_):
            raise Refused("wrong_type", name, field)
        return int(given)

    def _said(self) -> Fault | None:
        """The fault that C has found last."""
        found = self._found
        if not found.name:
            return None
        index = None if found.index == _NOWHERE else int(found.index)
        self._undefined()
        return _fault(FAULTS[found.name], found.signal.decode(), found.field.decode(), index)

    def _none(self, refused: Refused) -> Fault:
        self._undefined()
        return refused.fault

    def _undefined(self) -> None:
        self.margins[:] = np.nan
        self.verdicts[:] = 2


class _Block:
    """The columns of one signal, copied into memory of their own one after the other; `own`: whose inputs point there."""

    def __init__(
        self, item: Input, label: str, capacity: int, places: Mapping[tuple[str, str], int], pointers: NDArray[np.uint64],
        counts: NDArray[np.uint64], number: int, own: tuple[int, ...],
    ) -> None:  # fmt: skip
        self.label = label
        self._capacity = capacity
        numbers = [info for info, _ in item.fields if info.kind == "number"]
        self._fields = [
            (i.name, None if i.default is None else np.full(capacity, i.default)) for i in numbers
        ]
        self.names = tuple(info.name for info in numbers)
        self._memory = np.zeros(max(1, len(numbers)) * capacity)
        self._columns = np.array([places[item.name, info.name] for info in numbers], dtype=np.intp)
        self._flags = [
            (info.name, np.zeros(capacity, dtype=np.int8), places[item.name, info.name])
            for info, _ in item.fields if info.kind == "bool"
        ]  # fmt: skip
        self._pointers, self._counts, self._number, self._own = pointers, counts, number, own
        for _, row, place in self._flags:
            for side in own:
                pointers[side, place] = row.ctypes.data
        self._count = -1
        #: Whether the signal is more than one column of numbers and nothing else.
        self._simple = len(numbers) > 1 and not self._flags
        self._pick = itemgetter(*[info.name for info in numbers] or [""])

    def fill(self, given: Any) -> None:
        """Take a signal's columns. Raises Refused for what is no set of equally long columns of numbers."""
        if not self._simple or type(given) is not dict or "id" in given:
            self._fill(given)
            return
        try:  # almost always, it is arrays of float64 of one length, which a few calls tell
            columns = self._pick(given)
            (n,) = set(map(len, columns))
            if n <= self._capacity and {column.dtype for column in columns} == _DOUBLES:
                np.concatenate(columns, out=self._memory[: n * len(columns)])
                if n != self._count:
                    self._point(n)
                return
        except (KeyError, ValueError, TypeError, AttributeError):
            pass
        self._fill(given)

    def columns(self) -> tuple[tuple[str, ...], Floats]:
        """Names and a copy of the columns of numbers, (fields, samples)."""
        width, n = len(self.names), self._count
        return self.names, self._memory[: width * n].reshape(width, n).copy()

    def _point(self, n: int) -> None:
        """Let the inputs point at columns of this length."""
        self._count = n
        base = self._memory.ctypes.data
        for side in self._own:
            self._pointers[side, self._columns] = base + 8 * n * np.arange(len(self._columns))
            self._counts[side, self._number] = n

    def _fill(self, given: Any) -> None:
        if type(given) is not dict and not isinstance(given, Mapping):
            raise Refused("missing" if given is None else "wrong_type", self.label)
        columns: list[Any] = []
        n = -1
        for name, default in self._fields:
            column = given.get(name)
            if column is None:
                if default is None or name in given:
                    raise Refused("missing", self.label, name)
                column = default
            elif type(column) is not np.ndarray or column.dtype is not _DOUBLE:
                column = _floats(column, self.label, name)
            if column is not default:
                if len(column) != n:
                    if n >= 0 or column.ndim != 1:
                        raise self._unequal(given)
                    n = len(column)
                    if n > self._capacity:
                        raise Refused("over_capacity", self.label, name, self._capacity)
            columns.append(column)
        for name, row, _ in self._flags:
            n = self._take_flags(given, n, name, row)
        n = max(n, 0)
        for k, (_, default) in enumerate(self._fields):
            if columns[k] is default:
                columns[k] = default[:n]
        if columns:
            try:
                np.concatenate(columns, out=self._memory[: n * len(columns)])
            except ValueError as error:
                raise Refused("wrong_type", self.label) from error
        if "id" in given and given["id"] is not None:
            self._check_ids(given["id"], n)
        if n != self._count:
            self._point(n)

    def _unequal(self, given: Mapping[str, Any]) -> Refused:
        """Which column has not the length that most have."""
        lengths: dict[str, int] = {}
        for name in (*(name for name, _ in self._fields), *(name for name, _, _ in self._flags)):
            column = given.get(name)
            if column is not None:
                if getattr(column, "ndim", 1) != 1 or not hasattr(column, "__len__"):
                    return Refused("wrong_type", self.label, name)
                lengths[name] = len(column)
        usual = Counter(lengths.values()).most_common(1)[0][0]
        name = next(name for name, length in lengths.items() if length != usual)
        if lengths[name] > self._capacity:
            return Refused("over_capacity", self.label, name, self._capacity)
        return Refused("wrong_length", self.label, name, min(lengths[name], usual))

    def _take_flags(self, given: Mapping[str, Any], n: int, name: str, row: NDArray[np.int8]) -> int:
        column = given.get(name)
        if column is None:
            raise Refused("missing", self.label, name)
        values = column.tolist() if type(column) is np.ndarray else column
        if not isinstance(values, list | tuple) or any(v is not None and type(v) is not bool for v in values):
            raise Refused("wrong_type", self.label, name)
        if n >= 0 and len(values) != n:
            raise self._unequal(given)
        n = len(values)
        if n > self._capacity:
            raise Refused("over_capacity", self.label, name, self._capacity)
        row[:n] = [-1 if value is None else int(value) for value in values]
        return n

    def _check_ids(self, ids: Any, n: int) -> None:
        if not hasattr(ids, "__len__") or len(ids) != n:
            raise Refused("wrong_length", self.label, "id")
        names = [str(name) for name in ids]
        if len(set(names)) < n:
            raise Refused(
                "duplicate", self.label, "id", next(i for i, s in enumerate(names) if s in names[:i])
            )


#: The status of a track that generated code does not hold; the index that says that there is none.
_UNSUPPORTED = 4
_NOWHERE = ctypes.c_size_t(-1).value


_FLOATS = {float}


def _picker(names: Sequence[str]) -> Callable[[Mapping[str, Any]], tuple[Any, ...]]:
    """A function that takes these entries of a mapping, in order; it raises KeyError where one is missing."""
    pick = itemgetter(*names)
    return pick if len(names) > 1 else lambda given: (pick(given),)


def _fault(name: str, signal: str, field: str, index: int | None) -> Fault:
    return fault(name, signal, field, index, name.replace("_", " "))


def _floats(column: Any, label: str, name: str) -> Floats:
    """A column of numbers, None as NaN; raises Refused for anything else."""
    kinds = {type(value) for value in column} if isinstance(column, list | tuple) else {bool}
    if type(column) is np.ndarray:
        kinds = {bool} if column.dtype.kind not in "iuf" else {float}
    if not kinds <= {int, float, type(None), np.float64}:
        raise Refused("wrong_type", label, name)
    try:
        return np.array(
            [math.nan if v is None else v for v in column] if type(None) in kinds else column,
            dtype=np.float64,
        )
    except OverflowError:
        return np.array([math.inf if abs(value) > 1e308 else value for value in column], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise Refused("wrong_type", label, name) from error


def _number(value: Any, signal: str, field: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float | np.integer | np.floating):
        raise Refused("wrong_type", signal, field)
    try:
        return float(value)
    except OverflowError:
        return math.inf
