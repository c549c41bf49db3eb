"""The matrix as a table: CSV for spreadsheets, Markdown for merge requests."""

from __future__ import annotations

import csv
import io

from trackmarshal.trace.cells import Item
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.model import day_said
from trackmarshal.trace.render.words import SIGNS, follows, inputs, printable, tally, unreviewed


def render_csv(matrix: Matrix) -> str:
    """A row a requirement; for each stage a column with the status and one with the items."""
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    stages = [str(stage.id) for stage in matrix.stages]
    head = ["id", "title", "asil", "status", "refines", "derived_from", "file", "line"]
    writer.writerow(head + [name for stage in stages for name in (stage, f"{stage} items")])
    for row in matrix.rows:
        r = row.requirement
        line: list[str] = [
            r.id,
            r.title,
            r.asil,
            r.status,
            " ".join(r.refines),
            " ".join(r.derived_from),
            r.place.file,
            str(r.place.line),
        ]
        for stage in stages:
            cell = row.cells.get(stage)
            line += ["", ""] if cell is None else [cell.status, "; ".join(_item(item) for item in cell.items)]
        writer.writerow([harmless(value) for value in line])
    return out.getvalue()


def _item(item: Item) -> str:
    title = f' "{item.title}"' if item.kind == "test" else ""
    place = f" ({item.place})" if item.place else ""
    return f"{item.kind} {item.name}{title} {item.status}{place}"


def harmless(value: str) -> str:
    """A value that no spreadsheet takes for a formula."""
    text = printable(value)
    return f"'{text}" if text[:1] in ("=", "+", "-", "@") else text


def render_markdown(matrix: Matrix) -> str:
    """Verdict, matrix, findings."""
    stages = [str(stage.id) for stage in matrix.stages]
    lines = [
        f"# Traceability of {escaped(matrix.project)}",
        "",
        f"**{matrix.verdict.upper()}** on {matrix.today.isoformat()}: {tally(matrix)}. From {inputs(matrix)}.",
        "",
        "| requirement | " + " | ".join(stages) + " |",
        "|---" * (len(stages) + 1) + "|",
    ]
    for row in matrix.rows:
        statuses = [row.cells[stage].status if stage in row.cells else "" for stage in stages]
        cells = [f"{SIGNS[status]} {status}" if status else "" for status in statuses]
        name = "&nbsp;" * 4 * row.depth + f"**{row.requirement.id}** {escaped(row.requirement.title)}"
        lines.append("| " + " | ".join([name, *cells]) + " |")
    coverage = matrix.coverage
    totals = [f"{coverage[stage]['covered']}/{coverage[stage]['of']}" for stage in stages]
    lines += ["| covered of | " + " | ".join(totals) + " |", ""]
    lines += [f"- {stage.id}, {escaped(stage.title)}: {escaped(stage.shows)}" for stage in matrix.stages]
    if matrix.findings:
        lines += ["", "## Findings", ""]
    for finding in matrix.standing:
        place = f" `{finding.place}`" if finding.place else ""
        help_ = f" *{escaped(finding.help)}*" if finding.help else ""
        lines.append(
            f"- **{finding.level} {finding.code}**{place}: {escaped(finding.message, code=True)}{help_}"
        )
        following = matrix.following(finding)
        if following:
            lines.append(f"  - {follows(following)}")
    if matrix.waivers:
        lines += ["", "## Waivers", ""]
    for waiver in matrix.waivers:
        excused, of = waiver.stages or waiver.codes, waiver.requirements or waiver.subjects
        what = f"{', '.join(excused)} of {', '.join(of)}"
        who = f"{escaped(waiver.owner)}, approved by {escaped(waiver.approver)}"
        said = f"{escaped(what)}, {who}, {day_said(waiver.granted)} until {day_said(waiver.expires)}"
        risk = f" Residual risk: {escaped(waiver.residual_risk)}" if waiver.residual_risk else ""
        lines.append(f"- **{waiver.id}** ({said}): {escaped(waiver.justification)}{risk}")
    if matrix.unreviewed:
        lines += ["", "## Nobody has reviewed", ""]
    for kind, ids in unreviewed(matrix):
        lines.append(f"- {kind}: {escaped(', '.join(ids))}")
    if matrix.accepted:
        lines += ["", "## Accepted by name", ""]
    for accepted in matrix.accepted:
        lines.append(f"- {accepted.on}, **{escaped(accepted.by)}**: {escaped(accepted.reason)}")
        lines += [f"  - {escaped(change, code=True)}" for change in accepted.weaker]
    return "\n".join(lines) + "\n"


def escaped(text: str, code: bool = False) -> str:
    """Text in one line that Markdown leaves alone; with `code`, backquotes keep their meaning."""
    marks = "\\|<>*_[]#&~$" if code else "\\|<>*_[]#&~$`"
    plain = printable(text)
    parts = plain.split("`") if code and plain.count("`") % 2 == 0 else [plain]
    for number in range(0, len(parts), 2):
        parts[number] = "".join(f"\\{char}" if char in marks else char for char in parts[number])
    return "`".join(part.replace("|", "\\|") if number % 2 else part for number, part in enumerate(parts))
