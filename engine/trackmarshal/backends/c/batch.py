"""A compiled program on many cases of one shape at once, from numpy arrays.

For data that has passed the input contract: what is here evaluates, it does not judge inputs.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.c.program import CProgram
from trackmarshal.errors import TrackmarshalError

Floats = NDArray[np.float64]


def run_columns(
    program: CProgram,
    columns: Mapping[tuple[str, str], Floats],
    numbers: Mapping[tuple[str, str], Floats] | None = None,
    flags: Mapping[tuple[str, str], Any] | None = None,
) -> tuple[NDArray[np.int8], Floats]:
    """Many cases of one shape, once: see `prepared_columns`."""
    return prepared_columns(program, columns, numbers, flags)()


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
