"""The planner's side: cycles go to a Supervisor that is a process of its own, its decisions come back."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Protocol

from .messages import Kind, Layout, LinkError, Message


class Channel(Protocol):
    """`SharedMemory` or `Datagrams`."""

    def send(self, box: str, message: bytearray) -> bool: ...

    def receive(self, seconds: float) -> bytes | None: ...

    def close(self) -> None: ...


class Border:
    """Points of a border or line, x and y by turns in m, that do not change: it is sent once, until another one takes its place."""

    __slots__ = ("count", "number", "points")
    _numbers = itertools.count(1)

    def __init__(self, points: Any) -> None:
        try:
            flat = [float(x) for point in points for x in point]
        except TypeError as error:
            raise LinkError("points are pairs [x, y]") from error
        if len(flat) % 2:
            raise LinkError("points are pairs [x, y]")
        from array import array

        self.points = array("d", flat)
        self.count = len(flat) // 2
        self.number = next(self._numbers)


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
        self._sequence = 0
        self._cycle, self._line, self._tick = (layout.kinds[name] for name in ("cycle", "line", "tick"))
        self._sent: list[tuple[int, int]] = [(0, 0)] * len(
            layout.lines
        )  # the line's number, the version that it has there
        self._versions = [0] * len(layout.lines)
        #: Messages that came and were not taken, by cause.
        self.refused: dict[str, int] = {}
        #: The newest sign of life.
        self.beat: Message | None = None

    def send(
        self, number: int | None, t: float | None, driving: Mapping[str, Any] | None, emergency: Mapping[str, Any] | None,
        signals: Mapping[str, Any], found: Sequence[Found] = (), came: bool = True,
    ) -> int:  # fmt: skip
        """Send a cycle, all in SI; the sequence of its message, 0 where it could not be sent.

        driving, emergency: columns by field. signals: columns, or values of a record, by field; of borders `Border`s, and `closed`; of an
        event True, False or None. What is left out, and has no default, is missing, as is None. found: faults that the caller has found. came: False says that a cycle was due.
        """
        kind, message = self._cycle, bytearray(self._cycle.length)
        given = {
            "driving": driving,
            "emergency": emergency,
            **{f"signals.{name}": one for name, one in signals.items()},
        }
        versions = self._lines(signals) if came else {}
        kind.put(message, "came", int(came))
        kind.put(message, "numbered", int(number is not None))
        kind.put(message, "stamped", int(t is not None))
        kind.put(message, "number", number or 0)
        kind.put(message, "t", 0.0 if t is None else t)
        for group, value in given.items():
            if came and value is not None:
                self._group(message, group, value, versions)
        for event in self._events():
            flag = signals.get(event)
            kind.put(message, f"signals.{event}/event", -1 if flag is None else int(bool(flag)))
        self._found(message, found)
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
        self._sequence += 1
        self.layout.seal(message, kind, self.session, self._sequence, self._clock())
        return self._sequence if self.channel.send(box, message) else 0

    def _events(self) -> Iterable[str]:
        ending = "/event"
        return [name[len("signals.") : -len(ending)] for name in self._cycle.entries if name.endswith(ending)]

    def _group(self, message: bytearray, group: str, value: Any, versions: Mapping[str, int]) -> None:
        kind = self._cycle
        entries = kind.entries
        if f"{group}/present" not in entries:
            if f"{group}/event" in entries:
                return
            raise LinkError(f"the program reads no `{group}`")
        kind.put(message, f"{group}/present", 1)
        if f"{group}/closed" in entries:
            kind.put(
                message,
                f"{group}/closed",
                int(bool(value["closed"]) if isinstance(value, Mapping) and "closed" in value else False),
            )
        if any(name.startswith(f"{group}.") for name in versions):
            for name, version in versions.items():
                if name.startswith(f"{group}."):
                    kind.put(message, name, version)
            return
        fields = [name for name in entries if name.startswith(f"{group}.")]
        record = f"{group}/count" not in entries
        columns = [value.get(name[len(group) + 1 :], _LEFT_OUT) for name in fields]
        count = (
            1
            if record
            else max((len(one) for one in columns if one is not None and one is not _LEFT_OUT), default=0)
        )
        absent = 0
        for place, (name, column) in enumerate(zip(fields, columns)):
            default = entries[name].default
            if column is _LEFT_OUT and default is not None:
                column = int(default) if entries[name].type == "i8" else default
                column = column if record else [column] * count
            if column is None or column is _LEFT_OUT:
                absent |= 1 << place
                if record:
                    kind.put(message, name, -1 if entries[name].type == "i8" else float("nan"))
                continue
            if not record and len(column) != count:
                raise LinkError(f"the columns of `{group}` have different lengths")
            kind.put(message, name, column)
        if not record:
            kind.put(message, f"{group}/count", count)
            kind.put(message, f"{group}/absent", absent)

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
        kind.put(message, "found_name", [layout.faults.index(name) for name, _, _, _ in given])
        kind.put(message, "found_signal", [_place(signal, layout.signals) for _, signal, _, _ in given])
        kind.put(message, "found_field", [_place(field, layout.fields) for _, _, field, _ in given])
        kind.put(message, "found_index", [-1 if index is None else index for _, _, _, index in given])


def _place(text: str, names: Sequence[str]) -> int:
    """A name's place, or the one after all."""
    return names.index(text) if text in names else len(names)
