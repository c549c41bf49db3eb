"""What generated code does for each kind of formula.

A formula is two variables, its margin in the worst and in the best case, which are the same object where nothing is undefined; whether it
holds is mostly read off its margin, else it has two more variables for that.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import NamedTuple, assert_never

import numpy as np

from trackmarshal.backends.numpy import steps
from trackmarshal.backends.numpy.asked import Asked
from trackmarshal.backends.numpy.blocks import Guarding, Node
from trackmarshal.backends.numpy.inputs import Inputs
from trackmarshal.backends.numpy.logic import ABOVE, AT_LEAST, BOTH, NEITHER
from trackmarshal.backends.numpy.writing import Writing, tuple_of
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme

#: An expression of the best case, or of the worst.
Side = Callable[[bool], str]


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


class Formulas:
    """The variables of all formulas that were written."""

    def __init__(
        self, writing: Writing, inputs: Inputs, same: Mapping[Node, Node], within: Mapping[Node, Guarding],
        weighed: Collection[Node], least: Mapping[ir.IR, ir.Axis], some: Mapping[ir.IR, Asked],
    ) -> None:  # fmt: skip
        """same: of every node the one that is computed alike. within: by node, the formula in whose block it is. weighed: those of whose margins
        the size counts. least, some: see `asked`."""
        self._writing, self._inputs = writing, inputs
        self._same, self._within, self._weighed = same, within, weighed
        self._asked_least, self._asked_some = least, some
        #: Where each formula's variables are.
        self.made: dict[ir.IR, Variables] = {}
        #: Variables that hold the rest, where only the least margins are worked out; and those that say whether any were left out.
        self.least: dict[ir.IR, str] = {}
        self.left_out: dict[ir.IR, str] = {}

    def of(self, node: ir.Formula) -> Variables:
        """The variables of a formula, or of one that is computed alike."""
        return self.made[self._same[node]]

    def write(self, node: ir.Formula, children: Sequence[Node]) -> Variables:
        """Write what a formula comes to. children: what it is computed of, which was written before."""
        made = self.made[node] = self._written(node, children, len(self.made))
        return made

    def _written(self, node: ir.Formula, children: Sequence[Node], number: int) -> Variables:
        line, hold = self._writing.line, self._writing.hold
        own = Variables(f"w{number}", f"b{number}", AT_LEAST)
        both = f"{own.worst}, {own.best}"
        parts = [self.made[child] for child in children if isinstance(child, ir.Formula)]
        at = [self._writing.numbers[child] for child in children if isinstance(child, ir.Num)]
        match node:
            case ir.Truth():
                line(node, f"{own.worst} = {own.best} = {'inf' if node.value else '-inf'}")
                return own._replace(says=BOTH)
            case ir.Flag():
                codes = f"b.event({node.signal!r}, {node.field or ''!r}, {node.offset})"
                if node.axis is not None and node.field is not None:
                    codes = self._inputs.column(ir.Column(node.axis, node.field, node.offset), "flags")
                line(node, f"{both} = flagged({codes})")
                return own._replace(says=BOTH)
            case ir.Compare():
                measure, says = steps.MEASURED[node.op]
                x, y = at
                line(node, f"{both} = compared({measure.format(x=x, y=y)}, {x}, {y})")
                return own._replace(says=says)
            case ir.InArea():
                weighed = node in self._weighed
                call = "in_area" if weighed else "within"
                line(node, f"{both} = {call}(b, {hold(node.area)}, {', '.join(at)})")
                return own if weighed else own._replace(says=BOTH)
            case ir.SweptInside():
                asked = f"b, {hold(node.area)}, {', '.join(at)}"
                along = self._asked_least.get(node)
                if along is None:
                    line(node, f"{both} = inside_area({asked})")
                    return own
                self.least[node] = f"g{number}"
                axis = f"axis={1 + along.level}, mask={self._inputs.mask(along)}"
                line(node, f"{both}, g{number} = least({asked}, {axis})")
                return own
            case ir.SweptClear():
                some = self._asked_some.get(node)
                if some is None:
                    line(node, f"{both} = clear({', '.join(at)})")
                    return own
                self.left_out[node] = f"g{number}"
                line(node, f"{both}, g{number} = asked_clear({self._counted(some)}, {', '.join(at)})")
                return own
            case ir.Scaled():
                (part,) = parts
                by = hold(np.float64(node.scale), ("constant", repr(node.scale)))
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
                values = tuple_of(part.value for part in parts)
                return self._given(node, number, f"temporal(b, {hold(node)}, {values})")
            case ir.Tallied():
                values = tuple_of(part.value for part in parts)
                return self._given(node, number, f"tally(b, {hold(node)}, {values}, {at[0]})")
            case ir.At():
                (body,) = parts
                level = node.axis.level
                index = hold((slice(None),) * (1 + level) + (slice(0, 1),), ("first", level))
                call, where = "first", index
                if node.place != "first":
                    call, where = "at", f"b.places({node.axis.signal!r}, {node.place!r}), {1 + level}"
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
        self._writing.line(node, f"{made.worst} = {margin(False)}")
        self._writing.line(node, f"{made.best} = {made.worst} if {same} else {margin(True)}")
        if says:
            return made
        made = made._replace(worst_sat=f"ws{number}", best_sat=f"bs{number}")
        self._writing.line(node, f"{made.worst_sat} = {sat(False)}")
        self._writing.line(node, f"{made.best_sat} = {made.worst_sat} if {same} else {sat(True)}")
        return made

    def _given(self, node: ir.Formula, number: int, expression: str) -> Variables:
        """A formula that is made as one object."""
        made = Variables(f"w{number}", f"b{number}", NEITHER, f"ws{number}", f"bs{number}")
        self._writing.line(node, f"{', '.join(made.names)} = parts({expression})")
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
        surely, maybe = self.ranges(node)

        def inside(best: bool) -> str:
            return surely if best == every else maybe

        return self._sides(
            node, number, parts, body.says,
            lambda best: f"{reduce}({body.margin(best)}, {axis}, {inside(best)})",
            lambda best: f"{reduce}_sat({body.sat(best)}, {axis}, {inside(best)})",
        )  # fmt: skip

    def ranges(self, node: ir.Quantify) -> tuple[str, str]:
        """The variables of what is in the range of a quantifier in the worst case, and in the best one."""
        mask, once, rank = self._inputs.mask(node.axis), self._writing.once, self._inputs.rank
        if node.guard is None:
            return mask, mask
        # See the reference evaluator: what may be in range counts against a `for all` in the worst case.
        guard, key = self.of(node.guard), (self._same[node.guard], mask)
        within = self._same[node.guard] in self._within
        maybe = once("r", key, f"inside({mask}, {guard.sat(True)}, {rank})", within)
        one = f"{maybe} if {guard.best} is {guard.worst} else "
        return once("q", key, f"{one}inside({mask}, {guard.sat(False)}, {rank})", within), maybe

    def _counted(self, asked: Asked) -> str:
        """What must hold for margins to count, whether only the least of a case does, where it is known what counts, and below what none does."""
        guards = [self.of(guard) for guard in asked.guards]
        floors = [self.made.get(self._same[floor]) for floor in asked.floors]
        conditions = tuple_of([*map(self._inputs.mask, asked.axes), *(guard.sat(True) for guard in guards)])
        known = [floor for floor in floors if floor is not None]
        by_case = asked.by_case and len(known) == len(floors)  # what stands behind it in an `or` comes later
        certain = " and ".join(f"{one.best} is {one.worst}" for one in (*guards, *known)) or True
        return f"{conditions}, {by_case and certain}, {tuple_of(floor.worst for floor in known)}"

    def _guarded(self, node: ir.Guarded, number: int, guard: Variables, body: Variables) -> Variables:
        return self._sides(
            node, number, [guard, body], body.says,
            lambda best: f"where({guard.sat(not best)}, {body.margin(best)}, inf)",
            lambda best: f"{body.sat(best)} | ~{guard.sat(not best)}",
        )  # fmt: skip


def _denied(says: int) -> int:
    """What a margin's sign says when turned round: what fails at 0 holds there when denied."""
    return (says & AT_LEAST and ABOVE) | (says & ABOVE and AT_LEAST)
