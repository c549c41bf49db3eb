"""The document as one HTML file: no script, nothing from elsewhere, for screens wide and narrow, and for paper."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from trackmarshal.trace import look
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
from trackmarshal.trace.render.words import LIKE, SIGNS

if TYPE_CHECKING:
    from markupsafe import Markup


def render(document: Document, folder: Path | None = None) -> str:
    """The page. folder: templates of the project, in place of ours. Raises TrackmarshalError T430 for a template that cannot be used."""
    return printed(document, "html", folder, {"line": Printing(document).line})


class Printing:
    """Pieces as HTML; links only to places that the document has."""

    def __init__(self, document: Document) -> None:
        from markupsafe import Markup

        self._anchors: Mapping[tuple[str, str], str] = document.anchors
        self._there = there(document)
        self._words = document.words
        #: Sentences of the program are English in every language.
        self._english = Markup("") if document.words["language"] == "en" else Markup(' lang="en"')

    def line(self, line: Line) -> Markup:
        from markupsafe import Markup

        return Markup("").join(map(self._piece, line))

    def _piece(self, piece: Piece) -> Markup:
        from markupsafe import Markup, escape

        match piece:
            case Fixed():
                return escape(piece.text)
            case Given():
                return Markup('<span class="given">{}</span>').format(piece.text)
            case Written():
                place = (
                    Markup(' <span class="place">{}</span>').format(piece.place)
                    if piece.place
                    else Markup("")
                )
                return Markup(
                    '<span class="people" title="{}"><span class="pen">✎ </span>{}</span>{}'
                ).format(self._words["people"], piece.text, place)
            case Made():
                return marked(piece.text, self._english)
            case Code():
                return Markup("<code>{}</code>").format(piece.text)
            case Number():
                return Markup('<span class="number" data-number="{}">{}</span>').format(piece.id, piece.value)
            case Status():
                like = LIKE[piece.word]
                return Markup('<span class="chip is-{}"><span class="sign">{}</span> {}</span>').format(
                    like, SIGNS[like], piece.text or self._words[f"status.{piece.word}"]
                )
            case Ref():
                anchor = self._anchors.get(piece.key, "")
                if anchor not in self._there:
                    return Markup('<span class="given">{}</span>').format(piece.text)
                return Markup('<a href="#{}">{}</a>').format(anchor, piece.text)
            case Inline():
                return Markup(piece.mathml)  # made of escaped text already
            case _:
                raise TypeError(f"unknown piece {piece!r}")


def marked(text: str, language: Markup) -> Markup:
    """Text of the program, with what stands between backquotes as code; language: an attribute that says which it is in."""
    from markupsafe import Markup

    return Markup('<span class="made"{}>{}</span>').format(language, look.marked(text))


def there(document: Document) -> frozenset[str]:
    """The places that the document really has: a section that left itself out has none of its things."""
    from trackmarshal.trace.case.model import Block, Part, Table

    found: set[str] = set()

    def look(block: Block) -> None:
        if isinstance(block, Part):
            found.add(block.anchor)
            for inner in block.blocks:
                look(inner)
        elif isinstance(block, Table):
            found.update(block.anchors)

    for section in document.all_sections():
        found.add(section.anchor)
        for block in section.blocks:
            look(block)
    return frozenset(found - {""})


__all__ = ["Printing", "render", "there"]
