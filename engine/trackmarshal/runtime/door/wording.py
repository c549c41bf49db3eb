"""What faults of values are said to be, in the units that data comes in: the same words whichever door found them."""

from __future__ import annotations

import math
from typing import Any

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.runtime.contract import Field
from trackmarshal.units import from_si

#: Members that a message names, and letters of a name that is none of theirs.
_MOST, _LONG = 12, 40


def worded(name: str, field: Field, values: Any, index: int, count: int = 1) -> str:
    """A message about an entry of a column, and how many others are like it."""
    return _one(name, field, values, index) + ("" if count == 1 else f", and {count - 1} more")


def no_member(name: str, members: tuple[str, ...]) -> str:
    """A message about a name that is none of a member's."""
    shown = name if len(name) <= _LONG else f"{name[: _LONG - 1]}..."
    hint = close_matches(name[:_LONG], members)
    return f"`{shown}` is none of {listed(members)}" + (f"; {hint}" if hint else "")


def listed(members: tuple[str, ...]) -> str:
    """Names of members, the first of many."""
    more = f" and {len(members) - _MOST} more" if len(members) > _MOST else ""
    return ", ".join(members[:_MOST]) + more


def _one(name: str, field: Field, values: Any, index: int) -> str:
    value = float(values[index])
    if field.kind == "bool":
        return "the value is missing"
    shown = repr(from_si(value, field.unit)) + (f" {field.unit}" if field.unit != "1" else "")
    match name:
        case "not_finite":
            return (
                "not finite"
                if math.isfinite(value) or math.isinf(value)
                else "the value is missing or no number"
            )
        case "out_of_range":
            constants = {k: v for check in field.checks for k, v in check.constants if k in ("low", "high")}
            low, high = (
                f"{from_si(bound, field.unit):g}" if isinstance(bound, float) and abs(bound) < 1e300 else inf
                for bound, inf in ((constants.get("low"), "-inf"), (constants.get("high"), "inf"))
            )
            return f"{shown} is outside [{low}, {high}]"
        case "no_member":
            last = len(field.members) - 1
            return f"{value!r} is no place of a member, which are 0 to {last}: {listed(field.members)}"
        case "not_increasing":
            return f"{float(values[index])!r} follows {float(values[index - 1])!r}"
        case _:
            return shown
