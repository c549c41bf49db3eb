"""What generated code computes step by step, beside plain arithmetic and numpy's own functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, assert_never

import numpy as np

from trackmarshal.backends.numpy import logic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import COMPARISONS, FUNCTIONS, Comparison, ComparisonOp, FunctionName, Measure

#: Numbers that one thread adds up.
FEW = 4096
#: By short names, since each comparison asks.
_isfinite, _vdot = math.isfinite, logic.vdot
#: Nodes that have one value for all cases when their inputs do and no case overrides a parameter.
INDEPENDENT = (
    ir.Const, ir.Param, ir.Truth, ir.Arith, ir.Neg, ir.Func, ir.Choose, ir.Compare, ir.Not, ir.Connective,
)  # fmt: skip


def _pow(x: Any, y: Any) -> Any:
    """A power; NaN in, NaN out, where IEEE 754 says that anything to the 0 is 1, and 1 to anything."""
    power = np.power(x, y)
    # For a single exponent of 0.5 numpy takes the root, which is another thing for -0.0 and for minus infinity.
    power = np.where(y == 0.5, np.where(x == -np.inf, np.inf, power + 0.0), power)
    return np.where(np.isnan(x) | np.isnan(y), np.nan, power)


def _function(name: FunctionName) -> Callable[..., Any]:
    match name:
        case "abs":
            return np.abs
        case "sign":
            return np.sign
        case "sqrt":
            return np.sqrt
        case "hypot":
            return lambda x, y: np.sqrt(x * x + y * y)  # in these steps: see `ir.arithmetic`
        case "floor":
            return np.floor
        case "ceil":
            return np.ceil
        case "round":
            return np.rint
        case "min":
            return lambda x, y: np.minimum(x, y) + logic.ZERO  # turns -0.0 into 0.0: see `ir.arithmetic`
        case "max":
            return lambda x, y: np.maximum(x, y) + logic.ZERO
        case "pow":
            return _pow
        case "exp":
            return np.exp
        case "log":
            return np.log
        case "sin":
            return np.sin
        case "cos":
            return np.cos
        case "tan":
            return np.tan
        case "asin":
            return np.arcsin
        case "acos":
            return np.arccos
        case "atan2":
            return np.arctan2
        case "tanh":
            return np.tanh
        case _:
            assert_never(name)


def _measured(measure: Measure) -> str:
    match measure:
        case Measure.ROOM:
            return "{y} - {x}"
        case Measure.NEARNESS:
            return "-abs({x} - {y})"
        case Measure.DISTANCE:
            return "abs({x} - {y})"
        case Measure.SAMENESS:
            return "where({x} == {y}, inf, -inf)"
        case _:
            assert_never(measure)


def _says(comparison: Comparison) -> int:
    """What a margin's sign says: that of a Boolean is never 0."""
    if comparison.measure is Measure.SAMENESS:
        return logic.BOTH
    return logic.AT_LEAST if comparison.holds_at_zero else logic.ABOVE


#: What functions of numbers are called with.
CALLS: dict[FunctionName, Callable[..., Any]] = {name: _function(name) for name in FUNCTIONS}
#: How far a comparison is from its boundary, and what that says. By gradual underflow a difference is 0 for equal numbers only.
MEASURED: dict[ComparisonOp, tuple[str, int]] = {
    op: (_measured(comparison.measure), _says(comparison)) for op, comparison in COMPARISONS.items()
}


def compared(margin: Any, x: Any, y: Any) -> tuple[Any, Any]:
    """The worst and the best margin of a comparison of x and y: undefined where one of them is not finite."""
    # A sum is finite only if all parts are: the cheapest question whose answer is mostly yes. For a few numbers that of
    # the squares is cheaper still; for many it would be shared among threads.
    if _isfinite(_vdot(margin, margin) if margin.size < FEW else np.add.reduce(margin, axis=None)):
        return margin, margin
    known = np.isfinite(x) & np.isfinite(y)
    return (margin, margin) if logic.full(known) else logic.partly(margin, known)


def flagged(code: Any) -> tuple[Any, Any]:
    """The worst and the best margin of a Boolean, given as 1, 0 and NaN for a missing value."""
    margin = logic.where(code == 1.0, logic.INF, logic.MINUS_INF)
    known = np.equal(code, code)  # NaN is not
    return (margin, margin) if logic.full(known) else logic.partly(margin, known)


def inside(mask: Any, guard: Any, rank: int) -> Any:
    """What is in the range of a quantifier: what is there, and fulfils its guard; None where that is everything, and at least one."""
    found = guard if mask is None else mask & guard
    if found.size and logic.full(found):
        return None
    return np.broadcast_to(found, (1,) * rank) if found.ndim == 0 else found


def at(values: Any, places: Any, axis: int) -> Any:
    """The values at one sample of each case. places: (cases,)."""
    if values.ndim == 0 or values.shape[axis] == 1:
        return values
    whole = np.broadcast_to(values, (len(places), *values.shape[1:]))
    return np.take_along_axis(whole, places.reshape(-1, *(1,) * (values.ndim - 1)), axis)


def first(values: Any, index: tuple[slice, ...]) -> Any:
    """The values at the first sample."""
    return values if values.ndim == 0 else values[index]
