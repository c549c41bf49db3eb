"""The matrix for a terminal."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.trace.cells import Cell
from trackmarshal.trace.findings import Finding
from trackmarshal.trace.matrix import Matrix, Row
from trackmarshal.trace.model import day_said
from trackmarshal.trace.render.words import SIGNS, follows, inputs, printable, tally, unreviewed
from trackmarshal.trace.verdict import FAIL, PASS, RESERVED

_COLOURS = {"covered": "32", "waived": "36", "partial": "33", "missing": "33", "stale": "35", "failed": "31"}
_LEVELS = {"error": "1;31", "warning": "1;33", "note": "1;32"}
_VERDICTS = {PASS: "1;32", RESERVED: "1;36", FAIL: "1;31"}
_TITLE = 34
#: Of each kind, so many things that nobody reviewed are named.
_NAMED = 20


def render(matrix: Matrix, *, colour: bool = False, verbose: bool = False) -> str:
    """Verdict, table, what is open, findings; those that follow from others are counted, or with `verbose` listed."""
    return "\n".join(_lines(matrix, _Paint(colour), verbose)) + "\n"


class _Paint:
    def __init__(self, colour: bool) -> None:
        self._colour = colour

    def __call__(self, code: str, text: str) -> str:
        return f"\033[{code}m{text}\033[0m" if self._colour and code else text


def _lines(matrix: Matrix, paint: _Paint, verbose: bool) -> Iterator[str]:
    word = matrix.verdict
    yield f"traceability of {printable(matrix.project) or 'a project without a name'}, {matrix.today.isoformat()}"
    yield paint(_VERDICTS[word], f"{word.upper()}") + f": {tally(matrix)}"
    yield f"from {inputs(matrix)}"
    if matrix.rows and matrix.stages:
        yield ""
        yield from _table(matrix, paint)
    open_cells = list(_open(matrix))
    if open_cells:
        yield ""
        yield "not covered:"
        yield from open_cells
    if matrix.waivers:
        yield ""
        yield "waivers:"
    for waiver in matrix.waivers:
        until = f"{printable(waiver.owner)}, approved by {printable(waiver.approver)}, {day_said(waiver.granted)} until {day_said(waiver.expires)}"
        yield f"  {waiver.id} ({until}): {printable(waiver.justification)}"
        if waiver.residual_risk:
            yield f"    residual risk: {printable(waiver.residual_risk)}"
    if matrix.unreviewed:
        yield ""
        yield "nobody has reviewed:"
    for kind, ids in unreviewed(matrix):
        named = ", ".join(map(printable, ids if verbose else ids[:_NAMED]))
        more = "" if verbose or len(ids) <= _NAMED else f" and {len(ids) - _NAMED} more"
        yield f"  {kind}: {named}{more}"
    if matrix.findings:
        yield ""
        yield "findings:"
    for finding in matrix.standing:
        yield _said(finding, paint)
        for place, label in finding.also:
            yield f"    {place}: {printable(label)}"
        if finding.help:
            yield f"    help: {printable(finding.help)}"
        following = matrix.following(finding)
        if following:
            yield f"    {follows(following)}" + ("" if verbose else "; --verbose lists them")
        for other in following if verbose else ():
            yield f"      {_said(other, paint)}"
            if other.help:  # a review that fell is one that follows, and its help has the fingerprint
                yield f"        help: {printable(other.help)}"


def _said(finding: Finding, paint: _Paint) -> str:
    where = f"{finding.place}: " if finding.place else ""
    return f"{where}{paint(_LEVELS[finding.level], f'{finding.level}[{finding.code}]')}: {printable(finding.message)}"


def _table(matrix: Matrix, paint: _Paint) -> Iterator[str]:
    names = [_name(row) for row in matrix.rows]
    width = max(len("covered of"), *map(len, names))
    columns = [(str(stage.id), max(9, len(stage.id))) for stage in matrix.stages]
    yield "  ".join(["requirement".ljust(width), *(name.ljust(size) for name, size in columns)]).rstrip()
    for name, row in zip(names, matrix.rows):
        cells = [_shown(row.cells.get(stage), size, paint) for stage, size in columns]
        yield "  ".join([name.ljust(width), *cells]).rstrip()
    coverage = matrix.coverage
    totals = [f"{coverage[stage]['covered']}/{coverage[stage]['of']}".ljust(size) for stage, size in columns]
    yield "  ".join(["covered of".ljust(width), *totals]).rstrip()


def _name(row: Row) -> str:
    title = printable(row.requirement.title)
    title = title if len(title) <= _TITLE else title[: _TITLE - 1] + "…"
    return f"{'  ' * min(row.depth, 4)}{row.requirement.id} {title}"


def _shown(cell: Cell | None, size: int, paint: _Paint) -> str:
    if cell is None:
        return "·".ljust(size)
    return paint(_COLOURS[cell.status], f"{SIGNS[cell.status]} {cell.status}".ljust(size))


def _open(matrix: Matrix) -> Iterator[str]:
    """The cells that are not covered, each with what keeps it from being so."""
    for row in matrix.rows:
        for stage, cell in row.cells.items():
            if cell.status == "covered":
                continue
            waiver = next((item.name for item in cell.items if item.kind == "waiver"), "")
            items = [item for item in cell.items if item.status != "covered" and item.kind != "waiver"]
            if waiver:
                yield f"  {row.requirement.id} {stage} waived by {waiver}"
                continue
            yield f"  {row.requirement.id} {stage} {cell.status}" + (
                "" if items else ": there is nothing that counts here"
            )
            for item in items[:6]:
                detail = (
                    f": {printable(item.detail)}"
                    if item.detail and item.kind != "requirement"
                    else f": {item.status}"
                )
                title = f' "{printable(item.title)}"' if item.kind == "test" and item.title else ""
                yield f"    {item.kind} {printable(item.name)}{title}{detail}"
            if len(items) > 6:
                yield f"    and {len(items) - 6} more"
