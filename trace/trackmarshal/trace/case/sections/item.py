"""The item: where it is meant to drive, what it consists of, and how the parts of its world meet."""

from __future__ import annotations

from trackmarshal.trace.case.figure import chart
from trackmarshal.trace.case.model import (
    TEXT_WIDTH,
    Block,
    Figure,
    Fixed,
    Given,
    Line,
    Part,
    Section,
    Status,
    Written,
)
from trackmarshal.trace.case.writing import Writing, joined, written
from trackmarshal.trace.model import Interface


def item(writing: Writing) -> Section | None:
    """The operational design domains; None where the project declares none."""
    domains = writing.of_kind("operational design domain")
    if not domains:
        return None
    ranges = {str(one.id): one.ranges for one in writing.given.project.entries if one.ranges}
    parts = [
        writing.part(writing.titled(node), [
            writing.facts([
                ("label.description", written(node.attributes.get("description", ""), node.place)),
                ("label.ranges", joined([_range(writing, *one) for one in ranges.get(node.id, ())], "; ")),
                ("label.source", written(node.attributes.get("source", ""))),
                ("label.hazards", writing.refs(n.key for n in writing.before(node.key, "operates_in"))),
                ("label.review", writing.review(node.key)),
            ])
        ], node.key)
        for node in domains
    ]  # fmt: skip
    return writing.section("item", parts)


def _range(writing: Writing, quantity: str, low: str, high: str) -> Line:
    ends = writing.line("parameters.between", least=Given(low), greatest=Given(high))
    return (Written(f"{quantity}:"), Fixed(" "), *ends)


def system(writing: Writing) -> Section | None:
    """Subsystems and interfaces as a chart and as tables; None where the project has no model."""
    project = writing.given.project
    if not project.subsystems:
        return None
    svg, size = chart(project.subsystems, project.interfaces, writing.words["system.figure"])
    size = min(size, TEXT_WIDTH)
    parts = writing.table((("column.id", 1.0), ("column.title", 2.5), ("column.role", 1.3), ("column.description", 6.0)), (
        [(writing.ref(("subsystem", str(one.id))),), (Given(one.title),), writing.line(f"role.{one.role}"), written(one.description, one.id.place)]
        for one in project.subsystems
    ), [("subsystem", str(one.id)) for one in project.subsystems])  # fmt: skip
    blocks: list[Block] = [
        Figure(svg, writing.words["system.figure"], size, size),
        writing.named("system.parts", [parts]),
    ]
    blocks.append(
        writing.named("system.interfaces", [_interface(writing, one) for one in project.interfaces])
    )
    if project.infeasible:
        columns = (("column.pair", 1.0), ("column.why", 8.0))
        rows = [
            [(Given(str(one.between)),), written(one.reason, one.between.place)] for one in project.infeasible
        ]
        blocks.append(writing.named("system.apart", [writing.table(columns, rows)]))
    return writing.section("system", blocks)


def _interface(writing: Writing, one: Interface) -> Part:
    key = ("interface", str(one.id))
    blocks: list[Block] = []
    if one.flows:
        blocks.append(writing.table((("column.kind", 1.2), ("column.starts", 1.2), ("column.passes", 7.0)), (
            [(Given(flow.kind),), (Given(str(flow.initiator)),), written(flow.what, flow.initiator.place)] for flow in one.flows
        )))  # fmt: skip
    if one.issues:
        rows = [
            [
                (writing.ref(("issue", str(issue.id))),), written(issue.text, issue.id.place),
                writing.refs(("requirement", str(target)) for target in issue.leads_to),
            ]
            for issue in one.issues
        ]  # fmt: skip
        columns = (("column.issue", 1.2), ("column.wrong", 6.5), ("column.leads_to", 1.8))
        blocks.append(writing.table(columns, rows, [("issue", str(issue.id)) for issue in one.issues]))
    elif one.rationale:
        blocks.append(writing.facts([("label.unanalysed", written(one.rationale, one.id.place))]))
    else:
        blocks.append(writing.missing("system.unanalysed"))
    title: Line = (Given(str(one.id)), Fixed(" "), Given(one.title))
    return writing.part(title, blocks, key, level=3)


def architecture(writing: Writing) -> Section | None:
    """The elements of the design with what is allocated to them, and the documents that are evidence at stages that count documents."""
    elements = writing.of_kind("design element")
    documents = writing.given.project.evidence
    blocks: list[Block] = []
    for node in elements:
        allocated = [n.key for n in writing.before(node.key, "allocated_to")]
        blocks.append(writing.part(writing.titled(node), [
            writing.facts([
                ("label.description", written(node.attributes.get("description", ""), node.place)),
                ("label.asil", (Given(node.attributes["asil"]),) if node.attributes.get("asil") else ()),
                ("label.part_of", writing.refs(n.key for n in writing.beyond(node.key, "part_of"))),
                ("label.allocated", writing.refs(allocated) or writing.line("none")),
                ("label.owner", writing.refs(n.key for n in writing.beyond(node.key, "owned_by"))),
                ("label.review", writing.review(node.key)),
            ])
        ], node.key, level=3))  # fmt: skip
    if not elements:
        blocks.append(writing.missing("architecture.no_elements"))
    if documents:
        rows = [
            [
                (writing.ref(("document", str(one.path))), Fixed(" "), Given(one.title)), (Given(str(one.stage)),),
                writing.refs(
                    link.target for link in writing.graph.out_of(("document", str(one.path)))
                    if link.kind == "evidence" and link.place == one.path.place
                ),
                (Status(writing.graph.nodes["document", str(one.path)].attributes["outcome"]),),
            ]
            for one in documents
        ]  # fmt: skip
        columns = (
            ("column.document", 5.0),
            ("column.stage", 1.0),
            ("column.requirements", 2.5),
            ("column.status", 1.0),
        )
        blocks.append(writing.named("architecture.documents", [writing.table(columns, rows)]))
    return writing.section("architecture", blocks)


__all__ = ["architecture", "item", "system"]
