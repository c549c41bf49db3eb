"""The document's content: every section in its order, of what the link graph, the matrix and the results hold."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from trackmarshal.trace.case.inputs import Inputs
from trackmarshal.trace.case.model import Document
from trackmarshal.trace.case.sections import (
    argument,
    closing,
    front,
    item,
    people,
    rules,
    safety,
    showing,
    tools,
)
from trackmarshal.trace.case.words.language import english
from trackmarshal.trace.case.writing import Writing
from trackmarshal.trace.collector import no_collection
from trackmarshal.trace.graph.graph import Graph, Key

#: What stands before the table of contents, and what after it. Sections that have nothing to say leave themselves out.
FIRST = (front.cover, front.open_points)
REST = (
    item.item, item.system, safety.hazards, safety.decomposition, argument.argument, safety.requirements, item.architecture, rules.rules, rules.assumptions,
    rules.parameters, showing.verification, tools.tools, people.people, closing.matrix, closing.glossary, closing.again,
)  # fmt: skip
#: Names of sections: those of the templates that a project may replace.
NAMES = (
    "cover", "open", "item", "system", "hazards", "decomposition", "argument", "requirements", "architecture", "rules", "assumptions", "parameters",
    "verification", "tools", "people", "matrix", "glossary", "again",
)  # fmt: skip
#: Kinds of nodes that have a place of their own in the document.
PLACED = (
    "operational design domain", "subsystem", "interface", "issue", "hazard", "safety goal", "analysis", "requirement", "design element", "rule",
    "assumption", "parameter", "scenario", "fault", "document", "method", "stage", "tool", "malfunction", "person", "review", "waiver",
)  # fmt: skip


def content(given: Inputs, words: Mapping[str, str] | None = None) -> Document:
    """The document, in English where no words are given; equal inputs make equal ones. Raises T424 and T425 where the argument is to be drawn and cannot be."""
    with no_collection():
        anchors = places(given.matrix.graph, [module.name for module in given.argument.modules])
        words = english() if words is None else words
        writing = Writing(given, words, anchors)
        first = tuple(make(writing) for make in FIRST)
        rest = tuple(section for make in REST if (section := make(writing)) is not None)
        matrix = given.matrix
        return Document(matrix.project, matrix.today.isoformat(), matrix.verdict, first, rest, anchors, words)


def places(graph: Graph, modules: Iterable[str] = ()) -> dict[Key, str]:
    """The names of places in the document, all different, also without regard to case; letters, digits and hyphens, whatever ids are like."""
    keys: Iterable[Key] = (
        *(("section", name) for name in NAMES),
        *(("module", name) for name in modules),
        *(node.key for kind in PLACED for node in graph.by_kind.get(kind, ())),
    )
    taken: set[str] = set()
    found: dict[Key, str] = {}
    for key in keys:
        plain = re.sub(r"[^A-Za-z0-9]+", "-", " ".join(key)).strip("-")[:80]
        name, number = plain, 2
        while name.lower() in taken:
            name, number = f"{plain}-{number}", number + 1
        taken.add(name.lower())
        found[key] = name
    return found


__all__ = ["NAMES", "content", "places"]
