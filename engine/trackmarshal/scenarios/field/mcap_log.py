"""Numbers out of an MCAP file: fields of JSON messages, at the times of the topic that the time is of."""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping as AnyMapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.field.mapping import Column
from trackmarshal.scenarios.fields import suggestion

Floats = NDArray[np.float64]
MAGIC = b"\x89MCAP0\r\n"
#: Instead of a field: when the message was logged, in seconds.
LOG_TIME = "log_time"


def read(
    data: bytes, shown: str, columns: AnyMapping[str, Column], hold: float
) -> tuple[dict[str, Floats], NDArray[np.int64], str]:
    """(rows,) of each column, which message of its topic each row is, from 1, and what of the beginning and the end is no row; empty: nothing.

    A column is `/topic.field.field`; a row is a message of the topic of `t`, and columns of other topics are what they said last, at most `hold`
    seconds of the log's own time before. A topic that two sources write by turns is of neither. Raises E484 without the package `mcap`, D170, D171 and D174.
    """
    try:
        from mcap.exceptions import McapError
        from mcap.reader import make_reader
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
        reader = make_reader(io.BytesIO(data), validate_crcs=True)
        summary = reader.get_summary()
        if summary is not None:
            topics = {channel.topic for channel in summary.channels.values()}
        for _, channel, message in reader.iter_messages(topics=sorted(wanted)):
            topics.add(channel.topic)
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


def _way(column: Column, name: str, shown: str) -> tuple[str, tuple[str, ...]]:
    topic, *fields = str(column.name).split(".")
    if not topic.startswith("/") or not fields:
        message = f"`{column.name}` is no field of a topic, which is to be `{name}`"
        raise TrackmarshalError("D170", message, file=shown, help="write /topic.field, or /topic.log_time")
    return topic, tuple(fields)


def _parsed(data: bytes, topic: str, number: int, shown: str) -> Any:
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as error:
        raise _wrong(f"a message of `{topic}` is no JSON", shown, number, "fetch the file again") from error


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
