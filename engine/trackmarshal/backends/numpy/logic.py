"""Formulas as arrays: worst case and best case, each a Boolean array and a margin array.

A value without anything undefined has the same arrays for both, and everything is computed once.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
#: As arrays without axes, which numpy takes faster than numbers.
INF, MINUS_INF, ZERO = np.array(np.inf), np.array(-np.inf), np.array(0.0)
TRUE, FALSE = np.array(True), np.array(False)


#: The same without the search for who else may define them, which takes as long as they do for a few numbers.
where: Callable[..., Any] = getattr(np.where, "_implementation", np.where)
vdot: Callable[..., Any] = getattr(np.vdot, "_implementation", np.vdot)

#: Taken by place: names take longer than a few numbers.
least_along: Callable[..., Any] = np.minimum.reduce
most_along: Callable[..., Any] = np.maximum.reduce
any_along: Callable[..., Any] = np.logical_or.reduce


def nowhere(flags: Any) -> bool:
    """Whether none of some Booleans is true, in the same way; None stands for some that all are."""
    return flags is not None and 1 not in flags.tobytes()


def full(flags: Any) -> bool:
    """Whether all of some Booleans are true, also where there are none: for a few several times as fast as asking numpy."""
    return 0 not in flags.tobytes()


#: What a margin says by itself: the formula holds where it is at least 0, or where it is above 0. Flags and constants, whose
#: margins are infinite, say it both ways; a formula whose parts differ in this says it in neither.
AT_LEAST, ABOVE = 1, 2
BOTH, NEITHER = AT_LEAST | ABOVE, 0


class Side:
    """The worst or the best case: the margin, and whether the formula holds; arrays, or numpy scalars.

    Where the margin says whether the formula holds, that is worked out when it is asked for.
    """

    __slots__ = ("_sat", "margin", "says")

    def __init__(self, margin: Any, says: int, sat: Any = None) -> None:
        if (says == NEITHER) != (sat is not None):
            raise AssertionError("a margin says whether a formula holds, or somebody else does")
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


def value(worst: Any, best: Any, says: int, worst_sat: Any = None, best_sat: Any = None) -> Value:
    """A value from its margins, and from whether it holds where those do not say so."""
    side = Side(worst, says, worst_sat)
    return Value(side, side if best is worst else Side(best, says, best_sat))


def parts(value: Value) -> tuple[Any, Any, Any, Any]:
    """The margins of a value, and whether it holds."""
    worst, best = value
    return worst.margin, best.margin, worst.sat, best.sat


def partly(margin: Any, known: Array) -> tuple[Array, Array]:
    """The worst and the best margin of what is undefined wherever `known` is false."""
    return where(known, margin, MINUS_INF), where(known, margin, INF)


def negate(value: Value) -> Value:
    """The denial of a value whose margin does not say whether it holds."""
    worst = Side(-value.best.margin, NEITHER, ~value.best.sat)
    if value.best is value.worst:
        return Value(worst, worst)
    return Value(worst, Side(-value.worst.margin, NEITHER, ~value.worst.sat))


def differ(a: Value, b: Value) -> Value:
    """a xor b."""
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


def every(margin: Any, axis: int, inside: Array | None) -> Any:
    """The margin of `for all` along an array axis, over what is inside; None: everything, and at least one."""
    if inside is not None:
        if nowhere(inside):
            return INF
        margin = where(inside, margin, INF)  # holds wherever it is asked for
    elif margin.ndim == 0 or margin.shape[axis] == 1:
        return margin  # nothing varies along the axis, and it is not empty
    return least_along(margin, axis, None, None, True, INF)


def some(margin: Any, axis: int, inside: Array | None) -> Any:
    """The margin of `exists`, in the same way."""
    if inside is not None:
        if nowhere(inside):
            return MINUS_INF
        if margin.ndim == 0:  # of one formula for all there is one, if there is any
            return where(any_along(inside, axis, None, None, True), margin, MINUS_INF)
        margin = where(inside, margin, MINUS_INF)
    elif margin.ndim == 0 or margin.shape[axis] == 1:
        return margin
    return most_along(margin, axis, None, None, True, MINUS_INF)


def every_sat(sat: Any, axis: int, inside: Array | None) -> Any:
    """Whether a `for all` holds, in the same way."""
    if inside is not None:
        sat = sat >= inside
    elif sat.ndim == 0 or sat.shape[axis] == 1:
        return sat
    return np.logical_and.reduce(sat, axis=axis, keepdims=True)


def some_sat(sat: Any, axis: int, inside: Array | None) -> Any:
    """Whether an `exists` holds, in the same way."""
    if inside is not None:
        if sat.ndim == 0:
            return sat & np.logical_or.reduce(inside, axis=axis, keepdims=True)
        sat = sat & inside
    elif sat.ndim == 0 or sat.shape[axis] == 1:
        return sat
    return np.logical_or.reduce(sat, axis=axis, keepdims=True)
