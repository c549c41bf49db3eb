"""Hazards, safety goals, how integrity levels are divided, and the requirements with what they come from."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.trace.case.model import Block, Fixed, Given, Line, Part, Section, Status
from trackmarshal.trace.case.writing import Writing, given, joined, written
from trackmarshal.trace.graph.graph import Node
from trackmarshal.trace.matrix import Row


def hazards(writing: Writing) -> Section | None:
    """Hazards with their rating, goals with their safe states, and what is watched in operation, which may be about requirements; None where there is nothing of it."""
    found, goals = writing.of_kind("hazard"), writing.of_kind("safety goal")
    watched = writing.of_kind("indicator")
    if not found and not goals and not watched:
        return None
    blocks: list[Block] = (
        [writing.named("hazards.hazards", [_hazard(writing, node) for node in found])] if found else []
    )
    if goals:
        blocks.append(writing.named("hazards.goals", [_goal(writing, node) for node in goals]))
    if watched:
        columns = (
            ("column.name", 3.0),
            ("column.claim", 2.0),
            ("column.threshold", 2.5),
            ("column.data", 3.5),
        )
        blocks.append(writing.named("hazards.indicators", [writing.table(columns, (
            [
                (Given(node.id), Fixed(" "), Given(node.title)), writing.refs(n.key for n in writing.beyond(node.key, "indicates")),
                written(node.attributes.get("threshold", "")), written(node.attributes.get("data", ""), node.place),
            ]
            for node in watched
        ))]))  # fmt: skip
    return writing.section("hazards", blocks)


def _hazard(writing: Writing, node: Node) -> Part:
    said = node.attributes
    rated = joined([given(said.get(name, "")) for name in ("severity", "exposure", "controllability")])
    rows = [
        ("label.situation", written(said.get("situation", ""), node.place)),
        ("label.rated", writing.line("hazards.rated", rated=rated, asil=Given(said.get("asil", "")))),
        ("label.rationale", written(said.get("rationale", ""))),
        ("label.source", written(said.get("source", ""))),
        ("label.arises_from", writing.refs(n.key for n in writing.beyond(node.key, "arises_from"))),
        ("label.operates_in", writing.refs(n.key for n in writing.beyond(node.key, "operates_in"))),
        (
            "label.prevented_by",
            writing.refs(n.key for n in writing.before(node.key, "prevents")) or writing.line("none"),
        ),
        ("label.owner", writing.refs(n.key for n in writing.beyond(node.key, "owned_by"))),
        ("label.review", writing.review(node.key)),
    ]
    return writing.part(writing.titled(node), [writing.facts(rows)], node.key, level=3)


def _goal(writing: Writing, node: Node) -> Part:
    said = node.attributes
    rows = [
        ("label.statement", written(said.get("statement", ""), node.place)),
        ("label.asil", given(said.get("asil", ""))),
        ("label.safe_state", written(said.get("safe_state", ""))),
        ("label.tolerance", given(said.get("tolerance", ""))),
        ("label.source", written(said.get("source", ""))),
        ("label.prevents", writing.refs(n.key for n in writing.beyond(node.key, "prevents"))),
        (
            "label.achieved_by",
            writing.refs(n.key for n in writing.before(node.key, "achieves")) or writing.line("none"),
        ),
        ("label.owner", writing.refs(n.key for n in writing.beyond(node.key, "owned_by"))),
        ("label.review", writing.review(node.key)),
    ]
    return writing.part(writing.titled(node), [writing.facts(rows)], node.key, level=3)


def decomposition(writing: Writing) -> Section | None:
    """Requirements whose integrity level is divided among those that refine them, and the analyses that argue for independence."""
    divided = [node for node in writing.of_kind("requirement") if node.demanded and any(
        "(" in child.attributes.get("asil", "") for child in writing.before(node.key, "refines")
    )]  # fmt: skip
    analyses = writing.of_kind("analysis")
    if not divided and not analyses:
        return None
    blocks: list[Block] = []
    for node in divided:
        children = [
            child for child in writing.before(node.key, "refines") if "(" in child.attributes.get("asil", "")
        ]
        argued = writing.beyond(node.key, "independence")
        rows = [
            [writing.titled(child), (Given(child.attributes["asil"]),), writing.refs(n.key for n in writing.beyond(child.key, "allocated_to"))]
            for child in children
        ]  # fmt: skip
        independence = joined([_argued(writing, analysis) for analysis in argued])
        asil = writing.line("decomposition.level", asil=Given(node.attributes["asil"]))
        blocks.append(writing.part((*writing.titled(node), Fixed(" "), *asil), [
            writing.table((("column.requirement", 5.0), ("column.asil", 1.0), ("column.allocated", 3.0)), rows),
            writing.facts([("label.independence", independence or writing.line("decomposition.unargued"))]),
        ], level=3))  # fmt: skip
    for node in analyses:
        said = node.attributes
        blocks.append(writing.part(writing.titled(node), [writing.facts([
            ("label.method", given(said.get("method", ""))),
            ("label.examines", writing.refs(n.key for n in writing.beyond(node.key, "examines"))),
            ("label.by", writing.refs(n.key for n in writing.beyond(node.key, "made_by"))),
            ("label.made_so_far" if said.get("open") else "label.made", given(said.get("made", ""))),
            ("label.open", written(said.get("open", ""), node.place)),
            ("label.document", writing.files(node.key)),
            ("label.review", writing.review(node.key)),
        ])], node.key, level=3))  # fmt: skip
    return writing.section("decomposition", blocks)


def _argued(writing: Writing, analysis: Node) -> Line:
    """An analysis that argues for something; one that leaves something open, or that nobody wrote down, argues for nothing yet, and is called so."""
    ref: Line = (writing.ref(analysis.key),)
    match analysis.attributes["outcome"]:
        case "complete":
            return ref
        case "open":
            return (*ref, *writing.line("decomposition.unfinished"))
        case "not written down":
            return (*ref, *writing.line("decomposition.unwritten"))
        case other:
            raise ValueError(f"an analysis of the outcome {other!r}")


def requirements(writing: Writing) -> Section:
    """Each requirement that is demanded, in the order of the matrix: what, why, where it comes from, what shows it; then those that are no more."""
    rows = writing.given.matrix.rows
    blocks: list[Block] = [_requirement(writing, row) for row in rows] or [
        writing.missing("requirements.none")
    ]
    gone = [node for node in writing.of_kind("requirement") if not node.demanded]
    if gone:
        said: list[Block] = [writing.paragraph("requirements.no_more")]
        said += [_no_more(writing, node) for node in gone]
        blocks.append(writing.named("requirements.obsolete", said))
    return writing.section("requirements", blocks)


def _no_more(writing: Writing, node: Node) -> Part:
    """A requirement that nobody demands any longer: its id stays, and so does what it said."""
    said = node.attributes
    facts = [
        ("label.statement", written(said["statement"], node.place)),
        ("label.rationale", written(said["rationale"])),
        ("label.source", written(said["source"])),
    ]
    return writing.part(writing.titled(node), [writing.facts(facts)], node.key, level=3)


def _requirement(writing: Writing, row: Row) -> Part:
    r, graph = row.requirement, writing.graph
    key = ("requirement", str(r.id))
    stages: list[Line] = [
        (Given(stage), Fixed(" "), Status(cell.status)) for stage, cell in row.cells.items()
    ]
    facts = [
        ("label.statement", written(r.statement, r.place)),
        ("label.rationale", written(r.rationale)),
        ("label.asil", given(str(r.asil))),
        ("label.state", given(r.status)),
        ("label.derivation", joined(list(_derivation(writing, row)), "; ")),
        ("label.adopted", written(r.adopted)),
        ("label.refined_by", writing.refs(n.key for n in writing.before(key, "refines"))),
        ("label.allocated_to", writing.refs(n.key for n in writing.beyond(key, "allocated_to"))),
        ("label.verification", joined([given(way) for way in r.verification])),
        ("label.methods", writing.refs(n.key for n in writing.beyond(key, "verified_by"))),
        ("label.not_verified_by", joined([
            (writing.ref(("method", name)), Fixed(": "), *written(why)) for name, why in r.not_verified_by
        ], "; ")),
        ("label.rules", writing.refs(n.key for n in writing.before(key, "satisfies")) or writing.line("requirements.no_rule")),
        ("label.waivers", writing.refs(n.key for n in writing.before(key, "excuses"))),
        ("label.stages", joined(stages) or writing.line("requirements.no_stage")),
        ("label.source", written(r.source)),
        ("label.owner", given(r.owner)),
        ("label.review", writing.review(key)),
    ]  # fmt: skip
    return writing.part(writing.titled(graph.nodes[key]), [writing.facts(facts)], key, level=3)


def _derivation(writing: Writing, row: Row) -> Iterator[Line]:
    """The goals and requirements above it, and the issues of the system model that it answers."""
    key = ("requirement", str(row.requirement.id))
    for kind, said in (("achieves", "requirements.achieves"), ("refines", "requirements.refines")):
        above = [node.key for node in writing.beyond(key, kind)]
        if above:
            yield writing.line(said, above=writing.refs(above))
    issues = [node.key for node in writing.before(key, "leads_to")]
    if issues:
        yield writing.line("requirements.answers", issues=writing.refs(issues))


__all__ = ["decomposition", "hazards", "requirements"]
