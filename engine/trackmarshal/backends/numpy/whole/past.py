"""Operators that look back along the cycles of a run, piece by piece: of what is past each keeps what its window may still hold."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, assert_never

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.numpy.logic import Value
from trackmarshal.backends.numpy.tallies import compared
from trackmarshal.backends.numpy.whole import values
from trackmarshal.backends.numpy.whole.elements import LONG_AGO, Elements, joined, one
from trackmarshal.backends.numpy.whole.values import Pair, constant, of, pairs, taken, together
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.kleene import FALSE, TRUE

Counts = NDArray[np.int64]


class Operator(Protocol):
    """An operator with its memory."""

    def step(self, new: Elements, operands: Sequence[Value], limit: Any, keep: bool) -> Value:
        """(elements,): its values in the next elements of the run, given those of its operands there, and the numbers that a count is compared
        with. keep: they are remembered; else the next ones come after those before."""


def operator(node: ir.OverRun | ir.Counted) -> Operator:
    """An operator that looks back, before the first cycle."""
    if isinstance(node, ir.Counted):
        return _Count(node)
    match node.op:
        case "previous":
            return _Previous(node)
        case "once" | "historically" | "since":
            return _Window(node)
        case "always" | "eventually" | "until" | "next":
            raise AssertionError(f"`{node.op}` does not look back")
        case _:
            assert_never(node.op)


class _Previous:
    def __init__(self, node: ir.OverRun) -> None:
        self._before = constant(TRUE if node.weak else FALSE, 1)

    def step(self, new: Elements, operands: Sequence[Value], limit: Any, keep: bool) -> Value:
        whole = together([self._before, operands[0]])
        if keep:
            self._before = values.applied(np.copy, taken(whole, slice(len(new), None)))
        return taken(whole, slice(0, len(new)))


class _Window:
    """once, historically, since. Without a bound, what it came to stands for all cycles before as one that lies long ago."""

    def __init__(self, node: ir.OverRun) -> None:
        self._node = node
        self._kept: Elements | None = None
        self._values: list[Value] = []

    def step(self, new: Elements, operands: Sequence[Value], limit: Any, keep: bool) -> Value:
        node, own = self._node, len(new)
        whole, given = new, list(operands)
        if self._kept is not None:
            whole = joined([self._kept, new])
            given = [together(pair) for pair in zip(self._values, operands)]
        found = self._found(given, whole, own)
        if keep and node.upper is None:
            last = values.applied(np.copy, taken(found, slice(own - 1, None)))
            self._kept, self._values = one(LONG_AGO), [constant(TRUE, 1), last][-len(given) :]
        elif keep and node.upper is not None:
            begin = whole.since(int(whole.last[-1]) - node.upper)
            self._kept = whole.after(begin)
            self._values = [values.applied(lambda array: array[begin:].copy(), each) for each in given]
        return found

    def _found(self, operands: list[Value], whole: Elements, own: int) -> Value:
        """(own,): the values in the last so many elements."""
        node = self._node
        windows = whole.back(node.lower or 0, node.upper, own)
        sides = [pairs(value) for value in operands]

        def found(side: int) -> Pair:
            given = [each[side] for each in sides]
            match node.op:
                case "once":
                    return temporal.eventually(*given[0], windows)
                case "historically":
                    return temporal.always(*given[0], windows)
                case "since":
                    return temporal.since(*given[0], *given[1], windows)
                case _:
                    raise AssertionError(f"`{node.op}` has no window in the past")

        worst = found(0)
        return of(worst, worst if all(low is best for low, best in sides) else found(1))


class _Count:
    """count: how many cycles count, surely and possibly, after the last one in which the count may, and surely does, start anew."""

    def __init__(self, node: ir.Counted) -> None:
        self._node = node
        self._kept: Elements | None = None
        self._arrays: list[Any] = []

    def step(self, new: Elements, operands: Sequence[Value], limit: Any, keep: bool) -> Value:
        node, own = self._node, len(new)
        gap = new.missed > 0
        counted, resets = operands[0], operands[1:]
        sure = counted.worst.sat.astype(np.int64)
        possible = np.where(gap, new.missed, counted.best.sat).astype(np.int64)
        nothing = np.zeros(own, dtype=bool)
        surely, possibly = nothing, nothing
        for reset in resets:
            surely, possibly = surely | reset.worst.sat, possibly | reset.best.sat
        arrays = [sure, possible, surely, possibly]
        whole = new
        if self._kept is not None:
            whole = joined([self._kept, new])
            arrays = [np.concatenate(pair) for pair in zip(self._arrays, arrays)]
        begin = whole.back(0, node.upper, len(whole)).start
        # What may start anew ends what surely counts, what surely does what possibly counts.
        found = [
            _since(count, begin, anew if resets else None)
            for count, anew in ((arrays[0], arrays[3]), (arrays[1], arrays[2]))
        ]
        if keep and node.upper is None:
            last = [each[-1:].copy() for each in found]
            self._kept, self._arrays = one(LONG_AGO), [*last, nothing[:1], nothing[:1]]
        elif keep and node.upper is not None:
            rest = whole.since(int(whole.last[-1]) - node.upper)
            self._kept, self._arrays = whole.after(rest), [array[rest:].copy() for array in arrays]
        return compared(node, found[0][len(whole) - own :], found[1][len(whole) - own :], limit)


def _since(count: Counts, begin: Any, anew: Any) -> Counts:
    """The sum of counts from each begin on, or from the last element on that starts anew, that one included."""
    total = np.concatenate(([0], np.cumsum(count)))
    if anew is not None:
        started = np.maximum.accumulate(np.where(anew, np.arange(len(anew)), 0))
        begin = np.maximum(begin, started)
    found: Counts = total[1:] - total[begin]
    return found
