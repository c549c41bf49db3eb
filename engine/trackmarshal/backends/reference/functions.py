"""What each node comes to by its definition, as a function of a case and of what its variables stand for: made once for all cases."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias, TypeVar, assert_never
from weakref import WeakKeyDictionary, WeakSet

from trackmarshal.backends.reference import geometry
from trackmarshal.backends.reference.lanes import on_lane
from trackmarshal.ir import arithmetic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.tables import read, read_grid
from trackmarshal.node import Node
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
from trackmarshal.runtime.verdict import Bound, Truth

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

#: The index of the variable of each axis that is bound, by the axis's level.
Env: TypeAlias = dict[int, int]
#: What a number, a formula, and what is swept or in an area is in a case.
Number: TypeAlias = Callable[["Reference", Env], float]
Value: TypeAlias = Callable[["Reference", Env], Truth]
Pose: TypeAlias = Callable[["Reference", Env], tuple[float, float, float]]
T = TypeVar("T")

#: Numbers that are as quickly read again as looked up.
_READ_AT_ONCE = (ir.Const, ir.Param, ir.Sample, ir.Scalar, ir.Column, ir.Ordinal, ir.Kept)

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


class Functions:
    """The functions of nodes. Formulas, and numbers that not every variable of what they are part of is in, are computed once a case for what the
    variables in them stand for.

    often: the same is asked about many times, as by all rules of a spec: then every number is computed once.
    """

    def __init__(self, often: bool = False) -> None:
        self._often = often
        #: By node, which is equal to itself alone.
        self._numbers: dict[ir.Num, Number] = {}
        self._truths: dict[ir.Formula, Value] = {}

    # Numbers --------------------------------------------------------------------------------------------------

    def number(self, node: ir.Num) -> Number:
        """The number that a node stands for; NaN where it has none."""
        found = self._numbers.get(node)
        if found is None:
            levels(node)  # first, and so of all below it: then it is known what is shared
            made = self._number(node)
            found = self._numbers[node] = made if isinstance(node, _READ_AT_ONCE) else _once(node, made)
        return found

    def _part(self, node: ir.Num, whole: ir.Num | ir.Formula) -> Number:
        """A number that another node is made of. Where every variable of that is in it, too, and nothing else is made of it, it is asked about once for
        what they stand for as it is: that is not kept."""
        if self._often or node in _SHARED or levels(node) != levels(whole):
            return self.number(node)
        return self._number(node)

    def _number(self, node: ir.Num) -> Number:
        match node:
            case ir.Const():
                value = node.value
                return lambda case, env: value
            case ir.Param():
                name = node.name
                return lambda case, env: case.frame.settings.params.get(name, case.spec.params[name].value)
            case ir.Column():
                return _column(node)
            case ir.Sample():
                return lambda case, env: float(case.frame.columns[node.signal].listed(node.field)[node.index])
            case ir.Scalar():
                return lambda case, env: case.frame.value(node.signal, node.field)
            case ir.Arith():
                operation = arithmetic.OPERATIONS[node.op]
                left, right = self._part(node.left, node), self._part(node.right, node)
                return lambda case, env: operation(left(case, env), right(case, env))
            case ir.Neg():
                operand = self._part(node.operand, node)
                return lambda case, env: -operand(case, env)
            case ir.Func():
                function, arguments = arithmetic.BUILT_IN[node.name], self._parts(node.args, node)
                return lambda case, env: function(*[one(case, env) for one in arguments])
            case ir.Choose():
                return self._choice(node)
            case ir.Lookup():
                return self._looked_up(node)
            case ir.GridLookup():
                return self._in_grid(node)
            case ir.Station() | ir.Offset() | ir.Direction():
                return self._projected(node)
            case ir.Distance():
                x, y = self._part(node.x, node), self._part(node.y, node)
                away = geometry.distance_to_path if node.line.kind == "path" else geometry.distance_to_line
                return lambda case, env: away(x(case, env), y(case, env), case.line(node.line))
            case ir.StationGap():
                start, end = self._part(node.start, node), self._part(node.end, node)
                return lambda case, env: geometry.station_gap(
                    case.line(node.line), start(case, env), end(case, env)
                )
            case ir.StretchRoom():
                station = self._part(node.station, node)
                begin, until = self._part(node.start, node), self._part(node.end, node)
                return lambda case, env: geometry.stretch_room(
                    case.line(node.line), station(case, env), begin(case, env), until(case, env)
                )
            case ir.OnLane():
                lane, places = self._part(node.lane, node), self._parts(node.ends, node)
                return lambda case, env: on_lane(
                    node, case.frame, lane(case, env), [place(case, env) for place in places]
                )
            case ir.Ordinal():
                return lambda case, env: float(env[node.axis.level])
            case ir.Fold():
                return lambda case, env: case.fold(node, env)
            case ir.Kept():
                return lambda case, env: case.kept[node]
            case _:
                assert_never(node)

    def _parts(self, nodes: tuple[ir.Num, ...], whole: ir.Num | ir.Formula) -> list[Number]:
        return [self._part(node, whole) for node in nodes]

    def _choice(self, node: ir.Choose) -> Number:
        condition = self.truth(node.condition)
        then, otherwise = self._part(node.then, node), self._part(node.otherwise, node)

        def choice(case: Reference, env: Env) -> float:
            verdict = condition(case, env).verdict
            if verdict == "undefined":
                return math.nan
            return then(case, env) if verdict == "satisfied" else otherwise(case, env)

        return choice

    def _looked_up(self, node: ir.Lookup) -> Number:
        argument = self._part(node.argument, node)

        def looked_up(case: Reference, env: Env) -> float:
            table = case.spec.tables[node.table]
            knots, values = case.frame.settings.tables.get(node.table, (table.knots, table.values))
            return read(knots, values, table.way, argument(case, env))

        return looked_up

    def _in_grid(self, node: ir.GridLookup) -> Number:
        first, second = self._part(node.first, node), self._part(node.second, node)

        def in_grid(case: Reference, env: Env) -> float:
            grid = case.spec.tables[node.table]
            assert grid.across is not None
            columns = (grid.across.knots, grid.across.way)
            return read_grid(
                (grid.knots, grid.way), columns, grid.values, first(case, env), second(case, env)
            )

        return in_grid

    def _projected(self, node: ir.Projected) -> Number:
        """Station, offset or direction of a point."""
        x, y = self._part(node.x, node), self._part(node.y, node)
        match node:
            case ir.Station():
                place = 0
            case ir.Offset():
                place = 1
            case ir.Direction():
                place = 2
            case _:
                assert_never(node)
        return lambda case, env: geometry.project(x(case, env), y(case, env), case.line(node.line))[place]

    # Formulas -------------------------------------------------------------------------------------------------

    def truth(self, node: ir.Formula) -> Value:
        """The value of a formula between its worst and its best case."""
        found = self._truths.get(node)
        if found is None:
            levels(node)  # as above
            found = self._truths[node] = _once(node, self._truth(node))
        return found

    def _joined(self, node: ir.Formula, whole: ir.Formula) -> Value:
        """A formula that another one, about the same elements, is made of: kept where `_part` keeps a number."""
        return self.truth(node) if node in _SHARED or levels(node) != levels(whole) else self._truth(node)

    def _truth(self, node: ir.Formula) -> Value:
        match node:
            case ir.Truth():
                value = TRUE if node.value else FALSE
                return lambda case, env: value
            case ir.Flag():
                return lambda case, env: case.flag(node, env)
            case ir.Compare():
                return self._compared(node)
            case ir.SweptInside() | ir.SweptClear() | ir.InArea():
                return self._measured(node)
            case ir.Scaled():
                formula = self._joined(node.operand, node)
                return lambda case, env: scaled(formula(case, env), node.scale)
            case ir.Not():
                denied = self._joined(node.operand, node)
                return lambda case, env: negate(denied(case, env))
            case ir.Connective():
                op = node.op
                left, right = self._joined(node.left, node), self._joined(node.right, node)
                return lambda case, env: connect(op, left(case, env), right(case, env))
            case ir.Quantify():
                return self._quantified(node)
            case ir.Guarded():
                return self._guarded(node)
            case ir.Temporal() | ir.Until() | ir.Shift():
                return lambda case, env: case.series(node, env)[env[node.axis.level]]
            case ir.Tallied():
                return lambda case, env: case.tallied(node, env)
            case ir.At():
                judged = self.truth(node.operand)
                return lambda case, env: judged(case, {**env, node.axis.level: case.place(node)})
            case ir.OverRun() | ir.Counted() | ir.InState():
                raise AssertionError("one cycle does not say what a formula over the run comes to")
            case _:
                assert_never(node)

    def _compared(self, node: ir.Compare) -> Value:
        left, right = self._part(node.left, node), self._part(node.right, node)
        holds, margin = arithmetic.COMPARED[node.op], arithmetic.MARGINS[node.op]

        def compared(case: Reference, env: Env) -> Truth:
            a, b = left(case, env), right(case, env)
            if not (math.isfinite(a) and math.isfinite(b)):
                return UNDEFINED
            return known(holds(a, b), margin(a, b))

        return compared

    def _guarded(self, node: ir.Guarded) -> Value:
        in_force, demanded = self.truth(node.guard), self.truth(node.body)

        def guarded(case: Reference, env: Env) -> Truth:
            guard = in_force(case, env)
            if not guard.best.sat:  # surely not in force, whatever it demands
                return TRUE
            body = demanded(case, env)
            return Truth(body.worst, body.best if guard.worst.sat else TRUE.best)

        return guarded

    def _quantified(self, node: ir.Quantify) -> Value:
        every, level = node.extreme is Extreme.LEAST, node.axis.level
        join, neutral = least if every else greatest, Bound(*node.extreme.neutral)
        in_range = None if node.guard is None else self.truth(node.guard)
        demanded = self.truth(node.body)

        def quantified(case: Reference, env: Env) -> Truth:
            worst = best = neutral
            for index in range(case.count(node.axis)):
                inner = {**env, level: index}
                guard = TRUE if in_range is None else in_range(case, inner)
                may_be, surely_is = guard.best.sat, guard.worst.sat
                if not may_be:  # whatever it comes to
                    continue
                body = demanded(case, inner)
                # In the worst case every element that may be in range counts against a `for all`, and only those
                # that surely are count for an `exists`; in the best case the other way round.
                in_worst, in_best = (may_be, surely_is) if every else (surely_is, may_be)
                worst = join(worst, body.worst) if in_worst else worst
                best = join(best, body.best) if in_best else best
            return Truth(worst, best)

        return quantified

    def _measured(self, node: ir.Geometry) -> Value:
        margin = self._margin(node)

        def measured(case: Reference, env: Env) -> Truth:
            found = margin(case, env)
            return UNDEFINED if math.isnan(found) else known(found >= 0.0, found)

        return measured

    def _margin(self, node: ir.Geometry) -> Number:
        match node:
            case ir.InArea():
                x, y = self._part(node.x, node), self._part(node.y, node)
                return lambda case, env: geometry.in_zone_margin(
                    x(case, env), y(case, env), case.zone(node.area)
                )
            case ir.SweptClear():
                start, end, box = (self._pose(pose, node) for pose in (node.start, node.end, node.box))
                length, width = self._part(node.length, node), self._part(node.width, node)
                box_length, box_width = self._part(node.box_length, node), self._part(node.box_width, node)
                bend = self._parts(node.bend, node)
                return lambda case, env: geometry.clear_margin(
                    start(case, env), end(case, env), length(case, env), width(case, env),
                    box(case, env), box_length(case, env), box_width(case, env), tuple([kappa(case, env) for kappa in bend]),
                )  # fmt: skip
            case ir.SweptInside():
                first, last = self._pose(node.start, node), self._pose(node.end, node)
                long, wide = self._part(node.length, node), self._part(node.width, node)
                curved = self._parts(node.bend, node)
                return lambda case, env: geometry.hull_margin_in(
                    case.region(node.area), first(case, env), last(case, env), long(case, env), wide(case, env),
                    tuple([kappa(case, env) for kappa in curved]),
                )  # fmt: skip
            case _:
                assert_never(node)

    def _pose(self, pose: ir.Pose, whole: ir.Geometry) -> Pose:
        x, y, heading = (self._part(part, whole) for part in (pose.x, pose.y, pose.heading))
        return lambda case, env: (x(case, env), y(case, env), heading(case, env))


def _column(node: ir.Column) -> Number:
    """The number of a sample or an element."""
    signal, level, field, offset = node.axis.signal, node.axis.level, node.field, node.offset

    def column(case: Reference, env: Env) -> float:
        listed = case.listed.get(node)
        if listed is None:
            listed = case.listed[node] = case.frame.columns[signal].listed(field)
        place = env[level] + offset
        return listed[place if place > 0 else 0]

    return column


def _once(node: ir.Num | ir.Formula, of: Callable[[Reference, Env], T]) -> Callable[[Reference, Env], T]:
    """What is worked out once a case for what the variables in it stand for."""
    read = tuple(levels(node))
    (only,) = read if len(read) == 1 else (None,)

    def once(case: Reference, env: Env) -> T:
        values = case.known.get(node)
        if values is None:
            values = case.known[node] = {}
        key: object = tuple(map(env.get, read)) if only is None else env.get(only)
        value: T | None = values.get(key)
        if value is None:
            value = values[key] = of(case, env)
        return value

    return once
