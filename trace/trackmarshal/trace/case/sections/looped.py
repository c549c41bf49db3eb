"""Runs in a closed loop: what became of the car by fault and situation, what found the fault, and how soon."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence

from trackmarshal.trace.case.charts import Cell, Legend, grid
from trackmarshal.trace.case.loop import OUTCOMES, Loop, LoopRun
from trackmarshal.trace.case.model import (
    TEXT_WIDTH,
    Block,
    Code,
    Figure,
    Fixed,
    Given,
    Line,
    Number,
    Part,
    Status,
)
from trackmarshal.trace.case.writing import EMPTY, Writing, joined

#: So many points wide are the names of faults.
_NAMES = 160.0


def closed_loop(writing: Writing) -> Iterator[Block]:
    """Counts, a chart of all runs, and a row a fault."""
    loop = writing.given.loop
    if loop is None:
        yield writing.missing("loop.none")
        return
    key = ("document", loop.path)
    yield writing.paragraph("loop.made", file=writing.ref(key), sha=Code(loop.sha256))
    yield _standing(writing, loop)
    inside = [run for run in loop.runs if not run.beyond]
    bad = [run for run in inside if OUTCOMES[run.outcome] == "failed"]
    yield writing.facts([
        ("label.runs", (_number("all/runs", len(loop.runs)),)),
        ("label.runs_inside", (_number("inside/runs", len(inside)),)),
        ("label.runs_bad", (_number("inside/bad", len(bad)),)),
    ])  # fmt: skip
    faults = list(dict.fromkeys(run.fault for run in sorted(loop.runs, key=lambda run: (run.beyond != "", run.fault != "none", run.fault))))  # fmt: skip
    by_fault = {fault: [run for run in loop.runs if run.fault == fault] for fault in faults}
    yield _chart(writing, loop, by_fault)
    yield _table(writing, loop, by_fault)


def _standing(writing: Writing, loop: Loop) -> Block:
    """Whether these are the results that somebody has reviewed, as evidence of their own or by pages that give their hash."""
    reviewed = [entry.path for entry in writing.given.project.evidence if entry.sha256]
    files = list(dict.fromkeys([*(path for path in reviewed if path == loop.path), *loop.pages]))
    for file in files:
        key = ("document", file)
        if writing.graph.nodes[key].attributes["outcome"] == "changed":
            return writing.paragraph("loop.changed", status=Status("stale"), file=writing.ref(key))
        if not loop.pages.get(file, True):
            return writing.paragraph("loop.other", status=Status("stale"), file=writing.ref(key))
    if not files:
        return writing.missing("loop.unreviewed")
    return writing.paragraph("loop.reviewed", files=writing.refs([("document", file) for file in files]))


def _chart(writing: Writing, loop: Loop, by_fault: dict[str, list[LoopRun]]) -> Part:
    """Rows are faults, columns situations; a cell has the mark of what became of the car, and its speed when the fault began."""
    situations = sorted({(run.track, run.traffic, run.place) for run in loop.runs})
    traffic = {kind: writing.words["loop.cars" if kind else "loop.alone"] for kind in (False, True)}
    heads = [
        [track for track, _, _ in situations],
        [traffic[cars] for _, cars, _ in situations],
        [place for _, _, place in situations],
    ]
    cells: dict[tuple[int, int], Cell] = {}
    ranks = list(OUTCOMES)
    for row, (fault, runs) in enumerate(by_fault.items()):
        # Of several in one situation, the worst one is seen: it is drawn last.
        for run in sorted(runs, key=lambda run: ranks.index(run.outcome)):
            column = situations.index((run.track, run.traffic, run.place))
            mark, came = writing.words[f"loop.mark.{run.outcome}"], writing.words[f"loop.{run.outcome}"]
            said = f"{fault}, {run.track}, {traffic[run.traffic]}, {run.speed:.1f} m/s: {came}"
            cells[row, column] = Cell(f"{mark} {run.speed:.0f}", OUTCOMES[run.outcome], said)
    name = writing.words["loop.figure"]
    present = {run.outcome for run in loop.runs}
    legend = [Legend(writing.words[f"loop.mark.{o}"], look, writing.words[f"loop.{o}"]) for o, look in OUTCOMES.items() if o in present]  # fmt: skip
    rows = [(fault, loop.titles.get(fault, "")) for fault in by_fault]
    svg, wide, high = grid(name, heads, rows, cells, legend, TEXT_WIDTH, _NAMES)
    return writing.named("loop.outcomes", [Figure(svg, name, wide, high)], level=3)


def _table(writing: Writing, loop: Loop, by_fault: dict[str, list[LoopRun]]) -> Part:
    columns = (
        ("column.fault", 3.3), ("column.requirement", 1.2), ("column.runs", 0.6), ("column.found_by", 2.2), ("column.reaction", 1.5), ("column.outcome", 2.5),
        ("column.clearance", 1.2), ("column.gap", 1.0),
    )  # fmt: skip
    rows = [_row(writing, loop, fault, runs) for fault, runs in by_fault.items()]
    return writing.named("loop.faults", [writing.table(columns, rows)], level=3)


def _row(writing: Writing, loop: Loop, fault: str, runs: Sequence[LoopRun]) -> list[Line]:
    beyond = runs[0].beyond
    title: Line = (Code(fault), Fixed(" "), Given(loop.titles.get(fault, "")))
    if beyond:
        title = (*title, Fixed(" "), *writing.line("loop.beyond", assumption=writing.ref(("assumption", beyond))))  # fmt: skip
    found = Counter(run.found for run in runs if run.after is not None and run.found)
    finders = joined([(Given(by), Fixed(" "), _number(f"{fault}/found/{by}", number)) for by, number in _most(found)])  # fmt: skip
    below = sum(run.below for run in runs)
    if below:
        finders = joined([finders, (*writing.line("loop.below"), Fixed(" "), _number(f"{fault}/below", below))])  # fmt: skip
    came = Counter(run.outcome for run in runs)
    outcomes = joined([(Fixed(writing.words[f"loop.{o}"]), Fixed(" "), _number(f"{fault}/{o}", number)) for o, number in _most(came)])  # fmt: skip
    gaps = [run.gap for run in runs if run.gap is not None]
    requirement = (writing.ref(("requirement", runs[0].requirement)),) if runs[0].requirement else EMPTY
    return [
        title, requirement, (_number(f"{fault}/runs", len(runs)),), finders or writing.line("loop.nothing"), _reaction(writing, fault, runs), outcomes,
        (Number(f"loop/{fault}/clearance", f"{min(run.clearance for run in runs):.2f}"), Fixed(" m")),
        (Number(f"loop/{fault}/gap", f"{min(gaps):.1f}"), Fixed(" m")) if gaps else EMPTY,
    ]  # fmt: skip


def _reaction(writing: Writing, fault: str, runs: Sequence[LoopRun]) -> Line:
    times = sorted(run.after for run in runs if run.after is not None)
    if not times:
        return EMPTY
    least, most = (Number(f"loop/{fault}/reaction/{name}", f"{time:.2f}") for name, time in (("least", times[0]), ("most", times[-1])))  # fmt: skip
    return (least, Fixed(" s")) if times[0] == times[-1] else writing.line("loop.reaction", least=least, most=most)  # fmt: skip


def _most(counts: Counter[str]) -> list[tuple[str, int]]:
    return sorted(counts.items(), key=lambda pair: (-pair[1], pair[0]))


def _number(id_: str, value: int) -> Number:
    return Number(f"loop/{id_}", str(value))


__all__ = ["closed_loop"]
