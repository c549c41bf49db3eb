"""Literals, and formulas that parameters and tables decide."""

from __future__ import annotations

import math
from functools import lru_cache

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.constants import constant_value
from trackmarshal.units import to_si


@lru_cache(maxsize=4096)
def literal(text: str, unit: str) -> tuple[float, str]:
    """Digits in a unit in SI, and why they have no value that a double can hold; empty where they have one."""
    value = to_si(float(text), unit)
    if not math.isfinite(value):
        return value, "this number is too large for a double (about 1.8e308 in SI units)"
    if value == 0.0 and any(digit in "123456789" for digit in text.lower().partition("e")[0]):
        return value, "this number is too small for a double: it would become 0"
    return value, ""


#: What the formula of a `constrain` may be made of: everything that parameters and tables decide.
_SETTLED = (
    ir.Const,
    ir.Param,
    ir.Arith,
    ir.Neg,
    ir.Func,
    ir.Choose,
    ir.Lookup,
    ir.GridLookup,
    ir.Truth,
    ir.Compare,
    ir.Not,
    ir.Connective,
)


def settled(formula: ir.Formula) -> bool:
    """Whether parameters and tables alone decide a formula, without any input."""
    return all(isinstance(node, _SETTLED) for node in ir.below(formula))


__all__ = ["constant_value", "literal", "settled"]
