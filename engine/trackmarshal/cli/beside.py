"""What the matrix page shows beside the matrix, from the project's specs, its evidence store, and the pages of its runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from trackmarshal.cli.assessment import Assessment
    from trackmarshal.trace import Matrix
    from trackmarshal.trace.render.page.beside import Beside

#: So many letters of pictures a page holds: those of thousands of rules would be most of it.
DRAWN = 2_000_000


def page_beside(
    found: Assessment, matrix: Matrix, against: str | None = None, pages: Mapping[str, str] | None = None, index: str = ""
) -> Beside:  # fmt: skip
    """All of it. pages: by scenario, the address of its run's page. index: of the page above. Raises T361 and T364 for `against`."""
    from trackmarshal.cli.against import compared
    from trackmarshal.cli.sheets import sheets
    from trackmarshal.trace.render.page.beside import Beside

    told = None if against is None else compared(against, found.root, found.project, matrix)
    broken = any(finding.level == "error" for finding in found.facts.findings)
    # Of specs with errors, the matrix says what is wrong; their rules are named there, and not explained.
    said = (
        None
        if broken
        else sheets(found.root, found.project, found.compiled, found.facts.state, found.compiled_first)
    )
    drawn, undrawn = ({}, {}) if said is None else _drawings(found, said.rules)
    return Beside(
        sheets={} if said is None else said.rules, drawings=drawn, undrawn=undrawn, clauses={} if said is None else said.clauses, tests={} if said is None else said.tests,
        runs=found.runs, entries=found.entries(), pages=pages or {}, index=index, compared=told,
    )  # fmt: skip


def _drawings(
    found: Assessment, sheets: Mapping[str, Mapping[str, Any]]
) -> tuple[dict[str, str], dict[str, str]]:
    """Pictures that are kept, in the order of the specs, and why there is none of some; nothing is drawn, which takes seconds.

    What is in neither is drawn by whoever asks for it.
    """
    from trackmarshal.cli.drawing import kept_drawings
    from trackmarshal.trace.case.words.language import english
    from trackmarshal.trace.report.svg.boundary import picture

    drawn: dict[str, str] = {}
    undrawn: dict[str, str] = {}
    room = DRAWN
    for name, drawing in kept_drawings(found.root, found.facts, sheets).items():
        if "none" in drawing:
            undrawn[name] = english()[f"drawing.none.{drawing['none']}"]
        elif room > 0:
            svg = picture(drawing, english(), "boundary").svg
            room -= len(svg)
            if room >= 0:
                drawn[name] = svg
    return drawn, undrawn


__all__ = ["page_beside"]
