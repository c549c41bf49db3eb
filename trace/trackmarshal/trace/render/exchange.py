"""The findings for tools: SARIF 2.1.0 and GitHub's workflow commands."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import Any
from urllib.parse import quote

import trackmarshal
from trackmarshal.diagnostics.github import command
from trackmarshal.trace.codes import CODES
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.render.words import follows, tally


def render_sarif(matrix: Matrix, where: Callable[[str], str] = str) -> str:
    """One run with all findings; its properties carry the verdict and the coverage."""
    codes = sorted({finding.code for finding in matrix.findings})
    rules = [_rule(code) for code in codes]
    run = {
        "tool": {"driver": {"name": "trackmarshal", "version": trackmarshal.__version__, "rules": rules}},
        "columnKind": "unicodeCodePoints",
        "results": [
            _result(finding, codes.index(finding.code), where, matrix.causes.get(finding))
            for finding in matrix.findings
        ],
        "properties": {"verdict": matrix.verdict, "coverage": matrix.coverage},
    }
    log = {"$schema": "https://json.schemastore.org/sarif-2.1.0.json", "version": "2.1.0", "runs": [run]}
    return json.dumps(log, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _rule(code: str) -> dict[str, Any]:
    if code not in CODES:  # of another room, which the caller passed on
        return {"id": code}
    title, explanation = CODES[code]
    return {"id": code, "shortDescription": {"text": title}, "fullDescription": {"text": explanation}}


def _result(
    finding: Finding, index: int, where: Callable[[str], str], cause: Finding | None
) -> dict[str, Any]:
    text = finding.message + (f"\nhelp: {finding.help}" if finding.help else "")
    result: dict[str, Any] = {
        "ruleId": finding.code,
        "ruleIndex": index,
        "level": finding.level,
        "message": {"text": text},
    }
    if cause is not None:
        result["properties"] = {"followsFrom": f"{cause.code}: {cause.message}"}
    if finding.place is not None:
        result["locations"] = [{"physicalLocation": _location(finding.place, where)}]
    if finding.also:
        result["relatedLocations"] = [
            {"id": number, "physicalLocation": _location(place, where), "message": {"text": label}}
            for number, (place, label) in enumerate(finding.also)
        ]
    return result


def _location(place: Place, where: Callable[[str], str]) -> dict[str, Any]:
    # A name that is no UTF-8 is quoted by its bytes, which are what it is called.
    uri = quote(where(place.file), errors="surrogateescape")
    location: dict[str, Any] = {"artifactLocation": {"uri": uri}}
    if place.line:
        location["region"] = {
            "startLine": place.line,
            **({"startColumn": place.column} if place.column else {}),
        }
    return location


def render_github(matrix: Matrix, where: Callable[[str], str] = str) -> str:
    """One workflow command a finding that stands for itself, since few are shown, and the verdict at the end."""
    lines = [_command(finding, where, matrix.following(finding)) for finding in matrix.standing]
    level = "note" if matrix.passes else "error"
    lines.append(command(level, {"title": "traceability"}, f"{matrix.verdict}: {tally(matrix)}"))
    return "\n".join(lines) + "\n"


def _command(finding: Finding, where: Callable[[str], str], following: Sequence[Finding]) -> str:
    properties: dict[str, object] = {}
    if finding.place is not None:
        properties["file"] = where(finding.place.file)
        if finding.place.line:
            properties["line"] = finding.place.line
        if finding.place.column:
            properties["col"] = finding.place.column
    properties["title"] = f"{finding.code} {CODES.get(finding.code, ('',))[0]}".rstrip()
    text = "\n".join(
        [
            finding.message,
            *([f"help: {finding.help}"] if finding.help else []),
            *filter(None, [follows(following)]),
        ]
    )
    return command(finding.level, properties, text)
