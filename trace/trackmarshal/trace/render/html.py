"""The matrix as one self-contained HTML page, on which one walks from anything to anything; without a script, a table of the cells still stands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING
from urllib.parse import quote

from trackmarshal.trace import look, verdict
from trackmarshal.trace.baseline import Change, changes
from trackmarshal.trace.codes import CODES
from trackmarshal.trace.findings import LEVELS, Finding
from trackmarshal.trace.graph.graph import Graph
from trackmarshal.trace.graph.kinds import NODES
from trackmarshal.trace.graph.statistics import grouped, numbers
from trackmarshal.trace.matrix import Matrix
from trackmarshal.trace.model import Stage
from trackmarshal.trace.render.page.beside import Beside, Compared
from trackmarshal.trace.render.page.content import content, dumped
from trackmarshal.trace.render.words import MEANINGS, SIGNS, follows, inputs, tally, unreviewed

if TYPE_CHECKING:
    from markupsafe import Markup

#: What one mostly walks: rows of a kind against another one; requirements against stages.
WAYS = (
    ("requirement", ""), ("requirement", "rule"), ("rule", "requirement"), ("test", "rule"), ("parameter", "rule"), ("run", "requirement"),
    ("assumption", "requirement"),
)  # fmt: skip
#: What a baseline calls kinds of nodes that have another name here.
_ENTRIES = {"param": "parameter", "evidence": "document"}


def render(matrix: Matrix, beside: Beside | None = None) -> str:
    """The page."""
    from markupsafe import Markup

    environment = look.environment(Path(__file__).parent / "page" / "templates")
    given = beside or Beside()
    compared = given.compared or _since_accepted(matrix)
    kinds = matrix.graph.by_kind
    page = environment.get_template("matrix.html.j2").render(
        matrix=matrix,
        index=given.index,
        verdict=matrix.verdict,
        look=verdict.LOOKS[matrix.verdict],
        sign=verdict.SIGNS[matrix.verdict],
        tally=tally(matrix),
        unreviewed=unreviewed(matrix),
        inputs=inputs(matrix),
        signs=SIGNS,
        meanings=MEANINGS,
        levels=[(level, [f for f in matrix.standing if f.level == level]) for level in LEVELS],
        following=_following(matrix),
        ids={finding: number for number, finding in enumerate(matrix.findings, 1)},
        follows=follows,
        titles={code: title for code, (title, _) in CODES.items()},
        ways=[(kind, other) for kind, other in WAYS if kind in kinds and (not other or other in kinds)],
        rows=Markup("\n").join(_rows(matrix)),
        bars=bars,
        numbers=list(_numbers(matrix)),
        compared=compared,
        differences=[_difference(change, matrix.graph) for change in compared.changes] if compared else [],
        data=Markup(dumped(content(matrix, given))),  # nothing in it ends the element that it stands in
    )  # fmt: skip
    return page.rstrip() + "\n"


def bars(matrix: Matrix) -> list[tuple[Stage, dict[str, int], int]]:
    """For each stage: how many cells of each status, best first, and how many in all."""
    table = []
    for stage in matrix.stages:
        count = matrix.coverage[stage.id]
        table.append((stage, {status: count[status] for status in SIGNS if count[status]}, count["of"]))
    return table


def _rows(matrix: Matrix) -> Iterator[Markup]:
    """The rows of the table that stands without a script."""
    from markupsafe import Markup, escape

    told = {
        status: Markup('<td class="is-{}">{} {}</td>').format(status, sign, status)
        for status, sign in SIGNS.items()
    }
    nothing = Markup("<td>–</td>")
    line = Markup('<tr><th class="name" style="--depth: {}"><b>{}</b> {}</th>{}</tr>')
    for row in matrix.rows:
        cells = Markup("").join(
            told[row.cells[stage.id].status] if stage.id in row.cells else nothing for stage in matrix.stages
        )
        yield line.format(row.depth, escape(str(row.requirement.id)), row.requirement.title, cells)


def _following(matrix: Matrix) -> Mapping[Finding, Sequence[Finding]]:
    """By finding, what follows from it."""
    found: dict[Finding, list[Finding]] = {}
    for finding in matrix.findings:
        cause = matrix.causes.get(finding)
        if cause is not None:
            found.setdefault(cause, []).append(finding)
    return found


#: A table of numbers: its heading, what is in its columns, and lines of an address, a name and numbers.
Table = tuple[str, Sequence[str], Sequence[tuple[str, str, Sequence[int]]]]


def _numbers(matrix: Matrix) -> Iterator[Table]:
    """What `trace --statistics` counts."""
    counted = grouped(numbers(matrix))
    yield (
        "Cells by stage",
        ("stage", "asked", *SIGNS),
        [
            (f"#stage={quote(stage)}", stage, [of["all"], *(of.get(status, 0) for status in SIGNS)])
            for stage, of in counted.get("stages", {}).items()
        ],
    )
    yield (
        "Requirements by ASIL",
        ("ASIL", "demanded", "with no open cell"),
        [
            (f"#asil={quote(level)}", level, [of["all"], of["with no open cell"]])
            for level, of in counted.get("requirements by ASIL", {}).items()
        ],
    )
    kinds = counted.get("nodes", {})
    outcomes = sorted({what for of in kinds.values() for what in of} - {"all", "without a link"})
    yield (
        "What came of it",
        ("kind", "in all", *outcomes),
        [
            (f"#kind={quote(kind)}", kind, [of["all"], *(of.get(what, 0) for what in outcomes)])
            for kind, of in kinds.items()
            if of.keys() & set(outcomes)
        ],
    )
    yield (
        "Kinds of things",
        ("kind", "in all", "without a link"),
        [
            (f"#kind={quote(kind)}", kind, [of["all"], of.get("without a link", 0)])
            for kind, of in kinds.items()
        ],
    )
    ways = counted.get("links", {})
    states = sorted({what for of in ways.values() for what in of} - {"all", "covers"})
    yield (
        "Kinds of links",
        ("link", "in all", *states),
        [
            ("", way.replace("_", " "), [of["all"], *(of.get(state, 0) for state in states)])
            for way, of in ways.items()
        ],
    )


def _since_accepted(matrix: Matrix) -> Compared | None:
    """The difference from the accepted baseline; None where there is none."""
    if matrix.baseline is None:
        return None
    last = matrix.baseline.acceptances[-1] if matrix.baseline.acceptances else None
    before = f"the baseline accepted on {last.on}" if last else "the accepted baseline"
    return Compared(before, "what is here", tuple(changes(matrix.baseline.content, matrix.content)))


def _difference(change: Change, graph: Graph) -> tuple[Change, str, str]:
    """A change, where on the page the thing is that changed (empty where it is gone, or is none), and how it changed."""
    kind = _ENTRIES.get(change.kind, change.kind.replace("-", " "))
    name = change.name.rpartition(" at ")[0] if change.kind == "evidence" else change.name
    there = kind in NODES and (kind, name) in graph.nodes
    return (
        change,
        f"#at={quote(f'{kind}:{name}', safe='')}" if there else "",
        str(change).removeprefix(change.key).lstrip(": "),
    )


__all__ = ["WAYS", "bars", "render"]
