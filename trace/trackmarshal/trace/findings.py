"""Findings of traceability: what is wrong, where, how bad, and what to do about it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

#: From worst to mildest; errors fail the gate.
LEVELS = ("error", "warning", "note")


class Place(NamedTuple):
    """A place in a file of the project: path with forward slashes, line and column from 1 (0: the file as a whole)."""

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        if not self.line:
            return self.file
        return f"{self.file}:{self.line}:{self.column}" if self.column else f"{self.file}:{self.line}"


@dataclass(frozen=True, slots=True)
class Finding:
    """One error, warning or note. `subject` is the name that it is about, which waivers refer to.

    about: what else it is about, such as the other end of a link. rests_on: by what it may have come about, such as the items of a cell.
    """

    code: str
    level: str
    message: str
    place: Place | None = None
    help: str = ""
    subject: str = ""
    also: tuple[tuple[Place, str], ...] = ()  #: further places, each with what is there
    about: tuple[str, ...] = ()
    rests_on: tuple[str, ...] = ()
    gone: bool = False  #: whether it says that something is not there any more
    excused: bool = False  #: an error that a waiver made a note

    def __hash__(self) -> int:
        """Of what tells findings apart: what they are further about may be as long as a project."""
        return hash((self.code, self.message, self.place, self.subject))

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        lines = [f"{where}{self.level}[{self.code}]: {self.message}"]
        lines += [f"  {place}: {label}" for place, label in self.also]
        if self.help:
            lines.append(f"  help: {self.help}")
        return "\n".join(lines)


def error(code: str, message: str, place: Place | None, help: str = "", subject: str = "") -> Finding:
    return Finding(code, "error", message, place, help, subject)


def warning(code: str, message: str, place: Place | None, help: str = "", subject: str = "") -> Finding:
    return Finding(code, "warning", message, place, help, subject)


def in_order(found: Iterable[Finding]) -> tuple[Finding, ...]:
    """Without repetitions, worst first, then by place."""
    return tuple(
        sorted(
            dict.fromkeys(found),
            key=lambda f: (LEVELS.index(f.level), f.place or Place(""), f.code, f.message),
        )
    )


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """A suggestion for a misspelt word, or the empty text."""
    names = sorted(set(known))
    if (
        len(names) > 2_000
    ):  # close matches cost time in proportion; among very many names only near-equal ones help
        names = [name for name in names if name[:1] == word[:1] and abs(len(name) - len(word)) <= 2][:2_000]
    from difflib import get_close_matches  # which nobody else waits for

    close = get_close_matches(word, names, n=2, cutoff=0.6)
    return "did you mean " + " or ".join(f"`{name}`" for name in close) + "?" if close else ""
