"""What windows over the run hold: cycles, and the gaps between them, in order. Stamps are whole nanoseconds."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.logic import Value
from trackmarshal.backends.numpy.temporal.windows import Edge, Windows
from trackmarshal.backends.numpy.whole.values import constant, put
from trackmarshal.runtime.kleene import UNDEFINED

Stamps = NDArray[np.int64]
Indices = NDArray[np.intp]
#: Before all that there is, and far enough from the end of what 64 bits hold.
LONG_AGO = np.iinfo(np.int64).min // 4


@dataclass(eq=False)
class Elements:
    """first, last: (elements,) the first and the last nanosecond of each, never decreasing; missed: (elements,) of a gap how many cycles
    are missing, of a cycle 0. Between two cycles there is at most one gap."""

    first: Stamps
    last: Stamps
    missed: Indices

    def __len__(self) -> int:
        return len(self.first)

    @cached_property
    def cycles(self) -> Indices | None:
        """Where the cycles are; None: there are no gaps."""
        return np.flatnonzero(self.missed == 0) if self.missed.max(initial=0) else None

    @cached_property
    def _ends(self) -> dict[tuple[int, int, bool], Edge]:
        return {}

    @cached_property
    def _windows(self) -> dict[tuple[int, int | None, int, bool], Windows]:
        return {}

    def spread(self, value: Value) -> Value:
        """(elements,): the value of a formula in each, undefined in gaps."""
        if self.cycles is None:
            return value
        return put(constant(UNDEFINED, len(self)), self.cycles, value)

    def of_cycles(self, array: NDArray[Any]) -> NDArray[Any]:
        """(cycles,) of an array (elements,)."""
        return array if self.cycles is None else array[self.cycles]

    def since(self, stamp: int) -> int:
        """How many elements end before a stamp."""
        return int(np.searchsorted(self.last, stamp, "left"))

    def after(self, begin: int) -> Elements:
        """A copy of all but the first so many."""
        first = self.first[begin:].copy()
        last = first if self.last is self.first else self.last[begin:].copy()
        return Elements(first, last, self.missed[begin:].copy())

    def back(self, lower: int, upper: int | None, asked: int) -> Windows:
        """The windows that hold what lies between so long and so long before each of the last so many elements; upper: None where they reach back
        to the first."""
        return self._of(lower, upper, asked, True)

    def ahead(self, lower: int, upper: int) -> Windows:
        """The windows of what lies between so long and so long after each element."""
        return self._of(lower, upper, len(self), False)

    def reached(self, upper: int) -> Edge:
        """The end of the windows of what lies up to so long after each element, wherever they begin."""
        return self._end(upper, len(self), False)

    def _end(self, upper: int, asked: int, past: bool) -> Edge:
        known = self._ends.get((upper, asked, past))
        if known is None:
            first, last = self._mirrored if past else (self.first, self.last)
            known = self._ends[upper, asked, past] = edge_of(first, last[:asked] + upper, "right")
        return known

    @cached_property
    def _mirrored(self) -> tuple[Stamps, Stamps]:
        """A window into the past is one into the future of what is mirrored in time: see `temporal.windows`."""
        first = -self.last[::-1]
        return first, first if self.last is self.first else -self.first[::-1]

    def _of(self, lower: int, upper: int | None, asked: int, past: bool) -> Windows:
        known = self._windows.get((lower, upper, asked, past))
        if known is None:
            known = self._windows[lower, upper, asked, past] = self._made(lower, upper, asked, past)
        return known

    def _made(self, lower: int, upper: int | None, asked: int, past: bool) -> Windows:
        n = len(self)
        end: Edge = n if upper is None else self._end(upper, asked, past)
        begin: Edge = 0
        if lower:
            last = self._mirrored[1] if past else self.last
            begin = edge_of(last, last[:asked] + lower, "left")
        return Windows(n, past, begin, end, asked)


def edge_of(keys: Stamps, reach: Stamps, side: Literal["left", "right"]) -> Edge:
    """For every element, or the first ones alone, how many keys lie before what it reaches, or up to and with it (right).

    Where cycles come evenly it is the same distance for all; that is guessed from the first one, and looked at. As in `temporal.windows`.
    """
    n, asked = len(keys), len(reach)
    guess = int(np.searchsorted(keys, reach[0], side)) if asked else 0
    if guess == n:
        return n
    count = min(n - guess + 1, asked)
    before = np.less_equal if side == "right" else np.less

    def passed(shift: int) -> NDArray[np.bool_]:
        """Whether the key `shift` from the guessed edge lies before the edge: before the first key all do, after the last one none."""
        begin = guess + shift
        low = max(-begin, 0)
        high = max(min(n - begin, count), low)
        found = np.zeros(count, dtype=bool)
        found[:low] = True
        before(keys[begin + low : begin + high], reach[low:high], out=found[low:high])
        return found

    near, far = passed(-1), passed(0)
    if near.all() and not far.any():
        return guess
    at_the_end = count == asked or bool(before(keys[-1], reach[count]))
    if at_the_end and passed(-2).all() and not passed(1).any():
        edge = np.arange(guess - 1, guess - 1 + asked)
        edge[:count] += np.add(near, far, dtype=np.int8)
        edge[count:] = n
        return edge
    return np.searchsorted(keys, reach, side)


def elements(stamps: Stamps, missed: Indices, before: int | None) -> Elements:
    """Cycles, and a gap before each before which cycles are missing. before: the stamp of the cycle before the first; None: there is none."""
    if not missed.max(initial=0):
        return Elements(stamps, stamps, missed)
    missed = missed.copy()
    if before is None and len(missed):
        missed[0] = 0  # what comes before the first cycle is no gap
    at = np.flatnonzero(missed)
    if not len(at):
        return Elements(stamps, stamps, missed)
    earlier = np.concatenate(([0 if before is None else before], stamps[:-1]))
    return Elements(
        np.insert(stamps, at, earlier[at] + 1),
        np.insert(stamps, at, stamps[at] - 1),
        np.insert(np.zeros(len(stamps), np.intp), at, missed[at]),
    )


def joined(parts: Sequence[Elements]) -> Elements:
    """Elements that follow one another."""
    first = np.concatenate([one.first for one in parts])
    moments = all(one.last is one.first for one in parts)
    last = first if moments else np.concatenate([one.last for one in parts])
    return Elements(first, last, np.concatenate([one.missed for one in parts]))


def one(stamp: int) -> Elements:
    """A single cycle."""
    stamps = np.array([stamp], np.int64)
    return Elements(stamps, stamps, np.zeros(1, np.intp))
