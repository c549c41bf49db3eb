"""Confidence in tools: what a fault of each could do, how it would be noticed, what shows that, and the level that follows."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cached_property

from trackmarshal.trace.case.model import Block, Code, Fixed, Given, Line, Number, Part, Section, Status
from trackmarshal.trace.case.writing import EMPTY, Writing, given, joined, written
from trackmarshal.trace.graph.graph import Node


def tools(writing: Writing) -> Section:
    """An overview, then each tool with its malfunctions; a project without tools is told what it lacks."""
    nodes = writing.of_kind("tool")
    engine = writing.paragraph("tools.engine", engine=Code(writing.given.engine))
    if not nodes:
        return writing.section("tools", [writing.missing("tools.none"), engine])
    shown = _Shown(writing)
    blocks: list[Block] = [writing.paragraph("tools.how"), engine, _overview(writing, nodes)]
    blocks += [_tool(writing, node, shown) for node in nodes]
    return writing.section("tools", blocks)


def _overview(writing: Writing, nodes: Sequence[Node]) -> Block:
    columns = (("column.tool_part", 4.0), ("column.version", 2.0), ("column.impact", 0.8), ("column.detection", 0.8), ("column.confidence", 0.8))  # fmt: skip
    return writing.table(columns, (
        [writing.titled(node), *(given(node.attributes.get(name, "")) or writing.line("tools.no_confidence") for name in ("version", "impact", "detection", "confidence"))]
        for node in nodes
    ))  # fmt: skip


def _tool(writing: Writing, node: Node, shown: _Shown) -> Part:
    said = node.attributes
    level = said.get("confidence", "")
    classes = joined([_class(writing, said.get(name, "")) for name in ("impact", "detection", "confidence") if said.get(name)], "; ")  # fmt: skip
    blocks: list[Block] = [writing.facts([
        ("label.version", given(said.get("version", ""))),
        ("label.used_for", writing.refs(n.key for n in writing.beyond(node.key, "used_for"))),
        ("label.confidence", classes or writing.line("tools.no_confidence")),
        ("label.rationale", written(said.get("rationale", ""), node.place)),
        ("label.open", written(said.get("open", ""))),
        ("label.qualification", writing.line("tools.unqualified") if level in ("TCL2", "TCL3") else EMPTY),
        ("label.examined", writing.refs(n.key for n in writing.before(node.key, "examines"))),
        ("label.review", writing.review(node.key)),
    ])]  # fmt: skip
    malfunctions = writing.before(node.key, "malfunction_of")
    if malfunctions:
        blocks += [_malfunction(writing, one, shown) for one in malfunctions if _first(writing, one, node)]
        elsewhere = [one.key for one in malfunctions if not _first(writing, one, node)]
        if elsewhere:
            blocks.append(writing.facts([("label.also", writing.refs(elsewhere))]))
    else:
        blocks.append(writing.missing("tools.undescribed"))
    return writing.part(writing.titled(node), blocks, node.key)


def _class(writing: Writing, name: str) -> Line:
    """A class with what it means."""
    return (Given(name), Fixed(" "), *writing.line(f"tools.{name}"))


def _first(writing: Writing, malfunction: Node, tool: Node) -> bool:
    """Whether a tool is the first of those that a malfunction is of: there it stands whole."""
    return writing.beyond(malfunction.key, "malfunction_of")[0].key == tool.key


def _malfunction(writing: Writing, node: Node, shown: _Shown) -> Part:
    said = node.attributes
    evidence = [shown.line(one) for one in writing.beyond(node.key, "backed_by")]
    return writing.part(writing.titled(node), [writing.facts([
        ("label.effect", written(said.get("effect", ""), node.place)),
        ("label.noticed", written(said.get("noticed", ""))),
        ("label.shown_in", joined(evidence, "; ") or writing.line("tools.nothing_shows")),
        ("label.review", writing.review(node.key)),
    ])], node.key, level=3)  # fmt: skip


class _Shown:
    """What files are worth as evidence: whether they are there, and what came of the tests in them that name a requirement, where they were run."""

    def __init__(self, writing: Writing) -> None:
        self._writing = writing

    @cached_property
    def _outcomes(self) -> Mapping[str, Counter[str]]:
        found: dict[str, Counter[str]] = {}
        for node in self._writing.of_kind("external test"):
            if node.place is not None:
                found.setdefault(node.place.file, Counter())[node.attributes["outcome"]] += 1
        return found

    def line(self, document: Node) -> Line:
        line = self._writing.file(document)
        for outcome, number in sorted(self._outcomes.get(document.id, Counter()).items()):
            line = (*line, Fixed(" "), Number(f"tests/{document.id}/{outcome}", str(number)), Fixed(" "), Status(outcome))  # fmt: skip
        return line


__all__ = ["tools"]
