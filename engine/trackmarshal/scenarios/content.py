"""The bytes of a recording, read with limits on their size; and bytes to text."""

from __future__ import annotations

import codecs
import gzip
import io
import re
import zlib
from pathlib import Path

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import fetching, read_regular

#: Largest file that is read, and largest total that it may unpack to. A cycle takes about 5 kB.
MAX_BYTES = 200_000_000
#: Largest record of a run that is run again: at 50 cycles a second, less than it has is a drive of minutes, and nobody can split it.
MAX_RECORD = 1_000_000_000
#: What to do about a record that is too large.
ANEW = "begin a new record now and then, with a new Supervisor"
#: Text of numbers packs to a half or a third of its size; a hundredth is something else.
MAX_RATIO = 100
#: Below this, the ratio is not looked at: short files of equal lines pack well.
SMALL = 1_000_000


def read_record(path: str) -> bytes:
    """All bytes of the record of a run; raises D120 or D124."""
    return read(Path(path), path, MAX_RECORD, ANEW)


def read(path: Path, shown: str, most: int | None = None, help_: str = "") -> bytes:
    """All bytes of a file, up to MAX_BYTES, or so many; raises D120 or D124."""
    most = MAX_BYTES if most is None else most
    try:
        size = path.stat().st_size
        if path.is_dir():
            raise TrackmarshalError("D120", "this is a folder", file=shown, help="name a file in it")
        if size > most:
            raise too_large(shown, f"{size} bytes", most, help_)
        return read_regular(path)
    except (OSError, ValueError) as error:  # ValueError: a NUL in the path
        reason = getattr(error, "strerror", None) or str(error)
        raise TrackmarshalError(
            "D120", reason, file=shown, help=fetching(path) or "check the path"
        ) from error


def is_of(data: bytes, format: str) -> bool:
    """Whether a YAML text says of itself that it is of a format, in quotes or not; a byte order mark may stand before it."""
    said = re.compile(
        rb"""\s*(['"]?)format\1\s*:\s+(['"]?)%s\2(\s*,)?\s*(\s#.*)?""" % re.escape(format.encode())
    )
    lines = data.removeprefix(codecs.BOM_UTF8).splitlines()
    return any(said.fullmatch(line) for line in lines[:200])


def too_large(shown: str, what: str, most: int | None = None, help_: str = "") -> TrackmarshalError:
    return TrackmarshalError(
        "D124",
        f"{what}, the limit is {MAX_BYTES if most is None else most}",
        file=shown,
        help=help_ or "split a long recording; don't open archives of unknown origin",
    )


def believed(packed: int) -> int:
    """To how much so much packed data may unpack: recordings don't unpack to more."""
    return max(SMALL, MAX_RATIO * packed)


def suspicious(packed: int, unpacked: int) -> bool:
    """Does this much packed data unpack to more than recordings do?"""
    return unpacked > believed(packed)


def gunzip(data: bytes, shown: str) -> bytes:
    """The content of a gzip stream; raises D142 or D124, never unpacks more than MAX_BYTES."""
    limit = min(MAX_BYTES, believed(len(data)))
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(data)) as stream:
            content = stream.read(limit + 1)
    except (OSError, EOFError, zlib.error, ValueError) as error:
        message = f"the gzip stream is damaged: {error}"
        raise TrackmarshalError("D142", message, file=shown, help="fetch the file again") from error
    if len(content) > limit:
        # Packed by somebody else, a car that stands may be as much: unpacked, it is read.
        help_ = "" if limit == MAX_BYTES else "where you know its origin, give it unpacked"
        raise too_large(shown, f"{len(data)} bytes unpack to more", limit, help_)
    return content


def gzipped(data: bytes) -> bytes:
    """A gzip stream that `gunzip` reads: of what packs better than that believes, as a car that stands does, so much is stored as it is. Nothing follows
    the stream, such as zeros, which not all readers pass over."""
    packed = gzip.compress(data, mtime=0)
    if not suspicious(len(packed), len(data)):
        return packed
    plain = -(-len(data) // MAX_RATIO)
    stored, rest = (zlib.compressobj(level, zlib.DEFLATED, -zlib.MAX_WBITS) for level in (0, 9))
    first = stored.compress(data[:plain]) + stored.flush(zlib.Z_FULL_FLUSH)
    # The head, and behind it the sum and the length of what is packed, stay.
    return packed[:10] + first + rest.compress(data[plain:]) + rest.flush() + packed[-8:]


def text(data: bytes, shown: str) -> str:
    """UTF-8 to text, a byte order mark taken off; raises D126 with the line."""
    try:
        decoded = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        message = f"byte {data[error.start]:#04x} at offset {error.start} is not UTF-8"
        raise TrackmarshalError("D126", message, file=shown, line=line, help="save it as UTF-8") from error
    if not decoded.strip():
        raise TrackmarshalError("D126", "the file is empty", file=shown, line=1, help="was it cut off?")
    return decoded
