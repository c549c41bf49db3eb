"""The planner's side: cycles go to a Supervisor that is a process of its own, its decisions come back."""

from __future__ import annotations

import itertools
import os
import time
from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Protocol

from .messages import (
    NO_COLUMNS,
    PLAIN,
    Entry,
    Kind,
    Layout,
    LinkError,
    Message,
    is_flag,
    is_number,
    is_text,
    is_whole,
    length_of,
    rounded,
)


class Channel(Protocol):
    """`SharedMemory` or `Datagrams`."""

    def send(self, box: str, message: bytearray) -> bool: ...

    def receive(self, seconds: float) -> bytes | None: ...

    def close(self) -> None: ...


class Block:
    """Columns that know how to put themselves into a message; for callers who have them in one piece.

    ids: of a set whose elements are known again in other cycles, the number of each.
    """

    ids: Sequence[int] = ()

    def write(self, message: bytearray, columns: Sequence[tuple[str, Entry]]) -> int:
        """Put all columns at their entries; how many values each has."""
        raise NotImplementedError


class Border:
    """Points of a border or line, x and y by turns in m, that do not change: it is sent once, until another one takes its place."""

    __slots__ = ("count", "number", "points")
    _numbers = itertools.count(1)

    def __init__(self, points: Any) -> None:
        try:
            rows: list[Any] = [points] if isinstance(points, NO_COLUMNS) else list(points)
            # Nobody says what those are numbers of, or in which order.
            if any(isinstance(row, NO_COLUMNS) for row in rows):
                raise LinkError("points are pairs [x, y]")
            flat: list[Any] = [one for x, y in rows for one in (x, y)]
        except (TypeError, ValueError, NotImplementedError) as error:
            raise LinkError("points are pairs [x, y]") from error
        others = [one for one in flat if type(one) not in PLAIN]
        if not all(map(is_number, others)):
            raise LinkError("points are pairs [x, y] of numbers")
        if rounded(others) or any(rounded(row) for row in rows if type(row) not in (list, tuple)):
            raise LinkError(
                "short floats have no two numbers nearer than 1 cm where the points are: give them as float64"
            )
        try:
            # Who changed them would be judged by what was sent before.
            self.points = memoryview(array("d", flat)).toreadonly()
        except OverflowError as error:
            raise LinkError(f"points are pairs [x, y] of numbers that a double holds: {error}") from error
        self.count = len(flat) // 2
        self.number = next(self._numbers)

    def __reduce__(self) -> tuple[Any, ...]:
        # Each process counts by itself: what comes from another one would pass for the border of the same number.
        flat = self.points.tolist()
        return Border, (list(zip(flat[::2], flat[1::2])),)


class _Group:
    """A signal or candidate as a cycle's message has it: its columns, or the entries of its lines."""

    def __init__(self, name: str, kind: Kind, lines: list[str], known_again: bool) -> None:
        """known_again: whether it is a set, whose elements may have ids."""
        self.name = name
        self.lines = lines
        self.closed = f"{name}/closed" in kind.entries
        self.record = f"{name}/count" not in kind.entries
        begin = f"{name}."
        self.columns = [
            (key.removeprefix(begin), entry)
            for key, entry in kind.entries.items()
            if key.startswith(begin) and key not in lines
        ]
        #: Whether it is one line, which no field names.
        self.line = lines == [f"{name}.line"]
        #: What may be given by these names.
        self.fields = {*(field for field, _ in self.columns), *(line.removeprefix(begin) for line in lines)}
        self.fields |= {"closed"} if self.closed else set()
        self.fields |= {"id"} if known_again else set()

    def look(self, name: str, value: Any) -> None:
        """Raise LinkError for what is no such signal: of what is misspelt, the default would be taken."""
        if self.line:
            _look_at_line(name, value)
            return
        if isinstance(value, Block) and not (self.record or self.lines):
            return
        if not isinstance(value, Mapping):
            raise LinkError(f"`{name}` is given field by field, not as {type(value).__name__}")
        for field in value:
            if field not in self.fields:
                raise LinkError(f"the program reads no `{name}.{field}`{_nearest(field, self.fields)}")
        for line in self.lines:
            given = value.get(line.removeprefix(f"{name}."))
            if given is not None:
                _look_at_line(line, given)

    def length(self, value: Mapping[str, Any]) -> int:
        """Of the columns that are there; of none, how many ids there are."""
        given = ((value.get(field), entry) for field, entry in self.columns)
        ids = value.get("id")
        alone = 0 if ids is None else length_of(ids, f"{self.name}.id")
        return max((length_of(one, entry.name) for one, entry in given if one is not None), default=alone)


def _groups(kind: Kind, layout: Layout) -> dict[str, _Group]:
    lines = [f"signals.{signal}.{field or 'line'}" for signal, field in layout.lines]
    sets = {f"signals.{signal}" for signal in layout.said["sets"]}
    found = {}
    for name in kind.entries:
        if name.endswith("/present"):
            group = name.removesuffix("/present")
            own = [line for line in lines if line.startswith(f"{group}.")]
            found[group] = _Group(group, kind, own, group in sets)
    return found


#: Stands for a field that is left out: its default counts then, where it has one.
_LEFT_OUT = object()
#: A fault that the sender has found: its name, signal, field, and the sample or element, None for none.
Found = tuple[str, str, str, int | None]


class Client:
    """One planner. clock: s, the Supervisor's: time.monotonic of this machine, or simulated time for one that was started so."""

    def __init__(self, layout: Layout, channel: Channel, clock: Callable[[], float] = time.monotonic) -> None:
        self.layout, self.channel, self._clock = layout, channel, clock
        #: A client that starts later replaces this one.
        self.session = time.monotonic_ns()
        self._process = os.getpid()
        self._sequence = 0
        #: How many cycles the process may have.
        self.cycles = [0]
        self._cycle, self._line, self._tick = (layout.kinds[name] for name in ("cycle", "line", "tick"))
        self._groups = _groups(self._cycle, layout)
        self._events = [
            name.removesuffix("/event") for name in self._cycle.entries if name.endswith("/event")
        ]
        self._sent: list[tuple[int, int]] = [(0, 0)] * len(
            layout.lines
        )  # the line's number, the version that it has there
        self._versions = [0] * len(layout.lines)
        #: Messages that came and were not taken, by cause.
        self.refused: dict[str, int] = {}
        #: The newest sign of life.
        self.beat: Message | None = None

    def send(
        self, number: int | None, t: float | None, driving: Mapping[str, Any] | Block | None,
        emergency: Mapping[str, Any] | Block | None, signals: Mapping[str, Any], found: Sequence[Found] = (), came: bool = True,
    ) -> int:  # fmt: skip
        """Send a cycle, all in SI; the sequence of its message, 0 where it could not be sent.

        driving, emergency: columns by field. signals: columns, or values of a record, by field; of borders `Border`s, and `closed`; of an
        event True, False or None; of a set whose elements are known again in other cycles, `id` has a whole number for each. What is left out, and has no default, is missing, as is None;
        a name that the program does not read is a LinkError. found: faults that the caller has found. came: False says that a cycle was due.
        """
        if not isinstance(signals, Mapping):
            raise LinkError(f"signals are given by their names, not as {type(signals).__name__}")
        found = _faults(found)
        kind, message = self._cycle, bytearray(self._cycle.length)
        given = {
            "driving": driving,
            "emergency": emergency,
            **{f"signals.{name}": one for name, one in signals.items()},
        }
        coming = {group: value for group, value in given.items() if came and value is not None}
        for group, value in coming.items():  # before anything is sent
            self._look(group, value)
        versions = self._lines(signals) if came else {}
        kind.put(message, "came", _truth("came", came))
        kind.put(message, "numbered", int(number is not None))
        kind.put(message, "stamped", int(t is not None))
        kind.put(message, "number", 0 if number is None else number)
        kind.put(message, "t", 0.0 if t is None else t)
        missing = list[Found]()
        for group, value in coming.items():
            if group in self._groups:
                missing += self._fill(message, group, value, versions)
        for event in self._events:
            flag = signals.get(event.removeprefix("signals."))
            kind.put(message, f"{event}/event", -1 if flag is None else _truth(event, flag))
        self._found(message, [*found, *(one for one in missing if one not in found)])
        self.cycles[0] += 1  # a signal that stops the rest of it may come behind its way out
        return self._post(kind, "cycle", message)

    def tick(self) -> int:
        """Say that time has passed, to a Supervisor whose clock is that of its messages; as `send`."""
        return self._post(self._tick, "tick", bytearray(self._tick.length))

    def answer(self, sequence: int, seconds: float) -> Message | None:
        """The decision about the message of this sequence and no other one; None where it does not come in time."""
        until = time.monotonic() + seconds
        while True:
            message = self.hear(max(0.0, until - time.monotonic()))
            if message is None:
                return None
            if message.kind.name == "decision" and (message["about_session"], message["about_sequence"]) == (
                self.session,
                sequence,
            ):
                return message

    def hear(self, seconds: float) -> Message | None:
        """Whatever comes next: a decision, whomever it is about, or a sign of life; None where nothing comes."""
        until = time.monotonic() + seconds
        while True:
            data = self.channel.receive(max(0.0, until - time.monotonic()))
            if data is None:
                return None
            cause, message = self.layout.look(data, up=False)
            if message is None:
                self.refused[cause] = self.refused.get(cause, 0) + 1
                continue
            if message.kind.name == "beat":
                self.beat = message
            elif message["about_session"] == self.session and message["wanted"]:
                self._forget(message["wanted"])
            return message

    def close(self) -> None:
        self.channel.close()

    # Parts ------------------------------------------------------------------------------------------------------

    def _post(self, kind: Kind, box: str, message: bytearray) -> int:
        # A copy in a forked process would count on with the same numbers, and each take decisions about the other's cycles for its own.
        if os.getpid() != self._process:
            raise LinkError("this client is that of another process: make one behind the fork")
        self._sequence += 1
        self.layout.seal(message, kind, self.session, self._sequence, self._clock())
        return self._sequence if self.channel.send(box, message) else 0

    def _look(self, group: str, value: Any) -> None:
        """Raise LinkError for what the program does not read, or not so."""
        if group in self._groups:
            self._groups[group].look(group, value)
        elif group not in self._events:
            raise LinkError(
                f"the program reads no `{group}`{_nearest(group, [*self._groups, *self._events])}"
            )

    def _fill(
        self, message: bytearray, group: str, value: Any, versions: Mapping[str, int]
    ) -> Sequence[Found]:
        """Put a signal or candidate into a message; the faults that the Supervisor cannot see in it: to C, no column of no elements is
        one of an empty set."""
        known, kind = self._groups[group], self._cycle
        kind.put(message, f"{group}/present", 1)
        if known.closed:
            kind.put(message, f"{group}/closed", _truth(f"{group}.closed", value.get("closed", False)))
        if known.lines:
            for name in known.lines:
                kind.put(message, name, versions[name])
            return ()
        if isinstance(value, Block):
            count = value.write(message, known.columns)
            kind.put(message, f"{group}/count", count)
            self._name(message, group, value.ids if len(value.ids) == count else None, count)
            return ()
        absent, missing = 0, list[str]()
        # None before the first column: one without elements has a length, as any other, and what else came is not as long.
        length: int | None = None
        for place, (field, entry) in enumerate(known.columns):
            column = value.get(field, _LEFT_OUT)
            if column is _LEFT_OUT and entry.default is not None:
                default = entry.default == 1 if entry.type == "i8" else entry.default
                column = default if known.record else [default] * known.length(value)
            if column is None or column is _LEFT_OUT:
                absent |= 1 << place
                missing.append(field)
                if known.record:
                    kind.set(message, entry, -1 if entry.type == "i8" else float("nan"))
                continue
            if known.record:
                column = _truth(entry.name, column) if entry.type == "i8" else column
            elif length not in (None, length_of(column, entry.name)):
                raise LinkError(f"the columns of `{group}` have different lengths")
            else:
                length = len(column)
            put = kind.set(message, entry, entry.places(column))
            if not known.record and put != length:
                raise _changed(entry)
        count = 1 if known.record else length or 0
        if not known.record:
            kind.put(message, f"{group}/count", count)
            kind.put(message, f"{group}/absent", absent)
            self._name(message, group, value.get("id"), count)
        signal = group.removeprefix("signals.")
        return [("missing", signal, field, None) for field in missing] if count == 0 else ()

    def _name(self, message: bytearray, group: str, ids: Sequence[int] | None, count: int) -> None:
        """Put in by what elements are known again, where rules ask for it; the Supervisor refuses a set in which not each has an id."""
        kind = self._cycle
        entry = kind.entries.get(f"{group}/id")
        if ids is None:
            return
        if entry is None:
            _look_at_ids(group, ids, count)
        elif length_of(ids, entry.name) == count:
            kind.put(message, f"{group}/named", 1)
            if kind.set(message, entry, ids) != count:
                raise _changed(entry)
        elif count == 0:  # whoever they are of would not be there at all
            raise LinkError(f"the columns of `{group}` have different lengths")

    def _lines(self, signals: Mapping[str, Any]) -> dict[str, int]:
        """The versions of all lines by their entries; those that are new are sent."""
        found = {}
        for slot, (signal, field) in enumerate(self.layout.lines):
            given = signals.get(signal)
            border = given.get(field) if isinstance(given, Mapping) else given
            found[f"signals.{signal}.{field or 'line'}"] = (
                0 if border is None else self._version(slot, border)
            )
        return found

    def _version(self, slot: int, border: Any) -> int:
        number, version = self._sent[slot]
        if version and number == border.number:
            return version
        kind, message = self._line, bytearray(self._line.length)
        self._versions[slot] += 1
        kind.put(message, "slot", slot)
        kind.put(message, "line_version", self._versions[slot])
        kind.put(message, "count", border.count)
        kind.put(message, "points", border.points)
        if not self._post(kind, f"line_{slot}", message):
            return 0
        self._sent[slot] = (border.number, self._versions[slot])
        return self._versions[slot]

    def _forget(self, wanted: int) -> None:
        for slot in range(len(self._sent)):
            if wanted >> slot & 1:
                self._sent[slot] = (0, 0)

    def _found(self, message: bytearray, found: Sequence[Found]) -> None:
        if not found:
            return
        kind, layout = self._cycle, self.layout
        most = kind.entries["found_name"].room
        given = list(found)[:most]
        kind.put(message, "found_count", len(given))
        known = layout.faults[1:]  # the first one says that there is none
        for name, _, _, index in given:
            if name not in known:
                raise LinkError(f"no fault is called `{name}`{_nearest(name, known)}")
            if index is not None and not (is_whole(index) and index >= 0):
                raise LinkError(f"`{name}` is found at {str(index)[:40]!r}, which is no place")
        kind.put(message, "found_name", [layout.faults.index(name) for name, _, _, _ in given])
        kind.put(message, "found_signal", [_place(signal, layout.signals) for _, signal, _, _ in given])
        kind.put(message, "found_field", [_place(field, layout.fields) for _, _, field, _ in given])
        kind.put(message, "found_index", [-1 if index is None else index for _, _, _, index in given])


def _truth(name: str, flag: Any) -> int:
    """A flag as it is sent; raises LinkError for what is none, such as a text that says "false", or a number, which is none to the Supervisor's own door."""
    if not is_flag(flag):
        raise LinkError(f"`{name}` is True or False, not {str(flag)[:40]!r}")
    return int(flag)


def _faults(found: Sequence[Found]) -> list[Found]:
    """Faults that a caller has found; raises LinkError for anything else."""
    if isinstance(found, NO_COLUMNS) or not isinstance(found, Iterable):
        raise LinkError(f"the faults that were found are a list, not {type(found).__name__}")
    listed = list(found)
    for one in listed:
        if not isinstance(one, (tuple, list)) or len(one) != 4:
            raise LinkError(f"a fault is its name, signal, field and index, not {str(one)[:40]!r}")
    return listed


def _changed(entry: Entry) -> LinkError:
    """Of a column that another thread fills while it is sent: zeros would stand for what it has no more."""
    return LinkError(f"`{entry.name}` has another length than just before: who sends it has to own it")


def _look_at_ids(group: str, ids: Sequence[Any], count: int) -> None:
    """Raise LinkError for ids that no message has a place for, as no rule knows elements by them, and that the Supervisor's own door refuses: columns that
    were put together wrongly show there first."""
    if isinstance(ids, NO_COLUMNS):
        raise LinkError(f"`{group}.id` is no column of ids")
    if length_of(ids, f"{group}.id") != count:
        raise LinkError(f"the columns of `{group}` have different lengths")
    known = set[str | float]()
    for one in ids:
        if not (is_text(one) or (is_number(one) and -(2.0**63) <= one < 2.0**63)):
            raise LinkError(
                f"an entry of `{group}.id` is neither a text nor a finite number of 64 bits: {str(one)[:40]!r}"
            )
        known.add(str(one) if is_text(one) else float(one))
    if len(known) != count:
        raise LinkError(f"an entry of `{group}.id` stands twice")


def _look_at_line(name: str, given: Any) -> None:
    if not isinstance(given, Border):
        raise LinkError(f"`{name.removesuffix('.line')}` is a Border, which is made once of its points")


def _nearest(name: Any, known: Iterable[str]) -> str:
    """What may have been meant."""
    found = get_close_matches(str(name), list(known), n=1)
    return f": `{found[0]}`?" if found else ""


def _place(text: str, names: Sequence[str]) -> int:
    """A name's place, or the one after all."""
    return names.index(text) if text in names else len(names)
