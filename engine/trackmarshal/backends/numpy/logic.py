"""Formulas as arrays: worst case and best case, each a Boolean array and a margin array.

A value without anything undefined has the same arrays for both, and everything is computed once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
#: As arrays without axes, which numpy takes faster than numbers.
INF, MINUS_INF = np.array(np.inf), np.array(-np.inf)


#: What a margin says by itself: the formula holds where it is at least 0, or where it is above 0. Flags and constants, whose
#: margins are infinite, say it both ways; a formula whose parts differ in this says it in neither.
AT_LEAST, ABOVE = 1, 2
BOTH, NEITHER = AT_LEAST | ABOVE, 0


class Side:
    """The worst or the best case: the margin, and whether the formula holds; arrays, or numpy scalars.

    Where the margin says whether the formula holds, that is worked out when it is asked for: mostly never.
    """

    __slots__ = ("_sat", "margin", "says")

    def __init__(self, margin: Any, says: int, sat: Any = None) -> None:
        assert (says == NEITHER) == (sat is not None)
        self.margin, self.says, self._sat = margin, says, sat

    @property
    def sat(self) -> Any:
        """Whether the formula holds."""
        if self._sat is None:
            self._sat = self.margin >= 0.0 if self.says & AT_LEAST else self.margin > 0.0
        return self._sat


class Value(NamedTuple):
    """A formula's value; `best is worst` where nothing is undefined."""

    worst: Side
    best: Side


def defined(margin: Any, says: int) -> Value:
    side = Side(margin, says)
    return Value(side, side)


def partly(margin: Array, says: int, known: Array) -> Value:
    """A value that is undefined wherever `known` is false."""
    return Value(Side(np.where(known, margin, MINUS_INF), says), Side(np.where(known, margin, INF), says))


def least(a: Side, b: Side) -> Side:
    says = a.says & b.says
    return Side(np.minimum(a.margin, b.margin), says, None if says else a.sat & b.sat)


def greatest(a: Side, b: Side) -> Side:
    says = a.says & b.says
    return Side(np.maximum(a.margin, b.margin), says, None if says else a.sat | b.sat)


def _opposite(side: Side) -> Side:
    # What fails at 0 holds there when denied: the two ways of saying it change places.
    says = (side.says & AT_LEAST) << 1 | (side.says & ABOVE) >> 1
    return Side(-side.margin, says, None if says else ~side.sat)


def negate(value: Value) -> Value:
    worst = _opposite(value.best)
    return Value(worst, worst if value.best is value.worst else _opposite(value.worst))


def connect(op: str, a: Value, b: Value) -> Value:
    """and, or, implies, iff, xor."""
    if op in ("and", "or"):
        join = least if op == "and" else greatest
        worst = join(a.worst, b.worst)
        if a.best is a.worst and b.best is b.worst:
            return Value(worst, worst)
        return Value(worst, join(a.best, b.best))
    if op == "implies":
        return connect("or", negate(a), b)
    if op == "xor":
        return _differ(a, b)
    if op == "iff":
        return negate(_differ(a, b))
    raise AssertionError(f"unknown connective {op}")


def _differ(a: Value, b: Value) -> Value:
    surely = (a.worst.sat & ~b.best.sat) | (b.worst.sat & ~a.best.sat)
    surely_not = (a.worst.sat & b.worst.sat) | ~(a.best.sat | b.best.sat)
    apart = np.maximum(
        np.maximum(0.0, _difference(a.worst.margin, b.best.margin)),
        _difference(b.worst.margin, a.best.margin),
    )
    at_most = np.maximum(
        _difference(a.best.margin, b.worst.margin), _difference(b.best.margin, a.worst.margin)
    )
    worst = Side(apart, NEITHER, surely)
    if a.best is a.worst and b.best is b.worst:
        return Value(worst, worst)
    return Value(worst, Side(at_most, NEITHER, ~surely_not))


def _difference(x: Array, y: Array) -> Array:
    """x - y, where equal infinities do not differ."""
    return np.where(x == y, 0.0, x - y)


def reduce(value: Value, every: bool, axis: int, in_worst: Array | None, in_best: Array | None) -> Value:
    """`for all` (every) or `exists` along an array axis, over the elements in range in the worst and in the best case.

    None: all of them are there, and at least one.
    """
    side = _every if every else _some
    worst = side(value.worst, axis, in_worst)
    if value.best is value.worst and in_best is in_worst:
        return Value(worst, worst)
    return Value(worst, side(value.best, axis, in_best))


def _every(side: Side, axis: int, inside: Array | None) -> Side:
    margin = side.margin
    if inside is not None:
        margin = np.where(inside, margin, INF)  # holds wherever it is asked for
    elif margin.ndim == 0 or margin.shape[axis] == 1:
        return side  # nothing varies along the axis, and it is not empty
    least_ = np.minimum.reduce(margin, axis=axis, keepdims=True, initial=np.inf)
    if side.says:
        return Side(least_, side.says)
    sat = side.sat if inside is None else side.sat >= inside
    return Side(least_, NEITHER, np.logical_and.reduce(sat, axis=axis, keepdims=True))


def _some(side: Side, axis: int, inside: Array | None) -> Side:
    margin = side.margin
    if inside is not None and margin.ndim == 0:  # of one formula for all there is one, if there is any
        there = np.logical_or.reduce(inside, axis=axis, keepdims=True)
        margin = np.where(there, margin, MINUS_INF)
        return Side(margin, side.says, None if side.says else side.sat & there)
    if inside is not None:
        margin = np.where(inside, margin, MINUS_INF)
    elif margin.ndim == 0 or margin.shape[axis] == 1:
        return side
    most = np.maximum.reduce(margin, axis=axis, keepdims=True, initial=-np.inf)
    if side.says:
        return Side(most, side.says)
    sat = side.sat if inside is None else side.sat & inside
    return Side(most, NEITHER, np.logical_or.reduce(sat, axis=axis, keepdims=True))
