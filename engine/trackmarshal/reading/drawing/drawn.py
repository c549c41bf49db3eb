"""The boundary of a rule's demand as plain data, for whoever puts it into a picture.

Places are shares of the picture, from 0 to 1, x to the right and y up. With one input, y says nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.errors import TrackmarshalError
from trackmarshal.ir import nodes as ir
from trackmarshal.reading.drawing.choosing import Known, Standing, nearer, ranked, typical, window
from trackmarshal.reading.drawing.contour import Grid, Says, lines
from trackmarshal.reading.drawing.demand import BROKEN, HOLDS, UNKNOWN, Demand, Floats
from trackmarshal.reading.drawing.quantities import Quantity
from trackmarshal.reading.drawing.recorded import thinned
from trackmarshal.runtime.frame import NO_SETTINGS, Settings
from trackmarshal.units import about, from_si, in_full, parse_unit, written

CODES = {
    "E493": (
        "an input that a drawing cannot have",
        "`--over` and `--against` name inputs of what the rule requires: a field (`v`, `p.v`), what a definition or a `let` measures (`gap_lon`), "
        "or a parameter that it reads; two different ones.",
    ),
}
#: Cells of the grid on which regions are looked for, across and up; and of that for the boundary of one test.
_CELLS, _OWN = (160, 120), (40, 30)
#: How often a window is made smaller, so that nothing is thinner than a cell.
_TIMES = 8
#: What a region is called.
_REGIONS = ((HOLDS, "holds"), (BROKEN, "broken"), (UNKNOWN, "unknown"))
#: How many tests have a boundary of their own drawn; and digits of places, a hundredth of a pixel.
_LETTERS, _DIGITS = "abcdefgh", 5
#: By how much, relative to itself, an input may differ from what is drawn and be called the same.
_SAME = 1e-9


def asked(demand: Demand, over: str | None, against: str | None, known: Known) -> list[int]:
    """The numbers of the inputs that are drawn, the one to the right first: those asked for, and of the others the most telling ones. Raises E493."""
    chosen = [None if name is None else _named(demand, name) for name in (over, against)]
    if chosen[0] is not None and chosen[0] == chosen[1]:
        raise _bad(demand, f"`{over}` and `{against}` are one input")
    others = [number for number in ranked(demand, known) if number not in chosen]
    up = others.pop(0) if chosen[1] is None and others else chosen[1]
    right = others.pop(0) if chosen[0] is None and others else chosen[0]
    return [number for number in (right, up) if number is not None]


def _named(demand: Demand, name: str) -> int:
    found = [number for number, one in enumerate(demand.quantities) if name in one.names]
    if len(found) == 1:
        return found[0]
    if found:
        labels = ", ".join(demand.quantities[number].label for number in found)
        raise _bad(demand, f"`{name}` may be {labels}")
    raise _bad(demand, f"`{demand.rule.name}` has no input `{name}`", name)


def _bad(demand: Demand, message: str, name: str = "") -> TrackmarshalError:
    rule, known = demand.rule, [one for quantity in demand.quantities for one in quantity.names]
    help_ = (
        close_matches(name, known) if name else ""
    ) or f"it has {', '.join(one.label for one in demand.quantities)}"
    return TrackmarshalError("E493", message, file=str(rule.span.file.path), line=rule.span.line, help=help_)


def drawn(demand: Demand, axes: Sequence[int], known: Known) -> dict[str, Any]:
    """The drawing. axes: numbers of one or two inputs, the one to the right first."""
    fixed = typical(demand, known)
    plane = _Plane(demand, axes, window(demand, axes, fixed, known))
    grid = plane.grid(fixed, NO_SETTINGS, _CELLS)
    for _ in range(_TIMES):
        if not grid.hides():
            break
        plane = _Plane(demand, axes, nearer(plane.spans, axes, fixed, known))
        grid = plane.grid(fixed, NO_SETTINGS, _CELLS)
    borders = {name: grid.borders(code) for code, name in _REGIONS}
    tests, others = _tests(plane, fixed, known.tests)
    made: dict[str, Any] = {
        "rule": demand.rule.name,
        "axes": [_axis(demand, number, span) for number, span in zip(axes, plane.spans)],
        "fixed": [
            [one.label, _shown(demand, one, fixed[number])] for number, one in enumerate(demand.quantities) if number not in axes
        ],
        "regions": {
            name: {"around": [_rounded(one.corners) for one in borders[name]], "in": _place(grid.widest(code))}
            for code, name in _REGIONS
        },
        "boundary": [_rounded(line) for one in borders["broken"] for line in lines(one, HOLDS)],
        "tests": tests,
        "others": others,
        "hides": grid.hides() or demand.exact(axes),
        "recorded": None,
    }  # fmt: skip
    if known.recorded is not None:
        kept = thinned(known.recorded, axes, plane.spans)
        made["recorded"] = {
            "held": _rounded(kept.held.tolist()), "broken": _rounded(kept.broken.tolist()), "seen": list(kept.seen),
            "beyond": list(kept.beyond), "lost": known.recorded.lost,
        }  # fmt: skip
    return made


class _Plane:
    """What a demand comes to in a picture."""

    def __init__(self, demand: Demand, axes: Sequence[int], spans: Sequence[tuple[float, float]]) -> None:
        self.demand, self.axes, self.spans = demand, axes, spans

    def says(self, fixed: Floats, settings: Settings) -> Says:
        """Of places in the picture, with all other inputs fixed."""

        def says(*places: Floats) -> Any:
            columns = [np.full(places[0].size, value) for value in fixed]
            for number, (low, high), share in zip(self.axes, self.spans, places):
                columns[number] = low + share * (high - low)
            return self.demand.judge(columns, settings)[0]

        return says

    def grid(self, fixed: Floats, settings: Settings, cells: tuple[int, int]) -> Grid:
        """With one input, what is said is the same all the way up."""
        return Grid(self.says(fixed, settings), cells[0] if len(self.axes) > 1 else 4 * cells[0], cells[1] if len(self.axes) > 1 else 1)  # fmt: skip

    def place(self, values: Floats) -> tuple[list[float], bool]:
        """Where values of all inputs lie in the picture, and whether that is at its edge as they lie beyond."""
        shares = [(values[number] - low) / (high - low) for number, (low, high) in zip(self.axes, self.spans)]
        shares += [0.5] * (2 - len(shares))
        inside = [min(max(float(share), 0.0), 1.0) for share in shares]
        return _rounded([inside])[0], inside != shares


def _tests(
    plane: _Plane, fixed: Floats, tests: Sequence[Standing]
) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """The tests as marks; and the boundaries of those on one that is not the one drawn, as they have other parameters or other inputs."""
    marks, others = list[dict[str, Any]](), dict[str, dict[str, Any]]()
    for test in tests:
        place, beyond = plane.place(test.values)
        unlike = ", ".join(_unlike(plane, fixed, test))
        if unlike and test.boundary and unlike not in others and len(others) < len(_LETTERS):
            own = test.values.copy()
            borders = plane.grid(own, test.settings, _OWN).borders(BROKEN)
            found = [_rounded(line) for one in borders for line in lines(one, HOLDS)]
            others[unlike] = {"letter": _LETTERS[len(others)], "with": unlike, "boundary": found}
        letter = others[unlike]["letter"] if test.boundary and unlike in others else ""
        marks.append(
            {"title": test.title, "at": place, "beyond": beyond, "expects": test.expects, "boundary": test.boundary, "alike": not unlike, "letter": letter}
        )  # fmt: skip
    return marks, list(others.values())


def _unlike(plane: _Plane, fixed: Floats, test: Standing) -> list[str]:
    """In which parameters and inputs a test differs from what is drawn."""
    demand = plane.demand
    reads, told = demand.params, list[str]()
    for name, value in sorted(test.settings.params.items()):
        info = demand.spec.params[name]
        if (
            name in reads
            and value != info.value
            and not any(one.field == ("", name) for one in demand.quantities)
        ):
            told.append(f"{info.short} = {about(in_full(value, info.unit))}")
    tables = {node.table for node in ir.below(demand.body) if isinstance(node, ir.Lookup | ir.GridLookup)}
    told += [f"another {name.rpartition('.')[2]}" for name in sorted(test.settings.tables) if name in tables]
    for number, one in enumerate(demand.quantities):
        here, there = float(test.values[number]), float(fixed[number])
        if number not in plane.axes and abs(here - there) > _SAME * max(abs(here), abs(there)):
            told.append(f"{one.label} = {_shown(demand, one, here)}")
    return told


def _axis(demand: Demand, number: int, span: tuple[float, float]) -> dict[str, Any]:
    one = demand.quantities[number]
    unit = _unit(demand, one)
    low, high = (from_si(end, unit) for end in span)
    return {"label": one.label, "unit": "" if unit == "1" else unit, "low": low, "high": high}


def _shown(demand: Demand, one: Quantity, value: float) -> str:
    return written(value, one.unit, _unit(demand, one))


def _unit(demand: Demand, one: Quantity) -> str:
    """The unit of an input: the one in which a limit on it is written, or else its own."""
    for node in ir.below(demand.body):
        if isinstance(node, ir.Compare) and node.shown and parse_unit(node.shown)[2] == one.dimension and one.node in _sides(node):  # fmt: skip
            return node.shown
    signal, name = one.field
    info = demand.spec.field(signal, name) if signal else demand.spec.params.get(name)
    return one.unit if info is None else info.unit


def _sides(node: ir.Compare) -> set[ir.Num]:
    """Both sides of a comparison, and of what a magnitude or a sign is."""
    found = {node.left, node.right}
    for side in (node.left, node.right):
        if isinstance(side, ir.Neg):
            found.add(side.operand)
        if isinstance(side, ir.Func) and side.name == "abs":
            found.add(side.args[0])
    return found


def _rounded(places: Sequence[Sequence[float]]) -> list[list[float]]:
    return [[round(float(x), _DIGITS) + 0.0, round(float(y), _DIGITS) + 0.0] for x, y in places]


def _place(point: tuple[float, float] | None) -> list[float] | None:
    return None if point is None else _rounded([point])[0]


def nothing(rule: str, reason: str) -> Mapping[str, Any]:
    """In place of a drawing: why there is none."""
    return {"rule": rule, "none": reason}
