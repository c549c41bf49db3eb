"""The matrix for people and machines: one module a format, one verdict in all of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from trackmarshal.trace.matrix import Matrix

if TYPE_CHECKING:
    from trackmarshal.trace.render.page.beside import Beside

FORMATS = ("text", "json", "csv", "md", "html", "sarif", "github", "junit")


def render(
    matrix: Matrix,
    format: str = "text",
    *,
    colour: bool = False,
    where: Callable[[str], str] | None = None,
    verbose: bool = False,
    beside: Beside | None = None,
) -> str:
    """The matrix in one of FORMATS; `colour` and `verbose` (what follows from findings, too) are for text on a terminal, `where` what paths are called in SARIF, annotations and JUnit;
    `beside` what the page shows beside the matrix.

    Raises ValueError for another format.
    """
    called = where or str
    match format:
        case "text":
            from trackmarshal.trace.render import text

            return text.render(matrix, colour=colour, verbose=verbose)
        case "json":
            from trackmarshal.trace.render import data

            return data.render(matrix)
        case "csv":
            from trackmarshal.trace.render import table

            return table.render_csv(matrix)
        case "md":
            from trackmarshal.trace.render import table

            return table.render_markdown(matrix)
        case "html":
            from trackmarshal.trace.render import html

            return html.render(matrix, beside)
        case "sarif":
            from trackmarshal.trace.render import exchange

            return exchange.render_sarif(matrix, called)
        case "github":
            from trackmarshal.trace.render import exchange

            return exchange.render_github(matrix, called)
        case "junit":
            from trackmarshal.trace.render import junit

            return junit.render(matrix, called)
        case _:
            raise ValueError(f"unknown format {format!r}, known are {', '.join(FORMATS)}")
