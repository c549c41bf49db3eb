"""Temporal operators: the operand at every sample into a series of the context, then one pass over the timeline."""

from __future__ import annotations

import math
from typing import assert_never

from trackmarshal.backends.c import tree as c
from trackmarshal.backends.c.functions.writer import Writer
from trackmarshal.backends.c.names import literal
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.overrun import nanoseconds

#: What is computed for all samples of a timeline at once.
Passed = ir.Timed | ir.Tallied


def series(writer: Writer, node: Passed, scope: c.Scope) -> tuple[c.Expr, ...]:
    """The series that hold a formula's value at every sample, or a count: one for what is known, else the worst and the best case."""
    operands = operands_of(node)
    free: frozenset[ir.Axis] = frozenset()
    for operand in operands:
        free |= writer.facts.free(operand)
    home = writer.home(free - {node.axis}, scope)
    known = writer.series.get((home, node))
    if known is None:
        known = writer.series[home, node] = _written(writer, node, operands, home)
    return tuple(_place(writer, slot) for slot in known)


def operands_of(node: Passed) -> list[ir.Formula]:
    """The formulas that a temporal operator is about."""
    if isinstance(node, ir.Tallied):
        return [node.counted, *([] if node.reset is None else [node.reset])]
    return [node.left, node.right] if isinstance(node, ir.Until) else [node.operand]


def _place(writer: Writer, slot: c.Expr) -> c.Expr:
    return c.Address(_series(writer, slot))


def _series(writer: Writer, slot: c.Expr) -> c.Expr:
    return c.Element(c.Member(writer.name("context"), "series", True), slot)


def _written(writer: Writer, node: Passed, operands: list[ir.Formula], home: c.Scope) -> list[c.Expr]:
    sides = 1 if writer.known else 2
    sources: list[list[c.Expr]] = []
    for operand in operands:
        slots = [_slot(writer) for _ in range(sides)]
        loop = writer.loop(node.axis, home, writer.names_of(node.axis, home))
        value = writer.formula(operand, loop)
        if node.axis.signal in writer.plan.courses:
            missing = c.Element(_of_course(writer, node.axis, "missing"), writer.index(node.axis, loop))
            value = writer.over("unless_missed", missing, value)
        kept = [*(_place(writer, slot) for slot in slots), writer.index(node.axis, loop), value]
        if writer.known:
            kept.append(c.Address(c.Name("known")))
        writer.add(loop, c.Evaluate(writer.over("keep", *kept)))
        home.close(loop)
        sources.append(slots)
    result = [_slot(writer) for _ in range(sides)]
    for side, target in enumerate(result):
        if isinstance(node, ir.Tallied):
            # A count surely starts anew where it may: what is sure is what comes after that.
            own = [sources[0][side], *(source[sides - 1 - side] for source in sources[1:])]
            call = _tally(writer, node, own, target, home)
        else:
            call = _call(writer, node, [s[side] for s in sources], target, home)
        writer.add(home, c.Evaluate(call))
    return result


def _slot(writer: Writer) -> c.Expr:
    writer.slots += 1
    return c.Slot(writer.slots)


def _call(writer: Writer, node: ir.Timed, own: list[c.Expr], target: c.Expr, home: c.Scope) -> c.Expr:
    """The pass over the timeline."""
    total, context = writer.count(node.axis), writer.name("context")
    match node:
        case ir.Temporal() | ir.Until():
            lower = 0.0 if node.lower is None else node.lower
            upper = math.inf if node.upper is None else node.upper
            if not 0.0 <= lower <= upper:
                raise writer.refuse(
                    node, f"[{lower:g} s, {upper:g} s] is no window: 0 <= lower <= upper does not hold"
                )
            ends = (c.Literal(literal(bound(end))) for end in (lower, upper))
            window = (context, *_times(writer, node.axis, home), total, *ends, truth(node.past))
            if isinstance(node, ir.Until):
                return writer.call("tm_held", *window, *own, target)
            return writer.call("tm_extreme", *window, truth(node.extreme is Extreme.LEAST), *own, target)
        case ir.Shift():
            return writer.call(
                "tm_shift", context, total, truth(node.step > 0), truth(node.weak), *own, target
            )
        case _:
            assert_never(node)


def _tally(writer: Writer, node: ir.Tallied, own: list[c.Expr], target: c.Expr, home: c.Scope) -> c.Expr:
    """The pass over the timeline that counts."""
    course = node.axis.signal in writer.plan.courses
    total, context = writer.count(node.axis), writer.name("context")
    missing = _of_course(writer, node.axis, "missing") if course else c.Name("NULL")
    if node.reset is not None:
        return writer.call("tm_tally_anew", context, missing, total, *own, target)
    upper = math.inf if node.upper is None else node.upper
    times, back = _times(writer, node.axis, home), c.Literal(literal(bound(upper)))
    return writer.call("tm_tally_last", context, *times, missing, total, back, *own, target)


def _times(writer: Writer, axis: ir.Axis, scope: c.Scope) -> tuple[c.Expr, c.Expr]:
    """When samples begin and end, in whole nanoseconds: those of a course may be gaps, those of a timeline end where they begin."""
    if axis.signal in writer.plan.courses:
        return _of_course(writer, axis, "begin"), _of_course(writer, axis, "end")
    slot = writer.times.get(axis.signal)
    if slot is None:
        slot = writer.times[axis.signal] = _slot(writer)
        root = writer.home(frozenset(), scope)
        seconds = writer.field(axis.signal, "t")
        writer.add(
            root, c.Evaluate(writer.call("tm_stamps", seconds, writer.count(axis), _place(writer, slot)))
        )
    times = c.Member(_series(writer, slot), "margin", False)
    return times, times


def _of_course(writer: Writer, axis: ir.Axis, member: str) -> c.Expr:
    return c.Member(writer.input(axis.signal), member, False)


def bound(seconds: float) -> float:
    """The bound of a window, in whole nanoseconds."""
    return seconds if math.isinf(seconds) else float(nanoseconds(seconds))


def truth(value: bool) -> c.Expr:
    """A Boolean constant."""
    return c.Literal("true" if value else "false")
