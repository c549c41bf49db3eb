"""Formulas along the cycles of a run as arrays: worst and best case, each a Boolean and a margin for every cycle."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, assert_never

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.logic import NEITHER, Side, Value, differ, negate
from trackmarshal.ir.operators import ConnectiveOp
from trackmarshal.runtime.kleene import FALSE, TRUE, UNDEFINED
from trackmarshal.runtime.verdict import Bound, Truth

__all__ = [
    "FALSE", "TRUE", "UNDEFINED", "applied", "connected", "constant", "guarded", "negate", "of", "one_side", "put", "taken", "together", "undefined_where",
]  # fmt: skip

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]
#: Whether a formula holds, and its margin.
Pair = tuple[Bools, Floats]


def of(worst: Pair, best: Pair) -> Value:
    """A value from what each side is; the same object for both where nothing is undefined."""
    side = one_side(worst)
    return Value(side, side if best is worst else one_side(best))


def one_side(pair: Pair) -> Side:
    return Side(pair[1], NEITHER, pair[0])


def pairs(value: Value) -> tuple[Pair, Pair]:
    """Both sides; the same object where nothing is undefined."""
    worst = value.worst.sat, value.worst.margin
    return worst, worst if value.best is value.worst else (value.best.sat, value.best.margin)


def constant(truth: Truth, count: int) -> Value:
    """(count,) of one value."""
    worst = _full(truth.worst, count)
    return of(worst, worst if truth.best == truth.worst else _full(truth.best, count))


def _full(bound: Bound, count: int) -> Pair:
    return np.full(count, bound.sat), np.full(count, bound.margin)


def applied(change: Callable[[Any], Any], value: Value) -> Value:
    """What a change of arrays makes of all arrays of a value."""
    worst, best = pairs(value)
    changed = change(worst[0]), change(worst[1])
    return of(changed, changed if best is worst else (change(best[0]), change(best[1])))


def taken(value: Value, places: Any) -> Value:
    """The value in some cycles."""
    return applied(lambda array: array[places], value)


def together(parts: Sequence[Value]) -> Value:
    """Values of cycles that follow one another."""
    if len(parts) == 1:
        return parts[0]
    sides = [pairs(part) for part in parts]

    def joined(side: int) -> Pair:
        return np.concatenate([each[side][0] for each in sides]), np.concatenate(
            [each[side][1] for each in sides]
        )

    worst = joined(0)
    return of(worst, worst if all(one is other for one, other in sides) else joined(1))


def put(into: Value, places: Any, value: Value) -> Value:
    """A value, with others in some cycles."""
    changed: list[Pair] = []
    for (sat, margin), (own_sat, own) in zip(pairs(into), pairs(value)):
        sat, margin = sat.copy(), margin.copy()
        sat[places], margin[places] = own_sat, own
        changed.append((sat, margin))
    single = into.best is into.worst and value.best is value.worst
    return of(changed[0], changed[0] if single else changed[1])


def undefined_where(value: Value, unknown: Bools | None) -> Value:
    """A value, undefined in some cycles."""
    if unknown is None or not unknown.any():
        return value
    return put(value, unknown, constant(UNDEFINED, int(unknown.sum())))


def connected(op: ConnectiveOp, a: Value, b: Value) -> Value:
    """Two formulas joined."""
    match op:
        case "and":
            return _both(np.logical_and, np.minimum, a, b)
        case "or":
            return _both(np.logical_or, np.maximum, a, b)
        case "xor":
            return differ(a, b)
        case "iff":
            return negate(differ(a, b))
        case _:
            assert_never(op)


def _both(of_sat: np.ufunc, of_margin: np.ufunc, a: Value, b: Value) -> Value:
    (aw, ab), (bw, bb) = pairs(a), pairs(b)
    worst = of_sat(aw[0], bw[0]), of_margin(aw[1], bw[1])
    return of(worst, worst if ab is aw and bb is bw else (of_sat(ab[0], bb[0]), of_margin(ab[1], bb[1])))


def guarded(guard: Value, body: Value) -> Value:
    """A demand wherever a guard holds."""
    (gw, gb), (bw, bb) = pairs(guard), pairs(body)

    def where(holds: Bools, pair: Pair) -> Pair:
        return pair[0] | ~holds, np.where(holds, pair[1], np.inf)

    worst = where(gb[0], bw)
    return of(worst, worst if gb is gw and bb is bw else where(gw[0], bb))
