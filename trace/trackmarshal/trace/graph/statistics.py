"""The graph in numbers: nodes, links and their states, requirements by ASIL and stage."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from trackmarshal.trace.graph.kinds import LINKS, NODES
from trackmarshal.trace.matrix import Matrix


class Number(NamedTuple):
    """How many things of some kind there are: `table` and `of` say what is counted, `what` a property of them, "" for all."""

    table: str
    of: str
    what: str
    number: int


def numbers(matrix: Matrix) -> list[Number]:
    """All numbers, in order; kinds of which there is nothing are left out."""
    graph = matrix.graph
    found: list[Number] = []
    for kind in NODES:
        nodes = graph.by_kind.get(kind, ())
        if nodes:
            found.append(Number("nodes", kind, "", len(nodes)))
            found.append(
                Number(
                    "nodes",
                    kind,
                    "without a link",
                    sum(not (graph.out_of(n.key) or graph.into(n.key)) for n in nodes),
                )
            )
            outcomes = Counter(n.attributes["outcome"] for n in nodes if n.attributes.get("outcome"))
            found += [Number("nodes", kind, outcome, outcomes[outcome]) for outcome in sorted(outcomes)]
    for name in LINKS:
        links = graph.of_kind(name)
        if links:
            found.append(Number("links", name, "", len(links)))
            states = Counter(link.state for link in links)
            found += [Number("links", name, state, states[state]) for state in sorted(states)]
    found += _by_asil(matrix)
    for stage, counts in matrix.coverage.items():
        found.append(Number("stages", stage, "", counts["of"]))
        found += [
            Number("stages", stage, what, number)
            for what, number in counts.items()
            if what != "of" and number
        ]
    return found


def _by_asil(matrix: Matrix) -> list[Number]:
    """Requirements that are demanded, by ASIL, and those of which no cell is open; one of which no stage asks anything is none of these."""
    levels: dict[str, list[bool]] = {}
    for row in matrix.rows:
        statuses = {cell.status for cell in row.cells.values()}
        closed = bool(statuses) and statuses <= {"covered", "waived"}
        levels.setdefault(str(row.requirement.asil), []).append(closed)
    found: list[Number] = []
    for level in sorted(levels):
        found += [Number("requirements by ASIL", level, "", len(levels[level])),
                  Number("requirements by ASIL", level, "with no open cell", sum(levels[level]))]  # fmt: skip
    return found


def grouped(found: list[Number]) -> Mapping[str, Mapping[str, Mapping[str, int]]]:
    """Numbers by table, by what is counted, by property; all of them under `all`."""
    tables: dict[str, dict[str, dict[str, int]]] = {}
    for entry in found:
        tables.setdefault(entry.table, {}).setdefault(entry.of, {})[entry.what or "all"] = entry.number
    return tables


__all__ = ["Number", "grouped", "numbers"]
