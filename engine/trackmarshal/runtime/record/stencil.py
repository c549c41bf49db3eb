"""The rows of a record that differ from an earlier one in numbers alone, verdicts among them: that row again, with those of the cycle at hand.

In most cycles, nothing else is new: as many samples and elements, the same ids and borders, and what is said against them as long, to the letter.
Their numbers stand one after the other in the frame's arena, and are put into the row by one call.
"""

from __future__ import annotations

import math
import struct
import sys
import zlib
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from trackmarshal.runtime.cycle import DRIVING, EMERGENCY
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Arena, Frame
from trackmarshal.runtime.program import Copied, Judged
from trackmarshal.runtime.record.arrow import Layout

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: A field of numbers: whether it is a candidate's, candidate or signal, and its name.
Place = tuple[bool, str, str]
#: Of a row: its place, number, stamp, both readings and how many cycles are missing; of what is driven: number and stamp.
_TIMES, _DRIVEN, _CHECKSUM = struct.Struct("<qqdddq"), struct.Struct("<qd"), struct.Struct("<q")
_OUTCOME = ("violations", "verdicts.driving", "verdicts.emergency", "margins.driving", "margins.emergency")
#: An arena is memory of this machine, and a row is as every machine reads it.
_LITTLE = sys.byteorder == "little"
#: Rows that are remembered.
_ROWS = 16
#: A letter for each verdict code, and for no other.
_SPELLED = b"svuio".ljust(256, b"\xff")


def letters(codes: bytes) -> str:
    """Verdicts as they stand in a row; raises ValueError for what is none."""
    return codes.translate(_SPELLED).decode("ascii")


class Stencils:
    """Rows by all that is in them besides numbers, verdicts and violations, and by how long these are.

    layout: what rows are written with. numbers: the fields whose numbers are in arenas, by the number of their column. closed, events: the
    signals that say whether something is so.
    """

    def __init__(
        self, layout: Layout, numbers: Mapping[int, Place], closed: Sequence[str], events: Sequence[str]
    ) -> None:
        self._layout, self._numbers, self._closed, self._events = layout, numbers, closed, events
        #: None: there was one row of these, and there may never be another.
        self._rows: dict[tuple[Any, ...], _Stencil | None] = {}

    def row(
        self, times: Sequence[Any], texts: Sequence[str], frame: Frame, decision: Decision, violations: str, whole: Callable[[], bytes]
    ) -> bytes | bytearray:  # fmt: skip
        """The row of a cycle without a fault, with the lines of the row before; its memory is used again for the next one. texts: what else the row has of the
        cycle. violations: as they stand in it. whole: writes it where nothing like it is known; empty where it cannot."""
        arena, judged, driven = frame.arena, decision.judged, decision.driven
        if arena is None or judged is None or not _LITTLE:
            return whole()
        outcome = violations.encode(), *_outcome(judged)
        others = (
            *texts, arena.data[8 : arena.begin], tuple(arena.shape.ids), *[frame.closed.get(name, False) for name in self._closed],
            *[frame.events[name] for name in self._events], *map(len, outcome), decision.state, decision.safe, decision.lost,
            None if driven is None else driven.candidate,
        )  # fmt: skip
        stencil = self._rows.get(others)
        if stencil is not None:
            ahead = (-1, math.nan) if driven is None else (driven.number, driven.t)
            return stencil.filled(times, ahead, arena, outcome)
        row = whole()
        if row:
            again = others in self._rows
            if len(self._rows) >= _ROWS and not again:
                self._rows.clear()
            self._rows[others] = _Stencil(self._layout, row, arena, self._numbers) if again else None
        return row


class _Stencil:
    """A row as it was written, of a cycle in an arena."""

    def __init__(self, layout: Layout, row: bytes, arena: Arena, numbers: Mapping[int, Place]) -> None:
        begins = layout.places(row)
        named = {name: begin for begin, (name, _) in zip(begins, layout.columns, strict=True)}
        left = {place: begins[column] // 8 for column, place in numbers.items()}
        called = (DRIVING, EMERGENCY, *arena.shape.called)
        where: list[NDArray[np.int64]] = []
        for at, (signal, names, count) in enumerate(
            zip(called, arena.shape.names, arena.counts, strict=True)
        ):
            where += [np.arange(count) + left.pop((at < 2, signal, field)) for field in names.numbers]
        if left:
            raise AssertionError(f"not in the arena: {list(left)}")
        self._where, self._begin = np.concatenate(where), arena.begin
        self._row = bytearray(row)
        #: The same memory; as whole numbers, so that the bits of a NaN stay.
        self._view, self._words = memoryview(self._row), np.frombuffer(self._row, np.int64)
        self._times, self._driven = named["row"], named["driven_number"]
        self._outcome = [named[name] for name in _OUTCOME]
        self._checksum = layout.body
        #: Of all before the first number, which stays as it is; the checksum itself counts as zero.
        self._crc = zlib.crc32(bytes(8), zlib.crc32(row[: layout.body]))
        self._rest = self._view[layout.body + 8 :]

    def filled(
        self, times: Sequence[Any], driven: Sequence[Any], arena: Arena, outcome: Sequence[bytes]
    ) -> bytearray:
        """The row of another cycle."""
        view = self._view
        _TIMES.pack_into(view, self._times, *times)
        _DRIVEN.pack_into(view, self._driven, *driven)
        self._words[self._where] = np.frombuffer(arena.data, np.int64, offset=self._begin)
        for begin, data in zip(self._outcome, outcome):
            view[begin : begin + len(data)] = data
        _CHECKSUM.pack_into(view, self._checksum, zlib.crc32(self._rest, self._crc))
        return self._row


def _outcome(judged: Judged) -> tuple[bytes, ...]:
    """Letters of verdicts, then margins, both of driving first."""
    rated = judged.rated
    if isinstance(rated, Copied):
        said, numbers = letters(rated.verdicts).encode(), rated.margins
        count, width = len(said) // 2, len(numbers) // 2
        return said[:count], said[count:], numbers[:width], numbers[width:]
    both = [rated[name] for name in (DRIVING, EMERGENCY)]
    margins = [np.asarray(one.margins, dtype=np.float64).tobytes() for one in both]
    return *[letters(one.verdicts).encode() for one in both], *margins
