"""Messages to and from a Supervisor that is a process of its own, packed and unpacked as their description (messages.json) says."""

from __future__ import annotations

import json
import math
import struct
import zlib
from array import array
from collections.abc import Mapping, Set
from functools import cached_property
from operator import le
from pathlib import Path
from typing import Any, NamedTuple, cast

_FORMATS = {"u64": "Q", "i64": "q", "f64": "d", "u32": "I", "u16": "H", "i8": "b", "u8": "B"}
#: What stands for a value that is missing, of types that have it.
_MISSING: dict[str, float] = {"f64": math.nan, "i8": -1}
#: What is no column: it holds none, or none in order, or bytes, of which nobody says which numbers they are.
NO_COLUMNS = (str, bytes, bytearray, Mapping, Set)
#: Types of numbers of which nothing need be asked.
PLAIN = {float, int}
_HEAD = struct.Struct("<IIHHIQQQd")
#: The CRC is of all that follows it.
_CRC_FROM = 8


class LinkError(Exception):
    """What cannot be: a description that is none, no Supervisor where one is looked for, values that a message has no room for."""


class Entry(NamedTuple):
    """An entry of a message: its place in bytes, its type, `room` for so many values; array: whether it is one.

    default: what is put in for a field that is left out; None: nothing is. members: names of which the values are the places. unit: in SI, of
    numbers of a spec.
    """

    name: str
    offset: int
    type: str
    room: int
    array: bool
    default: float | None
    members: tuple[str, ...] = ()
    unit: str = ""

    def places(self, value: Any) -> Any:
        """A value, or a column, with the places of members in place of their names; raises LinkError for a name of none."""
        if not self.members:
            return value
        if not self.array:
            return self._place(value)
        if isinstance(value, NO_COLUMNS):  # of which names could be taken all the same
            raise LinkError(f"`{self.name}` is no column of numbers")
        return [self._place(one) for one in value] if any(map(is_text, value)) else value

    def _place(self, one: Any) -> Any:
        """Of a name its place, of nothing NaN; anything else as it is, for whoever packs it to look at."""
        if not is_text(one):
            return math.nan if one is None else one
        name = str(one)
        if name not in self.members:
            raise LinkError(f"`{self.name}` is none of {', '.join(self.members)}: {name[:40]!r}")
        return float(self.members.index(name))

    @property
    def format(self) -> str:
        return _FORMATS[self.type]

    @property
    def end(self) -> int:
        return self.offset + struct.calcsize("=" + self.format) * self.room


class Head(NamedTuple):
    """What every message begins with."""

    magic: int
    crc: int
    version: int
    kind: int
    length: int
    layout: int
    session: int
    sequence: int
    sent: float


class Kind:
    """A kind of message, with its entries by name."""

    def __init__(self, said: Mapping[str, Any]) -> None:
        self.name: str = said["name"]
        self.number: int = said["kind"]
        self.up: bool = said["from"] == "planner"
        self.length: int = said["length"]
        entries = (
            Entry(
                e["name"],
                e["offset"],
                e["type"],
                e["count"],
                e["array"],
                _default(e.get("default")),
                tuple(e.get("members", ())),
                e.get("unit", ""),
            )
            for e in said["entries"]
        )
        self.entries = {entry.name: entry for entry in entries}
        if any(entry.end > self.length for entry in self.entries.values()):
            raise LinkError(f"the description of `{self.name}` has an entry beyond its end")

    def put(self, into: bytearray, name: str, value: Any) -> None:
        """Set an entry: a number, or of an array its first values; an array of C's doubles or bytes is copied as it stands."""
        self.set(into, self.entries[name], value)

    def set(self, into: bytearray, entry: Entry, value: Any) -> int:
        """As `put`, of an entry at hand; how many values there were, those among them for which it has no room."""
        if not entry.array:
            if entry.type == "f64" and not is_number(value):
                raise LinkError(f"`{entry.name}` is no number: {str(value)[:40]!r}")
            if entry.type != "f64" and not is_whole(value):
                raise LinkError(f"`{entry.name}` cannot be that: {str(value)[:40]!r} is no whole number")
            _refuse_rounded([value], entry)
            try:
                struct.pack_into("<" + entry.format, into, entry.offset, value)
            except (struct.error, OverflowError) as error:  # the one or the other, as Python's version has it
                raise LinkError(f"`{entry.name}` cannot be that: {error}") from error
            return 1
        length_of(value, entry.name)
        _refuse_rounded(value, entry)  # while it says what it is of: what is masked becomes a list next
        value = _unmasked(value, entry)
        try:
            data = memoryview(value)
            # Whole numbers are no flags, though both have one byte.
            same = entry.type != "i8" and data.format == entry.format and data.contiguous and data.ndim == 1
        except (TypeError, ValueError):  # no buffer, or one of what no buffer has, such as times
            same = False
        if not same:
            listed = _listed(value, entry)
            try:
                data = memoryview(array(entry.format, listed))
            except (TypeError, OverflowError) as error:
                raise LinkError(
                    f"an entry of `{entry.name}` is a number that it cannot hold: {error}"
                ) from error
        there = len(data)
        if there > entry.room:
            data = data[: entry.room]
        into[entry.offset : entry.offset + data.nbytes] = data.cast("B")
        return there

    def get(self, data: bytes | bytearray, name: str) -> Any:
        """An entry: a number, or a view of an array."""
        entry = self.entries[name]
        if not entry.array:
            return struct.unpack_from("<" + entry.format, data, entry.offset)[0]
        return memoryview(data)[entry.offset : entry.end].cast(cast(Any, entry.format))


def _unmasked(value: Any, entry: Entry) -> Any:
    """Values as they are sent: what numpy's masked arrays hide is missing, as to the Supervisor's own door; what stands below is no value."""
    if not hasattr(value, "filled"):
        return value
    hidden, below = value.mask.tolist(), value.data
    if hidden is False:  # one flag for all of them: nothing is
        return below
    if entry.type not in _MISSING:
        raise LinkError(f"`{entry.name}` is masked, and cannot be missing")
    return [None if hides else one for one, hides in zip(below.tolist(), hidden, strict=True)]


def _kind(value: Any) -> str | None:
    """The kind of a number of numpy, or of an array of one without axes; empty for arrays with axes and for what is masked, None for what is not numpy's."""
    kind: str | None = getattr(getattr(value, "dtype", None), "kind", None)
    return "" if kind is not None and (getattr(value, "ndim", 0) != 0 or hasattr(value, "filled")) else kind


def is_number(value: Any) -> bool:
    """Whether something is a number to the Supervisor's own door: no Boolean, no text, nothing complex, no fraction, no time, of which numpy makes a
    whole one, and no array with axes."""
    kind = _kind(value)
    if kind is None:
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return kind in ("i", "u", "f")


def is_whole(value: Any) -> bool:
    """Whether something is a whole number to it."""
    kind = _kind(value)
    if kind is None:
        return isinstance(value, int) and not isinstance(value, bool)
    return kind in ("i", "u")


def is_flag(value: Any) -> bool:
    """Whether something is a Boolean to it: 0 and 1 are none."""
    return isinstance(value, bool) or _kind(value) == "b"


def is_text(value: Any) -> bool:
    """Whether something is a text to it."""
    return type(value) not in PLAIN and (isinstance(value, str) or _kind(value) == "U")


def _short(held: Any) -> str:
    """What `struct` calls the floats of less than 64 bits that a number or an array of numpy, or a buffer, is of; empty where it is of none."""
    dtype = getattr(held, "dtype", None)
    if dtype is not None:
        return {4: "f", 2: "e"}.get(dtype.itemsize, "") if dtype.kind == "f" else ""
    try:
        code = memoryview(held).format[-1:]
    except (TypeError, ValueError):
        return ""
    return code if code in ("f", "e") else ""


def rounded(column: Any) -> bool:
    """Whether any of some lengths, m, is of floats of less than 64 bits that lie more than 1 cm apart there, whatever holds them: the door of a Supervisor
    refuses these. Raises TypeError or ValueError for what is no column."""
    if getattr(column, "dtype", None) == "f8" or (type(column) is array and column.typecode == "d"):
        return False
    # What an array holds says by itself what it is of, below a mask, too; what a buffer holds has become a double.
    of = "" if hasattr(column, "dtype") else _short(column)
    return any(_lost(one, of or _short(one)) for one in column if of or type(one) not in PLAIN)


def _lost(one: Any, code: str) -> bool:
    if not code or not math.isfinite(one):
        return False
    size = abs(float(one))
    try:
        return bool(struct.unpack(code, struct.pack(code, size + 0.005))[0] == size)
    except OverflowError:  # it is next to the largest there is
        return True


def _refuse_rounded(value: Any, entry: Entry) -> None:
    """Raise LinkError for lengths that short floats have rounded."""
    if entry.unit != "m":
        return
    try:
        lost = rounded(value)
    except (TypeError, ValueError):  # no column, which is said next
        return
    if lost:
        raise LinkError(
            f"`{entry.name}` is of short floats, which have no two numbers nearer than 1 cm there: give it as float64"
        )


def length_of(column: Any, name: str) -> int:
    """Of a column; raises LinkError for what has none, such as one number, or a generator, which is empty once it was looked at."""
    try:
        return len(column)
    except TypeError as error:
        raise LinkError(f"`{name}` is no column of numbers") from error


def _listed(value: Any, entry: Entry) -> list[Any]:
    """The entries of a column, as they are sent; raises LinkError for what is none to the Supervisor's own door."""
    kind = getattr(getattr(value, "dtype", None), "kind", "")
    if isinstance(value, NO_COLUMNS) or kind in ("m", "M") or _of_bytes(value):
        raise LinkError(f"`{entry.name}` is no column of numbers")
    found = value.tolist() if hasattr(value, "tolist") else list(value)
    plain = entry.type != "i8" and PLAIN.issuperset(map(type, found))
    return found if plain else [_sent(one, entry) for one in found]


def _of_bytes(value: Any) -> bool:
    """Whether it is bytes that nobody has said to be numbers, in a view of them."""
    return isinstance(value, memoryview) and value.format in ("B", "c")


def _sent(one: Any, entry: Entry) -> Any:
    """An entry of a column: None is missing, flags are Booleans, and nothing else is."""
    if one is None and entry.type in _MISSING:
        return _MISSING[entry.type]
    if entry.type == "i8":
        if not is_flag(one):
            raise LinkError(f"an entry of `{entry.name}` is True or False, not {str(one)[:40]!r}")
        return int(one)
    if not is_number(one):
        raise LinkError(f"an entry of `{entry.name}` is no number: {str(one)[:40]!r}")
    return one


def _default(said: float | str | None) -> float | None:
    return None if said is None else float(said)


class Layout:
    """The messages of one program. Raises LinkError for a description that is none."""

    def __init__(self, said: Mapping[str, Any]) -> None:
        if said.get("format") != "trackmarshal-messages" or said.get("version") != 1:
            raise LinkError("this is no description of messages, or one of another version")
        if struct.pack("=H", 1) != struct.pack("<H", 1):
            raise LinkError("messages are little-endian, and this machine is not")
        self.said = said
        self.fingerprint = int(said["layout"], 16)
        self.kinds = {kind.name: kind for kind in map(Kind, said["messages"])}
        self._by_number = {kind.number: kind for kind in self.kinds.values()}
        self.causes: list[str] = said["causes"]
        self.signals: list[str] = said["signals"]
        self.fields: list[str] = said["fields"]
        self.faults: list[str] = said["faults"]
        self.states: list[str] = said["states"]
        self.rules: list[str] = [rule["name"] for rule in said["rules"]]
        self.plan: list[str] = said["plan"]
        planned = self.kinds["decision"].entries
        #: Those of which the numbers are places of an enumeration's members.
        self.plan_members = frozenset(name for name in self.plan if planned[f"driving.{name}"].members)
        self.lines: list[tuple[str, str]] = [(line["signal"], line["field"]) for line in said["lines"]]
        self.period: float = said["period"]
        self.silence: float = said["silence"]
        self.datagrams: bool = said["datagrams"]

    @classmethod
    def read(cls, path: str | Path) -> Layout:
        """The description in a file."""
        try:
            said = json.loads(Path(path).read_text(encoding="utf-8"))
        except ValueError as error:
            raise LinkError(f"{path} is no JSON: {error}") from error
        if not isinstance(said, dict):
            raise LinkError(f"{path} is no description of messages")
        return cls(said)

    @cached_property
    def longest(self) -> int:
        """Bytes of the longest message."""
        return max(kind.length for kind in self.kinds.values())

    def seal(self, message: bytearray, kind: Kind, session: int, sequence: int, sent: float) -> None:
        """Put the head before entries that are set, with the CRC last."""
        _HEAD.pack_into(
            message, 0, self.said["magic"], 0, self.said["version"], kind.number, kind.length, self.fingerprint, session, sequence, sent
        )  # fmt: skip
        struct.pack_into("<I", message, 4, zlib.crc32(memoryview(message)[_CRC_FROM:]))

    def look(self, data: bytes, up: bool) -> tuple[str, Message | None]:
        """Bytes that came: why they are not taken, or "none" and the message. up: whether it goes to the Supervisor."""
        if len(data) < _HEAD.size:
            return "size", None
        head = Head._make(_HEAD.unpack_from(data))
        kind = self._by_number.get(head.kind)
        for cause, wrong in (
            ("magic", head.magic != self.said["magic"]),
            ("version", head.version != self.said["version"]),
            ("layout", head.layout != self.fingerprint),
            ("kind", kind is None or kind.up != up),
        ):
            if wrong:
                return cause, None
        assert kind is not None
        if head.length != kind.length:
            return "length", None
        if head.length != len(data):
            return "size", None
        if head.crc != zlib.crc32(memoryview(data)[_CRC_FROM:]):
            return "crc", None
        message = Message(self, kind, head, data)
        return ("none", message) if message.sound() else ("content", None)


class Message:
    """A message that came: `message["state"]`, of arrays a view."""

    __slots__ = ("data", "head", "kind", "layout")

    def __init__(self, layout: Layout, kind: Kind, head: Head, data: bytes) -> None:
        self.layout, self.kind, self.head, self.data = layout, kind, head, data

    def __getitem__(self, name: str) -> Any:
        return self.kind.get(self.data, name)

    def column(self, group: str, name: str) -> Any:
        """(count,) of a column of `driving` or `fallback`, of which one may be called `due` or `count`."""
        return self[f"{group}.{name}"][: self[f"{group}/count"]]

    def due(self, group: str) -> Any:
        """(count,) s, when each sample of `driving` or `fallback` is due."""
        return self[f"{group}/due"][: self[f"{group}/count"]]

    def sound(self) -> bool:
        """Whether what is in it can be; C says the same of it."""
        head = self.head
        if head.session < 1 or head.sequence < 1 or not math.isfinite(head.sent):
            return False
        if self.kind.name == "decision":
            return self._decision()
        if self.kind.name == "beat":
            return bool(self["simulated"] <= 1 and 0 <= self["state"] < len(self.layout.states))
        return True  # what goes up is for the Supervisor to look at

    def _decision(self) -> bool:
        layout = self.layout
        state, driven, safe, stored = self["state"], self["driven"], self["safe"], self["stored"]
        reasons, rules = self["reason_count"], len(layout.rules)
        if not (
            0 <= state < len(layout.states)
            and 0 <= driven <= 2
            and safe in (0, 1)
            and stored in (0, 1)
            and self["simulated"] <= 1
            and 0 <= self["lost"] < len(layout.faults)
            and self["serial"] >= 1
            and 0 <= reasons <= self.kind.entries["reason_name"].room
        ):
            return False
        # Only a cycle is safe; the safe one is driven, and leaves a trajectory to fall back to.
        if (safe == 1) != (driven == 1) or (
            driven == 1 and not (self["about_sequence"] >= 1 and stored == 1)
        ):
            return False
        if driven == 2 and stored != 1:
            return False
        if (driven == 1 and not self._planned("driving")) or (stored == 1 and not self._planned("fallback")):
            return False
        listed = all(
            self["reason_kind"][i] <= 2
            and self["reason_candidate"][i] <= 1
            and self["reason_name"][i] < len(layout.faults)
            and self["reason_rule"][i] < rules
            for i in range(reasons)
        )
        verdicts = (self[name][:rules] for name in ("driving_verdict", "emergency_verdict"))
        return listed and all(max(one, default=0) <= 4 for one in verdicts)

    def _planned(self, group: str) -> bool:
        count = self[f"{group}/count"]
        entry = self.kind.entries[f"{group}/due"]
        if not 2 <= count <= entry.room:
            return False
        due = self[f"{group}/due"][:count].tolist()
        if not all(map(le, due, due[1:])):  # a large stamp moves two to one time
            return False
        return bool(due[-1] - due[0] < 1e9) or all(b - a < 1e9 for a, b in zip(due, due[1:]))
