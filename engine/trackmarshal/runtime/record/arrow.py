"""Arrow's IPC stream format, as far as a record needs it: one schema, then batches of one row, appended one by one.

Written and read here with `struct` alone; pyarrow, pandas, polars and DuckDB read it too. Only what was written here is
read back: the schema is made again from its own metadata and compared byte by byte, so there is nothing to interpret.

Source: the format's definition, arrow.apache.org/docs/format/Columnar.html, with Schema.fbs and Message.fbs.
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

import numpy as np

#: Kinds of columns: int64, float64, utf8, list<float64>, list<utf8>.
INT, FLOAT, TEXT, FLOATS, TEXTS = "int", "float", "text", "floats", "texts"
#: A column: its name and its kind.
Column = tuple[str, str]

_CONTINUES = b"\xff\xff\xff\xff"
END = _CONTINUES + bytes(4)
_V5 = 4
_SCHEMA, _BATCH = 1, 3
#: Column of every batch that holds the CRC-32 of the batch, its own eight bytes taken as zero. It comes first.
CHECKSUM = "crc32"
KEY = "trackmarshal"
_MARK = b'{"format":'

Ref = Callable[[bytearray], int]
_SIZES = {"B": 1, "h": 2, "i": 4, "q": 8, "ref": 4}


# Flatbuffers ------------------------------------------------------------------------------------------------------


def _table(out: bytearray, fields: Sequence[tuple[str, Any] | None]) -> int:
    """Append a table: its layout, its fields, and behind them what they refer to. Returns where it begins."""
    places, size = [], 4
    for field in fields:
        if field is None:
            places.append(0)
            continue
        width = _SIZES[field[0]]
        size = -(-size // width) * width
        places.append(size)
        size += width
    layout = struct.pack(f"<HH{len(places)}H", 4 + 2 * len(places), size, *places)
    out += bytes(-(len(out) + len(layout)) % 8) + layout
    begin = len(out)
    out += struct.pack("<i", len(layout)) + bytes(size - 4)
    for field, place in zip(fields, places):
        if field is None:
            continue
        kind, value = field
        if kind == "ref":
            struct.pack_into("<I", out, begin + place, value(out) - (begin + place))
        else:
            struct.pack_into(f"<{kind}", out, begin + place, value)
    return begin


def _text(text: str) -> tuple[str, Ref]:
    def put(out: bytearray) -> int:
        data = text.encode()
        out += bytes(-len(out) % 4)
        begin = len(out)
        out += struct.pack("<I", len(data)) + data + b"\0"
        return begin

    return "ref", put


def _of(*fields: tuple[str, Any] | None) -> tuple[str, Ref]:
    return "ref", lambda out: _table(out, fields)


def _list(items: Sequence[tuple[str, Ref]]) -> tuple[str, Ref]:
    def put(out: bytearray) -> int:
        out += bytes(-len(out) % 4)
        begin = len(out)
        out += struct.pack("<I", len(items)) + bytes(4 * len(items))
        for i, (_, item) in enumerate(items):
            place = begin + 4 + 4 * i
            struct.pack_into("<I", out, place, item(out) - place)
        return begin

    return "ref", put


def _pairs(count: int, remember: Callable[[int], None]) -> tuple[str, Ref]:
    """A vector of `count` structs of two int64, zero for now; its place is remembered."""

    def put(out: bytearray) -> int:
        out += bytes((4 - len(out)) % 8)
        begin = len(out)
        out += struct.pack("<I", count) + bytes(16 * count)
        remember(begin + 4)
        return begin

    return "ref", put


def _message(kind: int, header: tuple[str, Ref], body: int = 0) -> bytearray:
    """A whole encapsulated message without its body."""
    out = bytearray(4)
    root = _table(out, [("h", _V5), ("B", kind), header, ("q", body)])
    struct.pack_into("<I", out, 0, root)
    out += bytes(-len(out) % 8)
    return bytearray(_CONTINUES + struct.pack("<i", len(out))) + out


def _field(name: str, kind: str) -> tuple[str, Ref]:
    types: dict[str, tuple[int, tuple[str, Ref]]] = {
        INT: (2, _of(("i", 64), ("B", 1))),
        FLOAT: (3, _of(("h", 2))),
        TEXT: (5, _of()),
        FLOATS: (12, _of()),
        TEXTS: (12, _of()),
    }
    number, made = types[kind]
    children = {FLOATS: [("item", FLOAT)], TEXTS: [("item", TEXT)]}.get(kind, [])
    return _of(
        _text(name), ("B", 0), ("B", number), made, None, _list([_field(*child) for child in children])
    )


# Messages ---------------------------------------------------------------------------------------------------------


class _Shape:
    """Rows of one shape: the message before the body, and the body's parts; None stands for what each row has of its own."""

    def __init__(self, message: bytes, parts: Sequence[tuple[str, Any]]) -> None:
        self._message = message
        self._crc = zlib.crc32(message)
        self._body = struct.Struct("<" + "".join(kind for kind, _ in parts))
        self._values = [value for _, value in parts]
        self._own = [place for place, (_, value) in enumerate(parts) if value is None]

    def filled(self, given: Sequence[Any]) -> bytes:
        """The bytes of a row."""
        values = self._values.copy()
        for place, value in zip(self._own, given, strict=True):
            values[place] = value
        body = bytearray(self._body.pack(*values))
        _INT.pack_into(body, 0, zlib.crc32(body, self._crc))
        return self._message + body


class Layout:
    """The schema of a stream and how its batches look. columns without the checksum; head is strict JSON data."""

    def __init__(self, columns: Sequence[Column], head: dict[str, Any]) -> None:
        self.columns = tuple(columns)
        every: list[Column] = [(CHECKSUM, INT), *columns]
        text = json.dumps({**head, "columns": [list(c) for c in columns]}, allow_nan=False)
        fields = _list([_field(*column) for column in every])
        metadata = _list([_of(_text(KEY), _text(text))])
        #: The bytes that the stream begins with.
        self.schema = bytes(_message(_SCHEMA, _of(("h", 0), fields, metadata)))
        nodes = sum(2 if kind in (FLOATS, TEXTS) else 1 for _, kind in every)
        buffers = sum(_BUFFERS[kind] for _, kind in every)
        places: list[int] = []
        batch = _of(("q", 1), _pairs(nodes, places.append), _pairs(buffers, places.append))
        marked = _message(_BATCH, batch, 0x5A5A5A5A5A5A5A5A)
        self._length_at = marked.index(b"\x5a" * 8)
        struct.pack_into("<q", marked, self._length_at, 0)
        self._template = bytes(marked)
        #: Where in a row's bytes its body begins, with the checksum.
        self.body = len(marked)
        self._nodes_at, self._buffers_at = (place + 8 for place in places)
        self._nodes = struct.Struct(f"<{2 * nodes}q")
        self._buffers = struct.Struct(f"<{2 * buffers}q")
        self._kinds = [kind for _, kind in every]
        #: By the lengths of arrays and texts: most rows are as long as the one before.
        self._shapes: dict[tuple[Any, ...], _Shape] = {}

    def batch(self, values: Sequence[Any]) -> bytes:
        """One row: int, float, str, float arrays (n,), also as bytes, or lists of str, one value a column."""
        given: list[Any] = [0]
        lengths: list[Any] = []
        for kind, value in zip(self._kinds[1:], values, strict=True):
            if kind == FLOATS:
                data = value if type(value) is bytes else np.asarray(value, dtype=_DOUBLE).tobytes()
                given.append(data)
                lengths.append(len(data))
            elif kind == TEXT:
                data = value.encode()
                given.append(data)
                lengths.append(len(data))
            elif kind == TEXTS:
                coded = [text.encode() for text in value]
                given.append(b"".join(coded))
                lengths.append(tuple(map(len, coded)))
            else:
                given.append(value)
        key = tuple(lengths)
        shape = self._shapes.get(key)
        if shape is None:
            if len(self._shapes) >= _SHAPES:
                self._shapes.clear()
            shape = self._shapes[key] = self._shaped(lengths)
        return shape.filled(given)

    def places(self, row: bytes) -> list[int]:
        """Where in a row's bytes the values of each column begin."""
        begins = self._buffers.unpack_from(row, self._buffers_at)[::2]
        ends = list(accumulate(_BUFFERS[kind] for kind in self._kinds))
        return [self.body + begins[end - 1] for end in ends[1:]]

    def _shaped(self, lengths: Sequence[Any]) -> _Shape:
        """How rows look whose arrays and texts are of these lengths, in bytes."""
        nodes, buffers = [1, 0], [0, 0, 0, 8]
        parts: list[tuple[str, Any]] = [("q", None)]
        at, rest = 8, iter(lengths)

        def fixed(data: bytes) -> None:
            nonlocal at
            parts.append((f"{len(data)}s", data))
            at += len(data)

        for kind in self._kinds[1:]:
            nodes += (1, 0)
            if kind in (INT, FLOAT):
                buffers += (at, 0, at, 8)
                parts.append(("q" if kind == INT else "d", None))
                at += 8
                continue
            length = next(rest)
            if kind == FLOATS:
                nodes += (length // 8, 0)
                buffers += (at, 0, at, 8, at + 8, 0, at + 8, length)
                fixed(_SPAN.pack(0, length // 8))
                parts.append((f"{length}s", None))
                at += length
                continue
            each = (length,) if kind == TEXT else length
            if kind == TEXTS:
                nodes += (len(each), 0)
                buffers += (at, 0, at, 8)
                fixed(_SPAN.pack(0, len(each)))
            ends = [0, *accumulate(each)]
            buffers += (at, 0, at, 4 * len(ends))
            fixed(struct.pack(f"<{len(ends)}i", *ends))
            fixed(bytes(-at % 8))
            buffers += (at, ends[-1])
            parts.append((f"{ends[-1]}s", None))
            at += ends[-1]
            fixed(bytes(-at % 8))
        message = bytearray(self._template)
        _INT.pack_into(message, self._length_at, at)
        self._nodes.pack_into(message, self._nodes_at, *nodes)
        self._buffers.pack_into(message, self._buffers_at, *buffers)
        return _Shape(bytes(message), parts)

    def rows(self, data: bytes) -> Iterator[Row]:
        """The whole batches of a stream, in order; ends before the first that is not whole. The data begins with the schema."""
        at = len(self.schema)
        view = memoryview(data)
        size = len(self._template)
        while at + size <= len(data):
            head = bytearray(view[at : at + size])
            (length,) = _INT.unpack_from(head, self._length_at)
            numbers = self._buffers.unpack_from(head, self._buffers_at)
            self._blank(head)
            end = at + size + length
            if head != self._template or not length >= 8 or end > len(data):
                return
            body = bytes(view[at + size : end])
            if zlib.crc32(bytes(8) + body[8:], zlib.crc32(view[at : at + size])) != _INT.unpack_from(body)[0]:
                return
            values = self._values(body, numbers)
            if values is None:
                return
            yield Row(values, end)
            at = end

    def torn(self, rest: bytes) -> bool:
        """Whether what is behind the whole batches can be the beginning of what was written when the process ended, and is not damaged."""
        size = len(self._template)
        head = bytearray(rest[:size])
        self._blank(head)
        if END.startswith(rest) or len(rest) < size:
            return END.startswith(rest) or self._template.startswith(head)
        (length,) = _INT.unpack_from(rest, self._length_at)
        numbers = self._buffers.unpack_from(rest, self._buffers_at)
        end = max(map(sum, zip(numbers[::2], numbers[1::2])))
        return head == self._template and end <= length < end + 8 and size + length > len(rest)

    def _blank(self, head: bytearray) -> None:
        """Take out of the message before a body, or of its beginning, what each row has of its own."""
        for place, count in (
            (self._length_at, 8),
            (self._nodes_at, self._nodes.size),
            (self._buffers_at, self._buffers.size),
        ):
            end = min(place + count, len(head))
            head[place:end] = bytes(max(0, end - place))

    def _values(self, body: bytes, numbers: Sequence[int]) -> list[Any] | None:
        """The values of a row; None where the places of its columns make no sense, checksum or not."""
        spans = iter(list(zip(numbers[::2], numbers[1::2])))

        def span() -> bytes:
            at, size = next(spans)
            if not 0 <= at <= at + size <= len(body):
                raise ValueError
            return body[at : at + size]

        values: list[Any] = []
        try:
            for kind in self._kinds:
                span()
                if kind in (INT, FLOAT):
                    values += (_INT if kind == INT else _FLOAT).unpack(span())
                    continue
                if kind in (FLOATS, TEXTS):
                    span()
                    span()
                if kind == FLOATS:
                    values.append(np.frombuffer(span(), dtype="<f8"))
                    continue
                ends = np.frombuffer(span(), dtype="<i4").tolist()
                data = span()
                texts = [data[a:b].decode() for a, b in zip(ends, ends[1:])]
                values.append(texts if kind == TEXTS else texts[0])
        except (ValueError, IndexError, struct.error):
            return None
        return values[1:]


@dataclass(frozen=True, slots=True)
class Row:
    """One value a column, and where the next batch begins."""

    values: list[Any]
    end: int


#: How many buffers a column has; the last one has the values.
_BUFFERS = {INT: 2, FLOAT: 2, TEXT: 3, FLOATS: 4, TEXTS: 5}
_INT, _FLOAT, _SPAN = struct.Struct("<q"), struct.Struct("<d"), struct.Struct("<ii")
#: As it stands in the file, whatever the machine.
_DOUBLE = np.dtype("<f8")
#: Shapes of rows that are remembered.
_SHAPES = 16


def layout_of(data: bytes) -> tuple[Layout, dict[str, Any]] | None:
    """The layout that a stream begins with, and its head; None where the data does not begin with one of these."""
    if not data.startswith(_CONTINUES) or len(data) < 8:
        return None
    (size,) = struct.unpack_from("<i", data, 4)
    schema = data[: 8 + size]
    begin = schema.find(_MARK)
    if size <= 0 or begin < 0:
        return None
    try:
        head, _ = json.JSONDecoder().raw_decode(schema[begin:].decode("ascii", "replace"))
        columns = [(str(name), str(kind)) for name, kind in head["columns"]]
        layout = Layout(columns, {name: value for name, value in head.items() if name != "columns"})
    except (ValueError, KeyError, TypeError, RecursionError, struct.error):
        return None
    return (layout, head) if layout.schema == schema else None
