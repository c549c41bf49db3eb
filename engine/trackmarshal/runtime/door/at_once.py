"""Cycles as most of them come, read in one go: dicts of float64 arrays and of floats, with names that are declared and nothing missing.

Anything else is for the readers of each signal, which say what is wrong with it, if anything is.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from trackmarshal.runtime.contract import RECORD, TIMELINE
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.frame import Arena, Columns

_ARRAYS = {np.ndarray}
_FLOATS = {float, np.float64}


class AtOnce:
    """Reads all signals of columns of a cycle; their numbers stand in one array, one signal after the other."""

    def __init__(self, readers: Sequence[ColumnsReader]) -> None:
        self._readers = readers
        #: Whether there are numbers in SI and nothing else, as it has to be.
        self._fits = all(reader.plain for reader in readers)

    def read(self, raws: list[Any]) -> tuple[list[Columns], Arena] | None:
        """The columns of each signal, and the arena in which they stand; None for what takes a closer look."""
        if not self._fits:
            return None
        try:
            return self._read(raws)
        except Exception:  # whatever it is, a closer look says what is wrong with it
            return None

    def _read(self, raws: list[Any]) -> tuple[list[Columns], Arena] | None:
        arrays: list[Any] = []
        shapes: list[tuple[ColumnsReader, int, tuple[str, ...]]] = []
        for reader, raw in zip(self._readers, raws, strict=True):
            if type(raw) is not dict or not raw.keys() <= reader.known:
                return None
            form = reader.signal.form
            if form == RECORD:
                found = reader.picked(raw, 1)
                if not _FLOATS.issuperset(map(type, found)):
                    return None
                arrays.append(np.array(found))
                shapes.append((reader, 1, ()))
                continue
            (count,) = set(map(len, raw.values()))
            if not count and form == TIMELINE:
                return None
            ids = reader.ids_of(raw, count)
            if ids is None:
                return None
            arrays += reader.picked(raw, count)
            shapes.append((reader, count, ids))
        if set(map(type, arrays)) != _ARRAYS:
            return None
        arena = np.concatenate(arrays, casting="no", dtype=np.float64)
        if arena.ndim != 1:
            return None
        arena.setflags(write=False)
        made, at = [], 0
        for reader, count, ids in shapes:
            made.append(Columns.within(reader.names, arena, at, count, ids))
            at += len(reader.names.numbers) * count
        return made, Arena(arena, b"")
