"""Why a formula has no verdict: which input, at which sample or element, or which operation on which numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING, assert_never

from trackmarshal.ir import nodes as ir
from trackmarshal.ir.overrun import sets, unbound
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.frame import Frame

if TYPE_CHECKING:
    from trackmarshal.backends.reference.evaluator import Reference

Env = dict[int, int]
#: The most inputs that are named.
MOST = 3
#: The most characters of an expression that are shown.
_WIDTH = 100
_NUMBERS = (
    ir.Const, ir.Param, ir.Column, ir.Sample, ir.Scalar, ir.Arith, ir.Neg, ir.Func, ir.Choose, ir.Lookup, ir.GridLookup, ir.Station, ir.Offset,
    ir.Direction, ir.Distance, ir.StationGap, ir.StretchRoom, ir.OnLane, ir.Ordinal, ir.Fold,
)  # fmt: skip


def why(node: ir.Formula, env: Env, spec: Spec, frame: Frame) -> str:
    """In words, what is undefined in a formula that is, for these values of its variables."""
    from trackmarshal.backends.reference.evaluator import Reference

    parts, values = unbound(node), Reference(spec, frame)
    return (
        _inputs(parts, env, frame)
        or _of_many(parts, env, values)
        or _lines(parts, frame)
        or _operation(node, env, values)
    )


def in_gap(signal: str, index: int, frame: Frame) -> str:
    """The same of what is asked in a gap of a timeline, where nothing is known, also of what has a value now."""
    columns = frame.columns[signal]
    missing = columns.weight(index)
    cycles = "1 cycle is" if missing == 1 else f"{missing} cycles are"
    return f"{signal}[{columns.name(index)}]: {cycles} missing there, and nothing is known of them"


def _of_many(parts: Iterable[ir.AnyNode], env: Env, values: Reference) -> str:
    """The inputs without a value of the first sample or element of many of which a number, or a condition that it hangs on, speaks."""
    for many in (part for part in parts if isinstance(part, ir.Quantify | ir.Fold)):
        below = [part for each in (many.guard, many.body) if each is not None for part in unbound(each)]
        for index in range(values.frame.columns[many.axis.signal].count - many.axis.width + 1):
            inside = {**env, many.axis.level: index}
            found = "" if _out_of_range(many, inside, values) else _inputs(below, inside, values.frame)
            if found:
                return found
        found = _of_many(below, _without(env, many.axis), values)
        if found:
            return found
    return ""


def _out_of_range(many: ir.Quantify | ir.Fold, env: Env, values: Reference) -> bool:
    """Whether one of many is surely not asked about; not where that hangs on a variable that stands for no one value."""
    if many.guard is None or any(axis.level not in env for axis in sets(many.guard)):
        return False
    return not values.truth(many.guard, env).best.sat


def _without(env: Env, axis: ir.Axis) -> Env:
    """What variables stand for outside the scope of one, where that has no one value."""
    return {level: at for level, at in env.items() if level != axis.level}


def of_reads(reads: Iterable[tuple[str, str]], frame: Frame) -> str:
    """The same of a rule of which no single comparison decides: the inputs that it reads and that are missing."""
    found = []
    for signal, name in sorted(reads):
        if not name:
            if signal in frame.events and frame.flag(signal, "") is None:
                found.append(f"the event `{signal}` is missing")
            continue
        columns = frame.columns.get(signal)
        if columns is None or name not in columns.names.rows:
            continue
        for index, value in enumerate(columns.listed(name)):
            problem = _problem(value)
            if problem:
                place = f"[{columns.name(index)}]" if columns.count > 1 or columns.ids else ""
                found.append(f"{signal}{place}.{name} {problem}")
                break
    return _listed(found) or "something that it reads has no value"


def _inputs(parts: Iterable[ir.AnyNode], env: Env, frame: Frame) -> str:
    """The inputs below a formula that have no value."""
    found: dict[str, str] = {}
    for part in parts:
        value: object
        match part:
            case ir.Column() | ir.Flag() if part.axis is not None and part.axis.level not in env:
                continue  # bound inside the formula
            case ir.Column():
                index = _index(part, env)
                value = frame.columns[part.axis.signal].listed(part.field)[index]
            case ir.Sample():
                value = frame.columns[part.signal].listed(part.field)[part.index]
            case ir.Scalar():
                value = frame.value(part.signal, part.field)
            case ir.Flag():
                value = _flag(part, env, frame)
            case _:
                continue
        problem = _problem(value)
        if problem:
            found[_called(part, env, frame)] = problem
    return _listed([f"{name} {problem}" for name, problem in sorted(found.items())])


def _lines(parts: Iterable[ir.AnyNode], frame: Frame) -> str:
    """The trajectories of which a formula reads the path, and that have none."""
    found = set()
    for part in parts:
        if not isinstance(part, ir.Line) or part.kind != "path":
            continue
        columns = frame.columns[part.name]
        for name in ("x", "y"):
            bad = next((i for i, z in enumerate(columns.listed(name)) if _problem(z)), None)
            if bad is not None:
                found.add(f"{part.name}[{bad}].{name} {_problem(columns.listed(name)[bad])}")
        if not found and len(set(zip(columns.listed("x"), columns.listed("y")))) < 2:
            found.add(f"the path of {part.name} has no length: all of its samples are in one place")
    return _listed(sorted(found))


def _flag(node: ir.Flag, env: Env, frame: Frame) -> object:
    if node.axis is None:
        return frame.flag(node.signal, node.field or "", node.offset)
    index = max(0, env[node.axis.level] + node.offset)
    return frame.columns[node.signal].listed(node.field or "")[index]


def _problem(value: object) -> str:
    """What is wrong with an input; empty where nothing is."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "is missing, or no number"
    if isinstance(value, float) and math.isinf(value):
        return "is infinite"
    return ""


def _listed(found: list[str]) -> str:
    more = f", and {len(found) - MOST} more" if len(found) > MOST else ""
    return ", ".join(found[:MOST]) + more


def _operation(root: ir.Formula, env: Env, values: Reference) -> str:
    """The innermost expressions that have no finite value although all of their parts do."""
    frame, found = values.frame, dict[str, None]()
    for part in unbound(root):
        if not isinstance(part, _NUMBERS) or isinstance(part, ir.Choose):
            continue
        if math.isfinite(values.number(part, env)):
            continue
        below = [child for child in _parts_of(part) if isinstance(child, _NUMBERS)]
        if all(math.isfinite(values.number(child, env)) for child in below):
            found[f"`{_short(part, env, frame)}`{_with(part, env, values)} has no value"] = None
    if found:
        return _listed(sorted(found))
    return f"`{root.span.in_line}` has no value" if hasattr(root, "span") else ""


def _parts_of(part: ir.Num) -> Iterable[object]:
    """What a number is made of for the variables that are bound where it stands."""
    if isinstance(part, ir.Fold):
        return () if part.otherwise is None else (part.otherwise,)
    return part.children()


def _with(part: ir.Num, env: Env, values: Reference) -> str:
    """The numbers in an expression, where it is more than a number of the input."""
    leaves = {}
    for leaf in unbound(part):
        if isinstance(leaf, ir.Column | ir.Sample | ir.Scalar | ir.Param):
            leaves[_called(leaf, env, values.frame)] = values.number(leaf, env)
    shown = _listed([f"{name} = {value:.6g}" for name, value in sorted(leaves.items())])
    return f" with {shown}" if shown else ""


def _index(node: ir.Column, env: Env) -> int:
    return max(0, env[node.axis.level] + node.offset)


def _called(node: ir.AnyNode, env: Env, frame: Frame) -> str:
    """What an input is called: `plan[31].v`, `objects[blue].x`, `ego.v`."""
    match node:
        case ir.Column():
            name = frame.columns[node.axis.signal].name(_index(node, env))
            return f"{node.axis.signal}[{name}].{node.field}"
        case ir.Sample():
            return f"{node.signal}.{'first' if node.index == 0 else 'last'}.{node.field}"
        case ir.Scalar():
            return f"{node.signal}.{node.field}"
        case ir.Param():
            return node.name.rpartition(".")[2]
        case ir.Flag():
            if node.axis is None and node.field and frame.columns[node.signal].count != 1:
                return f"{node.signal}.{'first' if node.offset == 0 else 'last'}.{node.field}"
            if node.axis is None:
                return f"{node.signal}.{node.field}" if node.field else node.signal
            name = frame.columns[node.signal].name(max(0, env[node.axis.level] + node.offset))
            return f"{node.signal}[{name}].{node.field}"
        case _:
            raise AssertionError(f"{type(node).__name__} is no input")


def _short(node: ir.Num, env: Env, frame: Frame) -> str:
    shown = _text(node, env, frame)
    if shown.startswith("(") and isinstance(node, ir.Arith):
        shown = shown[1:-1]
    return shown if len(shown) <= _WIDTH else shown[: _WIDTH - 4] + " ..."


def _text(node: ir.Num, env: Env, frame: Frame) -> str:
    """An expression with its inputs by name."""

    def of(part: ir.Num) -> str:
        return _text(part, env, frame)

    match node:
        case ir.Const():
            return f"{node.value:.6g}"
        case ir.Param() | ir.Sample() | ir.Scalar():
            return _called(node, env, frame)
        case ir.Column():
            if node.axis.level not in env:  # bound inside the formula
                return f"{node.axis.signal}[..].{node.field}"
            return _called(node, env, frame)
        case ir.Arith():
            return f"({of(node.left)} {node.op} {of(node.right)})"
        case ir.Neg():
            return f"-{of(node.operand)}"
        case ir.Func():
            return f"{node.name}({', '.join(map(of, node.args))})"
        case ir.Choose():
            return f"(one of {of(node.then)} and {of(node.otherwise)})"
        case ir.Lookup():
            return f"{node.table.rpartition('.')[2]}({of(node.argument)})"
        case ir.GridLookup():
            return f"{node.table.rpartition('.')[2]}({of(node.first)}, {of(node.second)})"
        case ir.Station() | ir.Offset() | ir.Direction() | ir.Distance():
            return f"{node.spoken} along {_line(node.line)} of ({of(node.x)}, {of(node.y)})"
        case ir.StationGap():
            return f"{node.spoken} along {_line(node.line)} of ({of(node.start)}, {of(node.end)})"
        case ir.OnLane():
            ends = ", ".join(map(of, node.ends))
            return f"{node.spoken} {_of_lane(node)} of ({ends})"
        case ir.StretchRoom():
            ends = f"from {of(node.start)} to {of(node.end)}"
            return f"{node.spoken} along {_line(node.line)} {ends} of {of(node.station)}"
        case ir.Kept():
            machine = node.machine.name.rpartition(".")[2]
            return f"{machine}.{node.name}" if node.name else f"time_in({machine})"
        case ir.Ordinal():
            return f"the number of one of {node.axis.signal}"
        case ir.Fold():
            return (
                f"({node.op} of {_text(node.body, _without(env, node.axis), frame)} over {node.axis.signal})"
            )
        case _:
            assert_never(node)


def _of_lane(node: ir.OnLane) -> str:
    return f"one of {node.signal}" + ("" if node.side == "centre" else f", its {node.side} border")


def _line(line: ir.Line) -> str:
    name = line.name.rpartition(".")[2]
    return {"centre": f"the middle of {name}", "path": f"the path of {name}"}.get(
        line.kind, f"{name}.{line.field}" if line.field else name
    )
