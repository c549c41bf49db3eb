"""Every number in a comparison that decided: its sides, its inputs and parameters, and what the rule's definitions came to."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import outside_machines, sets
from trackmarshal.ir.spec import Called, Spec
from trackmarshal.units import beside

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

Env = dict[int, int]


def numbers(
    node: ir.Formula, env: Env, values: Reference, names: Sequence[Called] = ()
) -> list[tuple[str, str]]:
    """Both sides of a comparison, then what it is made of, each with its value; SI but for the sides."""
    rows: list[tuple[str, str]] = []
    if isinstance(node, ir.Compare) and node.op != "is":
        _, left, right = node.written
        for name, side in (("left side", left), ("right side", right)):
            rows.append((name, beside(values.number(side, env), node.unit, node.shown, 9)))
    if isinstance(node, ir.SweptInside | ir.SweptClear):
        rows.append(("swept", _way(node, env, values)))
    called = {id(one.node): one.name for one in names if one.own}
    leaves: dict[str, str] = {}
    for part in outside_machines(node):
        if isinstance(part, ir.Num) and any(axis.level not in env for axis in sets(part)):
            continue  # of a number of many: there are many
        told = _leaf(part, env, values)
        if told is None and id(part) in called and isinstance(part, ir.Num):
            told = called[id(part)], values.number(part, env)
        if told is not None:
            leaves[told[0]] = _member(part, values.spec, told[1]) or figure(told[1])
    return rows + sorted(leaves.items())


def _member(part: ir.AnyNode, spec: Spec, value: float) -> str:
    """The name of the member that a number is the place of; empty for any other number."""
    if not isinstance(part, ir.Column | ir.Scalar | ir.Sample):
        return ""
    signal = part.axis.signal if isinstance(part, ir.Column) else part.signal
    info = spec.field(signal, part.field)
    members = () if info is None or info.enumeration is None else info.enumeration.members
    return next((name for place, name in enumerate(members) if place == value), "")


def _leaf(part: ir.AnyNode, env: Env, values: Reference) -> tuple[str, float] | None:
    match part:
        case ir.Column():
            place = max(0, env[part.axis.level] + part.offset)
            columns = values.columns(part.axis)
            called = place if columns.joined is None else columns.name(place)
            return f"{part.axis.signal}[{called}].{part.field}", values.number(part, env)
        case ir.Scalar():
            return f"{part.signal}.{part.field}", values.number(part, env)
        case ir.Sample():
            end = "first" if part.index == 0 else "last"
            return f"{part.signal}.{end}.{part.field}", values.number(part, env)
        case ir.Param():
            return part.name, values.number(part, env)
        case ir.Kept():
            what = part.name or "time_in"
            return f"{part.machine.name}.{what}", values.number(part, env)
        case ir.Lookup():
            return f"{part.table}({figure(values.number(part.argument, env))})", values.number(part, env)
        case ir.GridLookup():
            inside = ", ".join(figure(values.number(each, env)) for each in (part.first, part.second))
            return f"{part.table}({inside})", values.number(part, env)
        case ir.OnLane():
            inside = ", ".join(figure(values.number(end, env)) for end in part.ends)
            lane = int(values.number(part.lane, env))
            side = "" if part.side == "centre" else f".{part.side}"
            return f"{part.spoken} of {part.signal}[{lane}]{side} of ({inside})", values.number(part, env)
        case ir.StretchRoom():
            station, start, end = (
                figure(values.number(each, env)) for each in (part.station, part.start, part.end)
            )
            told = f"{part.spoken} along {part.line.name} from {start} to {end} of {station}"
            return told, values.number(part, env)
        case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance() | ir.StationGap():
            ends = (part.start, part.end) if isinstance(part, ir.StationGap) else (part.x, part.y)
            inside = ", ".join(figure(values.number(end, env)) for end in ends)
            return f"{part.spoken} along {part.line.name} of ({inside})", values.number(part, env)
        case _:
            return None


def _way(node: ir.SweptInside | ir.SweptClear, env: Env, values: Reference) -> str:
    """What is taken for swept: straight, or along a curve, and what is added to that."""
    if not node.bend:
        return "the footprint" if node.start == node.end else "the straight hull of two footprints"
    curve = values.curve(node, env)
    if curve is None:
        return "along a curve of which a number is missing"
    pieces = len(curve.poses) - 1
    return f"along a curve, in {pieces} piece{'s' * (pieces > 1)}, and {figure(curve.more)} m around {'them' if pieces > 1 else 'it'}"


def figure(value: float) -> str:
    """A number as people read it; NaN and infinities by their names."""
    return f"{value:.9g}" if math.isfinite(value) else str(value)
