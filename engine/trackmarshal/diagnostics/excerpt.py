"""Source lines with marks under them, aligned on a terminal: tabs, wide and combining characters, long lines."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterator, Sequence

from trackmarshal.node import Node
from trackmarshal.source import Span

#: Blanks that a tab shows as.
TAB = "    "
#: A mark over more lines than this is shown by its first and last lines.
MOST_LINES = 4


class Mark(Node):
    """A stretch of text to be underlined with a sign, and what is written beside it."""

    stretch: Span
    sign: str
    label: str


def printable(text: str) -> str:
    """Without characters that move a terminal's cursor, change its colour or turn the direction of writing."""
    return text if text.isascii() and text.isprintable() else "".join(_cell(char) for char in text)


def width(text: str) -> int:
    """The columns that a text takes on a terminal."""
    return len(text) if text.isascii() else sum(_width(char) for char in text)


def _cell(char: str) -> str:
    if char == "\t":
        return TAB
    return (
        "\N{REPLACEMENT CHARACTER}"
        if unicodedata.category(char) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")
        else char
    )


def _width(char: str) -> int:
    if unicodedata.combining(char) or unicodedata.category(char) in ("Mn", "Me"):
        return 0
    return 2 if unicodedata.east_asian_width(char) in ("W", "F") else 1


def excerpt(marks: Sequence[Mark], room: int) -> Iterator[tuple[int | None, str, str]]:
    """Rows of an excerpt, all of one file: (line number, "", source), (None, sign, underline), (None, "", "") for a gap."""
    rows: dict[int, list[tuple[int, int, str, str]]] = {}
    for mark in marks:
        for number, start, end, label in _pieces(mark):
            rows.setdefault(number, []).append((start, end, mark.sign, label))
    previous = None
    for number in sorted(rows):
        if previous is not None and number == previous + 2:
            yield number - 1, "", _windowed(_line(marks[0].stretch, number - 1), 0, room)[0]
        elif previous is not None and number > previous + 1:
            yield None, "", ""
        previous = number
        line = _line(marks[0].stretch, number)
        waiting = sorted(rows[number])
        while waiting:  # once for all marks that one window shows: in a long line, others are far from it
            shown, cut = _windowed(line, waiting[0][0], room)
            yield number, "", shown
            taken = 0
            for start, end, sign, label in waiting:
                before, under = width(printable(line[:start])) - cut, width(printable(line[start:end]))
                if taken and before > room - 2:
                    break
                under = max(1, min(under, room - before))
                yield None, sign, " " * before + f"{sign * under} {printable(label)}".rstrip()
                taken += 1
            waiting = waiting[taken:]


def _line(stretch: Span, number: int) -> str:
    """The text of a line of the file that a stretch is in."""
    return stretch.file.line(number)


def _pieces(mark: Mark) -> Iterator[tuple[int, int, int, str]]:
    """A mark line by line: (number, first column, end column) from 0; the label goes to the last."""
    file = mark.stretch.file
    first, column = file.position(mark.stretch.start)
    last, end = file.position(max(mark.stretch.start, mark.stretch.end))
    if last == first:
        yield first, column - 1, max(end - 1, column), mark.label
        return
    middle = range(first + 1, last)
    for number in (first, *(middle if last - first < MOST_LINES else ()), last):
        line = _line(mark.stretch, number)
        start = column - 1 if number == first else len(line) - len(line.lstrip())
        stop = end - 1 if number == last else len(line.rstrip())
        if stop > start or number in (first, last):
            yield number, start, max(stop, start + 1), mark.label if number == last else ""


def _windowed(line: str, start: int, room: int) -> tuple[str, int]:
    """A line as shown, cut around column `start` if it is long, and the terminal columns cut off before it."""
    shown = printable(line)
    if width(shown) <= room:
        return shown, 0
    before = width(printable(line[:start]))
    skip = max(0, before - room // 3)
    if skip == 0:
        return _clipped(shown, room - 1) + "…", 0
    position, index = 0, 0
    while position < skip + 1:
        position += _width(shown[index])
        index += 1
    while index < len(shown) and _width(shown[index]) == 0:
        index += 1
    rest = shown[index:]
    tail = rest if width(rest) <= room - 1 else _clipped(rest, room - 2) + "…"
    return "…" + tail, position - 1


def _clipped(text: str, room: int) -> str:
    taken = 0
    for index, char in enumerate(text):
        taken += _width(char)
        if taken > room:
            return text[:index]
    return text
