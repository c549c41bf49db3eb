"""All that the matrix page walks, as plain data: every node and link of the graph, cells, findings, and what stands beside them.

Nodes are called by their number, kinds and statuses by theirs: the page of 10,000 items stays small.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping
from typing import Any

from trackmarshal.records.runs import RunSummary
from trackmarshal.store import Entry
from trackmarshal.trace.cells import Cell, Item, combined
from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.graph import Graph, Key, Link
from trackmarshal.trace.graph.kinds import LINKS, NODES, STATES
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.render.page.beside import Beside
from trackmarshal.trace.render.words import LIKE, MEANINGS, SIGNS

FORMAT = "trackmarshal-walk"
VERSION = 2
#: Kinds of items of cells that are nodes of another kind.
_NODE_OF = {"monitor": "assumption"}
#: What of a rule for readers the page shows; the Typst source of formulas is for the document.
_FORMS = ("spec", "words")
_KINDS = {kind: number for number, kind in enumerate(NODES)}
_WAYS = {way: number for number, way in enumerate(LINKS)}
_STATES = {state: number for number, state in enumerate(STATES)}
#: Texts of so many letters take no more room than their number.
_SHORT = 4
#: From best to worst, as `SIGNS` has them.
_STATUSES = {status: number for number, status in enumerate(SIGNS)}


def dumped(content: Mapping[str, Any]) -> str:
    """JSON that may stand between the tags of a script element: nothing in it ends the element, or begins another one or a comment."""
    said = json.dumps(content, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return said.replace("<", "\\u003c")


def content(matrix: Matrix, beside: Beside) -> dict[str, Any]:
    """The matrix with its graph, and what stands beside it."""
    graph = matrix.graph
    numbers = {key: number for number, key in enumerate(graph.nodes)}
    stages = {str(stage.id): number for number, stage in enumerate(matrix.stages)}
    rows = {numbers["requirement", str(row.requirement.id)]: row for row in matrix.rows}
    standing = _standing(matrix, numbers)
    files, names, makers = _Table(), _Table(), _Table()
    texts = _repeated(graph)
    made: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        "project": matrix.project,
        "day": matrix.today.isoformat(),
        "verdict": matrix.verdict,
        "kinds": [[kind, meaning] for kind, meaning in NODES.items()],
        "ways": [[name, kind.converse, kind.down] for name, kind in LINKS.items()],
        "states": list(STATES),
        "statuses": [[status, SIGNS[status], MEANINGS[status]] for status in SIGNS],
        "stages": [
            {"id": str(s.id), "title": s.title, "shows": s.shows, "node": numbers["stage", str(s.id)]} for s in matrix.stages
        ],
        "nodes": [
            [
                _KINDS[node.kind], node.id, node.title, _place(node.place, files), standing.get(number, -1),
                *(part for name, text in node.attributes.items() if text for part in (names[name], texts.get(text, text))),
            ]
            for number, node in enumerate(graph.nodes.values())
        ],
        "links": [_link(link, numbers, files) for link in graph.links],
        "rows": [[number, row.depth] for number, row in rows.items()],
        "cells": [
            [[stages[name], *_cell(cell, numbers, files)] for name, cell in row.cells.items()] for row in rows.values()
        ],
        "findings": [_about(one, graph, numbers) for one in matrix.findings],
        "words": dict(beside.clauses),
        "rules": {
            numbers[key]: _sheet(beside.sheets[key[1]])
            for key in numbers
            if key[0] in ("rule", "assumption") and key[1] in beside.sheets
        },
        "drawings": {
            numbers[key]: beside.drawings[key[1]]
            for key in numbers
            if key[0] in ("rule", "assumption") and key[1] in beside.drawings
        },
        "undrawn": {
            numbers[key]: beside.undrawn[key[1]]
            for key in numbers
            if key[0] in ("rule", "assumption") and key[1] in beside.undrawn
        },
        "tests": {
            numbers[key]: text
            for (rule, title), text in beside.tests.items()
            if (key := ("test", f"{rule}: {title}")) in numbers
        },
        "runs": {
            numbers[key]: _run(run, numbers, beside.pages.get(run.scenario, ""))
            for run in beside.runs
            if (key := ("run", run.scenario)) in numbers
        },
        "evidence": {
            numbers[key]: _entry(entry, makers)
            for (kind, subject), entry in beside.entries.items()
            if (key := (kind, subject)) in numbers
        },
    }  # fmt: skip
    return {
        **made,
        "files": list(files),
        "names": list(names),
        "texts": list(texts),
        "makers": [list(maker) for maker in makers],
    }


class _Table(dict[Any, int]):
    """Numbers for what is said over and over, in the order in which it is first said."""

    def __missing__(self, said: Any) -> int:
        self[said] = len(self)
        return self[said]


def _repeated(graph: Graph) -> dict[str, int]:
    """Numbers for attributes that are said more than once, where a number is shorter: a status, a source, a reason."""
    said = Counter(text for node in graph.nodes.values() for text in node.attributes.values())
    often = (text for text, times in said.items() if times > 1 and len(text) > _SHORT)
    return {text: number for number, text in enumerate(often)}


def _place(place: Place | None, files: _Table) -> list[int]:
    """The number of a file, line and column; nothing where there is no place."""
    return [] if place is None else [files[place.file], place.line, place.column]


def _link(link: Link, numbers: Mapping[Key, int], files: _Table) -> list[Any]:
    """Kind, source, target (a number, or kind and id where there is no such node), state, place."""
    target = numbers.get(link.target)
    ends = [link.target[0], link.target[1]] if target is None else target
    return [_WAYS[link.kind], numbers[link.source], ends, _STATES[link.state], _place(link.place, files)]


def _cell(cell: Cell, numbers: Mapping[Key, int], files: _Table) -> Iterator[Any]:
    yield _STATUSES[cell.status]
    yield [_item(item, numbers, files) for item in cell.items]


def _item(item: Item, numbers: Mapping[Key, int], files: _Table) -> list[Any]:
    """Status, detail and node; where there is no such node, what the item says of itself."""
    number = numbers.get(item_key(item))
    if number is None and item.kind == "run":  # it was not run
        number = numbers.get(("scenario", item.name))
    said = [_STATUSES[item.status], item.detail, -1 if number is None else number]
    return [*said, item.kind, item.name, item.title, _place(item.place, files)] if number is None else said


def item_key(item: Item) -> Key:
    """The node that an item of a cell is, where it is one."""
    kind = _NODE_OF.get(item.kind, item.kind)
    match kind:
        case "test":
            return (kind, f"{item.name}: {item.title}")
        case "fault":
            return (kind, f"{item.place.file if item.place else ''} {item.name}")
        case "external test":
            return (kind, f"{item.title}: {item.name}")
        case _:
            return (kind, item.name)


def _standing(matrix: Matrix, numbers: Mapping[Key, int]) -> dict[int, int]:
    """By node its status: of a requirement that of its cells together, of what came to something that; of others all as which they count, together.

    What came to something is failed all the same where it counts as that: a run that was made may contradict what it must show.
    """
    found: dict[int, str] = {}
    counted: dict[int, list[str]] = {}
    for row in matrix.rows:
        of_all = combined(cell.status for cell in row.cells.values())
        if of_all is not None:
            found[numbers["requirement", str(row.requirement.id)]] = of_all
        for cell in row.cells.values():
            for item in cell.items:
                if item.kind != "requirement":
                    counted.setdefault(numbers.get(item_key(item), -1), []).append(item.status)
    for number, node in enumerate(matrix.graph.nodes.values()):
        if number in found:
            continue
        outcome = node.attributes.get("outcome", "")
        as_what = counted.get(number, [])
        if outcome:
            found[number] = "failed" if "failed" in as_what else LIKE[outcome]
        elif as_what:
            found[number] = combined(as_what) or ""
    return {number: _STATUSES[status] for number, status in found.items()}


def _about(finding: Finding, graph: Graph, numbers: Mapping[Key, int]) -> list[int]:
    """The nodes that a finding is about; what it says stands on the page."""
    about = dict.fromkeys((finding.subject, *finding.about))
    return [
        numbers[node.key] for name in about for node in graph.by_id.get(name, ()) if node.kind != "result"
    ]


def _sheet(sheet: Mapping[str, Any]) -> dict[str, Any]:
    made: dict[str, Any] = {name: sheet[name] for name in _FORMS if sheet.get(name)}
    formula = sheet.get("formula")
    if formula is not None:
        made["clauses"] = [
            [one["kind"], one["depth"], one["said"], one["mathml"]] for one in formula["clauses"]
        ]
        made["definitions"] = [one["mathml"] for one in formula["definitions"]]
        made["machines"] = [
            [
                one["mathml"], one["states"], f"{one['start']}; bridges {one['bridges']}" if one["bridges"] else one["start"],
                [[move["to"], move["from"], move["when"]["mathml"], [kept["mathml"] for kept in move["remembers"]]] for move in one["moves"]],
            ]
            for one in formula["machines"]
        ]  # fmt: skip
        made["parameters"] = [
            [one["name"], one["shown"], one["written"], one["range"], one["from"]]
            for one in formula["parameters"]
        ]
        made["tables"] = [[one["name"], one["way"], one["rows"]] for one in formula["tables"]]
        made["places"] = [[one["name"], one["kind"], len(one["points"])] for one in formula["places"]]
        made["inputs"] = [
            [f"{one['signal']}.{one['field']}".rstrip("."), one["unit"]] for one in formula["inputs"]
        ]
    return {name: value for name, value in made.items() if value}


def _run(run: RunSummary, numbers: Mapping[Key, int], page: str) -> dict[str, Any]:
    """The page of a run, and of each rule in it the node, the first violation (s), and how often it came to what."""
    rules = []
    for facts in run.rules:
        node = numbers.get(("rule", facts.rule), numbers.get(("assumption", facts.rule), -1))
        rules.append(
            [
                node,
                facts.rule,
                facts.first_violation,
                {candidate: dict(said) for candidate, said in facts.counts.items()},
            ]
        )
    truths = [[kind, truth.inside] for kind, truth in run.ground_truth.items()]
    return {
        "page": page,
        "rules": rules,
        "truths": truths,
        "recording": run.source_hash,
        "overrides": list(run.overrides),
    }


def _entry(entry: Entry, makers: _Table) -> list[Any]:
    """Id, day and hour, what it was made by (a number), and the names of what it was made from."""
    return [entry.id, entry.made, makers[entry.tool, entry.commit, entry.platform], sorted(entry.inputs)]


__all__ = ["FORMAT", "VERSION", "content", "dumped", "item_key"]
