"""A record that is being written, row by row as cycles are decided."""

from __future__ import annotations

import errno
import json
import math
import os
import struct
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.runtime.contract import Contract
from trackmarshal.runtime.cycle import DRIVING, EMERGENCY, Limits
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.frame import Frame, Packed
from trackmarshal.runtime.record.arrow import END, Layout
from trackmarshal.runtime.record.columns import (
    FORMAT,
    TIMES,
    VERSION,
    all_si,
    columns_of,
    empty,
    empty_decision,
    inputs_of,
)
from trackmarshal.runtime.record.decided import decided, spelt, violations
from trackmarshal.runtime.record.left_out import left_out_of, spare_of, track_names
from trackmarshal.runtime.record.raw import plain
from trackmarshal.runtime.record.snapshots import EVERY, Snapshots
from trackmarshal.runtime.record.stencil import Stencils
from trackmarshal.runtime.saving import Saving

#: Endings of other formats: what opens a file by its name would find no file of its own under them.
_OTHERS = (".mcap", ".jsonl", ".json", ".csv", ".saa", ".gz", ".zip", ".parquet", ".feather", ".yaml", ".yml")


class Record:
    """A record that is being written; satisfies `Recorder`. Close it, or let the process die: what was appended stays.

    identity: the judge's. saving: what a replay from the middle needs (`Supervisor.saving`), saved after so many cycles (`every`; 0: never),
    a little of it in each of the next ones; without it, a replay starts at the beginning. sync waits in every cycle until the disk has the data (against a power failure; a process that is killed loses
    nothing either way). Raises E483 where the file cannot be made or is there already, or has the ending of another format.
    """

    def __init__(
        self,
        path: str | Path,
        contract: Contract,
        limits: Limits,
        identity: Mapping[str, Any],
        sync: bool = False,
        saving: Callable[[], Saving] | None = None,
        every: int = EVERY,
    ) -> None:
        _refuse_ending(path)
        self._sync = sync
        self._snapshots = Snapshots(saving, every)
        self._inputs = inputs_of(contract)
        #: The same with all numbers of a signal, which stand one after the other, as one part, and how many these are.
        self._parts = [
            (*one, count)
            for one, count in Counter(
                (part, signal, "" if part in ("plan", "column", "number") else field)
                for part, signal, field, _ in self._inputs
            ).items()
        ]
        #: Numbers come in as they are kept: then what passed the door is what came in.
        self._plain = all_si(contract)
        #: The signals that may name the track.
        self._corridors = [signal for part, signal, *_ in self._inputs if part == "name"]
        self._spare = spare_of(contract)
        self._kept: dict[tuple[str, str], Any] = {}
        #: How long the file is up to its last whole row, and cycles since then that have none.
        self._end = 0
        self._missed = 0
        #: What the next cycles rest on, as long as it could not be written.
        self._resting = ""
        #: How many rows the file has.
        self._rows = 0
        #: How many cycles there were, which the last row says.
        self._cycles = 0
        #: Whether the file may be longer than that.
        self._longer = False
        head = {
            "format": FORMAT,
            "version": VERSION,
            "counted": True,
            "identity": dict(identity),
            "limits": {name: spelt(value) for name, value in asdict(limits).items()},
        }
        head["inputs"] = [list(one) for one in self._inputs]
        self._layout = Layout(columns_of(self._inputs), head)
        # Behind the row, what came in, and what did not.
        places = enumerate(self._inputs, len(TIMES) + 3)
        self._stencils = Stencils(
            self._layout,
            {at: (part == "plan", signal, field) for at, (part, signal, field, _) in places if part in ("plan", "column", "number")},
            [signal for part, signal, *_ in self._inputs if part == "closed"],
            [signal for part, signal, *_ in self._inputs if part == "event"],
        )  # fmt: skip
        try:
            self._file = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | os.O_APPEND, 0o644)
            self._write(self._layout.schema)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            message = f"the record cannot be made: {reason}"
            raise TrackmarshalError(
                "E483", message, file=str(path), help="records are never overwritten; name a new file"
            ) from error

    def append(
        self, cycle: object, frame: Frame | None, decision: Decision, readings: tuple[float, float]
    ) -> None:
        """One more row. Raises OSError where the disk refuses it; the file then ends with the row before, and the next row that can be
        written says how many are missing."""
        number = -1 if decision.number is None else decision.number
        if self._resting:
            self._rest()
        times = [self._rows, number, decision.t, *readings, self._missed]
        self._missed += 1  # until it is written
        self._cycles += 1
        row: bytes | bytearray = b""
        kept = self._kept
        if frame is not None and self._plain and not decision.faults:
            names = track_names(cycle, self._corridors)
            left_out = None if names is None else left_out_of(cycle, self._spare, names)
            if names is not None and left_out is not None:
                row = self._row(times, left_out, [name or "" for name in names.values()], frame, decision)
            kept = frame.lines if row else kept
        if not row:
            raw = json.dumps(plain(cycle))
            row = self._layout.batch([*times, raw, "", *empty(self._inputs), *decided(decision)])
        try:
            self._add(row)
        except OSError:
            self._kept = {}  # whoever reads the next row has no border from this one
            raise
        self._kept, self._missed = kept, 0
        part = self._snapshots.next()
        if part:
            self._beside(part)

    def stopped(self) -> None:
        """A cycle that has no row: what comes behind it rests on it, and nobody knows what would have been decided."""
        self._missed += 1
        self._cycles += 1

    def restored(self, lines: Sequence[str]) -> None:
        """The next cycles rest on what this snapshot says, and not on the rows before. Raises OSError where the disk refuses it; the next cycle then
        has no row before it has one."""
        self._resting = self._snapshots.restored(lines)
        self._add(self._no_cycle(-1, 0, self._resting))
        self._resting = ""

    def _rest(self) -> None:
        """What could not be written of where the run goes on from, before a cycle; where that has no row again, it has none either."""
        try:
            self._add(self._no_cycle(-1, 0, self._resting))
        except OSError:
            self.stopped()
            raise
        self._resting = ""

    @property
    def snapshot_error(self) -> str:
        """Why the record has no snapshots any more; empty where it has."""
        return self._snapshots.error

    def _beside(self, part: str) -> None:
        """A part of a snapshot, in a row that is no cycle. Where the disk refuses it, that snapshot is none: the cycles are whole."""
        try:
            self._add(self._no_cycle(-1, 0, part))
        except OSError:
            self._snapshots.drop()

    def close(self) -> None:
        """End the stream; nothing can be appended any more."""
        if self._file >= 0:
            for part in self._snapshots.rest():
                self._beside(part)
            self._add(self._no_cycle(self._cycles, self._missed, ""))
            self._write(END)
            os.close(self._file)
            self._file = -1

    def _no_cycle(self, number: int, missed: int, raw: str) -> bytes:
        """A row without a decision."""
        times = [self._rows, number, math.nan, math.nan, math.nan, missed]
        return self._layout.batch([*times, raw, "", *empty(self._inputs), *empty_decision()])

    def _add(self, row: bytes | bytearray) -> None:
        self._write(row)
        self._rows += 1

    def _write(self, data: bytes | bytearray) -> None:
        """Write all of it, or nothing: what was written of it is cut off again."""
        if self._file < 0:
            raise OSError(errno.EBADF, "the record is closed")
        if self._longer:
            os.ftruncate(self._file, self._end)  # that could not be done when it was written
        self._longer = True
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._file, view) :]
            if self._sync:  # what the disk may not have counts as not written
                os.fsync(self._file)
        except OSError:
            with suppress(OSError):
                os.ftruncate(self._file, self._end)
            raise
        self._end += len(data)
        self._longer = False

    def _row(
        self, times: list[Any], left_out: str, names: list[str], frame: Frame, decision: Decision
    ) -> bytes | bytearray:
        """The row of a cycle that passed the door; empty for one with an id that is no text, which JSON can spell."""

        def whole() -> bytes:
            outcome = decided(decision)
            try:
                return self._layout.batch([*times, "", left_out, *self._passed(frame, names), *outcome])
            except ValueError:
                return b""

        lines, kept = frame.lines, self._kept
        same = lines is kept or all(line is kept.get(place) for place, line in lines.items())
        if not same:
            return whole()
        return self._stencils.row(times, (left_out, *names), frame, decision, violations(decision), whole)

    def _passed(self, frame: Frame, names: Sequence[str]) -> list[Any]:
        """The columns of what passed the door; names: those of its tracks."""
        passed: list[Any] = []
        named = iter(names)
        candidates, columns = _packed(frame)
        for part, signal, field, fields in self._parts:
            if part in ("plan", "column"):
                count, _, data = (candidates if part == "plan" else columns)[signal]
                width = 8 * count
                passed += [data[i * width : (i + 1) * width] for i in range(fields)]
            elif part == "number":
                passed += struct.unpack(f"<{fields}d", columns[signal].numbers)
            elif part == "ids":
                passed.append(columns[signal].ids)
            elif part in ("x", "y"):
                line = frame.line(signal, field)
                same = line is self._kept.get((signal, field))
                passed.append(b"" if same else line.points[:, 0 if part == "x" else 1])
            elif part == "closed":
                passed.append(int(frame.closed.get(signal, False)))
            elif part == "name":
                passed.append(next(named))
            elif part == "event":
                passed.append(frame.events[signal])
            else:
                raise AssertionError(f"unknown part {part}")
        return passed


def _refuse_ending(path: str | Path) -> None:
    """Raise E483 for a name that says that the file is of another format."""
    ending = Path(path).suffix
    if ending.lower() not in _OTHERS:
        return
    name = f"{Path(path).stem.removesuffix('.arrows')}.arrows"
    after = (
        f", from which `trackmarshal replay {name} --mcap FILE` makes MCAP"
        if ending.lower() == ".mcap"
        else ""
    )
    raise TrackmarshalError(
        "E483", f"the record cannot be made: it is a stream of Arrow, and no {ending}", file=str(path),
        help=f"its ending is .arrows: `{name}`{after}",
    )  # fmt: skip


def _packed(frame: Frame) -> tuple[dict[str, Packed], dict[str, Packed]]:
    """Candidates and columns of a frame as memory; where they are in an arena, nothing is made of them for that."""
    if frame.arena is not None:
        driving, emergency, *others = frame.arena.packed()
        return {DRIVING: driving, EMERGENCY: emergency}, dict(zip(frame.arena.shape.called, others))
    candidates, columns = (
        {name: Packed(one.count, one.ids, one.packed()) for name, one in held.items()}
        for held in (frame.candidates, frame.columns)
    )
    return candidates, columns
