"""What a run comes to after a cycle as plain data: saved piece by piece, and restored only where it is of the same rules, and whole.

A snapshot is a head and pieces, all of them JSON. The head says of what it is: `kind` (who can restore it) and `of`, the hash of all that its
meaning rests on. The digest of the pieces comes after them. Floats are kept to the bit: those that JSON has no word for as the 16 hex digits of their bits.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir.spec import Spec, TableInfo
from trackmarshal.runtime.frame import NO_SETTINGS, Settings
from trackmarshal.runtime.program import Memory

FORMAT = "trackmarshal-snapshot"
VERSION = 3
#: A part of what is saved, as JSON: small, so that it takes a few microseconds.
Piece = list[Any]
#: Who can restore what rules remember that remember nothing: every Supervisor in Python.
PLAIN = "plain"
_BITS = struct.Struct(">d")


@dataclass(frozen=True, slots=True)
class Saving:
    """Something that is being saved. Its pieces are made one by one, later: what was taken is as it was when this was made."""

    kind: str
    of: str
    pieces: Iterator[Piece]

    @property
    def head(self) -> Piece:
        """What comes before the pieces."""
        return [FORMAT, VERSION, self.kind, self.of]


class Pieces:
    """The pieces of something that is restored, in order. Raises ValueError where one is not what should come."""

    def __init__(self, pieces: Iterable[Any]) -> None:
        self._pieces = iter(pieces)

    def next(self, name: str, count: int) -> Piece:
        """The next piece, without its name: so many values."""
        piece = next(self._pieces, None)
        if type(piece) is not list or len(piece) != count + 1 or piece[0] != name:
            raise ValueError(f"{name} should come")
        return piece[1:]

    def any(self) -> tuple[str, Piece]:
        """The next piece, whichever it is: its name, and the rest of it."""
        piece = next(self._pieces, None)
        if type(piece) is not list or not piece or type(piece[0]) is not str:
            raise ValueError("a piece is missing")
        return piece[0], piece[1:]

    def end(self) -> None:
        """Nothing is left."""
        if next(self._pieces, None) is not None:
            raise ValueError("more than there should be")


@runtime_checkable
class Keeping(Protocol):
    """A program that can save what its rules remember."""

    def kept(self) -> tuple[str, str]:
        """Who can restore it, and in words what it is made of. Raises TrackmarshalError E486 where it cannot be saved."""

    def save(self, memory: Memory) -> Iterator[Piece]:
        """What is taken is taken when this is called; the pieces are made later. Raises TrackmarshalError E486 for what has no JSON."""

    def restored(self, pieces: Pieces) -> Memory:
        """Raises ValueError, KeyError, TypeError or IndexError for what was not saved by a program of the same `kept`."""


def kept_by(program: object) -> tuple[str, str]:
    """Who can restore what a program remembers, and what that is made of. Raises TrackmarshalError E486."""
    return program.kept() if isinstance(program, Keeping) else (PLAIN, "")


def save(program: object, memory: Memory) -> Iterator[Piece]:
    """What a program's rules remember, piece by piece. Raises TrackmarshalError E486."""
    if isinstance(program, Keeping):
        return program.save(memory)
    if type(memory) is not Memory:
        raise unsaved("what its rules remember is not known here")
    return iter(())


def restored(program: Any, pieces: Pieces) -> Memory:
    """What a program's rules remember again; raises as `Keeping.restored` does."""
    if isinstance(program, Keeping):
        return program.restored(pieces)
    memory: Memory = program.start()
    if type(memory) is not Memory:
        raise ValueError("what its rules remember is not known here")
    return memory


def unsaved(why: str) -> TrackmarshalError:
    """E486: what is remembered cannot be saved."""
    return TrackmarshalError("E486", why, help="a replay starts at the beginning of the run")


# What it is of --------------------------------------------------------------------------------------------------------


def meaning(
    spec: Spec, rules: Sequence[str], words: str, settings: Settings = NO_SETTINGS, more: Any = None
) -> str:
    """The hash of all that a snapshot rests on: the spec, the rules that are judged, what memory is made of, the values in force."""
    given = [
        [VERSION, spec.fingerprint, spec.inputs, list(rules), words],
        [[name, spelt(info.value)] for name, info in sorted(spec.params.items())],
        [[name, _rows(info.knots, info.values, *_more(info))] for name, info in sorted(spec.tables.items())],
        [[name, spelt(value)] for name, value in sorted(settings.params.items())],
        [[name, _rows(*rows)] for name, rows in sorted(settings.tables.items())],
        [[name, [[spelt(x) for x in point] for point in points]] for name, points in sorted(settings.places.items())],
        more,
    ]  # fmt: skip
    return hashlib.sha256(dumped(given).encode()).hexdigest()


def _more(info: TableInfo) -> Iterator[Iterable[float]]:
    """What a table has besides knots and values: a period, or a second argument."""
    if info.way.length:
        yield (info.way.length,)
    if info.across is not None:
        yield info.across.knots
        yield (info.across.way.length,)


def _rows(*rows: Iterable[float]) -> list[list[Any]]:
    return [[spelt(value) for value in row] for row in rows]


# Numbers and text -----------------------------------------------------------------------------------------------------


def spelt(value: float) -> float | str:
    """A float as JSON, to the bit."""
    number = float(value)
    return number if math.isfinite(number) else _BITS.pack(number).hex()


def unspelt(value: Any) -> float:
    """The float that `spelt` gave; raises ValueError for anything else."""
    if type(value) is float and math.isfinite(value):
        return value
    if type(value) is str and len(value) == 16:
        found: float = _BITS.unpack(bytes.fromhex(value))[0]
        if not math.isfinite(found):
            return found
    raise ValueError("no number")


def checked(value: Any, *kinds: type) -> Any:
    """A value of one of these types, which JSON tells apart; raises ValueError for another one."""
    if type(value) not in kinds:
        raise ValueError(
            f"a {type(value).__name__} where {' or '.join(kind.__name__ for kind in kinds)} belongs"
        )
    return value


def count(value: Any) -> int:
    """A whole number from 0; raises ValueError for anything else."""
    if type(value) is not int or value < 0:
        raise ValueError("no count")
    return value


def dumped(piece: Any) -> str:
    """A piece as one line."""
    return json.dumps(piece, allow_nan=False, separators=(",", ":"))


# Whole snapshots ------------------------------------------------------------------------------------------------------


class Writer:
    """Makes the lines of a snapshot, one a piece: the head, the pieces, and the digest of all of them."""

    def __init__(self, saving: Saving) -> None:
        self._pieces = saving.pieces
        self._digest = hashlib.sha256()
        self._head: Piece | None = saving.head
        #: Whether the digest was the last line.
        self.done = False

    def lines(self, most: int, full: float = math.inf) -> list[str]:
        """At most so many of the lines that are next, fewer where they have that many characters. Raises as what makes the pieces does."""
        found: list[str] = []
        while len(found) < most and not self.done and sum(map(len, found)) < full:
            piece = self._head if self._head is not None else next(self._pieces, None)
            self._head = None
            if piece is None:
                self.done = True
                found.append(dumped(["end", self._digest.hexdigest()]))
            else:
                found.append(dumped(piece))
                self._digest.update(found[-1].encode())
                self._digest.update(b"\n")
        return found


def whole(saving: Saving) -> list[str]:
    """All lines of a snapshot at once."""
    writer, lines = Writer(saving), list[str]()
    while not writer.done:
        lines += writer.lines(64)
    return lines


def opened(lines: Sequence[str], kind: str, of: str, shown: str = "") -> Pieces:
    """The pieces of a snapshot. Raises TrackmarshalError D163 for one that is damaged, D164 for one of something else."""
    if type(lines) not in (list, tuple) or len(lines) < 2 or any(type(line) is not str for line in lines):
        raise damaged("it is not whole", shown)
    digest = hashlib.sha256()
    for line in lines[:-1]:
        digest.update(line.encode("utf-8", "surrogatepass"))
        digest.update(b"\n")
    try:
        read = [json.loads(line, parse_constant=_no_constant) for line in lines]
    except RecursionError as error:
        raise damaged("it is nested too deeply", shown) from error
    except ValueError as error:
        raise damaged(str(error), shown) from error
    if read[-1] != ["end", digest.hexdigest()]:
        raise damaged("its digest is another one", shown)
    head = read[0]
    if type(head) is not list or len(head) != 4:
        raise damaged("it has no head", shown)
    wanted = [FORMAT, VERSION, kind, of]
    said = ("format", "version", "evaluator", "spec, rules, parameters or program")
    for what, found, known in zip(said, head, wanted):
        if type(found) is not type(known) or found != known:
            raise TrackmarshalError(
                "D164", f"it is of another {what}", file=shown, help="a replay from the beginning needs none"
            )
    return Pieces(read[1:-1])


def damaged(why: str, shown: str = "") -> TrackmarshalError:
    """D163: nothing is restored from it."""
    return TrackmarshalError(
        "D163",
        f"the snapshot cannot be used: {why}",
        file=shown,
        help="a replay from the beginning needs none",
    )


#: What is raised by whoever finds in a snapshot what nobody saved.
NOT_SAVED = (ValueError, KeyError, TypeError, IndexError, OverflowError, AttributeError)


def _no_constant(word: str) -> float:
    raise ValueError(f"{word} is not strict JSON")
