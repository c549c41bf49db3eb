"""The reference evaluator: every node by its definition, one case, plain Python. Slow, and meant to be obviously right."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from functools import cache, partial
from typing import assert_never
from weakref import WeakKeyDictionary, WeakSet

from trackmarshal.backends import witness
from trackmarshal.backends.over_run.counts import Range, compared
from trackmarshal.backends.reference import geometry, temporal
from trackmarshal.backends.reference.lanes import on_lane
from trackmarshal.backends.results import Outcomes, Stateless, rated
from trackmarshal.ir import arithmetic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import Spec
from trackmarshal.ir.tables import read, read_grid
from trackmarshal.node import Node
from trackmarshal.runtime.frame import Columns, Frame
from trackmarshal.runtime.kleene import (
    FALSE,
    TRUE,
    UNDEFINED,
    connect,
    greatest,
    known,
    least,
    negate,
    scaled,
)
from trackmarshal.runtime.lines import Point
from trackmarshal.runtime.timeline import Measured, measured
from trackmarshal.runtime.verdict import Bound, Truth

#: The index of the variable of each axis that is bound, by the axis's level.
Env = dict[int, int]
#: Numbers that are as quickly read again as looked up.
_READ_AT_ONCE = {ir.Const, ir.Param, ir.Sample, ir.Scalar}


#: What `levels` found, as long as a node is there.
_LEVELS: WeakKeyDictionary[Node, frozenset[int]] = WeakKeyDictionary()
#: Nodes that `levels` came to more than once: what is bound by `let` and used twice would be worked out twice, and in a chain of such twice as often
#: for each of them.
_SHARED: WeakSet[Node] = WeakSet()


def levels(node: Node) -> frozenset[int]:
    """The levels of the axes that a node reads."""
    found = _LEVELS.get(node)
    if found is None:
        own = (node.level,) if isinstance(node, ir.Axis) else ()
        found = frozenset(own)
        for child in node.children():
            if child in _LEVELS:
                _SHARED.add(child)
            found |= levels(child)
        if isinstance(node, ir.Fold):  # it binds the variable of its axis itself
            found -= {node.axis.level}
        _LEVELS[node] = found
    return found


class Reference:
    """Values of the nodes of a spec for one case, given the numbers that state machines keep; formulas, and numbers that not every bound variable is in, are computed once
    for what the variables in them stand for.

    often: the same is asked about many times, as by all rules of a spec: then every number is computed once.
    """

    def __init__(
        self, spec: Spec, frame: Frame, kept: Mapping[ir.Kept, float] | None = None, often: bool = False
    ) -> None:
        self.spec = spec
        self._often = often
        self._kept = kept or {}
        self.frame = frame
        #: By node, as in all that follows (a node is equal to itself alone): the levels that it reads, and what it was for what stood there.
        self._truths: dict[ir.Formula, tuple[tuple[int, ...], dict[object, Truth]]] = {}
        self._series: dict[tuple[ir.Timed, tuple[tuple[int, int], ...]], list[Truth]] = {}
        self._lines: dict[ir.Line, geometry.Line] = {}
        self._regions: dict[ir.Area, geometry.Region | str] = {}
        #: Where columns are read: the numbers, the level of their axis, and how many places further.
        self._columns: dict[ir.Column, tuple[list[float], int, int]] = {}
        self._numbers: dict[ir.Num, tuple[tuple[int, ...], dict[object, float], bool]] = {}
        self._recalling: dict[tuple[tuple[ir.Kept, str], ...], Reference] = {}

    # Numbers --------------------------------------------------------------------------------------------------

    def number(self, node: ir.Num, env: Env) -> float:
        """The number that a node stands for; NaN where it has none."""
        kind = type(node)
        if kind is ir.Column:
            return self._read(node, env)  # type: ignore[arg-type]
        if kind in _READ_AT_ONCE:
            return self._number(node, env)
        known = self._numbers.get(node)
        if known is None:
            read = tuple(levels(node))
            known = self._numbers[node] = (read, {}, self._often or node in _SHARED)
        read, values, often = known
        if len(env) <= len(read) and not often:  # every variable that is bound, mostly
            return self._number(node, env)
        key: object = env.get(read[0]) if len(read) == 1 else tuple(map(env.get, read))
        value = values.get(key)
        if value is None:
            value = values[key] = self._number(node, env)
        return value

    def _number(self, node: ir.Num, env: Env) -> float:
        match node:  # what there is most of comes first
            case ir.Arith():
                operation = arithmetic.OPERATIONS[node.op]
                return operation(self.number(node.left, env), self.number(node.right, env))
            case ir.Param():
                return self.frame.settings.params.get(node.name, self.spec.params[node.name].value)
            case ir.Func():
                return arithmetic.apply(node.name, [self.number(arg, env) for arg in node.args])
            case ir.Const():
                return node.value
            case ir.Scalar():
                return self.frame.value(node.signal, node.field)
            case ir.Station():
                return self._projected(node, env)[0]
            case ir.Offset():
                return self._projected(node, env)[1]
            case ir.Direction():
                return self._projected(node, env)[2]
            case ir.StationGap():
                ends = self.number(node.start, env), self.number(node.end, env)
                return geometry.station_gap(self.line(node.line), *ends)
            case ir.Column():
                return self._read(node, env)
            case ir.Sample():
                return float(self.frame.columns[node.signal].listed(node.field)[node.index])
            case ir.Neg():
                return -self.number(node.operand, env)
            case ir.Choose():
                verdict = self.truth(node.condition, env).verdict
                if verdict == "undefined":
                    return math.nan
                return self.number(node.then if verdict == "satisfied" else node.otherwise, env)
            case ir.Lookup():
                table = self.spec.tables[node.table]
                knots, values = self.frame.settings.tables.get(node.table, (table.knots, table.values))
                return read(knots, values, table.way, self.number(node.argument, env))
            case ir.GridLookup():
                grid = self.spec.tables[node.table]
                assert grid.across is not None
                columns = (grid.across.knots, grid.across.way)
                x, y = self.number(node.first, env), self.number(node.second, env)
                return read_grid((grid.knots, grid.way), columns, grid.values, x, y)
            case ir.Distance():
                x, y = self.number(node.x, env), self.number(node.y, env)
                if node.line.kind == "path":
                    return geometry.distance_to_path(x, y, self.line(node.line))
                return geometry.distance_to_line(x, y, self.line(node.line))
            case ir.StretchRoom():
                ends = self.number(node.start, env), self.number(node.end, env)
                return geometry.stretch_room(self.line(node.line), self.number(node.station, env), *ends)
            case ir.Kept():
                return self._kept[node]
            case ir.OnLane():
                at = [self.number(end, env) for end in node.ends]
                return on_lane(node, self.frame, self.number(node.lane, env), at)
            case ir.Ordinal():
                return float(env[node.axis.level])
            case ir.Fold():
                return self._fold(node, env)
            case _:
                assert_never(node)

    def _read(self, node: ir.Column, env: Env) -> float:
        """The number of a sample or an element."""
        found = self._columns.get(node)
        if found is None:
            listed = self.frame.columns[node.axis.signal].listed(node.field)
            found = self._columns[node] = listed, node.axis.level, node.offset
        column, level, offset = found
        place = env[level] + offset
        return column[place if place > 0 else 0]

    def _fold(self, node: ir.Fold, env: Env) -> float:
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

    def _projected(self, node: ir.Projected, env: Env) -> tuple[float, float, float]:
        """Station, offset and direction of a point."""
        return geometry.project(self.number(node.x, env), self.number(node.y, env), self.line(node.line))

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
        known = self._truths.get(node)
        if known is None:
            known = self._truths[node] = (tuple(levels(node)), {})
        read, values = known
        key: object = env.get(read[0]) if len(read) == 1 else tuple(map(env.get, read))
        value = values.get(key)
        if value is None:
            value = values[key] = self._truth(node, env)
        return value

    def _truth(self, node: ir.Formula, env: Env) -> Truth:
        match node:  # what there is most of comes first
            case ir.Compare():
                a, b = self.number(node.left, env), self.number(node.right, env)
                if not (math.isfinite(a) and math.isfinite(b)):
                    return UNDEFINED
                return known(arithmetic.compare(node.op, a, b), arithmetic.margin(node.op, a, b))
            case ir.Connective():
                return connect(node.op, self.truth(node.left, env), self.truth(node.right, env))
            case ir.Not():
                return negate(self.truth(node.operand, env))
            case ir.Truth():
                return TRUE if node.value else FALSE
            case ir.Flag():
                return self._flag(node, env)
            case ir.SweptInside() | ir.SweptClear() | ir.InArea():
                margin = self._geometry(node, env)
                return UNDEFINED if math.isnan(margin) else known(margin >= 0.0, margin)
            case ir.Scaled():
                return scaled(self.truth(node.operand, env), node.scale)
            case ir.Quantify():
                return self._quantify(node, env)
            case ir.Guarded():
                guard = self.truth(node.guard, env)
                if not guard.best.sat:  # surely not in force, whatever it demands
                    return TRUE
                body = self.truth(node.body, env)
                return Truth(body.worst, body.best if guard.worst.sat else TRUE.best)
            case ir.Temporal() | ir.Until() | ir.Shift():
                return self.series(node, env)[env[node.axis.level]]
            case ir.Tallied():
                return self._tallied(node, env)
            case ir.At():
                return self.truth(node.operand, {**env, node.axis.level: self.place(node)})
            case ir.OverRun() | ir.Counted() | ir.InState():
                raise AssertionError("one cycle does not say what a formula over the run comes to")
            case _:
                assert_never(node)

    def _flag(self, node: ir.Flag, env: Env) -> Truth:
        if node.axis is not None:
            assert node.field is not None
            column = self.frame.columns[node.signal].listed(node.field)
            value = column[max(0, env[node.axis.level] + node.offset)]
        else:
            value = self.frame.flag(node.signal, node.field or "", node.offset)
        if value is None:
            return UNDEFINED
        return TRUE if value else FALSE

    def _geometry(self, node: ir.Geometry, env: Env) -> float:
        match node:
            case ir.InArea():
                return geometry.in_zone_margin(
                    self.number(node.x, env), self.number(node.y, env), self.zone(node.area)
                )
            case ir.SweptClear():
                return geometry.clear_margin(
                    self._pose(node.start, env), self._pose(node.end, env),
                    self.number(node.length, env), self.number(node.width, env),
                    self._pose(node.box, env), self.number(node.box_length, env), self.number(node.box_width, env),
                    self._bend(node, env),
                )  # fmt: skip
            case ir.SweptInside():
                start, end = self._pose(node.start, env), self._pose(node.end, env)
                body = self.number(node.length, env), self.number(node.width, env), self._bend(node, env)
                return geometry.hull_margin_in(self._region(node.area), start, end, *body)
            case _:
                assert_never(node)

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

    def _region(self, area: ir.Area) -> geometry.Region | str:
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

    def _quantify(self, node: ir.Quantify, env: Env) -> Truth:
        every = node.extreme is Extreme.LEAST
        join = least if every else greatest
        worst = best = Bound(*node.extreme.neutral)
        for index in range(self.count(node.axis)):
            inner = {**env, node.axis.level: index}
            guard = TRUE if node.guard is None else self.truth(node.guard, inner)
            may_be, surely_is = guard.best.sat, guard.worst.sat
            if not may_be:  # whatever it comes to
                continue
            body = self.truth(node.body, inner)
            # In the worst case every element that may be in range counts against a `for all`, and only those
            # that surely are count for an `exists`; in the best case the other way round.
            in_worst, in_best = (may_be, surely_is) if every else (surely_is, may_be)
            worst = join(worst, body.worst) if in_worst else worst
            best = join(best, body.best) if in_best else best
        return Truth(worst, best)

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

    def _tallied(self, node: ir.Tallied, env: Env) -> Truth:
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
            known = self._recalling[key] = Reference(self.spec, self.frame, kept)
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

    def outcomes(self, frames: Sequence[Frame]) -> list[Outcomes]:
        made = [(frame, cache(partial(Reference, self.spec, frame))) for frame in frames]
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
