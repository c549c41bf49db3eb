"""Extrema over any spans of a piece of a run, as they are asked for: by spans of powers of two, of which two cover each."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.carrier import Carrier, Rows
from trackmarshal.backends.numpy.whole.elements import Indices

#: By length how many bits it has: they are looked for level by level, in bytes.
_BITS = np.frexp(np.arange(1 << 16))[1].astype(np.uint8)


class Levels:
    """Spans by the power of two that is the longest in them: which, and where the two that cover each begin."""

    def __init__(self, begin: Indices, end: Indices) -> None:
        self.begin, length = begin, end - begin
        #: Which have an element.
        self.some = length > 0
        self.all_some = bool(self.some.all())
        longest = int(length.max(initial=0))
        bits = _BITS.take(length) if longest < len(_BITS) else np.frexp(length)[1].astype(np.uint8)
        #: Each level of spans of more than one element, its spans, and where the two begin.
        self.levels: list[tuple[int, Indices, Indices, Indices]] = []
        for level in range(1, longest.bit_length()):
            chosen = np.flatnonzero(bits == level + 1)
            if len(chosen):
                self.levels.append((level, chosen, begin.take(chosen), end.take(chosen) - (1 << level)))


class Spans:
    """`until`: p until q inside a span; `all`: the least of p there. held, goal: (elements,) p and q; None: p always holds, q is not asked for.

    What is not asked for is not made: spans that are long come seldom.
    """

    def __init__(self, held: Rows | None, goal: Rows | None, carrier: Carrier) -> None:
        self.carrier = carrier
        self._held, self._goal = [held], [goal]

    def _longer(self, level: int) -> tuple[Rows | None, Rows | None]:
        """p and q over the spans of two to the power of a level, from each element from which there is one."""
        carrier = self.carrier
        while len(self._held) <= level:
            step = 1 << len(self._held) - 1
            held, goal = self._held[-1], self._goal[-1]
            self._held.append(None if held is None else carrier.meet(held[:-step], held[step:]))
            if goal is not None:
                later = goal[step:] if held is None else carrier.meet(held[:-step], goal[step:])
                goal = carrier.join(goal[:-step], later, out=None if held is None else later)
            self._goal.append(goal)
        return self._held[level], self._goal[level]

    def all(self, spans: Levels) -> Rows:
        """The least of p over each span."""
        found = self._first(self._held[0], spans, self.carrier.top)
        for level, chosen, left, right in spans.levels:
            held, _ = self._longer(level)
            assert held is not None, "nothing has to hold here"
            found[chosen] = self.carrier.meet(held.take(left), held.take(right))
        return found

    def until(self, spans: Levels) -> Rows:
        """p until q inside each span."""
        found = self._first(self._goal[0], spans, self.carrier.bottom)
        for level, chosen, left, right in spans.levels:
            held, goal = self._longer(level)
            assert goal is not None, "nothing is asked for here"
            later = goal.take(right)
            if held is not None:
                later = self.carrier.meet(held.take(left), later)
            found[chosen] = self.carrier.join(goal.take(left), later)
        return found

    @staticmethod
    def _first(rows: Rows | None, spans: Levels, nothing: float | bool) -> Rows:
        """What stands at the begin of each span: of one element that is all."""
        assert rows is not None
        if spans.all_some:
            return rows.take(spans.begin)
        found: Rows = np.where(spans.some, rows.take(spans.begin, mode="clip"), nothing)
        return found
