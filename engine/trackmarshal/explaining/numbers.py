"""Every number in a comparison that decided: its sides, its inputs and parameters, and what the rule's definitions came to."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING

from trackmarshal import typed
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import unbound
from trackmarshal.ir.spec import Called, RuleInfo, Spec
from trackmarshal.units import beside, parse_unit, show

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

Env = dict[int, int]


def numbers(
    node: ir.Formula, env: Env, values: Reference, names: Sequence[Called] = (), kept: Mapping[str, str] | None = None
) -> list[tuple[str, str]]:  # fmt: skip
    """Both sides of a comparison, then what it is made of, each with its value and unit; SI but for the sides.

    names: what the rule calls values. kept: the SI units of what its state machines remember, by `machine.name`.
    """
    rows: list[tuple[str, str]] = []
    if isinstance(node, ir.Compare) and node.op != "is":
        _, left, right = node.written
        for name, side in (("left side", left), ("right side", right)):
            if not isinstance(side, ir.Ordinal):  # of which one is the nearest
                rows.append((name, beside(values.number(side, env), node.unit, node.shown, 9)))
    if isinstance(node, ir.SweptInside | ir.SweptClear):
        rows.append(("swept", _way(node, env, values)))
    parts = unbound(node)
    called = {one.node: one for one in names if one.own}
    often = Counter(called[part].name for part in parts if part in called)
    leaves: dict[tuple[str, str], None] = {}  # of one name, several numbers
    for part in parts:
        told = _leaf(part, env, values)
        unit = "1" if told is None else _unit(part, values.spec, kept or {})
        if told is None and part in called and isinstance(part, ir.Num):
            one = called[part]
            name = one.text if often[one.name] > 1 else one.name  # of what definition
            told, unit = (name, values.number(part, env)), one.unit
        if told is not None:
            leaves[told[0], _member(part, values.spec, told[1]) or measured(told[1], unit)] = None
    return rows + sorted(leaves)


def kept_units(rule: RuleInfo) -> Mapping[str, str]:
    """The SI units of the numbers that a rule's state machines remember, by `machine.name`."""
    return {} if rule.typed is None else _kept_units(rule.typed)


@lru_cache(maxsize=256)
def _kept_units(rule: typed.Rule) -> Mapping[str, str]:
    found = (node for node in typed.below(rule) if isinstance(node, typed.Kept))
    return {f"{node.machine.symbol.qualified}.{node.name}": show(node.dimension) for node in found}


def _unit(part: ir.AnyNode, spec: Spec, kept: Mapping[str, str]) -> str:
    """The SI unit of what `_leaf` tells."""
    match part:
        case ir.Column() | ir.Scalar() | ir.Sample():
            info = spec.field(part.axis.signal if isinstance(part, ir.Column) else part.signal, part.field)
            return "1" if info is None else _si(info.unit)
        case ir.Param():
            return _si(spec.params[part.name].unit)
        case ir.Kept():
            return kept.get(f"{part.machine.name}.{part.name}", "1") if part.name else "s"
        case ir.Lookup() | ir.GridLookup():
            return _si(spec.tables[part.table].units[1])
        case ir.OnLane():
            return "rad" if part.what == "direction" else "m"
        case ir.Direction():
            return "rad"
        case ir.StretchRoom() | ir.Station() | ir.Offset() | ir.Distance() | ir.StationGap():
            return "m"
        case _:
            raise AssertionError(f"{type(part).__name__} is told of nowhere")


@lru_cache(maxsize=256)
def _si(unit: str) -> str:
    """The SI unit for a unit of a spec; an angle is a ratio, and is told to be one of those in radians."""
    if not unit:  # of the place of a member, and of what is no number
        return "1"
    return "rad" if unit in ("rad", "deg") else show(parse_unit(unit)[2])


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
            axis, what = part.machine.axis, part.name or "time_in"
            element = "" if axis is None else f"[{env[axis.level]}]"
            return f"{part.machine.name}{element}.{what}", values.number(part, env)
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


def measured(value: float, unit: str) -> str:
    """An SI number with its unit as people read it."""
    return figure(value) if unit == "1" else f"{figure(value)} {unit}"


def figure(value: float) -> str:
    """A number as people read it; NaN and infinities by their names."""
    return f"{value:.9g}" if math.isfinite(value) else str(value)
