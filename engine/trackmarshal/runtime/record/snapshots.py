"""Snapshots in the record of a run: written a little in each step, beside the cycles, and found again when it is read.

A part is one JSON object: `{"snapshot": N, "part": K, "last": false, "lines": [...]}`, with lines of `saving.py`. It is what the run came to after
the first N cycles of the record; parts of one snapshot are counted from 0. One of which the last part is missing is none. One with `"restored": true`
at its end was not taken of this run, which went on from it there.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.saving import Saving, Writer

#: After how many cycles a snapshot is begun.
EVERY = 200
#: How many lines are made in a step, and in how many characters; from how many on they are written.
_LINES, _LENGTH, _FULL = 8, 2_000, 32_000
_HEAD = re.compile(r'\{"snapshot":(\d+),"part":(\d+),"last":(true|false),"lines":\[')
#: How a snapshot ends that the run went on from. No text within has these quotes.
_RESTORED = ',"restored":true}'


class Snapshots:
    """Takes snapshots of something that counts cycles. every: after how many; 0, or nothing to save: never. Raises TrackmarshalError E481 for what is no number of cycles."""

    def __init__(self, saving: Callable[[], Saving] | None, every: int = EVERY) -> None:
        if type(every) is not int or every < 0:
            message = f"snapshots are taken after so many cycles, not after {every!r:.40}"
            raise TrackmarshalError("E481", message, help="a whole number; 0: never")
        self._saving = saving if every else None
        self._every = every
        self._cycles = 0
        self._writer: Writer | None = None
        self._after = self._part = self._size = 0
        self._lines: list[str] = []
        #: Why there are no more; empty where there are.
        self.error = ""

    def next(self) -> str:
        """A cycle was written: the part of a snapshot that is to be written now; empty where there is none."""
        self._cycles += 1
        if self._saving is None:
            return ""
        try:
            if self._writer is None:
                if self._cycles - self._after < self._every:
                    return ""
                self._writer, self._after, self._part = Writer(self._saving()), self._cycles, 0
            return self._more(self._writer)
        except Exception as error:
            return self._fail(error)

    def rest(self) -> Iterator[str]:
        """The parts that are still to come of what was begun."""
        while self._writer is not None:
            try:
                part = self._more(self._writer)
            except Exception as error:
                part = self._fail(error)
            if part:
                yield part

    def restored(self, lines: Sequence[str]) -> str:
        """A snapshot that the run goes on from, as one part: it is restored between two steps, where nobody waits."""
        self.drop()  # what was being saved is no more where the run is
        return (
            f'{{"snapshot":{self._cycles},"part":0,"last":true,"lines":{json.dumps(list(lines))}{_RESTORED}'
        )

    def drop(self) -> None:
        """Give up the snapshot at hand: a part of it could not be written."""
        self._writer, self._lines, self._size = None, [], 0

    def _more(self, writer: Writer) -> str:
        made = writer.lines(_LINES, _LENGTH)
        self._lines += made
        self._size += sum(map(len, made))
        if not writer.done and self._size < _FULL:
            return ""
        last = "true" if writer.done else "false"
        part = f'{{"snapshot":{self._after},"part":{self._part},"last":{last},"lines":{json.dumps(self._lines)}}}'
        self._part += 1
        self._lines, self._size = [], 0
        if writer.done:
            self._writer = None
        return part

    def _fail(self, error: Exception) -> str:
        """What rules remember cannot be saved: the record goes on without."""
        self.drop()
        self._saving = None
        self.error = f"{type(error).__name__}: {error}"
        return ""


# Reading ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Snapshot:
    """A whole snapshot of a record. after: of how many of its cycles; parts: as they were written; restored: whether the run went on from it."""

    after: int
    parts: tuple[str, ...]
    restored: bool = False

    def lines(self) -> list[str]:
        """Its lines; whoever restores it looks whether they are what was saved. Raises ValueError for what was not written here."""
        found: list[str] = []
        for part in self.parts:
            lines: Any = json.loads(part)["lines"]
            if type(lines) is not list:
                raise ValueError("its lines are none")
            found += lines
        return found


class Parts:
    """Puts the parts of snapshots together as they come."""

    def __init__(self) -> None:
        self.whole: list[Snapshot] = []
        self._after = -1
        self._parts: list[str] = []

    def add(self, part: str, cycles: int) -> None:
        """A part, after so many cycles. Raises ValueError for what is no part of a snapshot of these."""
        head = _HEAD.match(part)
        if head is None or int(head[1]) > cycles:
            raise ValueError("it is no part of a snapshot")
        after, number = int(head[1]), int(head[2])
        if number == 0:
            self._after, self._parts = after, []
        if after != self._after or number != len(self._parts):
            self._after = -1  # a part is missing
            return
        self._parts.append(part)
        if head[3] == "true":
            self.whole.append(Snapshot(after, tuple(self._parts), part.endswith(_RESTORED)))
            self._after = -1
