"""Scalar arithmetic as the language defines it: IEEE double, no exceptions, NaN for what has no value.

The reference evaluator and the compiler's constants use these; the numpy evaluator is tested against them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

NAN = math.nan


def arith(op: str, a: float, b: float) -> float:
    """`+ - * /`; a division by zero gives an infinity or NaN, as IEEE 754 says."""
    if op == "+":
        return a + b
    if op == "-":
        return a - b
    if op == "*":
        return a * b
    if op == "/":
        if b != 0.0:
            return a / b
        if a == 0.0 or math.isnan(a) or math.isnan(b):
            return NAN
        return math.copysign(math.inf, a) * math.copysign(1.0, b)
    raise AssertionError(f"unknown operator {op}")


def _total(function: Callable[..., float]) -> Callable[..., float]:
    """A function of the math module whose domain errors are NaN and whose overflow is infinite."""

    def call(*args: float) -> float:
        if any(math.isnan(x) for x in args):
            return NAN
        try:
            return float(function(*args))
        except ValueError:
            return NAN
        except OverflowError:
            return math.inf

    return call


def _log(x: float) -> float:
    if x == 0.0:
        return -math.inf
    return math.log(x)


def _floor(x: float) -> float:
    return x if math.isinf(x) or x == 0.0 else float(math.floor(x))  # the floor of -0.0 is -0.0


# Which of two opposite zeros is the smaller one is up to the processor: `min` and `max` give 0.0 for both.


def _least(a: float, b: float) -> float:
    return min(a, b) + 0.0


def _greatest(a: float, b: float) -> float:
    return max(a, b) + 0.0


def _pow(x: float, y: float) -> float:
    if math.isnan(x) or math.isnan(y):
        return NAN
    try:
        return math.pow(x, y)
    except OverflowError:
        return -math.inf if x < 0 and y % 2 == 1 else math.inf
    except ValueError:
        if x == 0.0:  # zero to a negative power
            return math.copysign(math.inf, x) if y % 2 == 1 else math.inf
        return NAN


_FUNCTIONS: dict[str, Callable[..., float]] = {
    "abs": abs, "sqrt": _total(math.sqrt), "sin": _total(math.sin), "cos": _total(math.cos), "tan": _total(math.tan),
    "exp": _total(math.exp), "log": _total(_log), "floor": _total(_floor), "min": _total(_least), "max": _total(_greatest),
    "atan2": _total(math.atan2), "pow": _pow,
}  # fmt: skip


def apply(name: str, args: Sequence[float]) -> float:
    """A built-in function; NaN in, NaN out."""
    return _FUNCTIONS[name](*args)


def compare(op: str, a: float, b: float) -> bool:
    """A comparison of two finite numbers."""
    if op == "<":
        return a < b
    if op == "<=":
        return a <= b
    if op == ">":
        return a > b
    if op == ">=":
        return a >= b
    if op == "==":
        return a == b
    if op == "!=":
        return a != b
    raise AssertionError(f"unknown comparison {op}")


def margin(op: str, a: float, b: float) -> float:
    """How far inside a comparison is: positive inside, negative outside."""
    if op in ("<", "<="):
        return b - a
    if op in (">", ">="):
        return a - b
    if op == "==":
        return -abs(a - b)
    if op == "!=":
        return abs(a - b)
    raise AssertionError(f"unknown comparison {op}")


def interpolate(knots: Sequence[float], values: Sequence[float], x: float) -> float:
    """A table: linear between knots, clamped outside, NaN for a non-finite argument."""
    if not math.isfinite(x):
        return NAN
    if x <= knots[0]:
        return values[0]
    if x >= knots[-1]:
        return values[-1]
    index = 0
    while knots[index + 1] <= x:
        index += 1
    slope = (values[index + 1] - values[index]) / (knots[index + 1] - knots[index])
    return values[index] + slope * (x - knots[index])
