"""What the functions and comparisons of the core are called in C."""

from __future__ import annotations

from typing import assert_never

from trackmarshal.ir.operators import ComparisonOp, FunctionName


def called(name: FunctionName) -> tuple[str, frozenset[str]]:
    """The C function of a function of numbers, and which functions of libm that is, or calls."""
    match name:
        case "abs":
            return "fabs", frozenset()
        case "sign":
            return "tm_sign", frozenset()
        case "min":
            return "tm_min", frozenset()
        case "max":
            return "tm_max", frozenset()
        case "hypot":
            return "tm_hypot", frozenset(["sqrt"])
        case "pow":
            return "tm_pow", frozenset(["pow"])
        case "round":
            return "rint", frozenset(["rint"])
        case "sqrt" | "floor" | "ceil" | "exp" | "log" | "tanh":
            return name, frozenset([name])
        case "sin" | "cos" | "tan" | "asin" | "acos" | "atan2":
            return name, frozenset([name])
        case _:
            assert_never(name)


def compared(op: ComparisonOp, turned: bool) -> str:
    """The C function of a comparison as it is written; `turned`: the other way round."""
    match op:
        case "<":
            return "greater" if turned else "less"
        case "<=":
            return "at_least" if turned else "at_most"
        case "==":
            return "equal"
        case "!=":
            return "unequal"
        case "is":
            return "is"
        case _:
            assert_never(op)
