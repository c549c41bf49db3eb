"""Findings as workflow commands, which GitHub shows beside the changed lines."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.diagnostics.excerpt import printable
from trackmarshal.diagnostics.finding import Finding, Where, findings
from trackmarshal.errors import TrackmarshalError

_COMMANDS = {"error": "error", "warning": "warning", "note": "notice"}


def render(items: Iterable[Diagnostic | TrackmarshalError], where: Where | None = None) -> str:
    """One line a finding."""
    return "".join(_line(found) + "\n" for found in findings(items, where))


def _line(found: Finding) -> str:
    place = found.place
    properties: dict[str, object] = {}
    if place.file is not None:
        properties["file"] = place.file
    if place.line is not None:
        properties["line"] = place.line
    if place.end_line is not None:
        properties["endLine"] = place.end_line
        if place.end_line == place.line:  # columns of different lines say nothing there
            properties["col"] = place.column
            properties["endColumn"] = place.end_column
    properties["title"] = f"{found.code} {found.title}".rstrip()
    lines = [found.message, place.label]
    lines += [
        f"{':'.join(str(part) for part in (o.file, o.line) if part is not None)}: {o.label}"
        for o in found.related
    ]
    lines.append(f"help: {found.help}" if found.help else "")
    return command(found.level, properties, "\n".join(line for line in lines if line))


def command(level: str, properties: Mapping[str, object], text: str) -> str:
    """One command, on one line whatever its parts hold."""
    shown = ",".join(f"{name}={_property(str(value))}" for name, value in properties.items())
    return f"::{_COMMANDS[level]} {shown}::{_data(text)}"


def _data(text: str) -> str:
    # Other line ends, which some readers of the log break lines at, are shown as the renderers for terminals show them.
    escaped = text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")
    return printable(escaped)


def _property(text: str) -> str:
    return _data(text).replace(":", "%3A").replace(",", "%2C")
