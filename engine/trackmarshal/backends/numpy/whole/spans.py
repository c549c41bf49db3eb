"""Extrema over any spans of a piece of a run, as they are asked for: by spans of powers of two, of which two cover each."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.carrier import Carrier, Rows
from trackmarshal.backends.numpy.whole.elements import Indices


class Spans:
    """`until`: p until q inside a span; `all`: the least of p there. held, goal: (elements,) p and q; None: p always holds, q is not asked for."""

    def __init__(self, held: Rows | None, goal: Rows | None, carrier: Carrier, longest: int) -> None:
        self._carrier = carrier
        self._held, self._goal = [held], [goal]
        step = 1
        while 2 * step <= longest:
            before, wanted = self._held[-1], self._goal[-1]
            self._held.append(
                None if before is None else _put(before, carrier.meet(before[:-step], before[step:]))
            )
            if wanted is not None:
                later = wanted[step:] if before is None else carrier.meet(before[:-step], wanted[step:])
                wanted = _put(wanted, carrier.join(wanted[:-step], later))
            self._goal.append(wanted)
            step *= 2

    def all(self, begin: Indices, end: Indices) -> Rows:
        """The least of p over each span."""
        found: Rows = np.full(len(begin), self._carrier.top, self._carrier.dtype)
        for level, chosen, left, right in _levels(begin, end):
            held = self._held[level]
            assert held is not None, "nothing has to hold here"
            found[chosen] = self._carrier.meet(held[left], held[right])
        return found

    def until(self, begin: Indices, end: Indices) -> Rows:
        """p until q inside each span."""
        found: Rows = np.full(len(begin), self._carrier.bottom, self._carrier.dtype)
        for level, chosen, left, right in _levels(begin, end):
            held, goal = self._held[level], self._goal[level]
            assert goal is not None, "nothing is asked for here"
            later = goal[right] if held is None else self._carrier.meet(held[left], goal[right])
            found[chosen] = self._carrier.join(goal[left], later)
        return found


def _put(into: Rows, first: Rows) -> Rows:
    """A copy with other values at the beginning."""
    made = into.copy()
    made[: len(first)] = first
    return made


def _levels(begin: Indices, end: Indices) -> list[tuple[int, Indices, Indices, Indices]]:
    """Spans by the power of two that is the longest in them: which, and where the two that cover each begin."""
    length = end - begin
    levels = np.frexp(length.astype(np.float64))[1] - 1  # of nothing: -1
    found = []
    for level in np.flatnonzero(np.bincount(levels[length > 0])).tolist():
        chosen = np.flatnonzero(levels == level)
        if level == 0:
            chosen = chosen[length[chosen] > 0]
        found.append((level, chosen, begin[chosen], end[chosen] - (1 << level)))
    return found
