"""The reference evaluator: every node by its definition, one case, plain Python. Slow, and meant to be obviously right."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, cached_property, partial
from typing import Any, assert_never

from trackmarshal.backends import witness
from trackmarshal.backends.over_run.counts import Range, compared
from trackmarshal.backends.reference import geometry, temporal
from trackmarshal.backends.reference.functions import Env, Functions
from trackmarshal.backends.results import Outcomes, Stateless, rated
from trackmarshal.ir import arithmetic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.frame import Columns, Frame
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED
from trackmarshal.runtime.lines import Point
from trackmarshal.runtime.timeline import Measured, measured
from trackmarshal.runtime.verdict import Bound, Truth


class Reference:
    """Values of the nodes of a spec for one case, given the numbers that state machines keep, and the functions of nodes, if others have them, too."""

    def __init__(
        self, spec: Spec, frame: Frame, kept: Mapping[ir.Kept, float] | None = None, functions: Functions | None = None
    ) -> None:  # fmt: skip
        self.spec = spec
        self.kept = kept or {}
        self.frame = frame
        self._functions = functions or Functions()
        #: By node, as in all that follows (a node is equal to itself alone): what it was for what stood where it reads.
        self.known: dict[ir.Num | ir.Formula, dict[object, Any]] = {}
        #: The numbers of columns.
        self.listed: dict[ir.Column, list[float]] = {}
        self._series: dict[tuple[ir.Timed, tuple[tuple[int, int], ...]], list[Truth]] = {}
        self._lines: dict[ir.Line, geometry.Line] = {}
        self._regions: dict[ir.Area, geometry.Region | str] = {}
        self._recalling: dict[tuple[tuple[ir.Kept, str], ...], Reference] = {}

    # Numbers --------------------------------------------------------------------------------------------------

    def number(self, node: ir.Num, env: Env) -> float:
        """The number that a node stands for; NaN where it has none."""
        return self._functions.number(node)(self, env)

    def fold(self, node: ir.Fold, env: Env) -> float:
        """One number of all that is in range, element by element."""
        found: list[tuple[int, float]] = []
        for index in range(self.count(node.axis)):
            inner = {**env, node.axis.level: index}
            guard = TRUE if node.guard is None else self.truth(node.guard, inner)
            if guard.verdict == "undefined":
                return math.nan
            if guard.verdict == "satisfied":
                found.append((index, self.number(node.body, inner)))
        match node.op:
            case "sum":
                total = 0.0
                for _, value in found:
                    total = arithmetic.arith("+", total, value)
                return total
            case "least" | "greatest":
                if not found:
                    return math.nan if node.otherwise is None else self.number(node.otherwise, env)
                extreme = found[0][1] + 0.0
                for _, value in found[1:]:
                    extreme = arithmetic.apply("min" if node.op == "least" else "max", [extreme, value])
                return extreme
            case "nearest":
                if not all(math.isfinite(value) for _, value in found):
                    return math.nan
                return float(min(found, key=lambda each: each[1])[0]) if found else -1.0
            case _:
                assert_never(node.op)

    def line(self, line: ir.Line) -> geometry.Line:
        """The points of a line, and whether it is closed."""
        found = self._lines.get(line)
        if found is None:
            found = self._lines[line] = self._line(line)
        return found

    def _line(self, line: ir.Line) -> geometry.Line:
        frame = self.frame
        match line.kind:
            case "place":
                points = frame.settings.places.get(line.name, self.spec.places[line.name].points)
                return geometry.line_again(points, False)
            case "signal":
                points = frame.line(line.name, line.field).tuples
                return geometry.line_again(points, frame.closed.get(line.name, False))
            case "path":
                columns = frame.columns[line.name]
                return geometry.Line(list(zip(columns.listed("x"), columns.listed("y"))), False)
            case "centre":
                left, right, closed = self.corridor(line.name)
                return geometry.centre_again(left, right, closed)
            case _:
                assert_never(line.kind)

    def corridor(self, name: str) -> tuple[Sequence[Point], Sequence[Point], bool]:
        left, right, closed = self.frame.corridor(name)
        return left.tuples, right.tuples, closed

    # Formulas -------------------------------------------------------------------------------------------------

    def truth(self, node: ir.Formula, env: Env) -> Truth:
        """The value of a formula between its worst and its best case."""
        return self._functions.truth(node)(self, env)

    def flag(self, node: ir.Flag, env: Env) -> Truth:
        if node.axis is not None:
            assert node.field is not None
            column = self.frame.columns[node.signal].listed(node.field)
            value = column[max(0, env[node.axis.level] + node.offset)]
        else:
            value = self.frame.flag(node.signal, node.field or "", node.offset)
        if value is None:
            return UNDEFINED
        return TRUE if value else FALSE

    def _pose(self, pose: ir.Pose, env: Env) -> tuple[float, float, float]:
        return self.number(pose.x, env), self.number(pose.y, env), self.number(pose.heading, env)

    def curve(self, node: ir.SweptInside | ir.SweptClear, env: Env) -> geometry.Curve | None:
        """The way along which something is swept; None where it is straight, or where there is none."""
        start, end = self._pose(node.start, env), self._pose(node.end, env)
        return geometry.curve_between(
            start, end, self._bend(node, env), self.number(node.length, env), self.number(node.width, env)
        )

    def _bend(self, node: ir.SweptInside | ir.SweptClear, env: Env) -> tuple[float, ...]:
        return tuple(self.number(kappa, env) for kappa in node.bend)

    def zone(self, area: ir.Area) -> Sequence[Point]:
        return self.frame.settings.places.get(area.name, self.spec.places[area.name].points)

    def region(self, area: ir.Area) -> geometry.Region | str:
        """The region that an area is, or what is wrong with it."""
        found = self._regions.get(area)
        if found is None:
            if area.kind == "zone":
                found = geometry.region_of(self.zone(area))
            else:
                found = geometry.region_between(*self.corridor(area.name))
            self._regions[area] = found
        return found

    def count(self, axis: ir.Axis) -> int:
        """How many values the variable of an axis takes."""
        return max(0, self.frame.count(axis.signal) - axis.width + 1)

    def series(self, node: ir.Timed, env: Env) -> list[Truth]:
        """The value of a temporal formula at every sample of its timeline."""
        key = (node, tuple(item for item in env.items() if item[0] != node.axis.level))
        values = self._series.get(key)
        if values is None:
            values = self._series[key] = self._temporal(node, env)
        return values

    def along(self, node: ir.Formula, axis: ir.Axis, env: Env) -> list[Truth]:
        """The value of any formula at every sample of a timeline; of a gap, nothing is known."""
        joined = self.frame.columns[axis.signal].joined
        gaps = () if joined is None else joined.gaps
        return [
            UNDEFINED if k in gaps else self.truth(node, {**env, axis.level: k})
            for k in range(self.count(axis))
        ]

    def _temporal(self, node: ir.Timed, env: Env) -> list[Truth]:
        axis = node.axis
        match node:
            case ir.Temporal():
                operand = self.along(node.operand, axis, env)
                windows = self._windows(node)
                kernel = temporal.always if node.extreme is Extreme.LEAST else temporal.eventually
                return _both(lambda side: kernel(side(operand)[0], side(operand)[1], windows))
            case ir.Until():
                left, right = self.along(node.left, axis, env), self.along(node.right, axis, env)
                windows = self._windows(node)
                held = temporal.since if node.past else temporal.until
                return _both(
                    lambda side: held(side(left)[0], side(left)[1], side(right)[0], side(right)[1], windows)
                )
            case ir.Shift():
                operand = self.along(node.operand, axis, env)
                return _both(
                    lambda side: temporal.shift(side(operand)[0], side(operand)[1], node.step, node.weak)
                )
            case _:
                assert_never(node)

    def tallied(self, node: ir.Tallied, env: Env) -> Truth:
        """From a sample backwards, up to the last one with which the count starts anew: that it surely does, or that it may."""
        axis, k = node.axis, env[node.axis.level]
        columns = self.frame.columns[axis.signal]
        window = measured(columns, None, node.upper)
        counted = self.along(node.counted, axis, env)
        resets = None if node.reset is None else self.along(node.reset, axis, env)
        sure = possible = 0
        surely_on = possibly_on = True
        for j in reversed(_windows(window, True)[k]):
            sure += surely_on * counted[j].worst.sat
            possible += possibly_on * counted[j].best.sat * columns.weight(j)
            if resets is not None:
                surely_on = surely_on and not resets[j].best.sat
                possibly_on = possibly_on and not resets[j].worst.sat
        return compared(node, Range(sure, possible), self.number(node.limit, env))

    def _windows(self, node: ir.Temporal | ir.Until) -> list[range]:
        columns = self.frame.columns[node.axis.signal]
        return _windows(measured(columns, node.lower, node.upper), node.past)

    def recalled(self, node: ir.Formula, env: Env, kept: Mapping[ir.Kept, float]) -> Truth:
        """The value of a formula about numbers that state machines keep, with those given: what is found out with some is known for all elements."""
        key = tuple((one, value.hex()) for one, value in kept.items())  # NaN is no key
        known = self._recalling.get(key)
        if known is None:
            known = self._recalling[key] = Reference(self.spec, self.frame, kept, self._functions)
        return known.truth(node, env)

    # What witnesses and results ask -------------------------------------------------------------------------

    def columns(self, axis: ir.Axis) -> Columns:
        """What an axis ranges over."""
        return self.frame.columns[axis.signal]

    def place(self, node: ir.At) -> int:
        """The number of the sample at which a rule is judged."""
        return self.frame.columns[node.axis.signal].place(node.place)

    def sides(self, node: ir.Formula, axis: ir.Axis, env: Env) -> witness.Sides:
        """The values of a formula for all values of the variable of an axis."""
        values = self.along(node, axis, env)
        return witness.Sides(*_worst(values), *_best(values))

    def name(self, axis: ir.Axis, index: int) -> int | str:
        """What reports call a sample or an element: its number, or an object's id."""
        return self.frame.columns[axis.signal].name(index)

    def geometry_fault(self, formula: ir.Formula) -> str | None:
        """What makes a corridor or zone that a formula reads unusable."""
        for node in ir.below(formula):
            if isinstance(node, ir.Area):
                fault = (
                    geometry.zone_fault(self.zone(node))
                    if node.kind == "zone"
                    else geometry.corridor_fault(*self.corridor(node.name))
                )
                if fault is not None:
                    return fault
        return None


class ReferenceProgram(Stateless):
    """Rules of a spec, evaluated by the reference."""

    backend = "reference"

    @cached_property
    def _functions(self) -> Functions:
        return Functions()

    def outcomes(self, frames: Sequence[Frame]) -> list[Outcomes]:
        made = [
            (frame, cache(partial(Reference, self.spec, frame, functions=self._functions)))
            for frame in frames
        ]
        return [Outcomes(rated(self.rules, frame, values), values) for frame, values in made]


def _windows(measured: Measured, past: bool) -> list[range]:
    begins, ends, lower, upper = measured
    return temporal.windows(begins.tolist(), lower, upper, past, None if ends is None else ends.tolist())


def _worst(values: list[Truth]) -> tuple[list[bool], list[float]]:
    return [v.worst.sat for v in values], [v.worst.margin for v in values]


def _best(values: list[Truth]) -> tuple[list[bool], list[float]]:
    return [v.best.sat for v in values], [v.best.margin for v in values]


Sides = tuple[list[bool], list[float]]
Pick = Callable[[list[Truth]], Sides]


def _both(kernel: Callable[[Pick], Sides]) -> list[Truth]:
    """Run a kernel on the worst cases and on the best ones."""
    worst, best = kernel(_worst), kernel(_best)
    return [Truth(Bound(a, b), Bound(c, d)) for a, b, c, d in zip(worst[0], worst[1], best[0], best[1])]
