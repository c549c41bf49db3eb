"""The first element of each window of which something holds: since nothing but places is compared, one look along the piece finds them all."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.windows import Windows
from trackmarshal.backends.numpy.whole.elements import Elements, Indices
from trackmarshal.backends.numpy.whole.values import Bools, Floats

#: Of a formula that nothing in its window decides before the window is closed.
STAYS = -1.0


class Firsts:
    """Of windows that look ahead, those of cycles. Places are those of cycles in the piece; infinite: there is none."""

    def __init__(self, windows: Windows, elements: Elements) -> None:
        self._n, self._elements = windows.n, elements
        cycles = elements.cycles
        self._own = np.arange(self._n) if cycles is None else cycles
        self._begin = self._edge(windows.begin)
        self._end = self._edge(windows.end)
        #: By element, and one after the last.
        self._places = np.full(self._n + 1, np.inf)
        self._places[self._own] = np.arange(len(self._own))

    def _edge(self, edge: int | Indices) -> Indices:
        if isinstance(edge, int):
            return np.minimum(self._own + edge, self._n)
        return self._elements.of_cycles(edge)

    def _after(self, holds: Bools) -> Indices:
        """(elements + 1,): which element from each on is the first of which something holds; as many as there are elements: none."""
        found = np.full(self._n + 1, self._n, dtype=np.intp)
        at = np.flatnonzero(holds)
        found[at] = at
        np.minimum.accumulate(found[::-1], out=found[::-1])
        return found

    def place(self, holds: Bools) -> Floats:
        """(cycles,): where in its window something holds first. holds: (elements,), in gaps False."""
        first = self._after(holds)[self._begin]
        return np.where(first < self._end, self._places[first], np.inf)

    def none(self, holds: Bools) -> Bools:
        """(cycles,): in no element of its window."""
        return self._after(holds)[self._begin] >= self._end

    def until(self, held: tuple[Bools, Bools], goal: tuple[Bools, Bools]) -> tuple[Floats, Floats]:
        """(cycles,) twice: where `held until goal` is surely true, and where surely false, or STAYS. Of both formulas: where they surely hold, where
        they may."""
        reached = self._after(goal[0])[self._begin]
        true = (reached < self._end) & (self._after(~held[0])[self._own] >= reached)
        broken = self._after(~held[1])[self._own]
        # A goal still counts in the cycle in which what has to hold until then fails.
        open_ = self._after(goal[1])[self._begin] < np.minimum(self._end, broken + 1)
        false = np.where(broken < self._end, self._places[broken], STAYS)
        return np.where(true, self._places[reached], np.inf), np.where(open_, np.inf, false)
