"""A compiled program on numpy arrays: one cycle at a time without allocation, or many cases of one shape at once.

For data that has passed the input contract: what is here evaluates, it does not judge inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.c.places import sources
from trackmarshal.backends.c.program import CProgram
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.case import Case

Floats = NDArray[np.float64]
Points = Sequence[tuple[float, float]]


class Stepper:
    """One context and one set of buffers: `step` copies a cycle's arrays in and runs all rules.

    samples, elements: how many a timeline and a set may have. Parameters and tables are the spec's own, or those of
    `settings`, a case as its reader makes them.
    """

    def __init__(
        self,
        program: CProgram,
        samples: int = 64,
        elements: int = 32,
        border: int = 2048,
        settings: Case | None = None,
    ) -> None:
        self._program = program
        self._limits = (samples, elements)
        self._border = border
        order = program.order
        self._library = program.new_library(samples, elements, border, settings)
        self._tracks = list(sources(program.source.plan))
        size = max(samples, elements)
        numeric = [(name, field) for name, field, flag in order.columns if not flag]
        boolean = [(name, field) for name, field, flag in order.columns if flag]
        self._doubles = np.zeros((max(1, len(numeric)), size))
        self._bytes = np.zeros((max(1, len(boolean)), size), dtype=np.int8)
        rows = {key: self._doubles[i] for i, key in enumerate(numeric)} | {
            key: self._bytes[i] for i, key in enumerate(boolean)
        }
        pointers = np.array(
            [rows[name, field].ctypes.data for name, field, _ in order.columns] or [0], dtype=np.uint64
        )
        self._columns: list[tuple[str, int, bool, list[tuple[str, Any]]]] = []
        for index, name in enumerate(order.counts):
            own = [(field, rows[name, field]) for signal, field, _ in order.columns if signal == name]
            self._columns.append((name, index, program.spec.signals[name].sequence, own))
        self._counts = np.zeros(max(1, len(order.counts)), dtype=np.uint64)
        self._numbers = np.full(max(1, len(order.numbers)), np.nan)
        self._flags = np.full(max(1, len(order.flags)), -1, dtype=np.int8)
        count = len(program.rules)
        #: (rules,) margins and verdict codes (places in runtime.verdict.VERDICTS) of the last step.
        self.margins = np.full(max(1, count), np.nan)
        self.verdicts = np.full(max(1, count), 2, dtype=np.int8)
        self._kept = pointers
        self._run = self._library.dll.tmg_run
        self._arguments = (
            self._library.context, 1, self._counts.ctypes.data, pointers.ctypes.data, self._numbers.ctypes.data, self._flags.ctypes.data,
            self.margins.ctypes.data, self.verdicts.ctypes.data,
        )  # fmt: skip

    def track(self, signal: str, left: Points, right: Points = (), closed: bool = False) -> int:
        """Set the borders of a corridor, or the points of a line, once for many steps; 0 when all of it is usable.

        Raises TrackmarshalError E473 for what is more than the capacity, or a closed track whose borders cross.
        """
        a, b = (np.ascontiguousarray(points, dtype=np.float64).reshape(-1, 2) for points in (left, right))
        status: int = self._library.dll.tmg_set_place(
            self._library.context,
            self._tracks.index(signal),
            a.ctypes.data,
            len(a),
            b.ctypes.data,
            len(b),
            int(closed),
        )
        if status in (1, 4):
            raise TrackmarshalError(
                "E473", f"the C geometry refuses `{signal}`", help="choose another backend"
            )
        return status

    def step(self, signals: Mapping[str, Any]) -> int:
        """Run all rules on one cycle; 0, or the status of a cycle that does not fit (every rule is then undefined).

        signals: columns by field for timelines and sets, a mapping of numbers for records, True, False or None for events.
        """
        for name, index, sequence, columns in self._columns:
            given = signals[name]
            n = 0
            for field, row in columns:
                column = given[field]
                n = len(column)
                if n > self._limits[0 if sequence else 1]:
                    self._refuse()
                    return 1
                row[:n] = column
            self._counts[index] = n
        order = self._program.order
        self._numbers[: len(order.numbers)] = [signals[name][field] for name, field in order.numbers]
        self._flags[: len(order.flags)] = [
            _code(signals[name][field] if field else signals[name]) for name, field in order.flags
        ]
        status: int = self._run(*self._arguments)
        return status

    def _refuse(self) -> None:
        self.margins[:] = np.nan
        self.verdicts[:] = 2


def run_columns(
    program: CProgram,
    columns: Mapping[tuple[str, str], Floats],
    numbers: Mapping[tuple[str, str], Floats] | None = None,
    flags: Mapping[tuple[str, str], Any] | None = None,
) -> tuple[NDArray[np.int8], Floats]:
    """Many cases of one shape, once: see `prepared_columns`."""
    return prepared_columns(program, columns, numbers, flags)()


def _code(value: bool | None) -> int:
    return -1 if value is None else int(value)


def prepared_columns(program: CProgram, columns: Mapping[tuple[str, str], Floats], numbers: Mapping[tuple[str, str], Floats] | None = None,
                flags: Mapping[tuple[str, str], Any] | None = None) -> Callable[[], tuple[NDArray[np.int8], Floats]]:  # fmt: skip
    """Many cases of one shape, to be run again and again: a function that gives (cases, rules) verdict codes and margins.

    columns: (signal, field) -> (cases, samples) float64, Booleans int8 with -1 for missing; numbers and flags:
    (signal, field) -> (cases,), events with field "". The program's own parameters and tables count.
    """
    order = program.order
    arrays = [
        _rows(columns[name, field], np.int8 if flag else np.float64) for name, field, flag in order.columns
    ]
    scalars, booleans = numbers or {}, flags or {}
    cases = (
        len(arrays[0])
        if arrays
        else max((len(v) for v in (*scalars.values(), *booleans.values())), default=0)
    )
    lengths = {name: array.shape[1] for (name, _, _), array in zip(order.columns, arrays)}
    if any(
        len({a.shape for (n, _, _), a in zip(order.columns, arrays) if n == name}) > 1 for name in lengths
    ) or any(len(a) != cases for a in arrays):
        raise ValueError("the columns have different shapes")
    sequences = [n for name, n in lengths.items() if program.spec.signals[name].sequence]
    lib = program.library_for(max(sequences, default=0), max(lengths.values(), default=0))
    program.reset(lib)
    rows = np.arange(cases, dtype=np.uint64)[:, None]
    base = np.array([a.ctypes.data for a in arrays], dtype=np.uint64)
    stride = np.array([a.strides[0] for a in arrays], dtype=np.uint64)
    pointers = np.ascontiguousarray(base + rows * stride)
    counts = np.tile(np.array([lengths.get(name, 0) for name in order.counts], dtype=np.uint64), (cases, 1))
    given = np.ascontiguousarray(
        np.array([scalars[key] for key in order.numbers], dtype=np.float64).reshape(-1, cases).T
    )
    booleans_ = np.ascontiguousarray(
        np.array([booleans[key] for key in order.flags], dtype=np.int8).reshape(-1, cases).T
    )
    margins = np.full((cases, len(program.rules)), np.nan)
    verdicts = np.full((cases, len(program.rules)), 2, dtype=np.int8)
    kept = (arrays, pointers, counts, given, booleans_)
    arguments = (
        lib.context, cases, counts.ctypes.data, pointers.ctypes.data, given.ctypes.data, booleans_.ctypes.data, margins.ctypes.data,
        verdicts.ctypes.data,
    )  # fmt: skip

    def run() -> tuple[NDArray[np.int8], Floats]:
        status = lib.dll.tmg_run(*arguments) if kept else 0
        if status != 0:
            raise TrackmarshalError("E473", f"the program refuses the input (status {status})")
        return verdicts, margins

    return run


def _rows(given: Any, kind: type) -> NDArray[Any]:
    """An array whose rows are contiguous; rows may be one and the same (`np.broadcast_to`)."""
    array: NDArray[Any] = np.asarray(given, dtype=kind)
    if array.ndim == 2 and array.strides[1] == array.itemsize and array.strides[0] >= 0:
        return array
    return np.ascontiguousarray(array)
