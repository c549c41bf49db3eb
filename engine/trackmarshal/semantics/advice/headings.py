"""Headings that are compared across a whole turn, and stations that are compared across the finish line."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TypeAlias

from trackmarshal import typed
from trackmarshal.semantics.advice.units import ANGLES, GIVE_ON, reads
from trackmarshal.semantics.values import behind, on_open_line
from trackmarshal.semantics.warnings.numbers import LapsOver, TurnsOver
from trackmarshal.source import Span
from trackmarshal.units import NUMBER


def turns_over(left: typed.Number, right: typed.Number, span: Span) -> TurnsOver | None:
    """What is to be said of a comparison of two headings, or of how far they are apart, where nothing takes whole turns out of it."""
    one, other = _but_for_constants(left, _turns), _but_for_constants(right, _turns)
    if one is not None and other is not None and (_leads(one) or _leads(other)):
        return _over(span, one, other, "{} and {} are no 358 deg apart")
    apart = next((found for number in (left, right) if (found := _apart(number)) is not None), None)
    return (
        None
        if apart is None
        else _over(apart.span, apart.left, apart.right, "from {} to {}, this is 358 deg")
    )


def laps_over(left: typed.Number, right: typed.Number, span: Span) -> LapsOver | None:
    """The same of stations of a line that may be closed, one beside another: a station and a constant are a place."""
    one, other = _but_for_constants(left, _stands), _but_for_constants(right, _stands)
    if one is not None and other is not None:
        return LapsOver(span, other.span.in_line, one.span.in_line)
    found = (_apart(number, _both_stand) for number in (left, right))
    apart = next((each for each in found if each is not None), None)
    return None if apart is None else LapsOver(apart.span, apart.right.span.in_line, apart.left.span.in_line)


def between(op: str, left: typed.Number, right: typed.Number, span: Span) -> TurnsOver | None:
    """What is to be said of arithmetic that takes a heading between two others from their numbers."""
    if left.dimension != NUMBER or right.dimension != NUMBER:  # mostly
        return None
    one, other = behind(left), behind(right)
    ends: _Ends | None = None
    if op == "+":
        ends = _shares(one, other) or _on_the_way(one, other) or _on_the_way(other, one)
    elif op in ("*", "/"):
        ends = _summed(one, other) or (_summed(other, one) if op == "*" else None)
    elif op != "-":
        raise AssertionError(f"unknown operator {op}")
    return (
        None
        if ends is None
        else _over(span, ends[0], ends[1], "of {} and {}, what lies between is taken for {}")
    )


def _over(span: Span, one: typed.Number, other: typed.Number, told: str) -> TurnsOver:
    """The warning, told of two headings that lie beside where these start anew, and of what is halfway between their numbers."""
    leads = next((each for each in (one, other) if _leads(each)), one)
    lowest = -180.0 if (turn := _turn(behind(leads))) is None else math.degrees(turn[0])
    seam = [f"{round(lowest + after)} deg" for after in (359.0, 1.0, 180.0)]
    return TurnsOver(span, one.span.in_line, other.span.in_line, told.format(*seam))


def _but_for_constants(node: typed.Number, kind: Callable[[typed.Number], bool]) -> typed.Number | None:
    """The number of a kind, such as a heading, that a number is but for a constant."""
    node = behind(node)
    while isinstance(node, typed.Arithmetic) and node.op in "+-":
        if not reads(node.right):
            node = behind(node.left)
        elif node.op == "+" and not reads(node.left):
            node = behind(node.right)
        else:
            return None
    return node if kind(node) else None


def _leads(node: typed.Number) -> bool:
    """Whether a number is where something heads for: a field of that name, or one whose range is a whole turn, or the direction of a line."""
    match behind(node):
        case typed.Field() as field:
            return field.name == "heading" or _turn(field) is not None
        case typed.OnLine(function="direction"):
            return True
        case _:
            return False


def _turn(node: typed.Number) -> tuple[float, float] | None:
    """The range of a field that is declared as an angle of a whole turn, as a course in [0, 360] is: it starts anew at its ends."""
    if not isinstance(node, typed.Field) or node.record.signal is None:
        return None
    kind = node.record.signal.field(node.name)
    if kind is None or kind.unit not in ANGLES or kind.lower is None or kind.upper is None:
        return None
    whole = math.isclose(kind.upper - kind.lower, math.tau, rel_tol=0.01)  # [0, 359.9], [-3.14, 3.14]
    return (kind.lower, kind.upper) if whole else None


def _turns(node: typed.Number) -> bool:
    """Whether a number starts anew after half a turn: where something heads for, or the bearing that `atan2` gives."""
    return _leads(node) or (isinstance(found := behind(node), typed.Function) and found.name == "atan2")


def _leads_apart(left: typed.Number, right: typed.Number) -> bool:
    """Whether a difference is one of two headings, or of one and a bearing or a constant that is not the middle of its range."""
    sides = (left, right)
    if not any(map(_leads, sides)) or not all(_turns(one) or not reads(one) for one in sides):
        return False
    return not (_is_middle(left, right) or _is_middle(right, left))


def _is_middle(node: typed.Number, field: typed.Number) -> bool:
    """Whether a constant is the middle of a field's range of a whole turn: from 180 deg, a course in [0, 360] is half a turn away at most."""
    value, turn = typed.literal(behind(node)), _turn(behind(field))
    return value is not None and turn is not None and math.isclose(value, sum(turn) / 2, abs_tol=0.01)


def _apart(
    node: typed.Number, of: Callable[[typed.Number, typed.Number], bool] = _leads_apart
) -> typed.Arithmetic | None:
    """The difference of two headings, or of what else is asked for, that a number is made of: its size, its rate, the most or least of several."""
    seen: set[typed.Number] = set()  # written out, they can be far more than they are
    stack = [node]
    while stack:
        part = behind(stack.pop())
        if part in seen:
            continue
        seen.add(part)
        match part:
            case typed.Arithmetic(op="-"):
                if of(part.left, part.right):
                    return part
            case typed.Arithmetic(op="*"):
                stack += [part.right, part.left]
            case typed.Arithmetic(op="/"):
                stack.append(part.left)
            case typed.Negative():
                stack.append(part.operand)
            case typed.Power():
                stack.append(part.base)
            case typed.Folded(body=body) if body is not None:
                stack.append(body)
            case typed.Choice():
                stack += [part.otherwise, part.then]
            case typed.NumberCase():
                stack += [branch.value for branch in reversed(part.branches)]
            case typed.Function() if part.name in GIVE_ON or part.name in ("sqrt", "hypot"):
                if not _both_ways(part):
                    stack += reversed(part.arguments)
            case _:  # whatever else is made of it, such as a sine, is another matter
                pass
    return None


def _both_ways(node: typed.Function) -> bool:
    """Whether a number is that of the shorter way round: `min(apart, 360 deg - apart)`, where `apart` is a size."""
    sizes = [
        each.span.in_line
        for each in node.arguments
        if isinstance(part := behind(each), typed.Function) and part.name == "abs"
    ]
    return node.name == "min" and any(
        isinstance(part, typed.Arithmetic)
        and part.op == "-"
        and _is_turn(part.left)
        and part.right.span.in_line in sizes
        for part in map(behind, node.arguments)
    )


def _is_turn(node: typed.Number) -> bool:
    """Whether a number is a whole turn: `360 deg`, `2 * pi`."""
    node = behind(node)
    factors = (node.left, node.right) if isinstance(node, typed.Arithmetic) and node.op == "*" else (node,)
    values = [value for each in factors if (value := typed.literal(each)) is not None]
    return len(values) == len(factors) and math.isclose(math.prod(values), math.tau)


def _stands(node: typed.Number) -> bool:
    """Whether a number is a station of a line that may be closed."""
    node = behind(node)
    return isinstance(node, typed.OnLine) and node.function == "station" and not on_open_line(node.line)


def _both_stand(left: typed.Number, right: typed.Number) -> bool:
    """Whether a difference is one of two stations."""
    return _stands(left) and _stands(right)


#: Two headings.
_Ends: TypeAlias = tuple[typed.Number, typed.Number]


def _shares(one: typed.Number, other: typed.Number) -> _Ends | None:
    """The headings of which two numbers are multiples: `(1 - share) * p.heading + share * q.heading`."""
    factors = [
        next(filter(_leads, (each.left, each.right)), None)
        for each in (one, other)
        if isinstance(each, typed.Arithmetic) and each.op == "*"
    ]
    found = [each for each in factors if each is not None]
    return (found[1], found[0]) if len(found) == 2 else None


def _on_the_way(begin: typed.Number, way: typed.Number) -> _Ends | None:
    """The headings between which one is, that is another one and a multiple of a difference: `p.heading + share * (q.heading - p.heading)`."""
    scaled = isinstance(way, typed.Arithmetic) and way.op in "*/"
    apart = _apart(way) if scaled and _leads(begin) else None
    return None if apart is None else (apart.left, apart.right)


def _summed(total: typed.Number, factor: typed.Number) -> _Ends | None:
    """The headings of which one is the mean: `(p.heading + q.heading) / 2`."""
    if not isinstance(total, typed.Arithmetic) or total.op != "+":
        return None
    both = _leads(total.left) and _leads(total.right)
    return (total.right, total.left) if both and not reads(factor) else None
