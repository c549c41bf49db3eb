"""What the matrix page shows beside the matrix, from the project's specs, its evidence store, and the pages of its runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trackmarshal.cli.assessment import Assessment
    from trackmarshal.trace import Matrix
    from trackmarshal.trace.render.page.beside import Beside


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
    return Beside(
        sheets={} if said is None else said.rules, clauses={} if said is None else said.clauses, tests={} if said is None else said.tests,
        runs=found.runs, entries=found.entries(), pages=pages or {}, index=index, compared=told,
    )  # fmt: skip


__all__ = ["page_beside"]
