"""Intervals of doubles: how their numbers can lie to each other, and what arithmetic and functions can make of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias, assert_never

from trackmarshal.ir.arithmetic import apply, arith
from trackmarshal.ir.operators import ArithmeticOp, ComparisonOp, FunctionName

Interval: TypeAlias = tuple[float, float]
ANY: Interval = (-math.inf, math.inf)
NOT_NEGATIVE: Interval = (0.0, math.inf)
#: How the left one of two numbers lies to the right one; bits of a set of these.
LESS, EQUAL, GREATER = 1, 2, 4
EVERY = LESS | EQUAL | GREATER
#: How two numbers lie of which a comparison holds.
HOLD: dict[ComparisonOp, int] = {
    "<": LESS, "<=": LESS | EQUAL, "==": EQUAL, "is": EQUAL, "!=": LESS | GREATER,
}  # fmt: skip


def between(lower: float | None, upper: float | None) -> Interval:
    """From one end to another, None where there is none."""
    return -math.inf if lower is None else lower, math.inf if upper is None else upper


def lie(left: Interval, right: Interval) -> int:
    """How numbers of two intervals can lie."""
    return (
        (LESS if left[0] < right[1] else 0)
        | (EQUAL if left[0] <= right[1] and right[0] <= left[1] else 0)
        | (GREATER if left[1] > right[0] else 0)
    )


def _product(a: float, b: float) -> float:
    """Of two ends; an infinite one stands for numbers without an end, and nothing times any of these is nothing."""
    return 0.0 if a == 0.0 or b == 0.0 else a * b


def square(interval: Interval) -> Interval:
    """A number times itself."""
    ends = [_product(end, end) for end in interval]
    return (0.0 if interval[0] <= 0.0 <= interval[1] else min(ends)), max(ends)


def arithmetic(op: ArithmeticOp, left: Interval, right: Interval) -> Interval:
    """Arithmetic is monotone in each operand, rounded or not: its least and its greatest value are at ends."""
    if op in "+-":
        low, high = right if op == "+" else (right[1], right[0])
        ends = [arith(op, left[0], low), arith(op, left[1], high)]
        return (-math.inf if math.isnan(ends[0]) else ends[0]), (math.inf if math.isnan(ends[1]) else ends[1])
    if op == "/" and right[0] <= 0.0 <= right[1]:
        return ANY
    if op == "*":
        found = [_product(a, b) for a in left for b in right]
    else:
        found = [arith(op, a, b) for a in left for b in right]
        if any(map(math.isnan, found)):
            return ANY
    return min(found), max(found)


def function(name: FunctionName, ends: Sequence[Interval]) -> Interval:
    """What a function comes to for numbers of some intervals."""
    low, high = ends[0]
    match name:
        case "abs":
            inside = low <= 0.0 <= high
            return (0.0 if inside else min(abs(low), abs(high))), max(abs(low), abs(high))
        case "min":
            return min(e[0] for e in ends), min(e[1] for e in ends)
        case "max":
            return max(e[0] for e in ends), max(e[1] for e in ends)
        case "sqrt" | "floor" | "ceil" | "round":
            if name == "sqrt":
                low, high = max(low, 0.0), max(high, 0.0)
            return apply(name, [low]), apply(name, [high])
        case "hypot":
            return NOT_NEGATIVE
        case "exp":
            return NOT_NEGATIVE
        case "sign" | "sin" | "cos" | "tanh":
            return -1.0, 1.0
        case "atan2" | "asin" | "acos":
            return -4.0, 4.0
        case "pow" | "log" | "tan":
            return ANY
        case _:
            assert_never(name)
