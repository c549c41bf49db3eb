"""Scalar arithmetic as the language defines it: IEEE double, no exceptions, NaN for what has no value.

The reference evaluator and the compiler's constants use these; the numpy evaluator is tested against them.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Sequence
from typing import assert_never

from trackmarshal.ir.operators import (
    ARITHMETIC,
    COMPARISONS,
    FUNCTIONS,
    ArithmeticOp,
    ComparisonOp,
    FunctionName,
    Measure,
)

NAN = math.nan


def _divided(a: float, b: float) -> float:
    if b != 0.0:
        return a / b
    if a == 0.0 or math.isnan(a) or math.isnan(b):
        return NAN
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _operation(op: ArithmeticOp) -> Callable[[float, float], float]:
    match op:
        case "+":
            return operator.add
        case "-":
            return operator.sub
        case "*":
            return operator.mul
        case "/":
            return _divided
        case _:
            assert_never(op)


#: `+ - * /`, by themselves for what asks for many; a division by zero gives an infinity or NaN, as IEEE 754 says.
OPERATIONS = {op: _operation(op) for op in ARITHMETIC}


def arith(op: ArithmeticOp, a: float, b: float) -> float:
    """One of them."""
    return OPERATIONS[op](a, b)


def _total(function: Callable[..., float]) -> Callable[..., float]:
    """A function of the math module whose domain errors are NaN and whose overflow is infinite."""

    def call(*args: float) -> float:
        for x in args:
            if math.isnan(x):
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


def _whole(rounded: Callable[[float], int]) -> Callable[[float], float]:
    """A function to whole numbers; zeros keep the argument's sign, as in IEEE 754, and infinities are themselves."""

    def call(x: float) -> float:
        return x if math.isinf(x) else math.copysign(float(rounded(x)), x)

    return call


def _sign(x: float) -> float:
    return 1.0 if x > 0.0 else -1.0 if x < 0.0 else 0.0


def _hypot(a: float, b: float) -> float:
    # In these steps everywhere: the C library's hypot and Python's own differ in the last digit.
    return math.sqrt(a * a + b * b)


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


def _function(name: FunctionName) -> Callable[..., float]:
    match name:
        case "abs":
            return abs
        case "sign":
            return _total(_sign)
        case "sqrt":
            return _total(math.sqrt)
        case "hypot":
            return _total(_hypot)
        case "floor":
            return _total(_whole(math.floor))
        case "ceil":
            return _total(_whole(math.ceil))
        case "round":
            return _total(_whole(round))
        case "min":
            return _total(_least)
        case "max":
            return _total(_greatest)
        case "pow":
            return _pow
        case "exp":
            return _total(math.exp)
        case "log":
            return _total(_log)
        case "sin":
            return _total(math.sin)
        case "cos":
            return _total(math.cos)
        case "tan":
            return _total(math.tan)
        case "asin":
            return _total(math.asin)
        case "acos":
            return _total(math.acos)
        case "atan2":
            return _total(math.atan2)
        case "tanh":
            return _total(math.tanh)
        case _:
            assert_never(name)


#: The built-in functions; NaN in, NaN out.
BUILT_IN = {name: _function(name) for name in FUNCTIONS}


def apply(name: FunctionName, args: Sequence[float]) -> float:
    """One of them."""
    return BUILT_IN[name](*args)


def _compared(op: ComparisonOp) -> Callable[[float, float], bool]:
    match op:
        case "<":
            return operator.lt
        case "<=":
            return operator.le
        case "==" | "is":
            return operator.eq
        case "!=":
            return operator.ne
        case _:
            assert_never(op)


#: Comparisons of two finite numbers.
COMPARED = {op: _compared(op) for op in COMPARISONS}


def compare(op: ComparisonOp, a: float, b: float) -> bool:
    """One of them."""
    return COMPARED[op](a, b)


def _measured(measure: Measure) -> Callable[[float, float], float]:
    match measure:
        case Measure.ROOM:
            return lambda a, b: b - a
        case Measure.NEARNESS:
            return lambda a, b: -abs(a - b)
        case Measure.DISTANCE:
            return lambda a, b: abs(a - b)
        case Measure.SAMENESS:
            return lambda a, b: math.inf if a == b else -math.inf
        case _:
            assert_never(measure)


#: How far inside comparisons are: positive inside, negative outside.
MARGINS = {op: _measured(comparison.measure) for op, comparison in COMPARISONS.items()}


def margin(op: ComparisonOp, a: float, b: float) -> float:
    """Of one of them."""
    return MARGINS[op](a, b)
