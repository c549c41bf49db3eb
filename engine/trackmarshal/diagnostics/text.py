"""Findings for people: the message, the place, the lines with carets under them, the help."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.diagnostics.excerpt import Mark, excerpt, printable
from trackmarshal.diagnostics.finding import Finding, Place, findings
from trackmarshal.errors import TrackmarshalError

#: Places at most this many lines apart share an excerpt.
NEARBY = 8
#: Of further places, so many are shown; the rest is named.
MOST_PLACES = 3

_BOLD, _BLUE, _CYAN, _RESET = "\033[1m", "\033[1;34m", "\033[1;36m", "\033[0m"
_LEVELS = {"error": "\033[1;31m", "warning": "\033[1;33m", "note": "\033[1;32m"}


def render(items: Iterable[Diagnostic | TrackmarshalError], *, colour: bool = False, width: int = 120) -> str:
    """All findings as text, a blank line between two; `width` is that of the excerpts."""
    return "\n".join(_Text(finding, colour, width).text() for finding in findings(items))


class _Text:
    """One finding being written."""

    def __init__(self, finding: Finding, colour: bool, width: int) -> None:
        self._finding = finding
        self._colour = colour
        self._width = width
        self._level = _LEVELS[finding.level]
        last = max((place.end_line or place.line or 0) for place in (finding.place, *finding.related))
        self._gutter = len(str(last))

    def text(self) -> str:
        found = self._finding
        head = self._painted(self._level, f"{found.level}[{found.code}]") + self._painted(
            _BOLD, f": {_lines(found.message)}"
        )
        lines = [head]
        place = found.place
        if place.file is not None:
            related, rest = found.related[:MOST_PLACES], found.related[MOST_PLACES:]
            near = [other for other in related if _near(place, other)]
            lines += self._shown(place, near, "-->")
            for other in related:
                if other not in near:
                    lines += self._shown(other, [], ":::")
            if rest:
                places = ", ".join(
                    f"{printable(other.file or '')}:{other.line}:{other.column}" for other in rest
                )
                lines.append(f"{self._margin()}= {len(rest)} more: {places}")
        if found.help:
            lines.append(f"{self._margin()}= {self._painted(_BOLD, 'help')}: {_lines(found.help)}")
        return "\n".join(lines) + "\n"

    def _margin(self) -> str:
        return " " * (self._gutter + 1)

    def _painted(self, colour: str, text: str) -> str:
        return f"{colour}{text}{_RESET}" if self._colour else text

    def _shown(self, place: Place, near: Sequence[Place], arrow: str) -> list[str]:
        """A place's head line, and the excerpt with its mark and those nearby."""
        where = [str(part) for part in (place.file, place.line, place.column) if part is not None]
        lines = [" " * self._gutter + self._painted(_BLUE, arrow) + " " + printable(":".join(where))]
        if place.mark is None:
            return [f"{lines[0]}: {printable(place.label)}"] if place.label else lines
        first = arrow == "-->"
        marks = [Mark(place.mark, "^" if first else "-", place.label)]
        marks += [Mark(other.mark, "-", other.label) for other in near if other.mark is not None]
        bar = self._painted(_BLUE, "|")
        lines.append(self._margin() + bar)
        for number, sign, shown in excerpt(marks, self._width - self._gutter - 3):
            if number is not None:
                lines.append(
                    f"{self._painted(_BLUE, str(number).rjust(self._gutter))} {bar} {shown}".rstrip()
                )
            elif sign:
                lines.append(
                    f"{self._margin()}{bar} " + self._painted(self._level if sign == "^" else _CYAN, shown)
                )
            else:
                lines.append(self._painted(_BLUE, "..."))
        return lines


def _near(place: Place, other: Place) -> bool:
    if place.mark is None or other.mark is None or place.mark.file is not other.mark.file:
        return False
    return abs((place.line or 0) - (other.line or 0)) <= NEARBY


def _lines(text: str) -> str:
    return "\n        ".join(printable(line) for line in text.split("\n"))
