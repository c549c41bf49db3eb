"""Oracle formulas (trees in JSON) as spec text, so that they go the way of every other rule."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

_INFIX = {"and", "or", "implies", "iff", "xor", "<", "<=", ">", ">=", "==", "!=", "+", "-", "*"}
_TEMPORAL = {"always", "eventually", "historically", "once"}
#: The oracle's next and prev are weak, its s_next and s_prev strong.
_STEPS = {"next": "weak next", "prev": "weak previous", "s_next": "next", "s_prev": "previous"}
_EDGES = {"rise": "rising", "fall": "falling"}


def spell(tree: Mapping[str, Any]) -> str:
    """A formula tree as an expression over the sample `s`; samples are one second apart."""
    op = tree["op"]
    if op == "var":
        return f"s.{tree['name']}"
    if op == "const":
        value = tree["value"]
        return f"(-{-value!r})" if value < 0 else repr(value)
    args = [spell(arg) for arg in tree["args"]]
    if op == "abs":
        return f"abs({args[0]})"
    if op == "not":
        return f"(not {args[0]})"
    window = "" if tree.get("interval") is None else "[{} s, {} s]".format(*tree["interval"])
    if op in _TEMPORAL:
        return f"({op}{window} {args[0]})"
    if op in ("until", "since"):
        return f"({args[0]} {op}{window} {args[1]})"
    if op in _STEPS:
        return f"({_STEPS[op]} {args[0]})"
    if op in _EDGES:
        return f"{_EDGES[op]}({args[0]})"
    if op in _INFIX:
        return f"({args[0]} {op} {args[1]})" if len(args) == 2 else "(" + f" {op} ".join(args) + ")"
    raise AssertionError(f"unknown operator {op}")


def module(name: str, formulas: Mapping[str, tuple[Sequence[str], Mapping[str, Any]]]) -> str:
    """A module with one rule a formula, each along a series of plain numbers of its own, named as `series` says."""
    lines = [f"module {name}"]
    for rule, (variables, tree) in formulas.items():
        columns = ", ".join(f"{variable}: 1" for variable in variables)
        lines += [
            f"signal {series(rule)} : series {{ t: s increasing, {columns} }}",
            f'rule {rule} "an oracle formula"',
            f"  along {series(rule)} as s",
            f"  require {spell(tree)}",
        ]
    return "\n".join(lines) + "\n"


def series(rule: str) -> str:
    """The name of the timeline that a rule ranges over."""
    return f"{rule}_trace"
