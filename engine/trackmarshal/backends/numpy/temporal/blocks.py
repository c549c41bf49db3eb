"""Windows cut into cache-sized blocks, each window as two overlapping spans of a power of two samples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from trackmarshal.backends.numpy.temporal.carrier import Rows
from trackmarshal.backends.numpy.temporal.windows import IndexArray, Windows, edge_at

#: Samples worked on at once, so that a block's buffers stay in the cache next to the core.
BLOCK = 16384

#: Which samples of a buffer, a slice where they are neighbours.
Choice: TypeAlias = slice | IndexArray


@dataclass(frozen=True, slots=True)
class Pick:
    """Windows of a block of [2**level, 2**(level + 1)) samples: two spans of 2**level cover each.

    into: which of the block's samples; left, right: where their spans begin, counted from the block's `low`.
    """

    level: int
    into: Choice
    left: Choice
    right: Choice


@dataclass(frozen=True, slots=True)
class Block:
    """The windows of the samples [first, last), which together look at the samples [low, high).

    `high` may lie beyond the trace's end. begins: all windows begin in so many samples from `low` on; picks: by ascending level; empty windows are
    in none.
    """

    first: int
    last: int
    low: int
    high: int
    begins: int
    picks: tuple[Pick, ...]


def blocks(w: Windows) -> Iterator[Block]:
    """All windows in blocks; together the blocks look at no more than a small multiple of n samples."""
    if w.longest == 0:
        return
    for first, last in cuts(w.asked, 2 * w.longest):
        yield _uniform(w, first, last) if w.uniform else _general(w, first, last)


def cuts(n: int, least: int = 1) -> list[tuple[int, int]]:
    """The samples [0, n) in consecutive stretches [first, last) of about a block, or of `least` if that is more, all of one length: a short
    last one would look at as many samples beyond as the others."""
    size = -(-n // max(1, round(n / max(BLOCK, least)))) or 1
    return [(first, min(first + size, n)) for first in range(0, n, size)]


def batches(rows: int, samples: int) -> Iterator[slice]:
    """Rows worked on at once, so that their buffers of so many samples stay in the cache, too."""
    size = max(1, BLOCK // max(samples, 1))
    for first in range(0, rows, size):
        yield slice(first, first + size)


def choose(buffer: Rows, choice: Choice) -> Rows:
    """The chosen samples of every row."""
    return buffer[:, choice] if isinstance(choice, slice) else buffer.take(choice, axis=1)


def _uniform(w: Windows, first: int, last: int) -> Block:
    """A block of equal windows: those cut off by the trace's end look beyond it instead."""
    assert isinstance(w.begin, int)
    assert isinstance(w.end, int)
    count, length = last - first, w.end - w.begin
    level = length.bit_length() - 1
    right = length - (1 << level)
    pick = Pick(level, slice(None), slice(0, count), slice(right, right + count))
    return Block(first, last, first + w.begin, last - 1 + w.end, count, (pick,))


def _general(w: Windows, first: int, last: int) -> Block:
    """A block of any windows, grouped by level."""
    begin, end = edge_at(w.begin, first, last, w.n), edge_at(w.end, first, last, w.n)
    if end[-1] == w.n:  # those cut off by the trace's end look beyond it: otherwise they come in all levels
        inside = int(end.searchsorted(w.n))
        end = np.concatenate((end[:inside], begin[inside:] + w.longest))
    low, high = int(begin[0]), int(end[-1])
    length = end - begin
    left: Choice = begin - low
    if isinstance(w.begin, int) and last - 1 + w.begin <= w.n:
        left = slice(0, last - first)
    shortest, longest = int(length.min()), int(length.max())
    picks = []
    for level in range(max(shortest.bit_length() - 1, 0), longest.bit_length()):
        right = end - (low + (1 << level))
        if shortest >> level == 1 and longest >> level == 1:
            picks.append(Pick(level, slice(None), left, right))
        else:
            into = np.flatnonzero(length >> level == 1)
            picks.append(Pick(level, into, begin[into] - low, right[into]))
    return Block(first, last, low, high, int(begin[-1]) - low + 1, tuple(picks))
