"""The gate: which cells have to be covered, and what a waiver excuses."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import date

from trackmarshal.trace.cells import Cell, Item
from trackmarshal.trace.findings import Finding, error
from trackmarshal.trace.model import Demand, Project, Requirement, Stage, Waiver, day_said, matches
from trackmarshal.trace.values import Placed

#: Findings that somebody may answer for. All others are mistakes, to be mended.
WAIVABLE = frozenset({"T207", "T208", "T211", "T212", "T252", "T253", "T254", "T255"})
#: Cells that a waiver may excuse. What failed, or is stale, is never excused.
GAPS = frozenset({"missing", "partial"})


class Waivers:
    """The waivers that hold today, and which of them were needed."""

    def __init__(self, project: Project, today: date) -> None:
        self._all = project.waivers
        self._today = today
        self._holding = [w for w in project.waivers if w.holds(today)]
        self._used: set[str] = set()

    def cell(self, cell: Cell, requirement: Requirement, stage: Stage) -> Cell:
        """The cell, waived where it is a gap that somebody answers for."""
        if cell.status not in GAPS:
            return cell
        waiver = self._first(
            w for w in self._holding if stage.id in w.stages and matches(requirement.id, w.requirements)
        )
        if waiver is None:
            return cell
        detail = f"{waiver.owner}, {day_said(waiver.granted)} until {day_said(waiver.expires)}: {waiver.justification}"
        item = Item("waiver", waiver.id, "", "waived", detail, waiver.id.place)
        return Cell("waived", (item, *cell.items))

    def finding(self, found: Finding) -> Finding:
        """The finding, as a note where somebody answers for it."""
        if found.code not in WAIVABLE or found.level == "note":
            return found
        waiver = self._first(
            w for w in self._holding if found.code in w.codes and matches(found.subject, w.subjects)
        )
        if waiver is None:
            return found
        message = f"{found.message} (waived by {waiver.id} until {day_said(waiver.expires)}: {waiver.justification})"
        return replace(found, level="note", message=message, excused=True)

    def _first(self, fitting: Iterable[Waiver]) -> Waiver | None:
        """The first waiver of a gap, None where there is none. All of them are needed: one is granted anew before the other ends."""
        waivers = list(fitting)
        self._used.update(waiver.id for waiver in waivers)
        return waivers[0] if waivers else None

    def check(self, cells: Mapping[str, Mapping[str, Cell]]) -> Iterator[Finding]:
        """What is wrong with the waivers themselves (T231 to T233)."""
        for waiver in self._all:
            place, name = waiver.id.place, str(waiver.id)
            if waiver.granted is None or waiver.expires is None:
                continue  # a day that cannot be read was reported where it stands
            if waiver.expires < self._today:
                message = f"the waiver `{name}` expired on {waiver.expires}"
                yield error("T231", message, place, "close the gap, or have it granted anew", name)
            elif waiver.granted > self._today:
                yield error(
                    "T231",
                    f"the waiver `{name}` holds from {waiver.granted} on",
                    place,
                    "correct the date",
                    name,
                )
            elif waiver.id not in self._used:
                yield Finding(
                    "T232", "warning", f"the waiver `{name}` excuses nothing", place, "strike it: the gap is closed", name,
                    rests_on=tuple(dict.fromkeys(_excused(waiver, cells))),
                )  # fmt: skip
            elif closed := _closed(waiver, cells):
                parts = ", ".join(f"`{part}`" for part in closed)
                yield Finding(
                    "T232", "warning", f"the waiver `{name}` excuses nothing of {parts}", closed[0].place,
                    "strike it there: the gap is closed, and one that opens later is excused", name, rests_on=tuple(map(str, closed)),
                )  # fmt: skip
            for code in waiver.codes:
                if code not in WAIVABLE:
                    help_ = "findings that can be waived: " + ", ".join(sorted(WAIVABLE))
                    yield error("T233", f"`{code}` cannot be waived", code.place, help_, name)


def _excused(waiver: Waiver, cells: Mapping[str, Mapping[str, Cell]]) -> Iterator[str]:
    """What a waiver is about: the items of its cells, its requirements, which may be gone, or its subjects."""
    yield from map(str, (*waiver.subjects, *waiver.requirements, *(f"at {stage}" for stage in waiver.stages)))
    for id_, row in cells.items():
        if matches(id_, waiver.requirements):
            yield id_
            yield from (
                item.name for stage, cell in row.items() if stage in waiver.stages for item in cell.items
            )


def _closed(waiver: Waiver, cells: Mapping[str, Mapping[str, Cell]]) -> list[Placed]:
    """The requirements and stages of a waiver all of whose cells are covered; what failed, or is stale, may be a gap again when that is mended."""

    def covered(requirements: Iterable[Placed], stages: Iterable[Placed]) -> bool:
        about = [row for id_, row in cells.items() if matches(id_, requirements)]
        found = {row[stage].status for row in about for stage in stages if stage in row}
        return found == {"covered"}

    closed = [one for one in waiver.requirements if covered([one], waiver.stages)]
    if len(closed) < len(waiver.requirements):  # else no stage has more to say
        closed += [one for one in waiver.stages if covered(waiver.requirements, [one])]
    return closed


def check(project: Project, cells: Mapping[str, Mapping[str, Cell]]) -> Iterator[Finding]:
    """A finding for every cell that is less covered than the gate demands (T230)."""
    stages = {str(stage.id): stage for stage in project.stages}
    wanted_of = demands(project)
    for requirement in project.by_id.values():
        for name, cell in cells.get(requirement.id, {}).items():
            message = falls_short(requirement, stages[name], cell, wanted_of)
            if message:
                items = (item.name for item in cell.items if item.status not in ("covered", "waived"))
                excused = (
                    w.id
                    for w in project.waivers
                    if name in w.stages and matches(requirement.id, w.requirements)
                )
                rests_on = tuple(dict.fromkeys(map(str, (*items, *excused, f"at {name}"))))
                yield Finding(
                    "T230", "error", message, requirement.place, "", str(requirement.id), rests_on=rests_on
                )


def demands(project: Project) -> tuple[Demand, ...]:
    """What the gate demands of cells: without a gate, that all are covered."""
    return project.gate or tuple(
        Demand(stage.id, (Placed.at("*", stage.id.place),), "covered") for stage in project.stages
    )


def falls_short(requirement: Requirement, stage: Stage, cell: Cell, demands: Sequence[Demand]) -> str | None:
    """How a cell is less covered than is demanded; empty when it is not, None when nothing is demanded of it."""
    wanted = [d.at_least for d in demands if d.stage == stage.id and matches(requirement.id, d.requirements)]
    if not wanted:
        return None
    if cell.status in ("covered", "waived") or (cell.status == "partial" and "covered" not in wanted):
        return ""
    degree = "covered" if "covered" in wanted else "at least partial"
    return f"`{requirement.id}` at {stage.id} ({stage.title}): {cell.status}, wanted {degree}; {_why(cell)}"


def _said(item: Item) -> str:
    if item.kind == "requirement" or not item.detail:
        return f"is {item.status}"
    return f'"{item.title}": {item.detail}' if item.kind == "test" else f"is {item.status}: {item.detail}"


def _why(cell: Cell) -> str:
    """The first items that keep a cell from being covered."""
    open_ = [item for item in cell.items if item.status not in ("covered", "waived")]
    if not open_:
        return "there is nothing that counts here"
    shown = [f"{item.kind} `{item.name}` {_said(item)}" for item in open_[:3]]
    more = f"; and {len(open_) - 3} more" if len(open_) > 3 else ""
    return f"{'; '.join(shown)}{more}"
