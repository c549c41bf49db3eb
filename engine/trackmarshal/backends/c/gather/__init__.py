"""Reads a cycle of arrays as `runtime.door.at_once` does, in C: what takes 30 calls of numpy is one call. The same columns come out."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from trackmarshal.backends.c.build import small_library
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import RECORD, SET, TIMELINE
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door.at_once import AtOnce
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.frame import Arena, Columns


class _Wanted(ctypes.Structure):
    """A `wanted` of gather.c."""

    _fields_ = [(name, ctypes.c_int64) for name in ("width", "record", "most", "least")]


class Gathered(AtOnce):
    """Reads all signals of columns of a cycle. Raises TrackmarshalError or OSError where C cannot be had."""

    def __init__(self, readers: Sequence[ColumnsReader], limits: Limits) -> None:
        super().__init__(readers)
        self._run = ctypes.PyDLL(str(small_library(Path(__file__).with_name("gather.c")))).gather
        pointer = ctypes.c_void_p
        given = ctypes.py_object
        self._run.argtypes = [given, pointer, ctypes.c_int64, *[pointer] * 4, given, pointer]
        self._run.restype = ctypes.c_int64
        widths = [len(reader.names.numbers) for reader in readers]
        most = [
            1 if r.signal.form == RECORD else limits.elements if r.signal.form == SET else limits.samples
            for r in readers
        ]
        self._wanted = (_Wanted * len(readers))(
            *(
                _Wanted(width, reader.signal.form == RECORD, entries, int(reader.signal.form == TIMELINE))
                for reader, width, entries in zip(readers, widths, most)
            )
        )
        fields = [field for reader in readers for field in reader.signal.numbers]
        #: Interned, so that looking them up compares addresses.
        self._texts = [sys.intern(name) for reader in readers for name in reader.names.numbers]
        self._names = np.array([id(text) for text in self._texts], dtype=np.uint64)
        self._defaults = np.array([0.0 if f.default is None else f.default for f in fields])
        self._optional = np.array([f.default is not None for f in fields], dtype=np.uint8)
        self._id = "id"
        self._types = np.array(
            [id(one) for one in (dict, np.ndarray, float, np.float64, self._id)], dtype=np.uint64
        )
        self._each = [
            (reader, reader.names, width, reader.signal.form == SET) for reader, width in zip(readers, widths)
        ]
        #: Three words a signal, of which the last is how many entries it has.
        self._words = bytearray(24 * len(readers))
        self._counts = memoryview(self._words).cast("q")[2::3]
        self._room = sum(width * entries for width, entries in zip(widths, most))
        self._before = (
            ctypes.addressof(self._wanted), len(readers), self._names.ctypes.data, self._defaults.ctypes.data,
            self._optional.ctypes.data, self._types.ctypes.data,
        )  # fmt: skip
        self._after = ctypes.addressof(ctypes.c_char.from_buffer(self._words))

    def _read(self, raws: list[Any]) -> tuple[list[Columns], Arena] | None:
        numbers = np.empty(self._room)
        if self._run(raws, *self._before, numbers, self._after) < 0:
            return None
        numbers.setflags(write=False)
        made, at = [], 0
        for (reader, names, width, is_set), raw, count in zip(self._each, raws, self._counts):
            ids = reader.ids_of(raw, count) if is_set else ()
            if ids is None:
                return None
            made.append(Columns.within(names, numbers, at, count, ids))
            at += width * count
        return made, Arena(numbers, bytes(self._words))


def fastest(readers: Sequence[ColumnsReader], limits: Limits) -> AtOnce:
    """Gathered in C where that can be had, else one call of numpy after the other: the columns are the same."""
    try:
        return Gathered(readers, limits)
    except (TrackmarshalError, OSError):
        return AtOnce(readers)
