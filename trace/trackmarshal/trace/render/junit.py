"""The gate as a report of tests: one for each cell that it demands, and one for whatever else fails it."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from trackmarshal.junit import writing
from trackmarshal.junit.writing import Line
from trackmarshal.trace.cells import Cell
from trackmarshal.trace.gates import falls_short
from trackmarshal.trace.matrix import Matrix


def render(matrix: Matrix, where: Callable[[str], str] = str) -> str:
    """The report; waived cells are skipped, with who answers for them. It verifies nothing: as evidence, it would be its own."""
    return writing.render("trackmarshal trace", [*_cells(matrix, where), *_others(matrix, where)])


def _cells(matrix: Matrix, where: Callable[[str], str]) -> Iterator[Line]:
    for stage in matrix.stages:
        for row in matrix.rows:
            cell = row.cells.get(stage.id)
            if cell is None:
                continue
            requirement = row.requirement
            short = falls_short(requirement, stage, cell, matrix.demands)
            if short is None:
                continue
            outcome, message = ("failed", short) if short else _answered(cell)
            yield Line(
                f"{stage.id} {stage.title}", str(stage.id), f"{requirement.id} {requirement.title}", outcome, message,
                "T230" if short else "", where(requirement.place.file), requirement.place.line,
            )  # fmt: skip


def _answered(cell: Cell) -> tuple[str, str]:
    if cell.status != "waived":
        return "passed", ""
    return "skipped", next(
        (f"waived by {item.name}: {item.detail}" for item in cell.items if item.kind == "waiver"),
        "waived below",
    )


def _others(matrix: Matrix, where: Callable[[str], str]) -> Iterator[Line]:
    for finding in matrix.findings:
        if finding.level == "error" and finding.code != "T230":
            file, line = (where(finding.place.file), finding.place.line) if finding.place else ("", 0)
            message = "\n".join([finding.message, *([f"help: {finding.help}"] if finding.help else [])])
            yield Line("findings", finding.code, finding.message, "failed", message, finding.code, file, line)
