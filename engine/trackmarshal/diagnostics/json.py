"""Findings as strict JSON: a list of objects."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.diagnostics.finding import Place, Where, findings
from trackmarshal.errors import TrackmarshalError


def render(items: Iterable[Diagnostic | TrackmarshalError], where: Where | None = None) -> str:
    """All findings as one JSON array, in the order given."""
    return json.dumps(records(items, where), ensure_ascii=False, allow_nan=False, indent=2) + "\n"


def records(
    items: Iterable[Diagnostic | TrackmarshalError], where: Where | None = None
) -> list[dict[str, Any]]:
    """All findings as plain data; lines and columns from 1, the end not included, null where not known."""
    return [
        {
            "code": found.code,
            "level": found.level,
            "message": found.message,
            **_place(found.place),
            "related": [_place(other) for other in found.related],
            "help": found.help or None,
        }
        for found in findings(items, where)
    ]


def _place(place: Place) -> dict[str, Any]:
    return {
        "file": place.file,
        "line": place.line,
        "column": place.column,
        "end_line": place.end_line,
        "end_column": place.end_column,
        "label": place.label or None,
    }
