"""Extrema over any spans of a piece of a run, as they are asked for: by spans of powers of two, of which two cover each."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.carrier import Carrier, Rows
from trackmarshal.backends.numpy.whole.elements import Indices

#: By length the power of two that is the longest in it; of 0 that of 1.
_LEVELS = np.maximum(np.frexp(np.arange(1 << 16))[1] - 1, 0).astype(np.uint8)

#: Of spans that are fewer than one of so many elements, and not long, each is looked through by itself: a table of all takes longer.
FEW = 16


class Levels:
    """Spans, none of which ends before it begins, of a piece of n elements: where the two that cover each begin in a table of all spans of powers of two."""

    def __init__(self, begin: Indices, end: Indices, n: int) -> None:
        length = end - begin
        longest = int(length.max(initial=0))
        self.begin, self.end = begin, end
        #: Those without an element.
        self.empty: Indices = np.flatnonzero(length == 0) if length.size and not length.all() else length[:0]
        #: The power of two that is the longest in any.
        self.level = max(longest.bit_length() - 1, 0)
        self.few = len(begin) * FEW < n and int(length.sum()) < n * self.level
        self.left = self.right = begin
        if self.level:
            level = _LEVELS.take(length) if longest < len(_LEVELS) else np.maximum(np.frexp(length)[1] - 1, 0)
            self.left = np.multiply(level, n, dtype=np.intp)
            self.left += begin
            self.right = self.left + length
            self.right -= np.left_shift(1, level, dtype=np.intp)


class Spans:
    """`until`: p until q inside a span; `all`: the least of p there. held, goal: (elements,) p and q; None: p always holds, q is not asked for.

    What is not asked for is not made: spans that are long come seldom.
    """

    def __init__(self, held: Rows | None, goal: Rows | None, carrier: Carrier) -> None:
        self.carrier = carrier
        #: (levels, elements) p and q over the spans of two to the power of each level, from each element from which there is one.
        self._held, self._goal = (None if one is None else one[None] for one in (held, goal))
        self._levels = 1

    def _make(self, level: int) -> None:
        """The spans up to a level."""
        if level < self._levels:
            return
        held = self._held = _grown(self._held, level + 1)
        goal = self._goal = _grown(self._goal, level + 1)
        for above in range(self._levels, level + 1):
            of, step = above - 1, 1 << above - 1
            if goal is not None:
                later = (
                    goal[of, step:] if held is None else self.carrier.meet(held[of, :-step], goal[of, step:])
                )
                self.carrier.join(goal[of, :-step], later, out=goal[above, :-step])
            if held is not None:
                self.carrier.meet(held[of, :-step], held[of, step:], out=held[above, :-step])
        self._levels = level + 1

    def all(self, spans: Levels) -> Rows:
        """The least of p over each span."""
        assert self._held is not None, "nothing has to hold here"
        if spans.few:
            return _each(self._held[0], self.carrier.meet, self.carrier.top, spans)
        self._make(spans.level)
        found = _looked_up(self._held, spans.left, spans)
        if spans.level:
            self.carrier.meet(found, _looked_up(self._held, spans.right, spans), out=found)
        found[spans.empty] = self.carrier.top
        return found

    def until(self, spans: Levels) -> Rows:
        """p until q inside each span."""
        assert self._goal is not None, "nothing is asked for here"
        if self._held is None and spans.few:
            return _each(self._goal[0], self.carrier.join, self.carrier.bottom, spans)
        self._make(spans.level)
        found = _looked_up(self._goal, spans.left, spans)
        if spans.level:
            later = _looked_up(self._goal, spans.right, spans)
            if self._held is not None:
                self.carrier.meet(later, _looked_up(self._held, spans.left, spans), out=later)
            self.carrier.join(found, later, out=found)
        found[spans.empty] = self.carrier.bottom
        return found


def _grown(table: Rows | None, levels: int) -> Rows | None:
    """A table with room for so many levels."""
    if table is None:
        return None
    made: Rows = np.empty((levels, table.shape[1]), table.dtype)
    made[: len(table)] = table
    return made


def _each(row: Rows, better: np.ufunc, neutral: float | bool, spans: Levels) -> Rows:
    """The extremum over each span, from its elements."""
    # What lies between one span and the next comes along, and is left out. A span may end, or be empty, behind the last element.
    edges = np.stack((spans.begin, spans.end), axis=1).ravel()
    found: Rows = better.reduceat(np.append(row, row[-1]), edges)[::2]
    found[spans.empty] = neutral
    return found


def _looked_up(table: Rows, at: Indices, spans: Levels) -> Rows:
    """What stands in a table; where a span has no element, anything."""
    return table.ravel().take(at, mode="clip" if spans.empty.size else "raise")
