"""Which samples a temporal operator looks at: one window for every sample of a timeline.

Everything here counts samples in the operator's own *direction*: along the timeline for future operators,
against it for past ones. A past window on times t is a future window on the times -t, reversed (negation is
exact, so t[k] - b <= t[j] and -t[j] <= -t[k] + b are one comparison to the last bit), and kernels know one
direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from trackmarshal.errors import TrackmarshalError

FloatArray: TypeAlias = NDArray[np.float64]
BoolArray: TypeAlias = NDArray[np.bool_]
IndexArray: TypeAlias = NDArray[np.intp]
#: One end of every window: min(k + edge, n) for a constant edge, else edge[k].
Edge: TypeAlias = int | IndexArray


@dataclass(frozen=True, eq=False)
class Windows:
    """The windows of one operator on one timeline, half open, in the operator's direction; made by `windows`.

    n: samples of the timeline; past: the direction; begin, end: both edges of every window, never decreasing
    from sample to sample, with k <= begin <= end <= n; asked: only the first so many samples have a
    window, all others are only looked at.
    """

    n: int
    past: bool
    begin: Edge
    end: Edge
    asked: int

    @cached_property
    def longest(self) -> int:
        """Samples of the longest window; of equal ones, before they are cut off by the trace's end."""
        if isinstance(self.begin, int) and isinstance(self.end, int):
            return max(min(self.end - self.begin, self.n), 0)
        begin, end = (edge_at(edge, 0, self.asked, self.n) for edge in (self.begin, self.end))
        return int((end - begin).max(initial=0))

    @property
    def uniform(self) -> bool:
        """Whether all windows are one window shifted, but for the truncation at the trace's end."""
        return isinstance(self.begin, int) and isinstance(self.end, int)

    @property
    def unbounded(self) -> bool:
        """Whether every window reaches to the trace's end (in its direction)."""
        return isinstance(self.end, int) and self.end >= self.n

    @property
    def start(self) -> IndexArray:
        """First sample of each window, in the timeline's order; equal to `stop` where the window is empty."""
        return self._ordered(self.end if self.past else self.begin)

    @property
    def stop(self) -> IndexArray:
        """One past the last sample of each window, in the timeline's order."""
        return self._ordered(self.begin if self.past else self.end)

    def _ordered(self, edge: Edge) -> IndexArray:
        """An edge of all windows, counted in the timeline's order."""
        index = edge_at(edge, 0, self.asked, self.n)
        return self.n - index[::-1] if self.past else index

    def lead(self) -> Windows:
        """The samples from each sample up to its window, without the window: where `until` demands p only."""
        return Windows(self.n, self.past, 0, self.begin, self.asked)


def windows(
    t: FloatArray, lower: float | None, upper: float | None, past: bool, ends: FloatArray | None = None
) -> Windows:
    """The windows of an operator with closed bounds [lower, upper] on the sample times t.

    t: (n,) never decreasing; lower, upper: in the same unit, 0 <= lower <= upper; None: from the sample itself, to the
    end of the trace (its start, when past). The window of sample k holds the samples j with
    t[k] + lower <= t[j] <= t[k] + upper (past: t[k] - upper <= t[j] <= t[k] - lower), computed as written.
    ends: (n,) when samples end that are no moments but gaps, of which a part in the window is enough.
    Linear in n where the samples are equidistant up to rounding, n log n otherwise.
    Raises D181 on times and D182 on bounds that mean nothing.
    Source: the language's temporal operators (section 5 of its definition).
    """
    n = t.size
    if t.shape != (n,) or t.dtype != np.float64:
        raise TypeError(f"times are a float64 array of shape (n,), not {t.dtype} of shape {t.shape}")
    if not (t[1:] >= t[:-1]).all() or not np.isfinite(t[:1]).all() or not np.isfinite(t[-1:]).all():
        raise TrackmarshalError("D181", "the times of a timeline are not finite, or step back")
    first, last = 0.0 if lower is None else lower, math.inf if upper is None else upper
    if not 0.0 <= first <= last:
        raise TrackmarshalError(
            "D182", f"[{first:g}, {last:g}] is no window: 0 <= lower <= upper does not hold"
        )
    if ends is not None:
        return _of_spans(t, ends, first, last, past)
    if past:
        t = -t[::-1]
    begin: Edge = 0 if first == 0.0 else _edge(t, first, closed=False)
    if not isinstance(begin, int):
        begin = np.maximum(
            begin, np.arange(n)
        )  # where a bound is lost beside t, earlier samples lie at the time that it leads to
    end: Edge = n if last == math.inf else _edge(t, last, closed=True)
    return Windows(n, past, begin, end, n)


def _edge(t: FloatArray, bound: float, *, closed: bool) -> Edge:
    """For every sample k the number of samples before t[k] + bound, or up to and with it when `closed`."""
    n = t.size
    side: Literal["left", "right"] = "right" if closed else "left"
    with np.errstate(over="ignore"):
        reach = t + bound
    guess = int(np.searchsorted(t, reach[0], side)) if n else 0
    if guess == n:
        return n  # the first window's edge is the trace's end, so all are
    # Equidistant samples have one offset for all k, up to one sample where t[k] + bound is rounded. Compare
    # with the samples around the guess, as far as edges lie inside the trace; search only if that fails.
    count = min(n - guess + 1, n)
    padded = np.concatenate(([-math.inf, -math.inf], t, [math.inf, math.inf]))
    before = np.less_equal if closed else np.less

    def passed(shift: int) -> BoolArray:
        """Whether the sample `shift` from the guessed edge still lies before the edge."""
        at = 2 + guess + shift
        return before(padded[at : at + count], reach[:count])

    near, far = passed(-1), passed(0)
    if near.all() and not far.any():
        return guess
    all_passed_later = count == n or bool(before(t[-1], reach[count]))
    if all_passed_later and passed(-2).all() and not passed(1).any():
        edge = np.full(n, n, dtype=np.intp)
        np.add(np.arange(guess - 1, guess - 1 + count), near, out=edge[:count])
        edge[:count] += far
        return edge
    return np.searchsorted(t, reach, side)


def _of_spans(begins: FloatArray, ends: FloatArray, first: float, last: float, past: bool) -> Windows:
    """The windows where some samples last: those that do not end before a window begins, and begin before it ends."""
    n = begins.size
    if past:
        begins, ends = -ends[::-1], -begins[::-1]
    begin: Edge = 0 if first == 0.0 else np.searchsorted(ends, begins + first, "left")
    end: Edge = n if last == math.inf else np.searchsorted(begins, begins + last, "right")
    return Windows(n, past, begin, end, n)


def edge_at(edge: Edge, first: int, last: int, n: int) -> IndexArray:
    """The edge of the windows of the samples [first, last)."""
    if isinstance(edge, int):
        moved = np.arange(first + edge, last + edge)
        return moved if last + edge <= n else np.minimum(moved, n, out=moved)
    return edge[first:last]
