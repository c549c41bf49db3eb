"""Findings as SARIF 2.1.0, the exchange format of static analysis (OASIS)."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from urllib.parse import quote

import trackmarshal
from trackmarshal.diagnostics.base import Diagnostic
from trackmarshal.diagnostics.finding import Finding, Place, Where, findings
from trackmarshal.errors import TrackmarshalError

#: Code -> (title, explanation), for errors that do not carry them.
Catalogue = Mapping[str, tuple[str, str]]


def render(
    items: Iterable[Diagnostic | TrackmarshalError],
    catalogue: Catalogue | None = None,
    where: Where | None = None,
) -> str:
    """One run with all findings, and the codes that occur as its rules."""
    return (
        json.dumps(log(items, catalogue or {}, where), ensure_ascii=False, allow_nan=False, indent=2) + "\n"
    )


def log(
    items: Iterable[Diagnostic | TrackmarshalError], catalogue: Catalogue, where: Where | None = None
) -> dict[str, Any]:
    """The SARIF log as plain data."""
    found = findings(items, where)
    codes = sorted({finding.code for finding in found})
    index = {code: number for number, code in enumerate(codes)}
    first = {finding.code: finding for finding in reversed(found)}
    driver = {
        "name": "trackmarshal",
        "version": trackmarshal.__version__,
        "rules": [_rule(first[code], catalogue) for code in codes],
    }
    run = {
        "tool": {"driver": driver},
        "columnKind": "unicodeCodePoints",
        "results": [_result(finding, index[finding.code]) for finding in found],
    }
    return {"$schema": "https://json.schemastore.org/sarif-2.1.0.json", "version": "2.1.0", "runs": [run]}


def _rule(found: Finding, catalogue: Catalogue) -> dict[str, Any]:
    title, explanation = catalogue.get(found.code, (found.title, found.explanation))
    rule: dict[str, Any] = {"id": found.code}
    if title:
        rule["shortDescription"] = {"text": title}
    if explanation:
        rule["fullDescription"] = {"text": explanation}
    return rule


def _result(found: Finding, index: int) -> dict[str, Any]:
    lines = [found.message, found.place.label, f"help: {found.help}" if found.help else ""]
    result: dict[str, Any] = {
        "ruleId": found.code,
        "ruleIndex": index,
        "level": found.level,
        "message": {"text": "\n".join(line for line in lines if line)},
    }
    if found.place.file is not None:
        result["locations"] = [{"physicalLocation": _location(found.place)}]
    related = [place for place in found.related if place.file is not None]
    if related:
        result["relatedLocations"] = [
            {"id": number, "physicalLocation": _location(place), "message": {"text": place.label}}
            for number, place in enumerate(related)
        ]
    return result


def _location(place: Place) -> dict[str, Any]:
    location: dict[str, Any] = {"artifactLocation": {"uri": _uri(place.file or "")}}
    names = {"line": "startLine", "column": "startColumn", "end_line": "endLine", "end_column": "endColumn"}
    region = {key: getattr(place, name) for name, key in names.items() if getattr(place, name) is not None}
    if region:
        location["region"] = region
    return location


def _uri(path: str) -> str:
    named = Path(path)
    return named.as_uri() if named.is_absolute() else quote(named.as_posix())
