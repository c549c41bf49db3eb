"""Answers of the graph, paths and numbers: for a terminal, as JSON, as CSV, as Markdown."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from typing import Any

from trackmarshal.trace.graph.graph import Graph, Key
from trackmarshal.trace.graph.paths import Path
from trackmarshal.trace.graph.statistics import Number, grouped
from trackmarshal.trace.render.table import escaped, harmless
from trackmarshal.trace.render.words import printable

FORMATS = ("text", "json", "csv", "md")
_HEAD = ["from", "to", "outcome", "by way of"]


def paths(graph: Graph, found: Sequence[Path], format: str, counted: Sequence[Number] | None = None) -> str:
    """Paths in one of FORMATS, with numbers where they are asked for, too; raises ValueError for another format."""
    if format == "json":  # one text, whatever was asked for
        asked = {} if counted is None else {"statistics": grouped(list(counted))}
        return _json(
            {"format": "trackmarshal-paths", "version": 1, "paths": [_path(graph, path) for path in found], **asked}
        )  # fmt: skip
    return _paths(graph, found, format) + ("" if counted is None else "\n" + numbers(counted, format))


def _paths(graph: Graph, found: Sequence[Path], format: str) -> str:
    if format == "csv":
        head = ["from_kind", "from", "to_kind", "to", "outcome", "by_way_of"]
        return _csv(
            head, [[p.source[0], p.source[1], *(p.target or ("", "")), *_row(graph, p)[2:]] for p in found]
        )
    return _table(_HEAD, [_row(graph, path) for path in found], format)


def numbers(found: Sequence[Number], format: str) -> str:
    """Numbers in one of FORMATS; raises ValueError for another."""
    if format == "json":
        return _json({"format": "trackmarshal-statistics", "version": 1, **grouped(list(found))})
    rows = [[entry.table, entry.of, entry.what, str(entry.number)] for entry in found]
    if format == "csv":
        return _csv(["table", "of", "what", "number"], rows)
    head = ["", "", "", "number"]
    repeated = [
        ["" if n and rows[n - 1][: k + 1] == row[: k + 1] and k < 2 else cell for k, cell in enumerate(row)]
        for n, row in enumerate(rows)
    ]
    return _table(head, repeated, format)


def outcome(graph: Graph, key: Key) -> str:
    """What came of a node, or how far it is, where it says so."""
    attributes = graph.nodes[key].attributes
    return attributes.get("outcome") or attributes.get("status", "")


def _row(graph: Graph, path: Path) -> list[str]:
    if path.target is None:
        return [_said(path.source), "", "", "nothing leads there"]
    steps = [f"{step.way} {_said(step.node)}" for step in path.steps[:-1]]
    over = ", ".join([*steps, path.steps[-1].way])
    return [_said(path.source), _said(path.target), outcome(graph, path.target), over]


def _said(key: Key) -> str:
    kind, id_ = key
    return id_ if kind == "requirement" else f"{kind} {id_}"


def _path(graph: Graph, path: Path) -> dict[str, Any]:
    return {
        "from": _node(graph, path.source),
        "to": None if path.target is None else _node(graph, path.target),
        "steps": [
            {"way": step.way, "state": step.link.state, "span": str(step.link.place), **_node(graph, step.node)} for step in path.steps
        ],
    }  # fmt: skip


def _node(graph: Graph, key: Key) -> dict[str, Any]:
    node = graph.nodes[key]
    return {"kind": node.kind, "id": node.id, "title": node.title, "outcome": outcome(graph, key) or None}


def _json(data: dict[str, Any]) -> str:
    return json.dumps(data, ensure_ascii=False, allow_nan=False, indent=1) + "\n"


def _csv(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([harmless(cell) for cell in row] for row in rows)
    return out.getvalue()


def _table(head: Sequence[str], rows: Sequence[Sequence[str]], format: str) -> str:
    if format == "md":
        lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
        return "\n".join([*lines, *("| " + " | ".join(map(escaped, row)) + " |" for row in rows)]) + "\n"
    if format != "text":
        raise ValueError(f"unknown format {format!r}, known are {', '.join(FORMATS)}")
    plain = [[printable(cell) for cell in row] for row in (head, *rows)]
    widths = [max(len(row[column]) for row in plain) for column in range(len(head))]
    return (
        "\n".join("  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in plain)
        + "\n"
    )


__all__ = ["FORMATS", "numbers", "outcome", "paths"]
