"""Rules as Python source over arrays: straight-line code in which each shared node is computed once for a whole batch.

A number is one variable. A formula is two, its margin in the worst and in the best case, which are the same object where nothing
is undefined; whether it holds is mostly read off its margin, else it has two more variables for that.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple, assert_never

import numpy as np

from trackmarshal.backends.numpy import folds, lanes, logic, places, steps, tallies, time
from trackmarshal.backends.numpy.batch import before, column_index
from trackmarshal.backends.numpy.blocks import Guarding, blocks, together
from trackmarshal.backends.numpy.logic import ABOVE, AT_LEAST, BOTH, NEITHER
from trackmarshal.backends.numpy.sharing import representatives
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import deciding
from trackmarshal.ir.operators import Extreme

#: What code may call by name.
_CALLED: dict[str, Any] = {
    "where": logic.where, "minimum": np.minimum, "maximum": np.maximum, "nan": np.nan, "inf": logic.INF, "zero": logic.ZERO, "minus_inf": logic.MINUS_INF, "true": logic.TRUE, "false": logic.FALSE,
    "before": before, "compared": steps.compared, "flagged": steps.flagged, "inside": steps.inside, "first": steps.first, "at": steps.at, "nowhere": logic.nowhere,
    "every": logic.every, "some": logic.some, "every_sat": logic.every_sat, "some_sat": logic.some_sat,
    "value": logic.value, "parts": logic.parts, "differ": logic.differ, "negate": logic.negate,
    "project": places.project, "distance": places.distance, "gap": places.gap, "stretch_room": places.stretch_room, "on_lane": lanes.on_lane, "inside_area": places.swept_inside, "clear": places.swept_clear, "asked_clear": places.asked_clear,
    "least": places.least, "in_area": places.in_area, "within": places.within, "temporal": time.operator, "tally": tallies.tally,
    "ordinal": folds.ordinal, "fold": folds.fold,
}  # fmt: skip

#: Numbers that are read from the input as they are.
_INPUTS = (ir.Column, ir.Sample, ir.Scalar)
#: Samples of which tables have one of every case at the same place.
_ENDS = {0: slice(0, 1), -1: slice(-1, None)}
#: An expression of the best case, or of the worst.
Side = Callable[[bool], str]
Point = tuple[ir.Num, ir.Num]
#: What is read from a table of a signal.
Part = ir.Column | ir.Sample


class Table(NamedTuple):
    """All points of a signal, by the fields that say where they are."""

    signal: str
    x: str
    y: str


class Variables(NamedTuple):
    """The variables of a formula; those of whether it holds are empty where its margin says it."""

    worst: str
    best: str
    says: int
    worst_sat: str = ""
    best_sat: str = ""

    def margin(self, best: bool) -> str:
        """The variable of its margin in the best case, or in the worst."""
        return self.best if best else self.worst

    def sat(self, best: bool) -> str:
        """An expression of whether it holds in the best case, or in the worst."""
        if self.says == NEITHER:
            return self.best_sat if best else self.worst_sat
        return f"({self.margin(best)} {'>=' if self.says & AT_LEAST else '>'} zero)"

    @property
    def value(self) -> str:
        """An expression of it as one object."""
        if self.says:
            return f"value({self.worst}, {self.best}, {self.says})"
        return f"value({self.worst}, {self.best}, {NEITHER}, {self.worst_sat}, {self.best_sat})"

    @property
    def names(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.worst, self.best, self.worst_sat, self.best_sat)))


class Asked(NamedTuple):
    """Who asks for a margin: by which axes, under which guards; and the formulas on the way to whoever asks for the least, from the margin's on."""

    axes: tuple[ir.Axis, ...]
    guards: tuple[ir.Formula, ...]
    partly: tuple[ir.Num | ir.Formula, ...]
    #: What it stands beside in an `or`: of both margins the greater one is asked for.
    floors: tuple[ir.Formula, ...]
    #: Whether the least margin of a case is all that is asked.
    by_case: bool


class Code:
    """Source of two functions: of what no case changes unless it overrides a parameter, and of the rest."""

    def __init__(self, formulas: Sequence[ir.Formula], ranges: Sequence[ir.Formula], rank: int = 1) -> None:
        """Of the `ranges`, other than of the `formulas`, only whether they hold is asked. rank: of arrays, at least."""
        every = ordered([*formulas, *ranges])
        #: Of nodes that are computed alike, the one that is.
        self._same = representatives(every)
        nodes = list(dict.fromkeys(self._same.values()))
        #: What nodes are computed of: asked for at each step below.
        self._made_of = {node: self._operands(node) for node in nodes}
        #: Nodes that are only worked out where a guard holds anywhere, with the formula that has it; and what is written of its block.
        self._within, self._shared = blocks(nodes, [*formulas, *ranges], self._same)
        self._block: list[str] | None = None
        nodes = together(nodes, self._within, self._shared)
        self._weighed = {self._same[node] for node in deciding(formulas)}
        axes = [child for node in nodes for child in node.children() if isinstance(child, ir.Axis)]
        self.rank = max([rank, *(axis.level + 2 for axis in axes)])
        #: Predicates of which only the least margin is asked, by a `for all`, with its axis; and variables that hold the rest.
        self._asked = self._asked_for_least(nodes, [*formulas, *ranges])
        self._least: dict[ir.IR, str] = {}
        #: Swept footprints that keep clear of a box, of which only some are asked; and the variables that say whether any were left out.
        self._asked_of: dict[ir.IR, Asked] = self._asked_of_some(nodes, [*formulas, *ranges])
        self._left_out: dict[ir.IR, str] = {}
        #: Where each formula's variables are.
        self.formulas: dict[ir.IR, Variables] = {}
        #: Objects that the source names.
        self.named: dict[str, Any] = {**_CALLED, **{f"{name}_": f for name, f in steps.CALLS.items()}}
        self.fixed: list[str] = []
        self.varying: list[str] = []
        #: The variables that `fixed` leaves behind.
        self.left: list[str] = []
        self._numbers: dict[ir.IR, str] = {}
        self._names: dict[Any, str] = {}
        self._free: list[str] = []
        self._made = 0  # variables of numbers
        self._is_fixed: set[ir.IR] = set()
        #: Where what is projected onto each line comes from, with the blocks that ask for it; none where somebody else does.
        self._points: dict[ir.Line, dict[Point | Table, frozenset[Guarding]]] = {}
        self._source: dict[ir.IR, Point | Table] = {}
        self._find_points([node for node in nodes if isinstance(node, ir.Projected)])
        used = {child for node in nodes for child in self._inputs(node)}
        nodes = [node for node in nodes if not isinstance(node, _INPUTS) or node in used]
        last_use = {child: place for place, node in enumerate(nodes) for child in self._inputs(node)}
        for place, node in enumerate(nodes):
            self._emit(node)
            for child in self._inputs(node):
                if last_use[child] == place:
                    self._release(child)
        self.formulas |= {
            node: self.formulas[one] for node, one in self._same.items() if one in self.formulas
        }
        #: Where, among the outputs, is what knows all margins of a formula of which only the least are among them.
        at = {name: place for place, name in enumerate(self.outputs)}
        self.least = {node: at[self._least[one]] for node, one in self._same.items() if one in self._least}
        #: Where, among the outputs, is whether a formula's margins are only those that its rule's verdict takes.
        partly = {
            node: at[self._left_out[top]]
            for node, top in self._within.items()
            if node in self.formulas and node not in self._is_fixed and top in self._left_out
        }
        partly |= {
            part: at[name]
            for one, name in self._left_out.items()
            if one in self._asked_of
            for part in self._asked_of[one].partly
        }
        self.partly = {node: partly[one] for node, one in self._same.items() if one in partly}

    def functions(self) -> tuple[Callable[[Any], tuple[Any, ...]], Callable[[Any, Any], tuple[Any, ...]]]:
        """The compiled functions: of a batch; of a batch and what the first one gave.

        All that a spec brings into the source are names, as Python writes strings, and numbers, which are held by name.
        """
        made: dict[str, Any] = dict(self.named)
        exec(compile(self.source, "<rules>", "exec"), made)
        return made["fixed"], made["varying"]

    @property
    def source(self) -> str:
        """The source of both functions."""
        left = _tuple(self.left)
        fixed = ["def fixed(b):", *self.fixed, f"return {left}"]
        varying = ["def varying(b, left):", f"{left} = left", *self.varying, f"return {_tuple(self.outputs)}"]
        return "\n    ".join(fixed) + "\n\n\n" + "\n    ".join(varying) + "\n"

    @property
    def outputs(self) -> list[str]:
        """All variables of formulas, and of what knows their margins where those do not."""
        names = dict.fromkeys(name for formula in self.formulas.values() for name in formula.names)
        return [*names, *self._least.values(), *self._left_out.values()]

    # Variables ------------------------------------------------------------------------------------------------

    def _emit(self, node: ir.Num | ir.Formula) -> None:
        if node in self._numbers:
            return
        if isinstance(node, steps.INDEPENDENT) and self._is_fixed.issuperset(self._inputs(node)):
            self._is_fixed.add(node)
        if self._block is None and self._tops(node) and node not in self._is_fixed:
            self._block = []
        if isinstance(node, ir.Num):
            expression = self._number(node)
            name = self._numbers[node] = self._new(node)
            self._line(node, f"{name} = {expression}")
            if isinstance(node, ir.Choose):
                condition = self.formulas[self._same[node.condition]]
                unknown = f"{condition.sat(True)} & ~{condition.sat(False)}"
                self._line(
                    node,
                    f"if {condition.best} is not {condition.worst}: {name} = where({unknown}, nan, {name})",
                )
        else:
            made = self.formulas[node] = self._formula(node, len(self.formulas))
            if node in self._is_fixed:
                self.left.extend(made.names)
            if self._block is not None and not self._tops(node):
                assert isinstance(node, (ir.Quantify, ir.Guarded))
                self._end_block(node, made)

    def _tops(self, node: ir.Num | ir.Formula) -> frozenset[Guarding]:
        """The formulas in whose blocks a node is worked out; none of one that is worked out whatever holds."""
        return self._shared.get(node) or (
            frozenset((self._within[node],)) if node in self._within else frozenset()
        )

    def _inputs(self, node: ir.Num | ir.Formula) -> list[ir.Num | ir.Formula]:
        """What a node is computed of."""
        return self._made_of[node]

    def _operands(self, node: ir.Num | ir.Formula) -> list[ir.Num | ir.Formula]:
        """What a node stands above, of what is computed alike that which is."""
        return [self._same[child] for child in ir.operands(node)]

    def _point(self, node: ir.Projected) -> Point:
        """The point that is projected."""
        x, y = self._operands(node)
        assert isinstance(x, ir.Num)
        assert isinstance(y, ir.Num)
        return x, y

    def _find_points(self, projected: Sequence[ir.Projected]) -> None:
        """Of samples and elements, however they are bound, all are projected at once; the first and the last sample are among them where
        all are projected whatever holds."""
        for node in sorted(projected, key=lambda node: isinstance(self._point(node)[0], ir.Sample)):
            point, tops = self._point(node), self._tops(node)
            points, table = self._points.setdefault(node.line, {}), self._table(*point)
            source: Point | Table = point
            if table is not None and (isinstance(point[0], ir.Column) or points.get(table) == frozenset()):
                source, self._made_of[node] = table, []
            self._source[node] = source
            before = points.get(source, tops)
            points[source] = before | tops if before and tops else frozenset()

    def _table(self, x: ir.Num, y: ir.Num) -> Table | None:
        """The table that a point is a part of; None for one that is not, or not of one alone."""
        if isinstance(x, ir.Column) and isinstance(y, ir.Column):
            fits = min(x.offset, y.offset) >= 0 and self._index(x) == self._index(y)
            return Table(x.axis.signal, x.field, y.field) if fits and x.axis.signal == y.axis.signal else None
        if isinstance(x, ir.Sample) and isinstance(y, ir.Sample):
            fits = x.index == y.index and x.index in _ENDS
            return Table(x.signal, x.field, y.field) if fits and x.signal == y.signal else None
        return None

    def _line(self, node: ir.IR, text: str) -> None:
        (self.fixed if node in self._is_fixed else self._lines(self._block is not None)).append(text)

    def _lines(self, within: bool) -> list[str]:
        """Where what varies is written: within the block that is being written, or before it."""
        if not within:
            return self.varying
        assert self._block is not None
        return self._block

    def _new(self, node: ir.IR) -> str:
        if node not in self._is_fixed and self._free:
            return self._free.pop()
        name = f"x{self._made}"
        self._made += 1
        if node in self._is_fixed:
            self.left.append(name)
        return name

    def _release(self, node: ir.IR) -> None:
        """Nobody needs a number any more: another may have its variable, and its memory is free then."""
        if node in self._shared:  # it is let go with each block
            return
        if node in self._numbers and node not in self._is_fixed and self._numbers[node] not in self._free:
            self._free.append(self._numbers[node])

    def _hold(self, thing: Any, key: Any = None) -> str:
        """The name of an object, or of one that is equal by key."""
        key = ("object", id(thing)) if key is None else key
        if key not in self._names:
            self._names[key] = f"k{len(self._names)}"
            self.named[self._names[key]] = thing
        return self._names[key]

    def _once(self, prefix: str, key: Any, expression: str, within: bool = False) -> str:
        """A variable of something of the batch, set where it is first needed. within: it is of a block that is being written."""
        if (prefix, key) not in self._names:
            self._names[prefix, key] = f"{prefix}{len(self._names)}"
            self._lines(within).append(f"{self._names[prefix, key]} = {expression}")
        return self._names[prefix, key]

    def _end_block(self, top: Guarding, made: Variables) -> None:
        """Write the block of a formula, or what it comes to where its guard holds nowhere: what it is made of has no value then."""
        assert self._block is not None
        block, self._block = self._block, None
        for node, tops in self._shared.items():
            if top in tops and node not in self._is_fixed and node in self._numbers:
                self._free.append(self._numbers.pop(node))
        for line, points in self._points.items():
            for point, tops in points.items():
                name = self._names.pop(("p", line, point), None) if top in tops and len(tops) > 1 else None
                if name is not None:  # the next block makes it anew; its name stays taken
                    self._names["gone", name] = name
        members = [node for node, of in self._within.items() if of is top and node not in self._is_fixed]
        flags = [self._left_out[node] for node in members if node in self._left_out]
        least = [self._least[node] for node in members if node in self._least]
        names = [name for node in members if node in self.formulas for name in self.formulas[node].names]
        every = isinstance(top, ir.Guarded) or top.extreme is Extreme.LEAST
        flag = self._left_out[top] = f"h{len(self._left_out)}"
        values = {
            "True": flags, "None": least, "inf" if every else "minus_inf": [*names, made.worst, made.best],
            "true" if every else "false": [*filter(None, (made.worst_sat, made.best_sat))],
        }  # fmt: skip
        self.varying += [
            f"{flag} = nowhere({self._anywhere(top)})",
            f"if {flag}:",
            *(f"    {' = '.join(each)} = {value}" for value, each in values.items() if each),
            "else:",
            *(f"    {line}" for line in block),
        ]

    def _anywhere(self, top: Guarding) -> str:
        """An expression of where the guard of a formula may hold."""
        assert top.guard is not None
        guard = self.formulas[self._same[top.guard]]
        return self._ranges(top, guard)[1] if isinstance(top, ir.Quantify) else guard.sat(True)

    # Numbers --------------------------------------------------------------------------------------------------

    def _number(self, node: ir.Num) -> str:
        at = [self._numbers[child] for child in self._inputs(node) if isinstance(child, ir.Num)]
        match node:
            case ir.Const():
                return self._hold(np.float64(node.value), ("constant", repr(node.value)))
            case ir.Param():
                return f"b.param({node.name!r})"
            case ir.Column():
                return self._column("table", node)
            case ir.Sample():
                return self._sample(node)
            case ir.Scalar():
                return f"b.scalar({node.signal!r}, {node.field!r})"
            case ir.Arith():
                return f"{at[0]} {node.op} {at[1]}"
            case ir.Neg():
                return f"-{at[0]}"
            case ir.Func():
                return f"{node.name}_({', '.join(at)})"
            case ir.Choose():
                return f"where({self.formulas[self._same[node.condition]].sat(False)}, {at[0]}, {at[1]})"
            case ir.Lookup():
                return f"b.curve({node.table!r})({at[0]})"
            case ir.GridLookup():
                return f"b.grid({node.table!r})({at[0]}, {at[1]})"
            case ir.Station():
                return self._projected(node, 0)
            case ir.Offset():
                return self._projected(node, 1)
            case ir.Direction():
                return self._projected(node, 2)
            case ir.Distance():
                return f"distance(b, {self._hold(node.line)}, {', '.join(at)})"
            case ir.StationGap():
                return f"gap(b, {self._hold(node.line)}, {', '.join(at)})"
            case ir.OnLane():
                return f"on_lane(b, {self._hold(node)}, {', '.join(at)})"
            case ir.StretchRoom():
                return f"stretch_room(b, {self._hold(node.line)}, {', '.join(at)})"
            case ir.Kept():
                return f"b.kept({self._hold(node)})"
            case ir.Ordinal():
                return f"ordinal(b, {self._hold(node.axis)})"
            case ir.Fold():
                return f"fold(b, {self._hold(node)}, {at[0]}, {at[1] if len(at) > 1 else None}, {self._in_range(node)})"
            case _:
                assert_never(node)

    def _in_range(self, node: ir.Fold) -> str:
        """Whether the guard of a fold holds, in the worst case and in the best one."""
        if node.guard is None:
            return "None, None"
        guard = self.formulas[self._same[node.guard]]
        same = f"None if {guard.best} is {guard.worst} else "
        return f"{guard.sat(False)}, {same}{guard.sat(True)}"

    def _projected(self, node: ir.Projected, part: int) -> str:
        """A number of a point's projection onto a line. All points that are plain input are projected together."""
        source = self._source[node]
        if ("p", node.line, source) not in self._names:
            tops = self._points[node.line][source]
            plain = [
                other
                for other, of in self._points[node.line].items()
                if ("p", node.line, other) not in self._names
                and (isinstance(other, Table) or all(isinstance(number, _INPUTS) for number in other))
                and of == tops
            ]
            together = list(dict.fromkeys([source, *plain]))
            points = [_tuple(self._variables(other, bool(tops))) for other in together]
            names = [f"p{len(self._names) + k}" for k in range(len(together))]
            self._names |= {("p", node.line, other): name for other, name in zip(together, names)}
            called = f"project(b, {self._hold(node.line)}, {', '.join(points)})"
            self._lines(bool(tops)).append(f"{_tuple(names)} = {called}")
        found = f"{self._names['p', node.line, source]}[{part}]"
        x, _ = self._point(node)
        return self._part(found, x) if isinstance(source, Table) and isinstance(x, Part) else found

    def _variables(self, source: Point | Table, within: bool) -> list[str]:
        """The variables of points. within: they are of the block that is being written."""
        if isinstance(source, Table):
            return [self._read("table", source.signal, field) for field in (source.x, source.y)]
        block, free = self._block, self._free
        if not within:  # they stand before the block, where variables that it has let go are not free yet
            self._block, self._free = None, [] if block is not None else free
        for number in source:
            self._emit(number)
        self._block, self._free = block, free
        return [self._numbers[number] for number in source]

    def _read(self, read: str, signal: str, field: str) -> str:
        """The variable of a table."""
        return self._once("t", (signal, field), f"b.{read}({signal!r}, {field!r})")

    def _column(self, read: str, node: ir.Column) -> str:
        """A field of the variable of an axis, `offset` samples on; before the start it is that of the first one."""
        table = self._read(read, node.axis.signal, node.field)
        if node.offset < 0:
            key = node.axis.signal, node.field, node.offset
            table = self._once("s", key, f"before({table}, {-node.offset})")
        return self._part(table, node)

    def _sample(self, node: ir.Sample) -> str:
        """A field of one sample; a table has the first one, and the last one, which is repeated up to the end."""
        if node.index in _ENDS:
            return self._part(self._read("table", node.signal, node.field), node)
        return f"b.sample({node.signal!r}, {node.field!r}, {node.index})"

    def _part(self, table: str, node: Part) -> str:
        """What a table has of a column or a sample."""
        index = self._index(node)
        part = f"{table}[{self._hold(index, ('index', repr(index)))}]"
        whole = isinstance(node, ir.Sample) or node.axis.width == 1
        return part if whole else f"{part}.copy()"  # of part of a table, which is in several pieces

    def _index(self, node: Part) -> tuple[slice | int | None, ...]:
        """Where a table has a column or a sample, shaped for broadcasting."""
        if isinstance(node, ir.Column):
            return column_index(node.axis, max(0, node.offset), self.rank)
        if self.rank == 1:  # of nothing but cases, a sample is one number of each
            return (slice(None), node.index)
        return (slice(None), _ENDS[node.index], *(None,) * (self.rank - 2))

    # Formulas -------------------------------------------------------------------------------------------------

    def _formula(self, node: ir.Formula, number: int) -> Variables:
        own = Variables(f"w{number}", f"b{number}", AT_LEAST)
        both = f"{own.worst}, {own.best}"
        parts = [self.formulas[child] for child in self._inputs(node) if isinstance(child, ir.Formula)]
        at = [self._numbers[child] for child in self._inputs(node) if isinstance(child, ir.Num)]
        match node:
            case ir.Truth():
                self._line(node, f"{own.worst} = {own.best} = {'inf' if node.value else '-inf'}")
                return own._replace(says=BOTH)
            case ir.Flag():
                codes = f"b.event({node.signal!r}, {node.field or ''!r}, {node.offset})"
                if node.axis is not None and node.field is not None:
                    codes = self._column("flags", ir.Column(node.axis, node.field, node.offset))
                self._line(node, f"{both} = flagged({codes})")
                return own._replace(says=BOTH)
            case ir.Compare():
                measure, says = steps.MEASURED[node.op]
                x, y = at
                self._line(node, f"{both} = compared({measure.format(x=x, y=y)}, {x}, {y})")
                return own._replace(says=says)
            case ir.InArea():
                weighed = node in self._weighed
                call = "in_area" if weighed else "within"
                self._line(node, f"{both} = {call}(b, {self._hold(node.area)}, {', '.join(at)})")
                return own if weighed else own._replace(says=BOTH)
            case ir.SweptInside():
                asked = f"b, {self._hold(node.area)}, {', '.join(at)}"
                along = self._asked.get(node)
                if along is None:
                    self._line(node, f"{both} = inside_area({asked})")
                    return own
                self._least[node] = f"g{number}"
                axis = f"axis={1 + along.level}, mask={self._mask(along)}"
                self._line(node, f"{both}, g{number} = least({asked}, {axis})")
                return own
            case ir.SweptClear():
                some = self._asked_of.get(node)
                if some is None:
                    self._line(node, f"{both} = clear({', '.join(at)})")
                    return own
                self._left_out[node] = f"g{number}"
                self._line(node, f"{both}, g{number} = asked_clear({self._counted(some)}, {', '.join(at)})")
                return own
            case ir.Scaled():
                (part,) = parts
                by = self._hold(np.float64(node.scale), ("constant", repr(node.scale)))
                return self._sides(
                    node, number, parts, NEITHER,  # a margin that is hardly any may be rounded to 0
                    lambda best: f"{part.margin(best)} / {by}", lambda best: f"{part.sat(best)}",
                )  # fmt: skip
            case ir.Not():
                return self._negation(node, number, parts[0])
            case ir.Connective():
                return self._connective(node, number, *parts)
            case ir.Quantify():
                return self._quantifier(node, number, *parts)
            case ir.Guarded():
                return self._guarded(node, number, *parts)
            case ir.Temporal() | ir.Until() | ir.Shift():
                values = _tuple(part.value for part in parts)
                return self._given(node, number, f"temporal(b, {self._hold(node)}, {values})")
            case ir.Tallied():
                values = _tuple(part.value for part in parts)
                return self._given(node, number, f"tally(b, {self._hold(node)}, {values}, {at[0]})")
            case ir.At():
                (body,) = parts
                index = self._hold(
                    (slice(None),) * (1 + node.axis.level) + (slice(0, 1),), ("first", node.axis.level)
                )
                call, where = "first", index
                if node.place != "first":
                    call = "at"
                    where = f"b.places({node.axis.signal!r}, {node.place!r}), {1 + node.axis.level}"
                return self._sides(
                    node, number, parts, body.says,
                    lambda best: f"{call}({body.margin(best)}, {where})",
                    lambda best: f"{call}({body.sat(best)}, {where})",
                )  # fmt: skip
            case ir.OverRun() | ir.Counted() | ir.InState():
                raise AssertionError("one cycle does not say what a formula over the run comes to")
            case _:
                assert_never(node)

    def _sides(
        self, node: ir.Formula, number: int, parts: Sequence[Variables], says: int, margin: Side, sat: Side
    ) -> Variables:
        """A formula whose two cases are made alike, and are one where those of all its parts are."""
        made = Variables(f"w{number}", f"b{number}", says)
        same = " and ".join(f"{part.best} is {part.worst}" for part in parts)
        self._line(node, f"{made.worst} = {margin(False)}")
        self._line(node, f"{made.best} = {made.worst} if {same} else {margin(True)}")
        if says:
            return made
        made = made._replace(worst_sat=f"ws{number}", best_sat=f"bs{number}")
        self._line(node, f"{made.worst_sat} = {sat(False)}")
        self._line(node, f"{made.best_sat} = {made.worst_sat} if {same} else {sat(True)}")
        return made

    def _given(self, node: ir.Formula, number: int, expression: str) -> Variables:
        """A formula that is made as one object."""
        made = Variables(f"w{number}", f"b{number}", NEITHER, f"ws{number}", f"bs{number}")
        self._line(node, f"{', '.join(made.names)} = parts({expression})")
        return made

    def _negation(self, node: ir.Formula, number: int, part: Variables) -> Variables:
        return self._sides(
            node, number, [part], _denied(part.says),
            lambda best: f"-{part.margin(not best)}", lambda best: f"~{part.sat(not best)}",
        )  # fmt: skip

    def _connective(self, node: ir.Connective, number: int, left: Variables, right: Variables) -> Variables:
        match node.op:
            case "and" | "or":
                extreme, joined = ("minimum", "&") if node.op == "and" else ("maximum", "|")
                return self._sides(
                    node, number, [left, right], left.says & right.says,
                    lambda best: f"{extreme}({left.margin(best)}, {right.margin(best)})",
                    lambda best: f"{left.sat(best)} {joined} {right.sat(best)}",
                )  # fmt: skip
            case "xor":
                return self._given(node, number, f"differ({left.value}, {right.value})")
            case "iff":
                return self._given(node, number, f"negate(differ({left.value}, {right.value}))")
            case _:
                assert_never(node.op)

    def _quantifier(self, node: ir.Quantify, number: int, *parts: Variables) -> Variables:
        every = node.extreme is Extreme.LEAST
        reduce, axis, body = "every" if every else "some", 1 + node.axis.level, parts[-1]
        surely, maybe = self._ranges(node, *parts[:-1])

        def inside(best: bool) -> str:
            return surely if best == every else maybe

        return self._sides(
            node, number, parts, body.says,
            lambda best: f"{reduce}({body.margin(best)}, {axis}, {inside(best)})",
            lambda best: f"{reduce}_sat({body.sat(best)}, {axis}, {inside(best)})",
        )  # fmt: skip

    def _ranges(self, node: ir.Quantify, *guards: Variables) -> tuple[str, str]:
        """The variables of what is in the range of a quantifier in the worst case, and in the best one."""
        mask = self._mask(node.axis)
        if node.guard is None:
            return mask, mask
        # See the reference evaluator: what may be in range counts against a `for all` in the worst case.
        (guard,), key = guards, (self._same[node.guard], mask)
        within = self._same[node.guard] in self._within
        maybe = self._once("r", key, f"inside({mask}, {guard.sat(True)}, {self.rank})", within)
        one = f"{maybe} if {guard.best} is {guard.worst} else "
        return self._once("q", key, f"{one}inside({mask}, {guard.sat(False)}, {self.rank})", within), maybe

    def _mask(self, axis: ir.Axis) -> str:
        """The variable of what is there along an axis."""
        return self._once("m", axis, f"b.mask({self._hold(axis)})")

    def _asked_for_least(
        self, nodes: Sequence[ir.Num | ir.Formula], roots: Sequence[ir.Formula]
    ) -> dict[ir.Num | ir.Formula, ir.Axis]:
        """Swept footprints in an area that one `for all` asks for and nobody else, with its axis."""
        uses = Counter(child for node in nodes for child in self._inputs(node))
        uses.update(self._same[root] for root in roots)
        return {
            self._same[node.body]: node.axis
            for node in nodes
            if isinstance(node, ir.Quantify) and node.extreme is Extreme.LEAST and node.guard is None
            if isinstance(node.body, ir.SweptInside)
            if uses[self._same[node.body]] == 1
        }

    def _asked_of_some(
        self, nodes: Sequence[ir.Num | ir.Formula], roots: Sequence[ir.Formula]
    ) -> dict[ir.IR, Asked]:
        """Swept footprints that keep clear of a box, which a `for all` asks for and nobody else."""
        uses = Counter(child for node in nodes for child in self._inputs(node))
        uses.update(self._same[root] for root in roots)
        users = {child: node for node in nodes for child in self._inputs(node)}
        found: dict[ir.IR, Asked] = {}
        for node in nodes:
            if not isinstance(node, ir.SweptClear):
                continue
            axes, guards, partly = list[ir.Axis](), list[ir.Formula](), list[ir.Num | ir.Formula]()
            at: ir.Num | ir.Formula = node
            floors, least = list[ir.Formula](), True
            while uses[at] == 1:
                user = users.get(at)
                if isinstance(user, ir.Connective):
                    least = least and user.op in ("and", "or")  # these grow with each of their parts
                    if user.op == "or":
                        floors.append(user.right if self._same[user.left] is at else user.left)
                elif (
                    isinstance(user, ir.Quantify)
                    and user.extreme is Extreme.LEAST
                    and self._same[user.body] is at
                ):
                    axes.append(user.axis)
                elif not (isinstance(user, ir.Guarded) and self._same[user.body] is at):
                    break
                if isinstance(user, (ir.Quantify, ir.Guarded)) and user.guard is not None:
                    guards.append(user.guard)
                partly.append(at)
                at = user
            if axes:
                varying = {below for below in ir.below(node) if isinstance(below, ir.Axis)}
                by_case = least and varying.issubset(axes)
                found[node] = Asked(tuple(axes), tuple(guards), tuple(partly), tuple(floors), by_case)
        return found

    def _counted(self, asked: Asked) -> str:
        """What must hold for margins to count, whether only the least of a case does, where it is known what counts, and below what none does."""
        guards = [self.formulas[self._same[guard]] for guard in asked.guards]
        floors = [self.formulas.get(self._same[floor]) for floor in asked.floors]
        conditions = _tuple([*map(self._mask, asked.axes), *(guard.sat(True) for guard in guards)])
        known = [floor for floor in floors if floor is not None]
        by_case = asked.by_case and len(known) == len(floors)  # what stands behind it in an `or` comes later
        certain = " and ".join(f"{one.best} is {one.worst}" for one in (*guards, *known)) or True
        return f"{conditions}, {by_case and certain}, {_tuple(floor.worst for floor in known)}"

    def _guarded(self, node: ir.Guarded, number: int, guard: Variables, body: Variables) -> Variables:
        return self._sides(
            node, number, [guard, body], body.says,
            lambda best: f"where({guard.sat(not best)}, {body.margin(best)}, inf)",
            lambda best: f"{body.sat(best)} | ~{guard.sat(not best)}",
        )  # fmt: skip


def _denied(says: int) -> int:
    """What a margin's sign says when turned round: what fails at 0 holds there when denied."""
    return (says & AT_LEAST and ABOVE) | (says & ABOVE and AT_LEAST)


def ordered(roots: Iterable[ir.Num | ir.Formula]) -> list[ir.Num | ir.Formula]:
    """All nodes below roots, children first; iterative, so depth is no limit."""
    done: dict[ir.Num | ir.Formula, None] = {}
    stack: list[tuple[ir.Num | ir.Formula, bool]] = [(root, False) for root in reversed(list(roots))]
    while stack:
        node, ready = stack.pop()
        if node in done:
            continue
        if ready:
            done[node] = None
        else:
            stack.append((node, True))
            stack.extend((child, False) for child in reversed(ir.operands(node)))
    return list(done)


def _tuple(names: Iterable[str]) -> str:
    """A tuple, to make or to take apart."""
    return f"({''.join(f'{name}, ' for name in names)})"
