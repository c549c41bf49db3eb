"""The matrix as strict JSON; its schema is matrix.schema.json beside this file."""

from __future__ import annotations

import json
from typing import Any

from trackmarshal.trace.cells import Item
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.graph import Graph, Link
from trackmarshal.trace.matrix import Matrix, Row

FORMAT = "trackmarshal-matrix"
VERSION = 1


def render(matrix: Matrix) -> str:
    return json.dumps(record(matrix), ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def record(matrix: Matrix) -> dict[str, Any]:
    """The matrix as plain data."""
    return {
        "format": FORMAT,
        "version": VERSION,
        "project": matrix.project,
        "date": matrix.today.isoformat(),
        "verdict": matrix.verdict,
        "reservations": list(matrix.reservations),
        "stages": [{"id": stage.id, "title": stage.title, "shows": stage.shows} for stage in matrix.stages],
        "requirements": [_row(row) for row in matrix.rows],
        "findings": _findings(matrix),
        "coverage": matrix.coverage,
        "waivers": [
            {
                "id": w.id, "stages": list(w.stages), "requirements": list(w.requirements), "codes": list(w.codes),
                "subjects": list(w.subjects), "justification": w.justification, "residual_risk": w.residual_risk,
                "owner": w.owner, "approver": w.approver, "granted": w.granted and w.granted.isoformat(), "expires": w.expires and w.expires.isoformat(), "span": str(w.id.place),
            }
            for w in matrix.waivers
        ],
        "accepted": [
            {"on": one.on, "by": one.by, "reason": one.reason, "weaker": list(one.weaker)} for one in matrix.accepted
        ],
        "unreviewed": [{"kind": kind, "id": id_} for kind, id_ in matrix.unreviewed],
        "links": _links(matrix.graph),
        "counts": dict(matrix.counts),
    }  # fmt: skip


def _links(graph: Graph) -> list[dict[str, str]]:
    """All links, in order; a result is called by its outcome, as it has been from the beginning."""
    found = {
        (
            link.kind,
            _outcome(graph, link) if link.kind == "result" else link.source[1],
            link.target[1],
            link.state,
            link.place,
        )
        for link in graph.links
    }
    names = ("kind", "source", "target", "state", "span")
    return [dict(zip(names, map(str, entry))) for entry in sorted(found)]


def _outcome(graph: Graph, link: Link) -> str:
    return graph.nodes[link.source].attributes["outcome"]


def _row(row: Row) -> dict[str, Any]:
    r = row.requirement
    return {
        "id": r.id, "title": r.title, "statement": r.statement, "rationale": r.rationale, "status": r.status, "asil": r.asil,
        "derived_from": list(r.derived_from), "refines": list(r.refines), "source": r.source, "span": str(r.place),
        "stages": {
            stage: {"status": cell.status, "items": [_item(item) for item in cell.items]} for stage, cell in row.cells.items()
        },
    }  # fmt: skip


def _item(item: Item) -> dict[str, Any]:
    return {
        "kind": item.kind, "name": item.name, "title": item.title, "status": item.status, "detail": item.detail,
        "span": span(item.place),
    }  # fmt: skip


def _findings(matrix: Matrix) -> list[dict[str, Any]]:
    """All of them, each with its number, and the number of the one that it follows from."""
    numbers = {finding: number for number, finding in enumerate(matrix.findings, 1)}
    return [
        {
            "id": number,
            "cause": numbers[matrix.causes[finding]] if finding in matrix.causes else None,
            **finding_record(finding),
        }
        for finding, number in numbers.items()
    ]


def finding_record(finding: Finding) -> dict[str, Any]:
    """A finding as plain data."""
    return {
        "code": finding.code, "level": finding.level, "message": finding.message, "span": span(finding.place),
        "help": finding.help or None, "subject": finding.subject or None,
        "also": [{"span": str(place), "message": label} for place, label in finding.also],
    }  # fmt: skip


def span(place: Place | None) -> str | None:
    """A place as text, `FILE:LINE:COLUMN`."""
    return None if place is None else str(place)
