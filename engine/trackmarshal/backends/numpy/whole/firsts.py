"""The first element of each window of which something holds: since nothing but places is compared, one look along the piece finds them all."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.windows import Windows
from trackmarshal.backends.numpy.whole.elements import Elements, Indices
from trackmarshal.backends.numpy.whole.values import Bools

#: The place of what never comes.
NEVER = np.iinfo(np.intp).max
#: What holds in fewer than three of so many elements, or does not in fewer than two, or changes in less than a quarter of one, is looked up, and
#: not sought element by element.
FEW = 16
#: Of a formula that nothing in its window decides before the window is closed.
STAYS = -1


class Firsts:
    """Of windows that look ahead, those of cycles. Places are those of cycles in the piece."""

    def __init__(self, windows: Windows, elements: Elements) -> None:
        self._n, self._elements = windows.n, elements
        self._begin = (
            None if isinstance(windows.begin, int) and windows.begin == 0 else self._edge(windows.begin)
        )
        self._end = self._edge(windows.end)

    def _edge(self, edge: int | Indices) -> Indices:
        if not isinstance(edge, int):
            return self._elements.of_cycles(edge)
        own = self._elements.cycles
        moved = np.arange(edge, self._n + edge) if own is None else own + edge
        return np.minimum(moved, self._n, out=moved)

    def _after(self, holds: Bools) -> Indices:
        """(elements,): which element from each on is the first of which something holds; NEVER: none."""
        n, count = self._n, np.count_nonzero(holds)
        if count * FEW < 3 * n:
            return _until(holds.nonzero()[0] + 1, n, 1)
        changed = holds[1:] != holds[:-1]
        if (n - count) * FEW >= 2 * n and np.count_nonzero(changed) * 4 * FEW >= n:
            return _sought(holds)
        # Where it does not hold: until it holds again, the place where it does.
        changes = changed.nonzero()[0] + 1
        edges, first = np.concatenate(([0], changes, [n])), int(holds[0])
        begins, ends = edges[first:-1:2], edges[first + 1 :: 2]
        lengths = ends - begins
        if not holds[-1]:
            ends[-1] = NEVER
        found = np.arange(n)
        found[(~holds).nonzero()[0]] = ends.repeat(lengths)
        return found

    def _inside(self, after: Indices) -> Indices:
        """(cycles,): the first one from the begin of its window on."""
        if self._begin is None:
            return self._elements.of_cycles(after)
        found = after.take(self._begin, mode="clip")
        found[np.searchsorted(self._begin, self._n) :] = NEVER  # they never decrease
        return found

    def _places(self, found: Indices) -> Indices:
        """The places of cycles among the elements; of what is behind the last one any."""
        cycles = self._elements.cycles
        return found if cycles is None else np.searchsorted(cycles, found)

    def decided(self, holds: Bools, may: Bools) -> tuple[Indices, Bools]:
        """(cycles,): where in its window something holds first, or NEVER; and whether it surely does in no element of it. (elements,): where it surely
        holds, in gaps False; where it may."""
        first = self._inside(self._after(holds))
        inside = first < self._end
        place = np.where(inside, self._places(first), NEVER)
        if may is holds:
            return place, ~inside
        return place, self._inside(self._after(may)) >= self._end

    def found(self, holds: Bools) -> tuple[Indices, Bools]:
        """(cycles,): where something holds first from the begin of its window on, or NEVER; and whether that is in it. (elements,): where it holds; there
        are no gaps."""
        first = self._inside(self._after(holds))
        return first, first < self._end

    def settles(self, held: Bools, goal: Bools) -> tuple[Indices, Bools]:
        """(cycles,): where `held until goal` is decided of which nothing is undefined, without gaps, before its window is closed, or NEVER or behind that
        window; and whether it holds. (elements,): whether both formulas hold."""
        reached, fails = self._inside(self._after(goal)), self._after(~held)
        holds = (reached < self._end) & (reached <= fails)
        return np.minimum(reached, fails), holds

    def until(self, held: tuple[Bools, Bools], goal: tuple[Bools, Bools]) -> tuple[Indices, Indices]:
        """(cycles,) twice: where `held until goal` is surely true, or NEVER, and where surely false, or STAYS, or NEVER. Of both formulas: where they
        surely hold, where they may."""
        end, (sure, may), cycles = self._end, goal, self._elements.of_cycles
        reached = self._inside(self._after(sure))
        fails = cycles(self._after(~held[0]))
        # A goal still counts in the cycle in which what has to hold until then fails.
        open_ = surely = (reached < end) & (reached <= fails)
        true = np.where(surely, self._places(reached), NEVER)
        broken = fails if held[1] is held[0] else cycles(self._after(~held[1]))
        if may is not sure or broken is not fails:
            possible = reached if may is sure else self._inside(self._after(may))
            open_ = (possible < end) & (possible <= broken)
        false = np.where(broken < end, self._places(broken), STAYS)
        return true, np.where(open_, NEVER, false)


def _sought(holds: Bools) -> Indices:
    """(n,): the first place from each on where something holds; NEVER: none. A sum, since to choose by what changes often takes longer; of short
    integers where they hold it, since the least of all from the end on waits for each."""
    n = len(holds)
    kind = np.int32 if 2 * n <= np.iinfo(np.int32).max else np.intp
    short = np.multiply(~holds, n, dtype=kind)
    short += np.arange(n, dtype=kind)
    np.minimum.accumulate(short[::-1], out=short[::-1])
    found = short.astype(np.intp)
    found[np.searchsorted(found, n) :] = NEVER  # they never decrease
    return found


def _until(ends: Indices, n: int, less: int = 0) -> Indices:
    """(n,): for all places before each end, and after the one before it, that end less so much; after the last one NEVER."""
    counts = np.append(ends, n)
    counts[1:] -= ends
    return np.append(ends - less if less else ends, NEVER).repeat(counts)
