"""The content of the document: sections of blocks, blocks of lines, lines of pieces. It says what stands there, not how it looks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar, NamedTuple, TypeAlias

from trackmarshal.trace.graph.graph import Key


class Fixed(NamedTuple):
    """Words of the program, the same in every document; no number is among them."""

    text: str


class Given(NamedTuple):
    """A name, an id, a title, a date or a place as it stands in the graph."""

    text: str


class Written(NamedTuple):
    """What a person wrote, and where it stands ("": beside it anyway)."""

    text: str
    place: str = ""


class Made(NamedTuple):
    """A sentence that the program made of the graph: a finding, a rule in words."""

    text: str


class Code(NamedTuple):
    """A name in a program, a path, a hash, a command."""

    text: str


class Number(NamedTuple):
    """A number, and the id under which the graph has it (`numbers.Numbers`)."""

    id: str
    value: str


class Status(NamedTuple):
    """A status of cells or what a thing has come to, shown with its sign; text: what is written, if not the word itself."""

    word: str
    text: str = ""


class Ref(NamedTuple):
    """A thing of the graph: a link where the document has a place for it."""

    key: Key
    text: str


class Inline(NamedTuple):
    """A small formula in a line, as MathML and as Typst."""

    mathml: str
    typst: str


Piece: TypeAlias = Fixed | Given | Written | Made | Code | Number | Status | Ref | Inline
Line: TypeAlias = tuple[Piece, ...]
#: Of a page of A4, in points.
TEXT_WIDTH = 482.0


@dataclass(frozen=True, slots=True)
class Paragraph:
    """One line of pieces, as long as it may be."""

    kind: ClassVar[str] = "paragraph"
    line: Line


@dataclass(frozen=True, slots=True)
class Missing:
    """What is not there, said where it would stand."""

    kind: ClassVar[str] = "missing"
    line: Line


@dataclass(frozen=True, slots=True)
class Facts:
    """Labels, and what is said under each."""

    kind: ClassVar[str] = "facts"
    rows: tuple[tuple[str, Line], ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of cells below a head. widths: shares of the width, as paper needs them; narrow: cells that are not broken where it can be helped."""

    kind: ClassVar[str] = "table"
    head: tuple[str, ...]
    rows: tuple[tuple[Line, ...], ...]
    widths: tuple[float, ...]
    anchors: tuple[str, ...] = ()  #: one a row, "" for none


@dataclass(frozen=True, slots=True)
class Verbatim:
    """Text whose lines stand as they are."""

    kind: ClassVar[str] = "verbatim"
    text: str


@dataclass(frozen=True, slots=True)
class Formula:
    """A formula of its own, with a word before it, words after it, and how far it is moved in."""

    kind: ClassVar[str] = "formula"
    mathml: str
    typst: str
    word: str = ""
    depth: int = 0
    said: str = ""


@dataclass(frozen=True, slots=True)
class Figure:
    """A picture as SVG, with its title; what it shows stands in words beside it."""

    kind: ClassVar[str] = "figure"
    svg: str
    title: str
    wide: float  #: its natural width in points
    high: float  #: and height
    caption: Line = ()  #: what else stands below it

    @property
    def lies(self) -> bool:
        """Whether it stands on a page of paper that lies on its side: it is much wider than the text of one that stands."""
        return self.wide > 1.15 * TEXT_WIDTH


@dataclass(frozen=True, slots=True)
class Verdict:
    """The word of `trace.verdict`, with what keeps it from a better one."""

    kind: ClassVar[str] = "verdict"
    word: str
    said: str


@dataclass(frozen=True, slots=True)
class Blanks:
    """An empty table that people fill in by hand, on paper."""

    kind: ClassVar[str] = "blanks"
    line: Line  #: what it is for, above it
    head: tuple[str, ...]
    widths: tuple[float, ...]
    rows: int


@dataclass(frozen=True, slots=True)
class Part:
    """Blocks under a heading of their own."""

    kind: ClassVar[str] = "part"
    title: Line
    blocks: tuple[Block, ...]
    anchor: str = ""
    level: int = 2


Block: TypeAlias = Paragraph | Missing | Facts | Table | Verbatim | Formula | Figure | Verdict | Blanks | Part


@dataclass(frozen=True, slots=True)
class Section:
    """A chapter. `id` is the name of the template that may replace the common one."""

    id: str
    title: str
    blocks: tuple[Block, ...]
    anchor: str


@dataclass(frozen=True, slots=True)
class Document:
    """The whole of it. `first` stands before the table of contents. anchors: by thing, the place that it has here."""

    project: str
    day: str
    verdict: str
    first: tuple[Section, ...]
    sections: tuple[Section, ...]
    anchors: Mapping[Key, str]
    words: Mapping[str, str]

    def all_sections(self) -> Iterator[Section]:
        """The first ones, and the others."""
        yield from self.first
        yield from self.sections


__all__ = [
    "Blanks", "Block", "Code", "Document", "Facts", "Figure", "Fixed", "Formula", "Given", "Inline", "Line", "Made", "Missing", "Number", "Paragraph",
    "Part", "Piece", "Ref", "Section", "Status", "Table", "Verbatim", "Verdict", "Written",
]  # fmt: skip
