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


class Side(NamedTuple):
    """The worst or the best case: whether the formula holds, and its margin; arrays, or numpy scalars."""

    sat: Any
    margin: Any


class Value(NamedTuple):
    """A formula's value; `best is worst` where nothing is undefined."""

    worst: Side
    best: Side


def defined(sat: Any, margin: Any) -> Value:
    side = Side(sat, margin)
    return Value(side, side)


def partly(sat: Array, margin: Array, known: Array) -> Value:
    """A value that is undefined wherever `known` is false."""
    worst = Side(sat & known, np.where(known, margin, MINUS_INF))
    return Value(worst, Side(sat | ~known, np.where(known, margin, INF)))


def least(a: Side, b: Side) -> Side:
    return Side(a.sat & b.sat, np.minimum(a.margin, b.margin))


def greatest(a: Side, b: Side) -> Side:
    return Side(a.sat | b.sat, np.maximum(a.margin, b.margin))


def _opposite(side: Side) -> Side:
    return Side(~side.sat, -side.margin)


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
    worst = Side(surely, apart)
    if a.best is a.worst and b.best is b.worst:
        return Value(worst, worst)
    return Value(worst, Side(~surely_not, at_most))


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
    sat, margin = side
    if inside is not None:
        sat, margin = sat >= inside, np.where(inside, margin, INF)  # holds wherever it is asked for
    elif sat.ndim == 0 or sat.shape[axis] == 1:
        return side  # nothing varies along the axis, and it is not empty
    return Side(
        np.logical_and.reduce(sat, axis=axis, keepdims=True),
        np.minimum.reduce(margin, axis=axis, keepdims=True, initial=np.inf),
    )


def _some(side: Side, axis: int, inside: Array | None) -> Side:
    sat, margin = side
    if inside is not None and sat.ndim == 0:  # of one formula for all there is one, if there is any
        there = np.logical_or.reduce(inside, axis=axis, keepdims=True)
        return Side(sat & there, np.where(there, margin, MINUS_INF))
    if inside is not None:
        sat, margin = sat & inside, np.where(inside, margin, MINUS_INF)
    elif sat.ndim == 0 or sat.shape[axis] == 1:
        return side
    return Side(
        np.logical_or.reduce(sat, axis=axis, keepdims=True),
        np.maximum.reduce(margin, axis=axis, keepdims=True, initial=-np.inf),
    )
