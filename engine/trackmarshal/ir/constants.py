"""Values of numbers that no input changes: literals, parameters, and arithmetic on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.arithmetic import apply, arith


def constant_value(node: ir.Num, param: Callable[[str], float | None]) -> float | None:
    """The value of a number, or None where it depends on the input; `param` gives the values of parameters."""
    return _value(node, param, {})


def _value(node: ir.Num, param: Callable[[str], float | None], met: dict[int, float | None]) -> float | None:
    """The same; a node that several others share, as `x^2` does `x` with itself, is worked out once."""
    if id(node) not in met:
        met[id(node)] = _worked_out(node, param, met)
    return met[id(node)]


def _worked_out(
    node: ir.Num, param: Callable[[str], float | None], met: dict[int, float | None]
) -> float | None:
    match node:
        case ir.Const():
            return node.value
        case ir.Param():
            return param(node.name)
        case ir.Arith():
            left, right = _value(node.left, param, met), _value(node.right, param, met)
            return None if left is None or right is None else arith(node.op, left, right)
        case ir.Neg():
            operand = _value(node.operand, param, met)
            return None if operand is None else -operand
        case ir.Func():
            values = [_value(arg, param, met) for arg in node.args]
            known = [value for value in values if value is not None]
            return apply(node.name, known) if len(known) == len(values) else None
        case ir.Column() | ir.Sample() | ir.Scalar() | ir.Choose() | ir.Lookup() | ir.GridLookup():
            return None
        case ir.Ordinal() | ir.Fold() | ir.Kept() | ir.OnLane():
            return None
        case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance() | ir.StationGap() | ir.StretchRoom():
            return None
        case _:
            assert_never(node)
