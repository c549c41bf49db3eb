"""The document as Typst's source, and as PDF. Every text goes in as a string of Typst, so that nothing that an author wrote is code."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace.case.html import there
from trackmarshal.trace.case.making import printed
from trackmarshal.trace.case.model import (
    Code,
    Document,
    Fixed,
    Given,
    Inline,
    Line,
    Made,
    Number,
    Piece,
    Ref,
    Status,
    Written,
)
from trackmarshal.trace.case.words import COLOURS
from trackmarshal.trace.render.words import LIKE, SIGNS

if TYPE_CHECKING:
    from markupsafe import Markup

#: Letters of a name or a hash in a row after which it may be broken, and signs of paths after which it may.
_RUN = 12
#: So many letters at least stand in a line of a table as wide as the text; a row that needs at most so many lines stays on one page.
_LINE, _HALF_PAGE = 90, 30
_BREAK = re.compile(r"(?<=[/_.:\-])(?=\w)")
#: Blanks that fonts have, and marks of where a line may end: none of them is printable, and people write them (`80 km/h` on one line, a tab in a spec).
_BLANK = frozenset("\n\t\u00a0\u00ad\u2007\u2009\u200b\u202f")
#: What typst says of a letter that no font has.
_UNSHOWN = re.compile(r'the text `"(.)"` could not be displayed')
#: Ids with hyphens, which stand on one line unless they are too long for a column of a table.
_ID = re.compile(r"(?<![\w-])[A-Z][A-Z0-9]*(?:-[A-Z0-9]+)+(?:\.[0-9]+)?(?![\w-])")


def source(document: Document, folder: Path | None = None) -> str:
    """What Typst sets. folder: templates of the project, in place of ours. Raises T430 for a template that cannot be used."""
    from markupsafe import Markup

    printing = Printing(document)

    def finalize(value: Any) -> Markup:
        """Whatever a template writes is a string of Typst, unless it is Typst already."""
        return value if isinstance(value, Markup) else Markup(string(str(value)))

    filters: dict[str, Callable[..., Any]] = {
        "line": printing.line, "plain": plain, "pieces": broken, "fits": fits,
    }  # fmt: skip
    return printed(
        document, "typ", folder, filters, {"colours": COLOURS, "anchors": printing.there}, finalize
    )


def pdf(text: str, day: str) -> bytes:
    """The PDF of a source; day: the one that it says it was made on. Raises T432 where typst is not installed, T433 where it refuses."""
    try:
        import typst
    except ImportError as missing:
        raise _no_typst() from missing
    from datetime import UTC, datetime

    try:
        made = typst.compile(
            text.encode(), ignore_system_fonts=True, timestamp=datetime.fromisoformat(day).replace(tzinfo=UTC)
        )
    except RuntimeError as refused:
        said = " ".join(str(getattr(refused, "message", "") or refused).split())
        raise TrackmarshalError("T433", f"typst refuses the document: {said}") from refused
    if not isinstance(made, bytes):
        raise TypeError(f"typst made {type(made).__name__} of one document")
    return made


def spelled(text: str) -> tuple[str, str]:
    """A source in which a letter that no font of the PDF has is told by its number, `‹U+6F22›`: typst leaves it out without a word. And these letters.

    Raises T432 where typst is not installed.
    """
    lacking = "".join(_lacking(sorted({char for char in text if char > "\x7f" and char.isprintable()})))
    return text.translate({ord(char): f"‹U+{ord(char):04X}›" for char in lacking}), lacking


def _lacking(letters: Sequence[str]) -> list[str]:
    """Those letters that no font has: documents for archives are to show all of theirs, and typst says of each that it does not."""
    try:
        import typst
    except ImportError as missing:
        raise _no_typst() from missing
    try:
        typst.compile(
            "\n".join(f"#{string(char)}" for char in letters).encode(),
            ignore_system_fonts=True,
            pdf_standards="a-2b",
        )
    except RuntimeError as refused:
        found = _UNSHOWN.findall(str(getattr(refused, "diagnostic", "") or refused))
        if not found or set(found) - set(letters):
            raise TrackmarshalError(
                "T433", f"typst does not say which letters it can show: {refused}"
            ) from refused
        return sorted(set(found))
    return []


def _no_typst() -> TrackmarshalError:
    return TrackmarshalError(
        "T432", "there is no PDF, as typst is not installed", help="pip install 'trackmarshal[pdf]'"
    )


def string(text: str) -> str:
    """A string of Typst, which is shown as it is; control characters are replaced."""
    shown = "".join(char if char.isprintable() or char in _BLANK else "\ufffd" for char in text)
    return '"' + shown.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'


def plain(line: Line) -> str:
    """A line's words alone, for headings in the table of contents."""
    return "".join(
        "" if isinstance(piece, Inline) else piece.word if isinstance(piece, Status) else _words(piece)
        for piece in line
    )


def _words(piece: Piece) -> str:
    if isinstance(piece, Number):
        return piece.value
    if isinstance(piece, Fixed | Given | Written | Made | Code | Ref):
        return piece.text
    raise TypeError(f"unknown piece {piece!r}")


def fits(row: Sequence[Line], widths: Sequence[float]) -> bool:
    """Whether a row surely takes less than half a page. A longer one is broken where the page ends: nothing of it may be cut off.

    widths: of its cells, in any unit.
    """
    room = _HALF_PAGE * _LINE / sum(widths)
    return all(_letters(line) <= room * width for line, width in zip(row, widths, strict=True))


def _letters(line: Line) -> int:
    """How many letters take as much room as a line."""
    return sum(map(_room, line))


def _room(piece: Piece) -> int:
    # The source of a formula is longer than what is set.
    if isinstance(piece, Inline):
        return len(piece.typst)
    if isinstance(piece, Status):
        return len(piece.text or piece.word) + 2
    return len(_words(piece)) + (len(piece.place) if isinstance(piece, Written) else 0)


def broken(text: str) -> str:
    """A name with places at which a line may end: after the signs of paths, and within long runs of letters."""
    parts = _BREAK.split(text)
    return "\u200b".join(
        "\u200b".join(part[at : at + _RUN] for at in range(0, len(part), _RUN)) for part in parts
    )


class Printing:
    """Pieces as Typst, each a call or a string in code."""

    def __init__(self, document: Document) -> None:
        self._anchors: Mapping[tuple[str, str], str] = document.anchors
        self._words = document.words
        self.there = there(document)

    def line(self, line: Line) -> Markup:
        """An expression of Typst."""
        from markupsafe import Markup

        return Markup("{" + "; ".join(map(self._piece, line)) + "}") if line else Markup("[]")

    def _piece(self, piece: Piece) -> str:
        match piece:
            case Fixed():
                return string(piece.text)
            case Given():
                return text(piece.text)
            case Written():
                place = f"; place({string(broken(piece.place))})" if piece.place else ""
                return f"people({{{string('✎ ')}; {text(piece.text)}}}){place}"
            case Made():
                return marked(piece.text)
            case Code():
                return f"code({_name(piece.text)})"
            case Number():
                return string(piece.value)
            case Status():
                look = LIKE[piece.word]
                return f"chip({string(look)}, {string(SIGNS[look] + ' ' + (piece.text or self._words[f'status.{piece.word}']))})"
            case Ref():
                anchor = self._anchors.get(piece.key, "")
                said = _name(piece.text) if _ID.fullmatch(piece.text) else string(broken_long(piece.text))
                return f"to({string(anchor)}, {said})" if anchor in self.there else said
            case Inline():
                return f"[{piece.typst}]".replace("[$ ", "[$").replace(" $]", "$]")
            case _:
                raise TypeError(f"unknown piece {piece!r}")


def broken_long(text: str) -> str:
    """Text in which only words that are too long for a column of a table may be broken."""
    return " ".join(broken(word) if len(word) > _RUN else word for word in text.split(" "))


def text(said: str) -> str:
    """Text in which ids stay on one line, as expressions of Typst."""
    made, at = list[str](), 0
    for found in _ID.finditer(said):
        if len(found[0]) <= _RUN:
            made += [string(broken_long(said[at : found.start()])), _name(found[0])]
            at = found.end()
    made.append(string(broken_long(said[at:])))
    return "; ".join(one for one in made if one != '""') or '""'


def _name(said: str) -> str:
    """A name, whole where it is an id that fits into a column; others may be broken."""
    whole = len(said) <= _RUN and _ID.fullmatch(said)
    return f"box({string(said)})" if whole else string(broken(said))


def marked(said: str) -> str:
    """Text of the program, with what stands between backquotes as code."""
    parts = said.split("`")
    if len(parts) % 2 == 0:
        return text(said)
    return "; ".join(
        f"code({_name(part)})" if number % 2 else text(part) for number, part in enumerate(parts) if part
    ) or '""'  # fmt: skip


__all__ = ["pdf", "source", "spelled", "string"]
