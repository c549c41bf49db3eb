"""Numbers out of an MCAP file: fields of JSON messages, at the times of the topic that the time is of."""

from __future__ import annotations

import io
import math
from collections.abc import Collection, Iterator
from collections.abc import Mapping as AnyMapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.json_text import parse
from trackmarshal.scenarios import content
from trackmarshal.scenarios.field.mapping import Column
from trackmarshal.scenarios.fields import suggestion

Floats = NDArray[np.float64]
MAGIC = b"\x89MCAP0\r\n"
#: Instead of a field: when the message was logged, in seconds.
LOG_TIME = "log_time"
#: What chunks may unpack to, as a multiple of the file, where that is more than `content.MAX_BYTES`.
_MAX_RATIO = 10


def read(
    data: bytes, shown: str, columns: AnyMapping[str, Column], hold: float
) -> tuple[dict[str, Floats], NDArray[np.int64], str]:
    """(rows,) of each column, which message of its topic each row is, from 1, and what of the beginning and the end is no row; empty: nothing.

    A column is `/topic.field.field`; a row is a message of the topic of `t`, and columns of other topics are what they said last, at most `hold`
    seconds of the log's own time before. A topic that two sources write by turns is of neither. Raises E484 without the package `mcap`, D124, D170, D171
    and D174.
    """
    try:
        from mcap.exceptions import McapError
    except ImportError as error:
        raise TrackmarshalError(
            "E484", "MCAP needs the package `mcap`", file=shown, help="pip install trackmarshal[mcap]"
        ) from error
    ways = {name: _way(column, name, shown) for name, column in columns.items()}
    base = ways["t"][0]
    wanted = {topic for topic, _ in ways.values()}
    latest: dict[str, tuple[int, Any]] = {}
    rows: list[list[float]] = []
    counts: list[int] = []
    topics: set[str] = set()
    number = 0
    early: list[int] = []  #: ns: messages of `base` before all other topics had come
    late: set[str] = set()
    began = last = 0  #: ns: the first row, and the last one
    over: list[int] = []  #: ns: messages of `base` since another topic fell silent
    ended: tuple[str, int] = "", 0  #: that topic, and the first of these messages
    channels: dict[str, list[int]] = {}  #: by topic the channels that wrote it, the last one behind
    try:
        for channel, message in _messages(data, shown, wanted, topics):
            number += 1
            if channel.message_encoding != "json":
                message_ = f"messages of `{channel.topic}` are encoded as `{channel.message_encoding}`"
                raise TrackmarshalError(
                    "D174",
                    message_,
                    file=shown,
                    help="only JSON is read: convert the log, or export it as CSV",
                )
            wrote = channels.setdefault(channel.topic, [])
            if channel.id in wrote[:-1]:
                raise TrackmarshalError(
                    "D174",
                    f"message {number}: two sources write `{channel.topic}` by turns, and nothing says which is meant",
                    file=shown,
                    help="leave one of them out of the log, or give it a topic of its own",
                )
            if channel.id not in wrote:
                wrote.append(channel.id)
            latest[channel.topic] = message.log_time, _parsed(message.data, channel.topic, number, shown)
            if channel.topic != base:
                continue
            silent = sorted(
                t for t in wanted if t not in latest or message.log_time - latest[t][0] > hold * 1e9
            )
            if silent:
                if rows:
                    ended = ended if over else (silent[0], number)
                    over.append(message.log_time)
                else:
                    early.append(message.log_time)
                    late.update(silent)
                continue
            if over:  # it was not the end
                raise _wrong(
                    f"nothing of `{ended[0]}` for more than {hold:g} s",
                    shown,
                    ended[1],
                    "`hold` says how long it may be silent",
                )
            if not rows:
                began = message.log_time
            last = message.log_time
            rows.append([_value(latest[topic], way, topic, shown, number) for topic, way in ways.values()])
            counts.append(number)
    except TrackmarshalError:
        raise
    except (
        McapError,
        ValueError,
        KeyError,
        EOFError,
        OverflowError,
        OSError,
        MemoryError,
        RuntimeError,
        TypeError,
        IndexError,
        AttributeError,
    ) as error:
        message_ = f"a damaged MCAP file: {str(error) or type(error).__name__}"
        raise TrackmarshalError("D174", message_, file=shown, help="fetch the file again") from error
    except Exception as error:  # of the packages that unpack: struct.error, and those of lz4 and zstandard
        message_ = f"a damaged MCAP file: {type(error).__name__}"
        raise TrackmarshalError("D174", message_, file=shown, help="fetch the file again") from error
    missing = sorted(wanted - topics)
    if missing:
        help_ = f"{suggestion(missing[0], topics)} topics: {', '.join(sorted(topics)[:12]) or 'none'}".strip()
        raise TrackmarshalError("D170", f"there is no topic `{missing[0]:.60}`", file=shown, help=help_)
    if not rows:
        raise TrackmarshalError(
            "D126",
            "there is no message with all columns",
            file=shown,
            help="are the topics there at one time?",
        )
    table = np.array(rows, dtype=np.float64)
    left_out = []
    if early:
        waited = ", ".join(f"`{topic}`" for topic in sorted(late))
        left_out.append(
            f"its first {(began - early[0]) / 1e9:.3f} s, {len(early)} messages of `{base}`, are left out: nothing of {waited} yet"
        )
    if over:
        left_out.append(
            f"its last {(over[-1] - last) / 1e9:.3f} s, {len(over)} messages of `{base}`, are left out: nothing of `{ended[0]}` any more"
        )
    return (
        {name: np.ascontiguousarray(table[:, i]) for i, name in enumerate(columns)},
        np.array(counts),
        "; ".join(left_out),
    )


def _messages(data: bytes, shown: str, wanted: Collection[str], topics: set[str]) -> list[tuple[Any, Any]]:
    """The messages of the wanted topics, each with its channel, by the times they were logged at; adds the topics of all channels to `topics`.

    The file is read from its beginning to its end. Its index is not asked: messages that this does not name are as much a part of the log.
    """
    from mcap.records import Channel, Message

    channels: dict[int, Any] = {}
    found: list[tuple[Any, Any]] = []
    for record in _records(data, shown):
        if isinstance(record, Channel):
            channels[record.id] = record
            topics.add(record.topic)
        elif isinstance(record, Message) and channels[record.channel_id].topic in wanted:
            found.append((channels[record.channel_id], record))
    return sorted(found, key=lambda each: each[1].log_time)


def _records(data: bytes, shown: str) -> Iterator[Any]:
    """The records of a file and of its chunks, held against their checksums; raises D124, D174 for more than one file, and the package's errors."""
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, breakup_chunk

    left = limit = max(content.MAX_BYTES, _MAX_RATIO * len(data))
    stream = io.BytesIO(data)
    for record in StreamReader(stream, emit_chunks=True, validate_crcs=True).records:
        if not isinstance(record, Chunk):
            yield record
            continue
        left -= record.uncompressed_size
        if record.uncompressed_size > content.MAX_BYTES:
            raise content.too_large(shown, f"a chunk unpacks to {record.uncompressed_size} bytes")
        if left < 0:
            raise content.too_large(shown, f"{len(data)} bytes unpack to more", limit)
        record.data, record.compression = _unpacked(record), ""
        yield from breakup_chunk(record, validate_crc=True)
    # The package stops at the end of the first of two files that were put together.
    behind = len(data) - stream.tell()
    if behind:
        message = f"{behind} bytes stand behind the end of the MCAP file, and would be lost"
        help_ = "are these two files in one? Merge them with `mcap merge`, or make a recording of each"
        raise TrackmarshalError("D174", message, file=shown, help=help_)


def _unpacked(chunk: Any) -> bytes:
    """What a chunk holds, if it is as much as it declares: the package would unpack whatever comes."""
    import zstandard
    from lz4.frame import LZ4FrameDecompressor

    size, data = chunk.uncompressed_size, b""
    match chunk.compression:
        case "":
            data = chunk.data
        case "lz4":
            data = LZ4FrameDecompressor().decompress(chunk.data, max_length=size + 1)
        case "zstd":
            if zstandard.frame_content_size(chunk.data) in (-1, size):  # -1: the frame does not say
                data = zstandard.decompress(chunk.data, size)
        case other:
            raise ValueError(f"a chunk is packed by `{other:.40}`")
    if len(data) != size:
        raise ValueError(f"a chunk that declares {size} bytes holds another number of them")
    return data


def _way(column: Column, name: str, shown: str) -> tuple[str, tuple[str, ...]]:
    topic, *fields = str(column.name).split(".")
    if not topic.startswith("/") or not fields:
        message = f"`{column.name}` is no field of a topic, which is to be `{name}`"
        raise TrackmarshalError("D170", message, file=shown, help="write /topic.field, or /topic.log_time")
    return topic, tuple(fields)


def _parsed(data: bytes, topic: str, number: int, shown: str) -> Any:
    try:
        return parse(data.decode(), constants=True)
    except ValueError as error:  # BadJson, or no UTF-8
        help_ = "mend what writes it, or fetch the file again"
        raise _wrong(f"a message of `{topic}` cannot be read: {error}", shown, number, help_) from error


def _value(latest: tuple[int, Any], way: tuple[str, ...], topic: str, shown: str, number: int) -> float:
    at, value = latest
    if way == (LOG_TIME,):
        return at / 1e9
    for name in way:
        counted = name.isascii() and name.isdigit() and len(name) < 10
        if isinstance(value, list) and counted and int(name) < len(value):
            value = value[int(name)]
            continue
        if not isinstance(value, dict) or name not in value:
            known = ", ".join(list(value)[:12]) if isinstance(value, dict) else "no fields"
            message = f"message {number}: `{topic}` has no `{'.'.join(way):.60}`"
            raise TrackmarshalError("D170", message, file=shown, help=f"at `{name}` there are: {known}")
        value = value[name]
    if (
        isinstance(value, bool)
        or not isinstance(value, int | float)
        or not abs(value) < 1e300
        or not math.isfinite(value)
    ):
        help_ = "take the message out of the log, or mend it; a missing number is not guessed"
        if isinstance(value, dict) and value.keys() >= {"sec"}:
            help_ = f"a stamp of two numbers is none: `{topic}.{LOG_TIME}` is when the message was logged"
        raise _wrong(f"`{topic}.{'.'.join(way)}` is {value!r:.40}, no finite number", shown, number, help_)
    return float(value)


def _wrong(message: str, shown: str, number: int, help: str) -> TrackmarshalError:
    return TrackmarshalError("D171", f"message {number}: {message}", file=shown, help=help)
