"""Conditions of the contract: written once, evaluated by Python's door, printed as C for the generated one."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

from trackmarshal.node import Node

_COMPARISONS: dict[type[ast.cmpop], str] = {
    ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==", ast.NotEq: "!=",
}  # fmt: skip
_OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.BitAnd: "&&", ast.BitOr: "||",
}  # fmt: skip


def _sqrt(x: float) -> float:
    return math.sqrt(x) if x >= 0.0 else math.nan


def remainder(x: float, y: float) -> float:
    """That of C's library, which does not raise: NaN where there is none, as of a turn between headings too far apart to be subtracted."""
    return math.remainder(x, y) if math.isfinite(x) else math.nan


def _floor(x: Any) -> Any:
    """Of a number, or of each of an array, which is not imported here."""
    if type(x) in (int, float):
        return math.floor(x) if math.isfinite(x) else x
    nearest = x.round()
    return nearest - (nearest > x)


#: What a condition may call, by the name that C has for it. IEEE 754 defines each to the last bit.
_FUNCTIONS: dict[str, Callable[..., Any]] = {
    "fabs": abs,
    "floor": _floor,
    "sqrt": _sqrt,
    "remainder": remainder,
}


class Condition(Node):
    """A condition as text: comparisons of names and numbers with + - *, fabs, floor, sqrt and remainder, joined by `&` and `|`.

    A comparison with NaN does not hold. Raises ValueError where the text is anything else.
    """

    text: str

    @property
    def names(self) -> frozenset[str]:
        """The names that it speaks of."""
        return frozenset(
            node.id
            for node in ast.walk(self._tree)
            if isinstance(node, ast.Name) and node.id not in _FUNCTIONS
        )

    @property
    def _tree(self) -> ast.expr:
        return ast.parse(self.text, mode="eval").body

    def function(self, *names: str) -> Callable[..., Any]:
        """A function of these names, in order: of numbers, or, where it calls no function but fabs and floor, of arrays of them."""
        return _function(self, names)

    def c(self, names: Mapping[str, str]) -> str:
        """C of it, with what names stand for there."""
        return _print(self._tree, names)

    def demands(self, names: Mapping[str, str]) -> list[str]:
        """C of each of what it joins by `&` outside of all else: it holds where all of them do."""
        found, left = [], [self._tree]
        while left:
            match left.pop():
                case ast.BinOp(left=one, op=ast.BitAnd(), right=other):
                    left += [other, one]
                case node:
                    found.append(_print(node, names))
        return found


@cache  # every door that is made asks for the same few
def _function(condition: Condition, names: tuple[str, ...]) -> Callable[..., Any]:
    if not condition.names <= set(names):
        raise ValueError(f"`{condition.text}` speaks of {', '.join(sorted(condition.names - set(names)))}")
    condition.c({name: name for name in names})  # nothing but what C has too
    made: Callable[..., Any] = eval(f"lambda {', '.join(names)}: {condition.text}", dict(_FUNCTIONS))
    return made


def _print(node: ast.expr, names: Mapping[str, str]) -> str:
    match node:
        case ast.Name(id=name):
            return names[name]
        case ast.Constant(value=int() | float() as value):
            return repr(value)
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return f"(-{_print(operand, names)})"
        case ast.Compare(left=left, ops=[operator], comparators=[right]):
            return f"({_print(left, names)} {_COMPARISONS[type(operator)]} {_print(right, names)})"
        case ast.BinOp(left=left, op=joined, right=right) if type(joined) in _OPERATORS:
            return f"({_print(left, names)} {_OPERATORS[type(joined)]} {_print(right, names)})"
        case ast.Call(func=ast.Name(id=name), args=args, keywords=[]) if name in _FUNCTIONS:
            return f"{name}({', '.join(_print(arg, names) for arg in args)})"
        case _:
            raise ValueError(f"a condition cannot have `{ast.unparse(node)}`")
