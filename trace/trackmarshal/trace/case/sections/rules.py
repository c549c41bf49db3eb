"""Rules and assumptions for readers: each in its forms, with what it rests on and the tests on both sides of its boundary; and all parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.records.specs import SpecItem, SpecTest
from trackmarshal.trace.case.model import (
    TEXT_WIDTH,
    Block,
    Code,
    Figure,
    Fixed,
    Formula,
    Given,
    Inline,
    Line,
    Made,
    Paragraph,
    Part,
    Section,
    Status,
    Table,
    Verbatim,
)
from trackmarshal.trace.case.writing import EMPTY, Writing, given, joined, made, written
from trackmarshal.trace.report.svg.boundary import picture


def rules(writing: Writing) -> Section:
    """Every rule that answers for a requirement, in the order of the specs."""
    found = [_item(writing, item) for item in writing.given.items if item.kind == "rule"]
    return writing.section("rules", found or [writing.missing("rules.none")])


def assumptions(writing: Writing) -> Section:
    """What is taken for granted, and who discharges it: by what it is watched, and what record backs it."""
    found = [_item(writing, item) for item in writing.given.items if item.kind != "rule"]
    return writing.section("assumptions", found or [writing.missing("assumptions.none")])


def _item(writing: Writing, item: SpecItem) -> Part:
    key = ("rule" if item.kind == "rule" else "assumption", item.name)
    sheet = writing.given.sheets.get(item.name, {})
    said = sheet.get("said", {})
    facts = [
        ("label.satisfies", writing.refs(n.key for n in writing.beyond(key, "satisfies"))),
        ("label.assuming", writing.refs(n.key for n in writing.beyond(key, "assuming"))),
        ("label.assumed_by", writing.refs(n.key for n in writing.before(key, "assuming"))),
        ("label.source", given(item.source)),
        ("label.because", written(said.get("because", ""))),
        ("label.severity", given(item.severity)),
    ]
    if item.kind != "rule":
        facts += [
            ("label.owner", given(item.owner) or writing.line("assumptions.no_owner")),
            ("label.monitor", writing.line("assumptions.monitored" if item.monitored else "assumptions.unmonitored")),
            ("label.evidence", writing.files(key) or writing.line("assumptions.no_evidence")),
        ]  # fmt: skip
    facts.append(("label.review", writing.review(key)))
    blocks: list[Block] = [writing.facts(facts)]
    if "spec" in sheet:
        blocks.append(
            writing.part(
                (*writing.line("rules.spec"), Code(str(sheet["declared"]))),
                [Verbatim(sheet["spec"])],
                level=4,
            )
        )
    if "formula" in sheet:
        blocks.append(writing.named("rules.formula", _formula(writing, sheet["formula"]), level=4))
    if "words" in sheet:
        told: list[Block] = [
            Paragraph((Made(text),)) for text in (*sheet["words"]["demand"], *sheet["words"]["definitions"])
        ]
        blocks.append(writing.named("rules.words", told, level=4))
    if sheet.get("formula", {}).get("parameters"):
        blocks.append(
            writing.named("rules.parameters", [_settings(writing, sheet["formula"]["parameters"])], level=4)
        )
    tests = writing.tests_of.get(item.name, ())
    if tests or item.monitored or item.kind == "rule":
        shown = [_tests(writing, tests)] if tests else [writing.missing("rules.no_tests")]
        blocks.append(writing.named("rules.tests", shown, level=4))
    if item.name in writing.given.drawings:
        drawing = writing.given.drawings[item.name]
        blocks.append(writing.named("rules.drawing", [_drawing(writing, drawing)], level=4))
    elif "formula" in sheet:
        how = writing.paragraph("drawing.more", command=Code(f"trackmarshal show {item.name} --draw"))
        blocks.append(writing.named("rules.drawing", [how], level=4))
    title: Line = (Code(item.name), Fixed(" "), Given(item.title))
    return writing.part(title, blocks, key, level=3)


def _drawing(writing: Writing, drawing: Mapping[str, Any]) -> Block:
    """The boundary, drawn; or in one line why it is not."""
    if "none" in drawing:
        return writing.paragraph(f"drawing.none.{drawing['none']}")
    name = str(drawing["rule"])
    drawn = picture(drawing, writing.words, f"boundary-{writing.anchors.get(('rule', name), name)}")
    caption = (*writing.line("drawing.caption"), Fixed(" "), Code(str(drawing["sha"])))
    scale = TEXT_WIDTH / drawn.wide
    title = writing.words["drawing.name"].format(rule=name)
    return Figure(drawn.svg, title, TEXT_WIDTH, drawn.high * scale, caption)


def _formula(writing: Writing, shown: Mapping[str, Any]) -> Iterator[Block]:
    """Clauses as they stand, then all that they call."""
    for clause in shown["clauses"]:
        word = writing.words[f"clause.{clause['kind']}"]
        yield Formula(clause["mathml"], clause["typst"], word, clause["depth"], clause["said"])
    if shown["definitions"]:
        yield writing.paragraph("rules.where")
    for one in shown["definitions"]:
        yield Formula(one["mathml"], one["typst"], depth=1)
    for machine in shown["machines"]:
        states = joined([given(state) for state in machine["states"]])
        said = writing.line(
            "rules.machine", name=Code(machine["text"]), states=states, start=Given(machine["start"])
        )
        if machine["bridges"]:
            said = (*said, Fixed(" "), *writing.line("rules.bridges", gap=Given(machine["bridges"])))
        yield Paragraph(said)
        yield writing.table((("column.becomes", 1.5), ("column.from", 1.5), ("column.when", 6.0)), (
            [given(move["to"]), joined([given(state) for state in move["from"]]), (Inline(move["when"]["mathml"], move["when"]["typst"]),)]
            for move in machine["moves"]
        ))  # fmt: skip
    for table in shown["tables"]:
        yield writing.part(
            (*writing.line("rules.table"), Given(table["shown"]), Fixed(": "), Code(table["way"])),
            [_grid(table["rows"])],
            level=4,
        )
    if shown["places"]:
        places = joined(
            [(Given(place["kind"]), Fixed(" "), Code(place["name"])) for place in shown["places"]]
        )
        yield writing.paragraph("rules.places", places=places)


def _grid(rows: Sequence[Sequence[str]]) -> Block:
    width = len(rows[0])
    return Table(
        tuple(rows[0]), tuple(tuple(given(cell) for cell in row) for row in rows[1:]), (1.0,) * width
    )


def _settings(writing: Writing, parameters: Sequence[Mapping[str, Any]]) -> Block:
    return writing.table((("column.parameter", 2.2), ("column.value", 1.6), ("column.range", 2.2), ("column.from_where", 4.0)), (
        [(writing.ref(("parameter", one["name"])),), given(one["written"]), _range(writing, one), _origin(writing, one)] for one in parameters
    ))  # fmt: skip


def _range(writing: Writing, parameter: Mapping[str, Any]) -> Line:
    """Between which values a configuration may choose."""
    least, greatest = map(Given, parameter["ends"])
    if least.text and greatest.text:
        return writing.line("parameters.between", least=least, greatest=greatest)
    if least.text:
        return writing.line("parameters.least", least=least)
    return writing.line("parameters.greatest", greatest=greatest) if greatest.text else EMPTY


def _origin(writing: Writing, parameter: Mapping[str, Any]) -> Line:
    """Where a value comes from: its source, where it stands, and which value of the spec it replaced."""
    place, replaced = Code(parameter["place"]), parameter["replaced"]
    stands = (
        writing.line("parameters.replaced", place=place, value=Given(replaced))
        if replaced
        else writing.line("parameters.declared", place=place)
    )
    return joined([given(parameter["source"]), stands], "; ") if parameter["source"] else stands


def _tests(writing: Writing, tests: Sequence[SpecTest]) -> Block:
    """Each test with what it expects; those on the boundary with how near they stand, and how far the limit moves before they fail."""
    rows: list[list[Line]] = []
    for test in tests:
        node = writing.graph.nodes["test", f"{test.rule}: {test.title}"]
        result = writing.result_of.get((test.rule, test.title))
        margin = EMPTY
        if test.boundary:
            margin = writing.line("tests.boundary", within=Given(test.within), distance=Given(test.distance))
        elif test.within:
            margin = writing.line("tests.near", within=Given(test.within))
        failed: Line = (Fixed(": "), Made(result.message)) if result is not None and result.message else EMPTY
        rows.append(
            [given(test.title), given(test.expects), margin, (Status(node.attributes["outcome"]), *failed)]
        )
    columns = (("column.test", 4.0), ("column.expects", 1.5), ("column.margin", 3.0), ("column.outcome", 1.8))
    return writing.table(columns, rows)


def parameters(writing: Writing) -> Section:
    """All parameters that rules read, with the values in force; and the constraints between them."""
    blocks: list[Block] = []
    nodes = writing.of_kind("parameter")
    if nodes:
        said = _as_written(writing)
        rows = []
        for node in nodes:
            used = [n.key for n in writing.before(node.key, "uses")]
            place = (Code(str(node.place)),) if node.place else EMPTY
            rows.append([(Code(node.id),), said.get(node.id) or made(node.title), writing.refs(used), place])
        columns = (
            ("column.parameter", 3.0),
            ("column.value", 3.0),
            ("column.used_by", 4.0),
            ("column.place", 2.5),
        )
        blocks.append(writing.table(columns, rows, [node.key for node in nodes]))
    else:
        blocks.append(writing.missing("parameters.none"))
    constraints = writing.of_kind("constraint")
    if constraints:
        lines = [[(Code(node.id),), (Code(str(node.place or "")),)] for node in constraints]
        blocks.append(
            writing.named(
                "parameters.constraints",
                [writing.table((("column.constraint", 6.0), ("column.place", 3.0)), lines)],
            )
        )
    return writing.section("parameters", blocks)


def _as_written(writing: Writing) -> Mapping[str, Line]:
    """By parameter, its value and range as rules for readers have them, in the units of the spec: 60 km/h, where the graph counts in m/s."""
    return {
        one["name"]: joined([line for line in (given(one["written"]), _range(writing, one)) if line])
        for sheet in writing.given.sheets.values()
        for one in sheet.get("formula", {}).get("parameters", ())
    }


__all__ = ["assumptions", "parameters", "rules"]
