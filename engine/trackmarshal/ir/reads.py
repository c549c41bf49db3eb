"""What a formula reads of the signals."""

from __future__ import annotations

from collections.abc import Iterable
from typing import assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import looks_ahead, outside_machines, over_run, sets

#: The signal that a candidate stands for, and the driving trajectory, for rules of both candidates: what the car follows until the next decision. In
#: earlier cycles, what was driven.
PLAN, FOLLOWED = "plan", "driving"
DRIVEN = frozenset((PLAN, FOLLOWED))
#: The event that tells the candidates apart, and the one that tells cycles in which something is driven from those in which nothing was.
IS_EMERGENCY, IS_DRIVEN = "emergency", "driven"


def reads(formula: ir.Formula | ir.Num | ir.Machine | None) -> frozenset[tuple[str, str]]:
    """Which fields of which signals a formula reads, or a state machine."""
    return _read_by(ir.below(formula)) if formula is not None else frozenset()


def reads_itself(node: ir.Formula | ir.Num) -> frozenset[tuple[str, str]]:
    """What it reads but for what decides the states of machines: of these something may be known where that is not."""
    return _read_by(outside_machines(node))


def asks_what_was_driven(formula: ir.Formula) -> bool:
    """Whether a formula reads the trajectory that is driven, of which nothing is known where nothing was."""
    return any(signal in DRIVEN for signal, _ in reads(formula))


def known_again(formula: ir.Formula | None) -> frozenset[str]:
    """The sets whose elements a formula knows again in other cycles, by their ids: what a field of theirs is called is another matter."""
    if formula is None or not over_run(formula):
        return frozenset()
    return frozenset(axis.signal for node in ir.below(formula) for axis in _known_by_ids(node))


def _known_by_ids(node: ir.AnyNode) -> tuple[ir.Axis, ...]:
    match node:
        case ir.Quantify() if node.axis.kind == "elements" and looks_ahead(node):
            return (node.axis,)  # of a cycle that is decided later, it is kept who was there
        case ir.OverRun() | ir.Counted() | ir.InState() | ir.Kept():
            return sets(node)
        case _:
            return ()


def _read_by(nodes: Iterable[ir.AnyNode]) -> frozenset[tuple[str, str]]:
    result: set[tuple[str, str]] = set()
    for node in nodes:
        result |= {(axis.signal, "id") for axis in _known_by_ids(node)}
        match node:
            case ir.Column():
                result.add((node.axis.signal, node.field))
            case ir.Sample() | ir.Scalar():
                result.add((node.signal, node.field))
            case ir.Flag():
                result.add((node.signal, node.field or ""))
            case ir.Axis():
                result.add((node.signal, ""))
            case ir.Line():
                result |= {(node.name, field) for field in _fields_of(node)}
            case ir.Area():
                if node.kind == "corridor":
                    result |= {(node.name, "left"), (node.name, "right")}
            case ir.Temporal() | ir.Until() | ir.Tallied():
                result.add((node.axis.signal, "t"))
            case (
                ir.Const()
                | ir.Param()
                | ir.Arith()
                | ir.Neg()
                | ir.Func()
                | ir.Choose()
                | ir.Lookup()
                | ir.GridLookup()
            ):
                pass  # what they are made of is below, too
            case ir.OnLane():
                result |= {(node.signal, "left"), (node.signal, "right")}
            case ir.Ordinal() | ir.Fold():
                pass
            case (
                ir.Station()
                | ir.Offset()
                | ir.Direction()
                | ir.Distance()
                | ir.StationGap()
                | ir.StretchRoom()
            ):
                pass
            case ir.Truth() | ir.Compare() | ir.SweptInside() | ir.SweptClear() | ir.InArea() | ir.Not():
                pass
            case ir.Scaled() | ir.Connective() | ir.Quantify() | ir.Guarded() | ir.Shift() | ir.At():
                pass
            case ir.Machine():
                pass
            case ir.OverRun() | ir.Counted() | ir.InState() | ir.Kept():
                pass
            case _:
                assert_never(node)
    return frozenset(result)


def _fields_of(line: ir.Line) -> tuple[str, ...]:
    """The fields of its signal that a line is made of."""
    match line.kind:
        case "path":
            return "x", "y"
        case "centre":
            return "left", "right"
        case "signal":
            return (line.field,)
        case "place":
            return ()
        case _:
            assert_never(line.kind)
