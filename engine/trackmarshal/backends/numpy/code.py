"""Rules as Python source over arrays: straight-line code in which each shared node is computed once for a whole batch.

A number is one variable, a formula several (`formulas`). What is only asked for where a guard holds stands in a block of that guard's formula.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from typing import Any, assert_never

import numpy as np

from trackmarshal.backends.numpy import asked, folds, lanes, logic, places, steps, tallies, time
from trackmarshal.backends.numpy.batch import before
from trackmarshal.backends.numpy.blocks import Guarding, Node, blocks, together
from trackmarshal.backends.numpy.formulas import Formulas, Variables
from trackmarshal.backends.numpy.inputs import INPUTS, Inputs, Part
from trackmarshal.backends.numpy.points import Point, Table, projections
from trackmarshal.backends.numpy.sharing import representatives
from trackmarshal.backends.numpy.writing import Writing, tuple_of
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


class Code:
    """Source of two functions: of what no case changes unless it overrides a parameter, and of the rest."""

    def __init__(self, formulas: Sequence[ir.Formula], ranges: Sequence[ir.Formula], rank: int = 1) -> None:
        """Of the `ranges`, other than of the `formulas`, only whether they hold is asked. rank: of arrays, at least."""
        roots = [*formulas, *ranges]
        #: Of nodes that are computed alike, the one that is.
        self._same = representatives(ir.ordered(roots))
        nodes = list(dict.fromkeys(self._same.values()))
        #: What nodes are computed of.
        self._made_of = {node: [self._same[child] for child in ir.operands(node)] for node in nodes}
        #: Nodes that are only worked out where a guard holds anywhere, with the formula that has it; and those that several such have.
        self._within, self._shared = blocks(nodes, roots, self._same)
        nodes = together(nodes, self._within, self._shared)
        axes = [child for node in nodes for child in node.children() if isinstance(child, ir.Axis)]
        self.rank = max([rank, *(axis.level + 2 for axis in axes)])
        self.writing = Writing({**_CALLED, **{f"{name}_": f for name, f in steps.CALLS.items()}})
        self._inputs = Inputs(self.writing, self.rank)
        #: Swept footprints that keep clear of a box, of which only some are asked.
        self._asked_of = asked.of_some(self._made_of, roots, self._same)
        self._formulas = Formulas(
            self.writing, self._inputs, self._same, self._within, {self._same[node] for node in deciding(formulas)},
            asked.of_least(self._made_of, roots, self._same), self._asked_of,
        )  # fmt: skip
        points = {node: self._point(node) for node in nodes if isinstance(node, ir.Projected)}
        self._points, self._source = projections(points, self._tops, self.rank)
        self._made_of |= {node: [] for node, source in self._source.items() if isinstance(source, Table)}
        used = {child for node in nodes for child in self._made_of[node]}
        nodes = [node for node in nodes if not isinstance(node, INPUTS) or node in used]
        last_use = {child: place for place, node in enumerate(nodes) for child in self._made_of[node]}
        for place, node in enumerate(nodes):
            self._emit(node)
            for child in self._made_of[node]:
                if last_use[child] == place and child not in self._shared:  # those are let go with each block
                    self.writing.release(child)
        made, left_out = self._formulas.made, self._formulas.left_out
        #: Where each formula's variables are.
        self.formulas = made | {node: made[one] for node, one in self._same.items() if one in made}
        #: Where, among the outputs, is what knows all margins of a formula of which only the least are among them.
        at = {name: place for place, name in enumerate(self.outputs)}
        least = self._formulas.least
        self.least = {node: at[least[one]] for node, one in self._same.items() if one in least}
        #: Where, among the outputs, is whether a formula's margins are only those that its rule's verdict takes.
        partly = {
            node: at[left_out[top]]
            for node, top in self._within.items()
            if node in made and node not in self.writing.unchanged and top in left_out
        }
        partly |= {
            part: at[left_out[one]]
            for one, asking in self._asked_of.items()
            if one in left_out
            for part in asking.partly
        }
        self.partly = {node: partly[one] for node, one in self._same.items() if one in partly}

    def functions(self) -> tuple[Callable[[Any], tuple[Any, ...]], Callable[[Any, Any], tuple[Any, ...]]]:
        """The compiled functions: of a batch; of a batch and what the first one gave.

        All that a spec brings into the source are names, as Python writes strings, and numbers, which are held by name.
        """
        made: dict[str, Any] = dict(self.writing.named)
        exec(compile(self.source, "<rules>", "exec"), made)
        return made["fixed"], made["varying"]

    @property
    def source(self) -> str:
        """The source of both functions."""
        written, left = self.writing, tuple_of(self.writing.left)
        fixed = ["def fixed(b):", *written.fixed, f"return {left}"]
        outputs = tuple_of(self.outputs)
        varying = ["def varying(b, left):", f"{left} = left", *written.varying, f"return {outputs}"]
        return "\n    ".join(fixed) + "\n\n\n" + "\n    ".join(varying) + "\n"

    @property
    def outputs(self) -> list[str]:
        """All variables of formulas, and of what knows their margins where those do not."""
        names = dict.fromkeys(name for formula in self.formulas.values() for name in formula.names)
        return [*names, *self._formulas.least.values(), *self._formulas.left_out.values()]

    def _emit(self, node: Node) -> None:
        writing, tops = self.writing, self._tops(node)
        if node in writing.numbers:
            return
        if isinstance(node, steps.INDEPENDENT) and writing.unchanged.issuperset(self._made_of[node]):
            writing.unchanged.add(node)
        if writing.block is None and tops and node not in writing.unchanged:
            writing.block = []
        if isinstance(node, ir.Num):
            name = writing.number(node, self._number(node))
            if isinstance(node, ir.Choose):
                condition = self._formulas.of(node.condition)
                unknown = f"{condition.sat(True)} & ~{condition.sat(False)}"
                changed = f"{name} = where({unknown}, nan, {name})"
                writing.line(node, f"if {condition.best} is not {condition.worst}: {changed}")
        else:
            made = self._formulas.write(node, self._made_of[node])
            if node in writing.unchanged:
                writing.left.extend(made.names)
            if writing.block is not None and not tops:
                assert isinstance(node, (ir.Quantify, ir.Guarded))
                self._end_block(node, made)

    def _tops(self, node: Node) -> frozenset[Guarding]:
        """The formulas in whose blocks a node is worked out; none of one that is worked out whatever holds."""
        return self._shared.get(node) or (
            frozenset((self._within[node],)) if node in self._within else frozenset()
        )

    def _point(self, node: ir.Projected) -> Point:
        """The point that is projected."""
        x, y = (self._same[number] for number in (node.x, node.y))
        assert isinstance(x, ir.Num)
        assert isinstance(y, ir.Num)
        return x, y

    def _end_block(self, top: Guarding, made: Variables) -> None:
        """Write the block of a formula, or what it comes to where its guard holds nowhere: what it is made of has no value then."""
        writing, left_out = self.writing, self._formulas.left_out
        assert writing.block is not None
        block, writing.block = writing.block, None
        for node, tops in self._shared.items():
            if top in tops:
                writing.forget(node)
        for line, points in self._points.items():
            for point, tops in points.items():
                name = writing.names.pop(("p", line, point), None) if top in tops and len(tops) > 1 else None
                if name is not None:  # the next block makes it anew; its name stays taken
                    writing.names["gone", name] = name
        members = [node for node, of in self._within.items() if of is top and node not in writing.unchanged]
        flags = [left_out[node] for node in members if node in left_out]
        least = [self._formulas.least[node] for node in members if node in self._formulas.least]
        names = [
            name
            for node in members
            if node in self._formulas.made
            for name in self._formulas.made[node].names
        ]
        every = isinstance(top, ir.Guarded) or top.extreme is Extreme.LEAST
        flag = left_out[top] = f"h{len(left_out)}"
        values = {
            "True": flags, "None": least, "inf" if every else "minus_inf": [*names, made.worst, made.best],
            "true" if every else "false": [*filter(None, (made.worst_sat, made.best_sat))],
        }  # fmt: skip
        writing.varying += [
            f"{flag} = nowhere({self._anywhere(top)})",
            f"if {flag}:",
            *(f"    {' = '.join(each)} = {value}" for value, each in values.items() if each),
            "else:",
            *(f"    {line}" for line in block),
        ]

    def _anywhere(self, top: Guarding) -> str:
        """An expression of where the guard of a formula may hold."""
        assert top.guard is not None
        if isinstance(top, ir.Quantify):
            return self._formulas.ranges(top)[1]
        return self._formulas.of(top.guard).sat(True)

    def _number(self, node: ir.Num) -> str:
        at = [self.writing.numbers[child] for child in self._made_of[node] if isinstance(child, ir.Num)]
        match node:
            case ir.Const():
                return self.writing.hold(np.float64(node.value), ("constant", repr(node.value)))
            case ir.Param():
                return f"b.param({node.name!r})"
            case ir.Column():
                return self._inputs.column(node)
            case ir.Sample():
                return self._inputs.sample(node)
            case ir.Scalar():
                return f"b.scalar({node.signal!r}, {node.field!r})"
            case ir.Arith():
                return f"{at[0]} {node.op} {at[1]}"
            case ir.Neg():
                return f"-{at[0]}"
            case ir.Func():
                return f"{node.name}_({', '.join(at)})"
            case ir.Choose():
                return f"where({self._formulas.of(node.condition).sat(False)}, {at[0]}, {at[1]})"
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
                return f"distance(b, {self.writing.hold(node.line)}, {', '.join(at)})"
            case ir.StationGap():
                return f"gap(b, {self.writing.hold(node.line)}, {', '.join(at)})"
            case ir.OnLane():
                return f"on_lane(b, {self.writing.hold(node)}, {', '.join(at)})"
            case ir.StretchRoom():
                return f"stretch_room(b, {self.writing.hold(node.line)}, {', '.join(at)})"
            case ir.Kept():
                return f"b.kept({self.writing.hold(node)})"
            case ir.Ordinal():
                return f"ordinal(b, {self.writing.hold(node.axis)})"
            case ir.Fold():
                return f"fold(b, {self.writing.hold(node)}, {at[0]}, {at[1] if len(at) > 1 else None}, {self._in_range(node)})"
            case _:
                assert_never(node)

    def _in_range(self, node: ir.Fold) -> str:
        """Whether the guard of a fold holds, in the worst case and in the best one."""
        if node.guard is None:
            return "None, None"
        guard = self._formulas.of(node.guard)
        same = f"None if {guard.best} is {guard.worst} else "
        return f"{guard.sat(False)}, {same}{guard.sat(True)}"

    def _projected(self, node: ir.Projected, part: int) -> str:
        """A number of a point's projection onto a line. All points that are plain input are projected together."""
        source, writing = self._source[node], self.writing
        if ("p", node.line, source) not in writing.names:
            tops = self._points[node.line][source]
            plain = [
                other
                for other, of in self._points[node.line].items()
                if ("p", node.line, other) not in writing.names
                and (isinstance(other, Table) or all(isinstance(number, INPUTS) for number in other))
                and of == tops
            ]
            together = list(dict.fromkeys([source, *plain]))
            points = [tuple_of(self._variables(other, bool(tops))) for other in together]
            names = [f"p{len(writing.names) + k}" for k in range(len(together))]
            writing.names |= {("p", node.line, other): name for other, name in zip(together, names)}
            called = f"project(b, {writing.hold(node.line)}, {', '.join(points)})"
            writing.lines(bool(tops)).append(f"{tuple_of(names)} = {called}")
        found = f"{writing.names['p', node.line, source]}[{part}]"
        x = self._same[node.x]
        return self._inputs.part(found, x) if isinstance(source, Table) and isinstance(x, Part) else found

    def _variables(self, source: Point | Table, within: bool) -> list[str]:
        """The variables of points. within: they are of the block that is being written."""
        if isinstance(source, Table):
            return [self._inputs.table(source.signal, field) for field in (source.x, source.y)]
        with nullcontext() if within else self.writing.before_the_block():
            for number in source:
                self._emit(number)
        return [self.writing.numbers[number] for number in source]
