"""Diagnostics and other reported errors in one flat shape, from which every format is rendered."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from trackmarshal.diagnostics.base import Diagnostic, Diagnostics
from trackmarshal.errors import TrackmarshalError
from trackmarshal.node import Node
from trackmarshal.source import NOWHERE, Span

#: What a path is called instead, counted from another folder.
Where = Callable[[str], str]
#: What a finding may weigh.
LEVELS = ("error", "warning", "note")


class Place(Node):
    """Where something is: lines and columns from 1, the end not included; None where it is not known.

    `mark` is the stretch of text itself, for formats that show it.
    """

    file: str | None
    line: int | None = None
    column: int | None = None
    end_line: int | None = None
    end_column: int | None = None
    label: str = ""
    mark: Span | None = None


class Finding(Node):
    """One error, warning or note, ready to be shown."""

    code: str
    level: str
    title: str
    message: str
    place: Place
    related: tuple[Place, ...] = ()
    help: str = ""
    explanation: str = ""


def findings(items: Iterable[Diagnostic | TrackmarshalError], where: Where | None = None) -> list[Finding]:
    """Flatten what was reported, in the order given, with paths as `where` has them; raises TypeError for anything that is no report."""
    found: list[Finding] = []
    for item in items:
        if isinstance(item, Diagnostic):
            found.append(_of_diagnostic(item))
        elif isinstance(item, Diagnostics):
            found += map(_of_diagnostic, item.items)
        elif isinstance(item, TrackmarshalError):
            place = Place(None if item.file is None else _encodable(item.file), item.line)
            found.append(
                Finding(
                    item.code, "error", "", _encodable(item.message), place, (), _encodable(item.help or "")
                )
            )
        else:
            raise TypeError(f"not a diagnostic: {type(item).__name__}")
    return found if where is None else [_moved(finding, where) for finding in found]


def _moved(found: Finding, where: Where) -> Finding:
    related = tuple(_elsewhere(place, where) for place in found.related)
    return Finding(**{**vars(found), "place": _elsewhere(found.place, where), "related": related})


def _elsewhere(place: Place, where: Where) -> Place:
    return place if place.file is None else Place(**{**vars(place), "file": where(place.file)})


def _of_diagnostic(item: Diagnostic) -> Finding:
    if item.level not in LEVELS:
        raise ValueError(f"{item.code} has the unknown level {item.level!r}")
    related = tuple(_place(span, label) for span, label in item.related)
    message, help_ = _encodable(item.message), _encodable(item.help)
    return Finding(
        item.code,
        item.level,
        item.title,
        message,
        _place(item.span, item.pointer),
        related,
        help_,
        item.explanation,
    )


def _place(span: Span, label: str) -> Place:
    if span.file is NOWHERE.file:
        return Place(span.file.path, label=_encodable(label))
    line, column = span.file.position(span.start)
    end_line, end_column = span.file.position(max(span.start, span.end))
    return Place(_encodable(span.file.path), line, column, end_line, end_column, _encodable(label), span)


def _encodable(text: str) -> str:
    """Without lone surrogates, which paths may hold and no output encoding can."""
    return text.encode("utf-8", "replace").decode("utf-8")
