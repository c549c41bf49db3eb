"""Values of numbers that are constant: literals, parameters, tables, and arithmetic on them."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.arithmetic import apply, arith
from trackmarshal.units import to_si


def literal_problem(text: str, unit: str) -> str:
    """Why digits in a unit have no value that a double can hold; empty where they have one."""
    value = to_si(float(text), unit)
    if not math.isfinite(value):
        return "this number is too large for a double (about 1.8e308 in SI units)"
    if value == 0.0 and any(digit in "123456789" for digit in text.lower().partition("e")[0]):
        return "this number is too small for a double: it would become 0"
    return ""


#: What the formula of a `constrain` may be made of: everything that parameters and tables decide.
_SETTLED = (
    ir.Const,
    ir.Param,
    ir.Arith,
    ir.Neg,
    ir.Func,
    ir.Choose,
    ir.Lookup,
    ir.Truth,
    ir.Compare,
    ir.Not,
    ir.Connective,
)


def settled(formula: ir.Formula) -> bool:
    """Whether parameters and tables alone decide a formula, without any input."""
    return all(isinstance(node, _SETTLED) for node in ir.below(formula))


def constant_value(node: ir.Num, param: Callable[[str], float | None]) -> float | None:
    """The value of a number, or None where it depends on the input; `param` gives the values of parameters."""
    match node:
        case ir.Const():
            return node.value
        case ir.Param():
            return param(node.name)
        case ir.Arith():
            left, right = constant_value(node.left, param), constant_value(node.right, param)
            return None if left is None or right is None else arith(node.op, left, right)
        case ir.Neg():
            operand = constant_value(node.operand, param)
            return None if operand is None else -operand
        case ir.Func():
            values = [constant_value(arg, param) for arg in node.args]
            known = [value for value in values if value is not None]
            return apply(node.name, known) if len(known) == len(values) else None
        case ir.Column() | ir.Sample() | ir.Scalar() | ir.Choose() | ir.Lookup():
            return None
        case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance() | ir.StationGap():
            return None
        case _:
            assert_never(node)
