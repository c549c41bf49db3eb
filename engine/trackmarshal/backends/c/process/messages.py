"""What a message is: entries of fixed length at fixed places, behind a head that all messages have."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

#: "TMSV" as it stands in memory, and the version of what is common to the messages of all specs.
MAGIC, VERSION = 0x5653_4D54, 1
#: Bytes of an entry by its type.
SIZES = {"u64": 8, "i64": 8, "f64": 8, "u32": 4, "u16": 2, "i8": 1, "u8": 1}
C_TYPES = {
    "u64": "uint64_t", "i64": "int64_t", "f64": "double", "u32": "uint32_t", "u16": "uint16_t", "i8": "int8_t", "u8": "uint8_t",
}  # fmt: skip
#: What a message can be refused for, in the order in which it is looked at; C counts them so.
CAUSES = {
    "none": "it is taken",
    "size": "fewer bytes than a head has, or not as many as it says",
    "magic": "it begins differently",
    "version": "another version of what is common to all specs",
    "layout": "made for another spec, other rules, capacities or limits, or by another engine",
    "kind": "no such kind, or not one that goes this way",
    "length": "not the length that its kind has",
    "crc": "its bytes were changed",
    "session": "its sender has been replaced by one that started later",
    "sequence": "not newer than one that was taken",
    "content": "an entry that cannot be what it is said to be",
    "torn": "in shared memory: written again and again while it was read",
}  # fmt: skip


@dataclass(frozen=True)
class Item:
    """An entry of a message: `count` values of a type at a place in bytes.

    group: what it belongs to (`driving`, `signals.ego`), empty for the message itself. own: whether it is ours and not a field of the
    spec. c_group, c_name: its C names. scalar: one value, no array. default: in SI, what a client puts in for a field that is left out.
    members: of an enumeration, whose places the values are. unit: in SI, of numbers of a spec.
    """

    group: str
    name: str
    type: str
    count: int
    about: str
    own: bool
    c_group: str
    c_name: str
    scalar: bool
    offset: int = 0
    default: float | None = None
    members: tuple[str, ...] = ()
    unit: str = ""

    @property
    def key(self) -> str:
        """The name in Python and in the description: `driving.x` is a field of the spec, `driving/count` an entry of ours."""
        return f"{self.group}{'/' if self.own else '.'}{self.name}" if self.group else self.name

    @property
    def size(self) -> int:
        return SIZES[self.type] * self.count

    @property
    def member(self) -> str:
        return f"{self.c_group}.{self.c_name}" if self.c_group else self.c_name

    @property
    def c_type(self) -> str:
        return C_TYPES[self.type]


@dataclass(frozen=True)
class Message:
    """A kind of message. up: from the planner's side to the Supervisor, or else back."""

    name: str
    kind: int
    up: bool
    about: str
    items: tuple[Item, ...]
    length: int

    def groups(self) -> list[tuple[str, list[Item]]]:
        """Entries that stand together in C, in order."""
        found: list[tuple[str, list[Item]]] = []
        for item in self.items:
            if not found or found[-1][0] != item.c_group or not item.c_group:
                found.append((item.c_group, []))
            found[-1][1].append(item)
        return found


@dataclass(frozen=True)
class Table:
    """All messages of one program.

    lines: (signal, field, C signal, C member) of borders and lines; a line's slot is its place here. names: what faults speak of: signals
    and fields; an index beyond them is something that the spec does not know.
    """

    messages: tuple[Message, ...]
    lines: tuple[tuple[str, str, str, str], ...]
    signals: tuple[str, ...]
    fields: tuple[str, ...]
    capacities: Mapping[str, int]

    def message(self, name: str) -> Message:
        return next(message for message in self.messages if message.name == name)


def own(
    name: str, type_: str, about: str, count: int | None = None, group: str = "", c_group: str = ""
) -> Item:
    """An entry that is ours. In C, what stands beside names of a spec has a prefix that they cannot have."""
    c_name = f"tm_{name}" if c_group else name
    return Item(group, name, type_, count or 1, about, True, c_group, c_name, count is None)


#: What every message begins with. The CRC is of everything after it.
HEAD = (
    own("magic", "u32", "TMSV"),
    own("crc", "u32", "CRC-32 (IEEE 802.3, as in zlib) of all bytes from the next entry to the end"),
    own("version", "u16", "of what is common to the messages of all specs"),
    own("kind", "u16", "of message"),
    own("length", "u32", "bytes, this head among them"),
    own("layout", "u64", "fingerprint of the layout: the first eight bytes of a SHA-256 of its description"),
    own("session", "u64", "when the sender started, ns on its clock: a later one replaces an earlier one"),
    own("sequence", "u64", "counts what the sender sends, from 1 on"),
    own("sent", "f64", "s, the sender's clock at sending"),
)


def message(name: str, kind: int, up: bool, about: str, items: Iterable[Item]) -> Message:
    """A message of these entries, behind the head."""
    placed = tuple(_placed([*HEAD, *items]))
    return Message(name, kind, up, about, placed, placed[-1].offset + placed[-1].size)


def _placed(items: Sequence[Item]) -> Iterator[Item]:
    """Entries at their places, those of a group together, each where C puts it; what is between them is filled."""
    place, fillers = 0, 0
    for number, item in enumerate(items):
        yield replace(item, offset=place)
        place += item.size
        after = items[number + 1] if number + 1 < len(items) else None
        ends = after is None or after.c_group != item.c_group
        wanted = 8 if ends else SIZES[after.type] if after is not None else 8
        gap = -place % wanted
        if gap:
            fillers += 1
            filler = own(f"filler_{fillers}", "u8", "zero", gap, item.group, item.c_group)
            yield replace(filler, offset=place)
            place += gap
