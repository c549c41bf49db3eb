"""Faults that were put into recordings: how soon they were found, by requirement, as a chart; and what found each, one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping

from trackmarshal.trace.case.charts import Cell, grid
from trackmarshal.trace.case.model import TEXT_WIDTH, Block, Code, Figure, Fixed, Given, Line, Made, Status
from trackmarshal.trace.case.writing import EMPTY, Writing, given, made
from trackmarshal.trace.graph.graph import Node

#: So many points wide are the names of requirements.
_NAMES = 200.0
#: What comes of faults that are not found as expected after some time, and what that looks like; `quiet`: nothing was to be found.
_OTHERS = {"quiet": "covered", "failed": "failed", "stale": "stale", "missing": "missing", "open": "partial"}


def faults(writing: Writing) -> Iterator[Block]:
    """A chart of how soon faults were found, by the requirement that they challenge; then each fault."""
    rows = writing.given.faults
    if not rows:
        yield writing.missing("verification.no_faults")
        return
    nodes = {node.id: node for node in writing.of_kind("fault")}
    of_row = [nodes[f"{row['campaign']} {row['id']}"] for row in rows]
    outcomes = Counter(node.attributes["outcome"] for node in writing.of_kind("fault"))
    yield writing.facts([
        ("label.faults", (writing.number("nodes", "fault"),)),
        *((f"label.faults_{outcome}", (writing.number("nodes", "fault", outcome),)) for outcome in ("covered", "failed", "stale", "missing", "open") if outcomes[outcome]),
    ])  # fmt: skip
    yield _chart(writing, nodes)
    yield writing.table((
        ("column.fault", 3.2), ("column.requirement", 1.3), ("column.found_by", 2.4), ("column.when_found", 0.7), ("column.after", 0.8), ("column.driven", 2.2),
        ("column.status", 2.5),
    ), (_row(writing, row, node) for row, node in zip(rows, of_row, strict=True)), [node.key for node in of_row])  # fmt: skip


def _row(writing: Writing, row: Mapping[str, str], node: Node) -> list[Line]:
    after = writing.said_number(node, "after") if "after" in node.attributes and row["by"] else None
    return [
        (Code(row["id"]), Fixed(" "), Given(row["title"])), (writing.ref(("requirement", row["requirement"])),), given(row["by"]),
        given(row["cycle"]), (after, Fixed(" s")) if after is not None else EMPTY, made(row["driven"]),
        (Status(row["status"]), *((Fixed(": "), Made(row["detail"])) if row["detail"] else EMPTY)),
    ]  # fmt: skip


def _chart(writing: Writing, nodes: Mapping[str, Node]) -> Figure:
    """Rows are the requirements that faults challenge; columns how long it took until one was found, or why it was not; cells how many."""
    challenged = {id_: [n.id for n in writing.beyond(node.key, "challenges")] for id_, node in nodes.items()}
    came = {id_: _came(node) for id_, node in nodes.items()}
    times = sorted({time for time, _ in came.values() if time}, key=float)
    others = [status for status in _OTHERS if ("", status) in came.values()]
    columns = [*((time, "covered") for time in times), *(("", status) for status in others)]
    heads = [*(f"{time} s" for time in times), *(writing.words[f"faults.{status}"] for status in others)]
    rows = sorted({requirement for those in challenged.values() for requirement in those})
    counts = Counter((requirement, came[id_]) for id_, those in challenged.items() for requirement in those)
    cells = {
        (row, column): Cell(str(number), _OTHERS.get(columns[column][1], "covered"), f"{requirement}, {heads[column]}: {number}")
        for row, requirement in enumerate(rows) for column in range(len(columns)) if (number := counts[requirement, columns[column]])
    }  # fmt: skip
    named = [(requirement, writing.graph.nodes["requirement", requirement].title) for requirement in rows]
    name = writing.words["faults.figure"]
    svg, wide, high = grid(name, [heads], named, cells, [], TEXT_WIDTH, _NAMES)
    return Figure(svg, name, wide, high)


def _came(node: Node) -> tuple[str, str]:
    """After how many seconds a fault was found as expected, and what came of it."""
    outcome = node.attributes["outcome"]
    if outcome != "covered":
        return "", outcome
    return (node.attributes["after"], outcome) if "after" in node.attributes else ("", "quiet")


__all__ = ["faults"]
