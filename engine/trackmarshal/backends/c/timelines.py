"""Temporal operators: the operand at every sample into a series of the context, then one pass over the timeline."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, assert_never

from trackmarshal.backends.c.names import literal
from trackmarshal.backends.c.slots import mark
from trackmarshal.backends.c.statements import Block
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme

if TYPE_CHECKING:
    from trackmarshal.backends.c.expressions import Writer


def series(self: Writer, node: ir.Timed, block: Block) -> tuple[int, ...]:
    """The series that hold a formula's value at every sample: one for what is known, else the worst and the best case."""
    operands = [node.left, node.right] if isinstance(node, ir.Until) else [node.operand]
    free: frozenset[ir.Axis] = frozenset()
    for operand in operands:
        free |= self.free(operand)
    home = self.home(free - {node.axis}, block)
    key = ("series", node)
    known = home.known.get(key)
    if known is None:
        known = home.known[key] = _written(self, node, operands, home)
    assert isinstance(known, tuple)
    return known


def _written(self: Writer, node: ir.Timed, operands: list[ir.Formula], home: Block) -> tuple[int, ...]:
    total = f"in->{self.plan.input(node.axis.signal).c_name}.count"
    sides = 1 if self.known else 2
    sources: list[list[int]] = []
    for operand in operands:
        slots = [self.fresh() for _ in range(sides)]
        i = f"i{self.fresh()}"
        loop = home.open(f"for (size_t {i} = 0u; {i} < {total}; ++{i})")
        loop.binds[node.axis] = i
        value = self.formula(operand, loop)
        for slot, (sat, margin) in zip(slots, value.sides):
            self.add(loop, f"c->series[{mark(slot)}].sat[{i}] = {sat};")
            self.add(loop, f"c->series[{mark(slot)}].margin[{i}] = {margin};")
        home.close(loop)
        sources.append(slots)
    result = tuple(self.fresh() for _ in range(sides))
    for side, target in enumerate(result):
        self.add(
            home,
            _call(self, node, total, [s[side] for s in sources], target),
        )
    return result


def _call(self: Writer, node: ir.Timed, total: str, own: list[int], target: int) -> str:
    """The pass over the timeline."""
    match node:
        case ir.Temporal() | ir.Until():
            lower = 0.0 if node.lower is None else node.lower
            upper = math.inf if node.upper is None else node.upper
            if not 0.0 <= lower <= upper:
                raise self.refuse(
                    node, f"[{lower:g} s, {upper:g} s] is no window: 0 <= lower <= upper does not hold"
                )
            signal = self.plan.input(node.axis.signal).c_name
            times = f"in->{signal}.{self.plan.field_name(node.axis.signal, 't')}"
            window = f"c, {times}, {total}, {literal(lower)}, {literal(upper)}"
            past = "true" if node.past else "false"
            if isinstance(node, ir.Until):
                return f"tm_held({window}, {past}, {mark(own[0])}u, {mark(own[1])}u, {mark(target)}u);"
            least = "true" if node.extreme is Extreme.LEAST else "false"
            return f"tm_extreme({window}, {past}, {least}, {mark(own[0])}u, {mark(target)}u);"
        case ir.Shift():
            ahead, weak = ("true" if node.step > 0 else "false"), ("true" if node.weak else "false")
            return f"tm_shift(c, {total}, {ahead}, {weak}, {mark(own[0])}u, {mark(target)}u);"
        case _:
            assert_never(node)
