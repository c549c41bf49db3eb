"""Cycles as most of them come, read in one go: dicts of float64 arrays and of floats, with names that are declared and nothing missing.

Anything else is for the readers of each signal, which say what is wrong with it, if anything is.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.runtime.contract import RECORD, TIMELINE
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.frame import Arena, Shape

Remembered = tuple[tuple[str, tuple[str, ...], tuple[Any, ...]], ...]
_ARRAYS = {np.ndarray}
_FLOATS = {float, np.float64}


def floats(data: bytes) -> NDArray[np.float64]:
    """Numbers of this machine, which nobody can change."""
    return np.frombuffer(data, np.float64)


class AtOnce:
    """Reads all signals of columns of a cycle; their numbers stand in one array, one signal after the other. readers: of the two candidates,
    then of the signals."""

    #: Whether it looks at what is remembered.
    remembers = False

    def __init__(self, readers: Sequence[ColumnsReader]) -> None:
        self._readers = readers
        self._called = tuple(reader.signal.name for reader in readers[2:])
        self._names = tuple(reader.names for reader in readers)
        #: What signals that are no columns were in a cycle that had all of them in order, as (name, names within, objects): objects that nobody
        #: can change. None where nothing is known of that.
        self.remembered: Remembered | None = None
        #: Whether there are numbers in SI and nothing else, as it has to be.
        self._fits = all(reader.plain for reader in readers)

    def read(self, driving: Any, emergency: Any, signals: dict[Any, Any]) -> Arena | None:
        """The arena in which the numbers of a cycle stand; None for what takes a closer look."""
        if not self._fits:
            return None
        try:
            return self._read(driving, emergency, signals)
        except Exception:  # whatever it is, a closer look says what is wrong with it
            return None

    def learn(self) -> None:
        """Readers have taken a closer look, and may know other ids."""

    def _read(self, driving: Any, emergency: Any, signals: dict[Any, Any]) -> Arena | None:
        arrays: list[Any] = []
        all_ids: list[tuple[str, ...]] = []
        words, begin = array("q", [0]), 8 * (1 + 3 * len(self._readers))
        raws = [driving, emergency, *map(signals.get, self._called)]
        for reader, raw in zip(self._readers, raws, strict=True):
            if type(raw) is not dict or not raw.keys() <= reader.known:
                return None
            form = reader.signal.form
            if form == RECORD:
                found = reader.picked(raw, 1)
                if not _FLOATS.issuperset(map(type, found)):
                    return None
                arrays.append(np.array(found))
                all_ids.append(())
                words.extend((begin, 0, 1))
                begin += 8 * len(found)
                continue
            (count,) = set(map(len, raw.values()))
            if not count and form == TIMELINE:
                return None
            ids = reader.ids_of(raw, count)
            if ids is None:
                return None
            arrays += reader.picked(raw, count)
            all_ids.append(ids)
            words.extend((begin, 0, count))
            begin += 8 * count * len(reader.names.numbers)
        if set(map(type, arrays)) != _ARRAYS:
            return None
        numbers = np.concatenate(arrays, casting="no", dtype=np.float64)
        if numbers.ndim != 1:
            return None
        return Arena(words.tobytes() + numbers.tobytes(), Shape(self._called, self._names, all_ids, floats))
