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

_ESCAPED = str.maketrans({"&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&#34;", "'": "&#39;"})


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

        # A case of thousands of things has hundreds of thousands of pieces: they are put together as strings, each of which is escaped here.
        return Markup("".join(map(self._piece, line)))

    def _piece(self, piece: Piece) -> str:
        """HTML: whatever is no markup of ours is escaped."""
        match piece:
            case Fixed():
                return _text(piece.text)
            case Given():
                return f'<span class="given">{_text(piece.text)}</span>'
            case Written():
                place = f' <span class="place">{_text(piece.place)}</span>' if piece.place else ""
                by = _text(self._words["people"])
                return f'<span class="people" title="{by}"><span class="pen">✎ </span>{_text(piece.text)}</span>{place}'
            case Made():
                return marked(piece.text, self._english)
            case Code():
                return f"<code>{_text(piece.text)}</code>"
            case Number():
                return f'<span class="number" data-number="{_text(piece.id)}">{_text(piece.value)}</span>'
            case Status():
                like = LIKE[piece.word]
                said = _text(piece.text or self._words[f"status.{piece.word}"])
                return f'<span class="chip is-{like}"><span class="sign">{SIGNS[like]}</span> {said}</span>'
            case Ref():
                anchor = self._anchors.get(piece.key, "")
                if anchor not in self._there:
                    return f'<span class="given">{_text(piece.text)}</span>'
                return f'<a href="#{_text(anchor)}">{_text(piece.text)}</a>'
            case Inline():
                return piece.mathml  # made of escaped text already
            case _:
                raise TypeError(f"unknown piece {piece!r}")


def _text(text: str) -> str:
    """Text that is no markup, as jinja2 escapes what templates write."""
    return text.translate(_ESCAPED)


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
