"""Nodes of the IR as closures: each computes its value from those of earlier nodes, in slots of a list."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np

from trackmarshal.backends.numpy import logic, places, time
from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.backends.numpy.logic import Value
from trackmarshal.ir import nodes as ir

#: Numbers that one thread adds up.
FEW = 4096
#: A step: the value of its node, from the batch and the values of earlier steps.
Step = Callable[[Batch, list[Any]], Any]


def _pow(x: Any, y: Any) -> Any:
    """A power; NaN in, NaN out, where IEEE 754 says that anything to the 0 is 1, and 1 to anything."""
    power = np.power(x, y)
    # For a single exponent of 0.5 numpy takes the root, which is another thing for -0.0 and for minus infinity.
    power = np.where(y == 0.5, np.where(x == -np.inf, np.inf, power + 0.0), power)
    return np.where(np.isnan(x) | np.isnan(y), np.nan, power)


_ARITH: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
}  # fmt: skip
_FUNC: dict[str, Callable[..., Any]] = {
    "abs": np.abs, "sqrt": np.sqrt, "floor": np.floor, "sin": np.sin, "cos": np.cos, "tan": np.tan, "exp": np.exp,
    "log": np.log, "atan2": np.arctan2,
    # Adding 0.0 turns -0.0 into 0.0: see `ir.arithmetic`.
    "min": lambda x, y: np.minimum(x, y) + 0.0, "max": lambda x, y: np.maximum(x, y) + 0.0,
    "pow": _pow,
}  # fmt: skip
#: How far a comparison is from its boundary, and what that says. By gradual underflow a difference is 0 for equal numbers only.
_COMPARE: dict[str, tuple[Callable[[Any, Any], Any], int]] = {
    "<": (lambda x, y: y - x, logic.ABOVE), "<=": (lambda x, y: y - x, logic.AT_LEAST),
    ">": (lambda x, y: x - y, logic.ABOVE), ">=": (lambda x, y: x - y, logic.AT_LEAST),
    "==": (lambda x, y: -abs(x - y), logic.AT_LEAST), "!=": (lambda x, y: abs(x - y), logic.ABOVE),
}  # fmt: skip


def step(node: ir.IR, at: tuple[int, ...]) -> Step:
    """The step of a node whose inputs are in the slots `at`."""
    match node:
        case ir.Const():
            constant = np.float64(node.value)
            return lambda b, v: constant
        case ir.Param():
            return lambda b, v: b.param(node.name)
        case ir.Column():
            return lambda b, v: b.column(node.axis, node.field, node.offset)
        case ir.Sample():
            return lambda b, v: b.per_case(
                [case.columns[node.signal][node.field][node.index] for case in b.cases]
            )
        case ir.Scalar():
            return lambda b, v: b.numbers([case.scalars[node.signal][node.field] for case in b.cases])
        case ir.Arith():
            return _binary(_ARITH[node.op], *at)
        case ir.Neg():
            return _unary(operator.neg, *at)
        case ir.Func():
            return _unary(_FUNC[node.name], *at) if len(at) == 1 else _binary(_FUNC[node.name], *at)
        case ir.Choose():
            i, j, k = at
            return lambda b, v: _choose(v[i], v[j], v[k])
        case ir.Lookup():
            (i,) = at
            return lambda b, v: b.curve(node.table)(v[i])
        case ir.Along():
            return lambda b, v: places.along(b, node, [v[i] for i in at])
        case ir.Truth():
            truth = logic.defined(np.float64(np.inf if node.value else -np.inf), logic.BOTH)
            return lambda b, v: truth
        case ir.Flag():
            return lambda b, v: _flag(b, node)
        case ir.Compare():
            return _comparison(node.op, *at)
        case ir.Geometry():
            return lambda b, v: places.predicate(b, node, [v[i] for i in at])
        case ir.Not():
            return _unary(logic.negate, *at)
        case ir.Connective():
            i, j = at
            return lambda b, v: logic.connect(node.op, v[i], v[j])
        case ir.Quantify():
            return _quantify(node, *at)
        case ir.Guarded():
            return _binary(_guarded, *at)
        case ir.Temporal() | ir.Until() | ir.Shift() | ir.Edge():
            return lambda b, v: time.operator(b, node, [v[i] for i in at])
        case ir.First():
            (i,) = at
            return lambda b, v: _first(node.axis, v[i])
        case _:
            raise AssertionError(f"unknown node {type(node).__name__}")


def independent(node: ir.IR) -> bool:
    """Whether a node has one value for all cases when its inputs do and no case overrides a parameter."""
    return isinstance(
        node,
        (
            ir.Const,
            ir.Param,
            ir.Truth,
            ir.Arith,
            ir.Neg,
            ir.Func,
            ir.Choose,
            ir.Compare,
            ir.Not,
            ir.Connective,
        ),
    )


def _unary(function: Callable[[Any], Any], i: int) -> Step:
    return lambda b, v: function(v[i])


def _binary(function: Callable[[Any, Any], Any], i: int, j: int) -> Step:
    return lambda b, v: function(v[i], v[j])


def _choose(condition: Value, then: Any, otherwise: Any) -> Any:
    chosen = np.where(condition.worst.sat, then, otherwise)
    if condition.best is condition.worst:
        return chosen
    return np.where(condition.best.sat & ~condition.worst.sat, np.nan, chosen)


def _comparison(op: str, i: int, j: int) -> Step:
    measure, says = _COMPARE[op]

    def compare(batch: Batch, values: list[Any]) -> Value:
        x, y = values[i], values[j]
        margin = measure(x, y)
        # A sum is finite only if all parts are: the cheapest question whose answer is mostly yes. For a few numbers that of
        # the squares is cheaper still; for many it would be shared among threads.
        if math.isfinite(np.vdot(margin, margin) if margin.size < FEW else np.add.reduce(margin, axis=None)):
            return logic.defined(margin, says)
        known = np.isfinite(x) & np.isfinite(y)
        if known.all():
            return logic.defined(margin, says)
        return logic.partly(margin, says, known)

    return compare


def _flag(batch: Batch, node: ir.Flag) -> Value:
    if node.axis is not None:
        assert node.field is not None
        code = batch.flag(node.axis, node.field, node.offset)
    else:
        code = batch.per_case([_code(case.scalars[node.signal][node.field or ""]) for case in batch.cases])
    margin = np.where(code == 1.0, np.inf, -np.inf)
    known = ~np.isnan(code)
    return logic.defined(margin, logic.BOTH) if known.all() else logic.partly(margin, logic.BOTH, known)


def _code(value: bool | None) -> float:
    return np.nan if value is None else float(value)


def _quantify(node: ir.Quantify, *at: int) -> Step:
    axis, every = node.axis, node.quantifier == "for all"
    if node.guard is None:
        (body,) = at

        def plain(batch: Batch, values: list[Any]) -> Value:
            mask = batch.mask(axis)
            return logic.reduce(values[body], every, 1 + axis.level, mask, mask)

        return plain
    guard, body = at

    def guarded(batch: Batch, values: list[Any]) -> Value:
        # See the reference evaluator: what may be in range counts against a `for all` in the worst case.
        mask, range_ = batch.mask(axis), values[guard]
        in_worst = range_.best.sat if mask is None else mask & range_.best.sat
        in_best = in_worst
        if range_.best is not range_.worst:
            in_best = range_.worst.sat if mask is None else mask & range_.worst.sat
        if not every:
            in_worst, in_best = in_best, in_worst
        if in_worst.ndim == 0:
            one = in_best is in_worst
            in_worst = np.broadcast_to(in_worst, (1,) * batch.rank)
            in_best = in_worst if one else np.broadcast_to(in_best, (1,) * batch.rank)
        return logic.reduce(values[body], every, 1 + axis.level, in_worst, in_best)

    return guarded


def _guarded(guard: Value, body: Value) -> Value:
    worst = _where(guard.best, body.worst)
    if guard.best is guard.worst and body.best is body.worst:
        return Value(worst, worst)
    return Value(worst, _where(guard.worst, body.best))


def _where(guard: logic.Side, body: logic.Side) -> logic.Side:
    """A side that holds, by any margin, wherever the guard does not."""
    margin = np.where(guard.sat, body.margin, np.inf)
    return logic.Side(margin, body.says, None if body.says else body.sat | ~guard.sat)


def _first(axis: ir.Axis, body: Value) -> Value:
    index = (slice(None),) * (1 + axis.level) + (slice(0, 1),)

    def take(side: logic.Side) -> logic.Side:
        if side.margin.ndim == 0:
            return side
        return logic.Side(side.margin[index], side.says, None if side.says else side.sat[index])

    worst = take(body.worst)
    return Value(worst, worst if body.best is body.worst else take(body.best))
