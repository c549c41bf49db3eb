"""Requirements as CSV (RFC 4180): a row each, a column for every field and for every foreign attribute; lists with `; ` between.

Spreadsheets of countries that write 1,5 put semicolons between cells, or tabs: a header that has more cells between those than between commas
says so. They may begin with a line `sep=;`, which names the character.
A cell that a spreadsheet would take for a formula begins with an apostrophe, which is taken off when it is read.
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence

from trackmarshal.json_text import named_twice
from trackmarshal.trace.exchange.content import BETWEEN, FIELDS, Document, Draft, Item, Value, attributes
from trackmarshal.trace.exchange.refused import Refused, decoded
from trackmarshal.trace.values import Table

#: Columns that say of which document a row is; a document without requirements has a row without an id.
OF_DOCUMENT = ("document", "document_title", "document_source")
_FORMULAS = ("=", "+", "-", "@", "\t", "\r", "'")
_LONGEST = 131_072  # of a cell, for Python's reader
_DIVIDERS = (",", ";", "\t")
_NAMED = re.compile(r"sep=([,;\t])\r?\n", re.IGNORECASE)


def write(documents: Sequence[Document], shown: str) -> bytes:
    """The documents as CSV in UTF-8 with CRLF; raises T352 for a text that is too long for a cell."""
    rows = [
        (document, attributes(one, (*FIELDS, *OF_DOCUMENT)))
        for document in documents
        for one in document.requirements or [_NOTHING]
    ]
    more = dict.fromkeys(name for _, said in rows for name in said if name not in FIELDS)
    head = (*OF_DOCUMENT, *FIELDS, *more)
    stream = io.StringIO(newline="")
    writer = csv.writer(stream, lineterminator="\r\n")
    writer.writerow(map(_cell, head))
    for document, said in rows:
        of_document = (document.name, document.table.text("title"), document.table.text("source"))
        cells = [*of_document, *(_joined(said.get(name, "")) for name in (*FIELDS, *more))]
        if any(len(cell) >= _LONGEST for cell in cells):
            raise Refused(
                "T352",
                f"a text of `{said.get('id')}` is longer than {_LONGEST} characters, which cells are not",
                shown,
                help="export it as ReqIF or needs.json",
            )
        writer.writerow(map(_cell, cells))
    return stream.getvalue().encode("utf-8")


def read(data: bytes, shown: str) -> list[Draft]:
    """The documents of a CSV file with a header; raises T350 for what is no CSV, T358 for its columns."""
    text = decoded(data, shown, "save the file as UTF-8; spreadsheets call it `CSV UTF-8`")
    rows = _rows(text, shown)
    line, head = next(rows, (1, []))
    names = [_text(cell).strip() for cell in head]
    while names and not names[-1]:  # spreadsheets write a column in which there once was something
        names.pop()
    twice = named_twice(names)
    if not names or twice is not None or "" in names:
        said = (
            f"the column `{twice}` is there twice"
            if twice is not None
            else "a column has no name"
            if names
            else "there is no header"
        )
        raise Refused(
            "T358",
            said,
            shown,
            line,
            "the first line names the columns, each once, such as `id,title,statement`",
        )
    drafts: dict[str, Draft] = {}
    for line, cells in rows:
        if not any(cell.strip() for cell in cells):
            continue  # a row that somebody emptied: as an entry it would be a list of its own, without a name
        unnamed = any(cell.strip() for cell in cells[len(names) :])
        if len(cells) != len(head) or unnamed:
            message = (
                f"{len(cells)} cells where the header has {len(head)}"
                if len(cells) != len(head)
                else f"a cell in column {len(names) + 1} or behind it, which has no name"
            )
            raise Refused(
                "T358",
                message,
                shown,
                line,
                "cells with commas, quotes or line breaks stand in double quotes",
            )
        lost = next((cell for cell in cells if _LOST.fullmatch(cell.strip())), None)
        if lost is not None:
            message = (
                f"a cell is `{lost.strip()}`, which a spreadsheet writes where it has lost what stood there"
            )
            raise Refused(
                "T358",
                message,
                shown,
                line,
                "write the text there again, in a cell that is formatted as text",
            )
        told: dict[str, Value] = dict(zip(names, map(_text, cells), strict=False))
        name, title, source = (str(told.pop(column, "")).strip() for column in OF_DOCUMENT)
        draft = drafts.setdefault(name, Draft(name, title, source))
        draft.title, draft.source = draft.title or title, draft.source or source
        if title not in ("", draft.title) or source not in ("", draft.source):
            raise Refused(
                "T354",
                f"the document `{name}` has two titles or two sources",
                shown,
                line,
                "keep one of them",
            )
        if any(value for value in told.values()):
            draft.items.append(Item(told, line))
    for name, draft in drafts.items():  # which no row says of some
        draft.title = draft.title or name or "Requirements"
    nameless = drafts.get("")
    if nameless is not None and nameless.items and len(drafts) > 1:
        raise Refused(
            "T354",
            f"the row names no list under `{OF_DOCUMENT[0]}`, and others do",
            shown,
            nameless.items[0].line,
            "write there which list it belongs to, such as `" + next(filter(None, drafts)) + "`",
        )
    return list(drafts.values())


#: What Excel and LibreOffice show of a text that they took for a formula, and of a date in a column that is too narrow.
_LOST = re.compile(r"#(NAME\?|VALUE!|REF!|DIV/0!|N/A|NUM!|NULL!|SPILL!|CALC!|#{3,})|Err:5\d\d")


def _rows(text: str, shown: str) -> Iterator[tuple[int, list[str]]]:
    named = _NAMED.match(text)
    begin = named.end() if named else 0
    divider = named[1] if named else _divider(text)
    reader = csv.reader(io.StringIO(text[begin:], newline=""), delimiter=divider, strict=True)
    while True:
        line = reader.line_num + 1 + bool(named)
        try:
            cells = next(reader, None)
        except csv.Error as problem:
            raise Refused(
                "T350",
                f"not CSV: {problem}",
                shown,
                line,
                "is the file whole, and are its cells between commas?",
            ) from None
        if cells is None:
            return
        if cells:
            yield line, cells


def _divider(text: str) -> str:
    """What stands between the cells of the header: what makes the most of it."""

    def cells(divider: str) -> int:
        try:
            reader = csv.reader(io.StringIO(text, newline=""), delimiter=divider, strict=True)
            return len(next(filter(None, reader), []))
        except csv.Error:
            return 0  # which is said when it is read

    return max(_DIVIDERS, key=cells)


def _joined(value: Value) -> str:
    return value if isinstance(value, str) else BETWEEN.join(value)


def _cell(text: str) -> str:
    return "'" + text if text.startswith(_FORMULAS) else text


def _text(cell: str) -> str:
    return cell[1:] if cell.startswith("'") and cell[1:].startswith(_FORMULAS) else cell


_NOTHING = Table()  # a document without requirements has a line all the same

__all__ = ("OF_DOCUMENT", "read", "write")
