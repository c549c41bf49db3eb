"""Extrema over any spans of a piece of a run, as they are asked for: by spans of powers of two, of which two cover each."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.carrier import Carrier, Rows
from trackmarshal.backends.numpy.whole.elements import Indices


class Levels:
    """Spans by the power of two that is the longest in them: which, and where the two that cover each begin."""

    def __init__(self, begin: Indices, end: Indices) -> None:
        self.count = len(begin)
        length = end - begin
        single, longer = np.flatnonzero(length == 1), np.flatnonzero(length > 1)
        levels = np.frexp(length[longer].astype(np.float64))[1] - 1
        chosen = [(level, longer[levels == level]) for level in np.flatnonzero(np.bincount(levels)).tolist()]
        self.levels: list[tuple[int, Indices, Indices, Indices]] = [
            (level, places, begin[places], end[places] - (1 << level))
            for level, places in [(0, single), *chosen]
            if len(places)
        ]


class Spans:
    """`until`: p until q inside a span; `all`: the least of p there. held, goal: (elements,) p and q; None: p always holds, q is not asked for.

    What is not asked for is not made: spans that are long come seldom.
    """

    def __init__(self, held: Rows | None, goal: Rows | None, carrier: Carrier) -> None:
        self.carrier = carrier
        self._held, self._goal = [held], [goal]

    def _longer(self, level: int) -> tuple[Rows | None, Rows | None]:
        """p and q over the spans of two to the power of a level."""
        carrier = self.carrier
        while len(self._held) <= level:
            step = 1 << len(self._held) - 1
            held, goal = self._held[-1], self._goal[-1]
            self._held.append(None if held is None else _put(held, carrier.meet(held[:-step], held[step:])))
            if goal is not None:
                later = goal[step:] if held is None else carrier.meet(held[:-step], goal[step:])
                goal = _put(goal, carrier.join(goal[:-step], later))
            self._goal.append(goal)
        return self._held[level], self._goal[level]

    def all(self, spans: Levels) -> Rows:
        """The least of p over each span."""
        found: Rows = np.full(spans.count, self.carrier.top, self.carrier.dtype)
        for level, chosen, left, right in spans.levels:
            held, _ = self._longer(level)
            assert held is not None, "nothing has to hold here"
            found[chosen] = self.carrier.meet(held[left], held[right]) if level else held[left]
        return found

    def until(self, spans: Levels) -> Rows:
        """p until q inside each span."""
        found: Rows = np.full(spans.count, self.carrier.bottom, self.carrier.dtype)
        for level, chosen, left, right in spans.levels:
            held, goal = self._longer(level)
            assert goal is not None, "nothing is asked for here"
            if not level:  # one element, on which nothing has to hold before the goal
                found[chosen] = goal[left]
                continue
            later = goal[right] if held is None else self.carrier.meet(held[left], goal[right])
            found[chosen] = self.carrier.join(goal[left], later)
        return found


def _put(into: Rows, first: Rows) -> Rows:
    """A copy with other values at the beginning."""
    made = into.copy()
    made[: len(first)] = first
    return made
