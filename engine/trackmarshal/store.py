"""The evidence store: an append-only file of results, each with all that it was made from, called by the hash of what it says.

A line is an entry, a JSON object that begins with its `id`, the sha256 of the rest of the line. What a text editor changed has another
hash than it is called by; who makes the hash again as well is found by running everything again. Nothing here imports more than the
standard library.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any, NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.files import UNMERGED, read_regular, unmerged

FILE = "evidence.jsonl"
#: The largest store that is read.
MAX_BYTES = 512_000_000
KINDS = ("test", "run", "fault", "external", "comparison")
#: How lines begin that git writes around the sides of what it could not merge.
_SIDES = (b"<<<<<<<", b"|||||||", b"=======", b">>>>>>>")
_HEAD, _ID = b'{"id": "', 64
_OTHER_VERSION = "it is no entry of this version"
#: From where on a line is hashed: behind its id, the quote, comma and space after it.
_REST = len(_HEAD) + _ID + 3

CODES = {
    "T293": (
        "an entry of the evidence store that is not what it was written as",
        "Each line of the store is called by the hash of what it says, and this one has another: it was changed by hand, or cut. It counts "
        "for nothing, and what it was the evidence of is run again. Nobody changes results: change what they are made from. Remove the line, "
        "or restore the file.",
    ),
    "T294": (
        "a result that does not come out again",
        "With `--rerun`, everything that the store answers for is run again. From the same inputs, something else came out than an entry of "
        "the store says: the entry was made by hand, hash included, or what was run depends on more than its inputs. What came out now counts, "
        "and is in the store from now on; find out which of the two it was before you rely on either.",
    ),
    "T295": (
        "an evidence store that cannot be read",
        "The store is larger than 512 MB, or no regular file. Move it away: what it was the evidence of is run again.",
    ),
    "T296": (
        "a file that was written while it was read",
        "Specs, requirements or recordings are others now than they were when this call read them, so that of a part of what it says nobody knows "
        "whether it is of the text of before or of the one behind it: an editor, a formatter or another checkout wrote them meanwhile. Nothing that was "
        "found out is kept, and no gate passes on it. Run it again.",
    ),
}  # fmt: skip


class Broken(NamedTuple):
    """A line that is not what it was written as."""

    line: int
    why: str
    subject: str = ""  #: as far as it can still be read


@dataclass(frozen=True, slots=True)
class Entry:
    """A result: what it is of, from which inputs (sha256 by name), what came out, and by which tool, at which commit, where, when."""

    kind: str
    subject: str
    inputs: Mapping[str, str]
    result: Mapping[str, Any]
    tool: str
    commit: str
    platform: str
    made: str
    #: Parameters in force, in SI, where the result is not of the declared ones alone.
    params: Mapping[str, float] = field(default_factory=dict)
    line: int = 0  #: where it stands in the store; 0: nowhere yet

    def text(self) -> bytes:
        """Its line, with its id, without the end of line."""
        said = {
            "kind": self.kind, "subject": self.subject, "inputs": dict(self.inputs), "result": dict(self.result), "tool": self.tool,
            "commit": self.commit, "platform": self.platform, "made": self.made, "params": dict(self.params),
        }  # fmt: skip
        rest = json.dumps(said, ensure_ascii=False, allow_nan=False, sort_keys=True)[1:].encode("utf-8")
        return _HEAD + hashlib.sha256(rest).hexdigest().encode() + b'", ' + rest

    def by(self, tool: str, commit: str, platform: str) -> Entry:
        """The entry with what it was made by."""
        return replace(self, tool=tool, commit=commit, platform=platform)

    @property
    def id(self) -> str:
        return self.text()[len(_HEAD) : len(_HEAD) + _ID].decode()


class Store:
    """The entries of a results folder: of each subject the last one, and the last one of each set of inputs."""

    def __init__(self, folder: Path) -> None:
        """Read them; raises T295."""
        self.path = folder / FILE
        self.broken: list[Broken] = []
        self._last: dict[tuple[str, str], Entry] = {}
        self._of: dict[tuple[str, str], list[Entry]] = {}
        for entry in self._read():
            self._take(entry)

    def latest(self, kind: str, subject: str) -> Entry | None:
        """The last entry of a subject, from whatever it was made."""
        return self._last.get((kind, subject))

    def find(self, kind: str, subject: str, inputs: Mapping[str, str]) -> Entry | None:
        """The last entry of a subject that was made from exactly these inputs."""
        entries = self._of.get((kind, subject), ())
        return next((entry for entry in reversed(entries) if entry.inputs == inputs), None)

    def add(self, entries: Iterable[Entry]) -> None:
        """Write entries at the end, all in one go, or none of them; raises OSError."""
        new = list(entries)
        if not new:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        data = b"".join(entry.text() + b"\n" for entry in new)
        with self.path.open("a+b", buffering=0) as stream:
            begin = stream.seek(0, os.SEEK_END)
            if begin and not _ends_a_line(stream):
                data = b"\n" + data  # what was cut there stays a line of its own
            written = 0
            try:
                while written < len(data):
                    written += stream.write(data[written:])
            except OSError:
                # On a full disk: part of a line would pass for one that somebody changed. Unless another process has written behind it.
                if stream.seek(0, os.SEEK_END) == begin + written:
                    stream.truncate(begin)
                raise
        for entry in new:
            self._take(entry)

    def refuse(self, entry: Entry) -> None:
        """Count an entry for nothing of which the result is none of this version: it is broken, and those before it count again."""
        key = (entry.kind, entry.subject)
        self.broken.append(Broken(entry.line, _OTHER_VERSION, entry.subject))
        self._of[key] = [one for one in self._of[key] if one is not entry]
        del self._last[key]
        for one in self._of[key][-1:]:
            self._last[key] = one

    def _take(self, entry: Entry) -> None:
        self._last[entry.kind, entry.subject] = entry
        self._of.setdefault((entry.kind, entry.subject), []).append(entry)

    def _read(self) -> Iterator[Entry]:
        try:
            if self.path.stat().st_size > MAX_BYTES:
                raise _refused(self.path, f"larger than {MAX_BYTES // 1_000_000} MB")
            data = read_regular(self.path)
        except FileNotFoundError:
            return
        except OSError as error:
            raise _refused(self.path, error.strerror or str(error)) from error
        sides = unmerged(data)  # entries of both of them hold
        if sides:
            self.broken.append(Broken(sides, UNMERGED))
        for number, line in enumerate(data.split(b"\n"), 1):
            if line.strip() and not (sides and line.startswith(_SIDES)):
                entry = _entry(
                    line.removesuffix(b"\r"), number
                )  # a checkout may have made it of two characters
                if isinstance(entry, Entry):
                    yield entry
                else:
                    self.broken.append(entry)


def _ends_a_line(stream: IO[bytes]) -> bool:
    stream.seek(-1, os.SEEK_END)
    return stream.read(1) == b"\n"


def _entry(line: bytes, number: int) -> Entry | Broken:
    """A line as an entry, if its hash is the one that it is called by."""
    id_, rest = line[len(_HEAD) : len(_HEAD) + _ID], line[_REST:]
    if not line.startswith(_HEAD) or hashlib.sha256(rest).hexdigest().encode() != id_:
        return Broken(number, "its hash is not the one that it is called by", _subject(rest))
    try:
        said = json.loads(b"{" + rest)
        entry = Entry(
            said["kind"], said["subject"], said["inputs"], said["result"], said["tool"], said["commit"], said["platform"], said["made"],
            said["params"], number,
        )  # fmt: skip
        texts = (
            entry.kind,
            entry.subject,
            entry.tool,
            entry.commit,
            entry.platform,
            entry.made,
            *entry.inputs.values(),
        )
        if (
            entry.kind not in KINDS
            or not all(isinstance(text, str) for text in texts)
            or not isinstance(entry.result, dict)
        ):
            raise ValueError
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return Broken(number, _OTHER_VERSION)
    return entry


def _subject(rest: bytes) -> str:
    """What a changed line says it is of; empty where that is no longer to be read."""
    try:
        said = json.loads(b"{" + rest)
        return said["subject"] if isinstance(said["subject"], str) else ""
    except (ValueError, KeyError, TypeError, RecursionError):
        return ""


def _refused(path: Path, why: str) -> TrackmarshalError:
    return TrackmarshalError(
        "T295", f"the evidence store cannot be read: {why}", file=str(path), help="move it away"
    )
