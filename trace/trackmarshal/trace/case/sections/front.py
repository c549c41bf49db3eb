"""What stands first: the verdict and what it rests on, and all that is open."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import PurePosixPath

from trackmarshal.trace.case.model import (
    Block,
    Code,
    Fixed,
    Given,
    Line,
    Made,
    Missing,
    Section,
    Status,
    Table,
    Verdict,
)
from trackmarshal.trace.case.sections.argument import undeveloped, wrong
from trackmarshal.trace.case.writing import EMPTY, Writing, given, joined, written
from trackmarshal.trace.cells import STATUSES, Cell, Item
from trackmarshal.trace.findings import LEVELS, Finding
from trackmarshal.trace.graph.graph import Key
from trackmarshal.trace.matrix import Row
from trackmarshal.trace.model import Stage, Waiver, day_said

#: Kinds of nodes that a safety case speaks of, and that a project may lack: each with the name of what is said then.
EXPECTED = (
    "operational design domain", "hazard", "safety goal", "design element", "analysis", "review", "person", "tool", "method",
)  # fmt: skip
#: So many things are named that keep one cell from being covered; all of them are in the matrix.
NAMED = 4


def cover(writing: Writing) -> Section:
    """The verdict in the one wording, of what, as of which day and commit."""
    made, matrix = writing.given, writing.given.matrix
    said = ", ".join(matrix.reservations) if matrix.passes else ""
    commit = made.commit.removesuffix("+")
    changed = writing.line("cover.changed") if made.commit.endswith("+") else EMPTY
    # Hashes are by the paths of files as they are; a document may write `./` before one.
    declared = made.project.baseline
    baseline = made.hashes.get(PurePosixPath(declared).as_posix(), "") if declared else ""
    blocks: list[Block] = [
        Verdict(matrix.verdict, said),
        writing.facts([
            ("cover.day", given(matrix.today.isoformat())),
            ("cover.commit", (Code(commit), *changed) if commit else writing.line("cover.no_commit")),
            ("cover.specs", (Code(made.specs),) if made.specs else EMPTY),
            ("cover.baseline", (Code(baseline),) if baseline else writing.line("cover.no_baseline")),
            ("cover.tool", (Given(made.tool),)),
            ("cover.findings", joined([
                (Fixed(f"{writing.words[f'level.{level}']} "), writing.number("findings", level)) for level in LEVELS
            ])),
        ]),
        writing.paragraph("cover.marks"),
        writing.paragraph("cover.limits"),
    ]  # fmt: skip
    return writing.section("cover", blocks)


def open_points(writing: Writing) -> Section:
    """What fails, what is stale, what is missing, and who answers for what: first what is worst."""
    matrix = writing.given.matrix
    misread = any(finding.level == "error" for finding in matrix.misread)
    blocks: list[Block] = [writing.missing("open.misread")] if misread else []
    for level in LEVELS:
        found = [finding for finding in matrix.standing if finding.level == level]
        if found:
            blocks.append(writing.named(f"open.{level}", [_findings(writing, found)]))
    gaps = [
        (row, stage, row.cells[stage.id]) for row in matrix.rows for stage in matrix.stages
        if stage.id in row.cells and row.cells[stage.id].status not in ("covered", "waived")
    ]  # fmt: skip
    gaps.sort(key=lambda gap: STATUSES.index(gap[2].status))
    asked = any(row.cells for row in matrix.rows)  # where nothing is, not all of it is covered
    no_gap = writing.paragraph("open.no_cells") if asked else writing.missing("open.no_demands")
    blocks.append(writing.named("open.cells", [_cells(writing, gaps) if gaps else no_gap]))
    stale = list(_stale(writing))
    blocks.append(
        writing.named(
            "open.stale", [_listed(writing, stale) if stale else writing.paragraph("open.no_stale")]
        )
    )
    found_wrong = wrong(writing)
    if found_wrong is not None:
        blocks.append(found_wrong)
    waivers = (
        [_waivers(writing, matrix.waivers)] if matrix.waivers else [writing.paragraph("open.no_waivers")]
    )
    blocks.append(writing.named("open.waivers", waivers))
    if matrix.unreviewed:
        blocks.append(
            writing.named("open.unreviewed", [writing.paragraph("open.unread"), _unreviewed(writing)])
        )
    open_claims = undeveloped(writing)
    if open_claims is not None:
        blocks.append(open_claims)
    follows = [finding for finding in matrix.findings if finding in matrix.causes]
    if follows:
        blocks.append(writing.named("open.follows", [_findings(writing, follows)]))
    lacking = [kind for kind in EXPECTED if not writing.of_kind(kind)]
    if lacking:
        blocks.append(
            writing.named("open.lacking", [Missing(writing.line(f"lacking.{kind}")) for kind in lacking])
        )
    blocks.append(writing.named("open.beyond", [writing.paragraph("open.undecidable")]))
    return writing.section("open", blocks)


def _findings(writing: Writing, found: list[Finding]) -> Table:
    columns = (("column.code", 1.0), ("column.finding", 6.0), ("column.place", 3.0))
    rows = []
    for finding in found:
        help_: Line = (Fixed(writing.words["finding.help"]), Made(finding.help)) if finding.help else EMPTY
        rows.append(
            [(Code(finding.code),), (Made(finding.message), *help_), (Code(str(finding.place or "")),)]
        )
    return writing.table(columns, rows)


def _cells(writing: Writing, gaps: list[tuple[Row, Stage, Cell]]) -> Table:
    columns = (
        ("column.requirement", 2.5),
        ("column.stage", 2.0),
        ("column.status", 1.2),
        ("column.why", 4.5),
    )
    return writing.table(columns, (
        [
            (*writing.titled(writing.graph.nodes["requirement", str(row.requirement.id)]),),
            (Given(str(stage.id)), Fixed(" "), Given(stage.title)), (Status(cell.status),),
            _why(writing, cell),
        ]
        for row, stage, cell in gaps
    ))  # fmt: skip


def _why(writing: Writing, cell: Cell) -> Line:
    """The first of what keeps a cell from being covered, worst first: one cause may have hundreds of consequences in one cell."""
    lacking = [item for item in cell.items if item.status not in ("covered", "waived")]
    lacking.sort(key=lambda item: STATUSES.index(item.status))
    said = joined([_item(writing, item) for item in lacking[:NAMED]], "; ") or writing.line("open.nothing")
    return (*said, *writing.line("open.more")) if len(lacking) > NAMED else said


def _item(writing: Writing, item: Item) -> Line:
    """What lacks something; kinds that only cells know, such as monitors, have no word of their own."""
    detail: Line = (Fixed(": "), Made(item.detail)) if item.detail else EMPTY
    return (
        Fixed(writing.words.get(f"thing.{item.kind}", item.kind)),
        Fixed(" "),
        Code(item.name),
        *((Fixed(" "), Given(item.title)) if item.title else EMPTY),
        *detail,
    )


def _stale(writing: Writing) -> Iterator[tuple[str, str, str]]:
    """Whatever rests on something that has changed since: kind, id, and what it has come to."""
    for kind in ("test", "run", "fault", "document", "external test"):
        for node in writing.of_kind(kind):
            if node.attributes.get("outcome") in ("stale", "changed"):
                yield kind, node.id, node.attributes["outcome"]
    for link in writing.graph.links:
        if link.kind == "reviews" and link.state == "outdated":
            yield "review", f"{link.source[1]} → {link.target[1]}", "changed"


def _listed(writing: Writing, stale: list[tuple[str, str, str]]) -> Table:
    rows: list[list[Line]] = [
        [(Fixed(writing.words[f"thing.{kind}"]),), (Code(name),), (Status(outcome),)]
        for kind, name, outcome in stale
    ]
    return writing.table((("column.kind", 1.5), ("column.name", 6.0), ("column.status", 1.5)), rows)


def _waivers(writing: Writing, waivers: tuple[Waiver, ...]) -> Table:
    columns = (
        ("column.waiver", 1.0), ("column.excuses", 2.0), ("column.answers", 2.0), ("column.holds", 1.6), ("column.risk", 2.4), ("column.justification", 4.0),
    )  # fmt: skip
    day = writing.given.matrix.today
    rows = []
    for waiver in waivers:
        holds = waiver.holds(day)
        state = Status(
            "waived" if holds else "failed", writing.words["waiver.holds" if holds else "waiver.not"]
        )
        gaps = [
            *map(str, (*waiver.stages, *waiver.codes)),
            *map(str, (*waiver.requirements, *waiver.subjects)),
        ]
        rows.append([
            (Given(str(waiver.id)),), joined([(Given(gap),) for gap in gaps]),
            writing.line("waiver.people", owner=Given(waiver.owner), approver=Given(str(waiver.approver))),
            (state, *writing.line("waiver.days", granted=Given(day_said(waiver.granted)), expires=Given(day_said(waiver.expires)))),
            written(waiver.residual_risk), written(waiver.justification),
        ])  # fmt: skip
    return writing.table(columns, rows, [("waiver", str(waiver.id)) for waiver in waivers])


def _unreviewed(writing: Writing) -> Table:
    """What nobody has reviewed, a row a kind."""
    found: dict[str, list[Key]] = {}
    for key in writing.given.matrix.unreviewed:
        found.setdefault(key[0], []).append(key)
    rows = [
        [(Fixed(writing.words.get(f"thing.{kind}", kind)),), writing.refs(keys)]
        for kind, keys in found.items()
    ]
    return writing.table((("column.kind", 1.5), ("column.name", 7.5)), rows)


__all__ = ["cover", "open_points"]
