"""The kinds of checks that values and signals have to pass, each of them here and nowhere else.

Python's door evaluates a kind's condition, the generated door has it as C: whoever adds a kind adds it to `KINDS`.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

from trackmarshal.ir.spec import FieldType, SignalType
from trackmarshal.node import Node
from trackmarshal.runtime.contract.conditions import Condition

#: The greatest number that is finite.
MOST = sys.float_info.max
#: Constants of a check by name: numbers in SI, or the name of a capacity of `Limits`.
Constants = tuple[tuple[str, float | str], ...]


class Kind(Node):
    """A kind of check. `fault` is what a breach of it is called.

    of: what the condition speaks of: `value`: every `x` by itself, numbers in SI, flags 1, 0 and -1 for a missing one;
    `step`: every `x` with the one `before` it; `count`: how many entries `n` a signal or line has; `point`: every
    coordinate `x` of a line. constants: by name, for a field or signal that is checked; None where it is not.
    """

    fault: str
    of: str
    holds: Condition
    constants: Callable[[FieldType | SignalType], Constants | None]


class Check(Node):
    """A kind of check with the constants of one field, signal or line."""

    kind: Kind
    constants: Constants


def _number(info: FieldType | SignalType) -> Constants | None:
    return (("most", MOST),) if isinstance(info, FieldType) and info.kind == "number" else None


def _flag(info: FieldType | SignalType) -> Constants | None:
    return () if isinstance(info, FieldType) and info.kind == "bool" else None


def _range(info: FieldType | SignalType) -> Constants | None:
    if (
        not isinstance(info, FieldType)
        or info.kind != "number"
        or (info.lower is None and info.upper is None)
    ):
        return None
    return (
        ("low", -MOST if info.lower is None else info.lower),
        ("high", MOST if info.upper is None else info.upper),
    )


def _member(info: FieldType | SignalType) -> Constants | None:
    if not isinstance(info, FieldType) or info.enumeration is None:
        return None
    return (("last", float(len(info.enumeration.members) - 1)),)


def _increasing(info: FieldType | SignalType) -> Constants | None:
    return () if isinstance(info, FieldType) and info.increasing else None


def _most(info: FieldType | SignalType) -> Constants | None:
    if isinstance(info, FieldType):
        return (("most", "border"),) if info.kind == "polyline" else None
    return (
        (("most", "elements" if info.capacity is None else float(info.capacity)),)
        if info.many
        else (("most", "samples"),)
        if info.sequence
        else (("most", "border"),)
        if info.kind == "polyline"
        else None
    )


def _least(info: FieldType | SignalType) -> Constants | None:
    if isinstance(info, FieldType) or not info.sequence:
        return None
    return (("least", 2.0 if info.kind == "trajectory" else 1.0),)


def _ends(info: FieldType | SignalType) -> Constants | None:
    return (("least", 2.0),) if info.kind == "polyline" else None


def _points(info: FieldType | SignalType) -> Constants | None:
    return (("most", MOST),) if info.kind == "polyline" else None


#: In the order in which they are looked at. Of the checks of values, the first that one fails names its fault; a signal or line
#: that fails one of its count is not looked at any further.
KINDS: list[Kind] = [
    Kind("over_capacity", "count", Condition("n <= most"), _most),
    Kind("too_short", "count", Condition("n >= least"), _least),
    Kind("bad_border", "count", Condition("n >= least"), _ends),
    Kind("not_finite", "point", Condition("(x >= -most) & (x <= most)"), _points),
    Kind("not_finite", "value", Condition("(x >= -most) & (x <= most)"), _number),
    Kind("not_finite", "value", Condition("(x == 0) | (x == 1)"), _flag),
    Kind("out_of_range", "value", Condition("(x >= low) & (x <= high)"), _range),
    Kind("no_member", "value", Condition("(x >= 0) & (x <= last) & (floor(x) == x)"), _member),
    Kind("not_increasing", "step", Condition("before < x"), _increasing),
]


def checks_of(info: FieldType | SignalType) -> tuple[Check, ...]:
    """The checks of a field or signal, in order."""
    found = ((kind, kind.constants(info)) for kind in KINDS)
    return tuple(Check(kind, constants) for kind, constants in found if constants is not None)
