"""Reads a cycle of arrays as `runtime.door.at_once` does, in C: what takes 30 calls of numpy is one call. The same columns come out."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from trackmarshal.backends.c.calling import shell
from trackmarshal.backends.c.calling.objects import OtherObjectsError, as_known
from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import RECORD, SET, TIMELINE
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door.at_once import AtOnce, floats
from trackmarshal.runtime.door.columns import ColumnsReader
from trackmarshal.runtime.frame import Arena, Shape

#: As gather.h has them: bits of what is said of a cycle, and the first of those that tell which signals have ids.
_UNCHANGED, _WHOLE, _IDS = 1, 2, 2
#: More signals than these take a closer look: there is a bit for each.
_MOST = 60


class _Wanted(ctypes.Structure):
    """A `wanted` of gather.h."""

    _fields_ = [(name, ctypes.c_int64) for name in ("width", "record", "most", "least", "named")]


class _Reading(ctypes.Structure):
    """A `reading` of gather.h."""

    _fields_ = [
        (name, ctypes.c_int64 if name in ("count", "fields") else ctypes.c_void_p)
        for name in ("signals", "count", "called", "fields", "names", "defaults", "optional", "types")
    ]


class Gathered(AtOnce):
    """Reads all signals of columns of a cycle. Raises TrackmarshalError or OSError where C cannot be had, or objects look otherwise here."""

    remembers = True

    def __init__(self, readers: Sequence[ColumnsReader], limits: Limits) -> None:
        super().__init__(readers)
        if not as_known() or len(readers) > _MOST:
            raise OtherObjectsError
        widths = [len(reader.names.numbers) for reader in readers]
        most = [
            1 if r.signal.form == RECORD else limits.elements if r.signal.form == SET else limits.samples
            for r in readers
        ]
        fields = [field for reader in readers for field in reader.signal.numbers]
        wanted = [
            _Wanted(width, s.form == RECORD, entries, s.form == TIMELINE, s.named)
            for s, width, entries in zip([reader.signal for reader in readers], widths, most)
        ]
        types = [
            dict,
            list,
            tuple,
            str,
            np.ndarray,
            float,
            np.float64,
            np.dtype(np.float64),
            sys.intern("id"),
        ]
        # Interned, so that looking them up compares addresses.
        called = [sys.intern(name) for name in self._called]
        names = [sys.intern(name) for reader in readers for name in reader.names.numbers]
        arrays: list[Any] = [
            (_Wanted * len(wanted))(*wanted), _addresses(called), _addresses(names), _addresses(types),
            (ctypes.c_double * len(fields))(*(0.0 if f.default is None else f.default for f in fields)),
            (ctypes.c_ubyte * len(fields))(*(f.default is not None for f in fields)),
        ]  # fmt: skip
        signals, by_name, by_field, by_type, defaults, optional = map(ctypes.addressof, arrays)
        reading = _Reading(signals, len(wanted), by_name, len(fields), by_field, defaults, optional, by_type)
        #: All that C has the addresses of.
        self._kept = (called, names, types, arrays, reading)
        #: Names that are looked for, in the order in which they are.
        self.looked_for = (*called, *names)
        #: Where C finds it.
        self.address = ctypes.addressof(reading)
        self._run: Callable[..., bytes | None] = shell().made_gather(self.address)
        self.learn()

    def learn(self) -> None:
        #: The ids of each signal; and shapes, by what C says of a cycle.
        self.known = tuple(reader.known_ids for reader in self._readers)
        self._shapes: dict[bytes, Shape] = {}

    def read(self, driving: Any, emergency: Any, signals: dict[Any, Any]) -> Arena | None:
        if not self._fits:
            return None
        data = self._run(driving, emergency, signals, self.known, self.remembered)
        if data is None:
            return None
        shape = self._shapes.get(data[:8])
        if shape is None:
            shape = self._shapes[data[:8]] = self._shape(int.from_bytes(data[:8], sys.byteorder))
        return Arena(data, shape)

    def _shape(self, said: int) -> Shape:
        """What C says of a cycle: a bit for each signal that has ids, and more."""
        ids = tuple(
            () if reader.signal.form != SET else known if said >> (_IDS + place) & 1 else None
            for place, (reader, known) in enumerate(zip(self._readers, self.known))
        )
        return Shape(self._called, self._names, ids, floats, bool(said & _UNCHANGED), bool(said & _WHOLE))


def _addresses(objects: Sequence[object]) -> Any:
    return (ctypes.c_void_p * len(objects))(*map(id, objects))


def fastest(readers: Sequence[ColumnsReader], limits: Limits) -> AtOnce:
    """Gathered in C where that can be had, else one call of numpy after the other: the columns are the same."""
    try:
        return Gathered(readers, limits)
    except (TrackmarshalError, OSError):
        return AtOnce(readers)
