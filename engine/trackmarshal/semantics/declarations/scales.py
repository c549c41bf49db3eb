"""Scales: how much of a dimension counts as 1, the same for all that is checked together."""

from __future__ import annotations

from typing import TYPE_CHECKING

from trackmarshal.semantics.declarations.ranges import finite
from trackmarshal.semantics.errors.declarations import ScaleConflict
from trackmarshal.semantics.errors.expressions import BadValue
from trackmarshal.syntax import ast
from trackmarshal.units import in_full, name, parse_unit, show

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions


def check_scale(item: ast.Scale, x: Expressions, first: dict[str, ast.Scale]) -> None:
    """Declare a scale; first: by SI unit the declaration that others must not contradict."""
    dimension, value = parse_unit(item.unit)[2], finite(x, item.value, item.unit)
    unit = show(dimension)
    if not value > 0.0:
        problem = f"a scale is above 0, not {in_full(value, item.unit)}"
        x.fail(BadValue(ast.span_of(item.value), problem, None, "write the margin that counts as 1"))
    other = first.setdefault(unit, item)
    if x.scales.setdefault(unit, value) != value:
        x.fail(ScaleConflict(item.span, other.span, name(dimension)))
