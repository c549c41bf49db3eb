"""The matrix as one self-contained HTML page: no network, no script, light and dark, phone and desktop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from trackmarshal.trace import verdict
from trackmarshal.trace.cells import Cell, Item
from trackmarshal.trace.codes import CODES
from trackmarshal.trace.findings import LEVELS
from trackmarshal.trace.matrix import Matrix, Row
from trackmarshal.trace.model import Stage
from trackmarshal.trace.render.words import MEANINGS, SIGNS, follows, inputs, tally

#: The colours of a verdict, which are those of a status of cells.
_LOOKS = {verdict.PASS: "covered", verdict.RESERVED: "waived", verdict.FAIL: "failed"}


@dataclass(frozen=True, slots=True)
class Group:
    """Items of one kind in a cell; tests by the rule that they test."""

    heading: str
    items: tuple[Item, ...]

    @property
    def folded(self) -> bool:
        """Whether these are many tests and none of them needs attention."""
        return len(self.items) > 3 and all(
            item.kind in ("test", "external test") and item.status == "covered" for item in self.items
        )


def render(matrix: Matrix) -> str:
    """The page."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["marked"] = marked
    page = environment.get_template("matrix.html.j2").render(
        matrix=matrix,
        verdict=matrix.verdict,
        look=_LOOKS[matrix.verdict],
        sign=verdict.SIGNS[matrix.verdict],
        tally=tally(matrix),
        inputs=inputs(matrix),
        signs=SIGNS,
        meanings=MEANINGS,
        levels=[(level, [f for f in matrix.standing if f.level == level]) for level in LEVELS],
        follows=follows,
        titles={code: title for code, (title, _) in CODES.items()},
        cells=cells,
        groups=groups,
        open_=is_open,
        gaps=sum(map(is_open, matrix.rows)),
        bars=bars,
    )
    return page.rstrip() + "\n"


def marked(text: str) -> str:
    """Text, escaped, with what stands between backquotes as code."""
    from markupsafe import Markup, escape

    parts = text.split("`")
    if len(parts) % 2 == 0:  # a backquote without its partner
        return escape(text)
    return Markup("").join(
        Markup("<code>{}</code>").format(part) if number % 2 else escape(part)
        for number, part in enumerate(parts)
    )


def cells(matrix: Matrix, row: Row) -> list[tuple[Stage, Cell | None]]:
    return [(stage, row.cells.get(stage.id)) for stage in matrix.stages]


def is_open(row: Row) -> bool:
    """Whether a cell of the row is neither covered nor waived."""
    return any(cell.status not in ("covered", "waived") for cell in row.cells.values())


def groups(items: Sequence[Item]) -> list[Group]:
    """Items by kind; tests by rule."""
    found: dict[tuple[str, str], list[Item]] = {}
    for item in items:
        found.setdefault((item.kind, item.name if item.kind == "test" else ""), []).append(item)
    return [
        Group(f"tests of {name}" if name else kind, tuple(members)) for (kind, name), members in found.items()
    ]


def bars(matrix: Matrix) -> list[tuple[Stage, dict[str, int], int]]:
    """For each stage: how many cells of each status, best first, and how many in all."""
    table = []
    for stage in matrix.stages:
        count = matrix.coverage[stage.id]
        table.append((stage, {status: count[status] for status in SIGNS if count[status]}, count["of"]))
    return table
