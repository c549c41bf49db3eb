"""always, eventually and their past mirrors: the extremum of a bound over every window.

Over windows to the trace's end it is accumulated, linear in n. Over any others it is doubled: from the
extrema over all spans of L samples those over 2 L, up to the longest power of two in a window, of which two
cover it; n log(window) operations on neighbouring numbers, which is faster than a deque.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trackmarshal.backends.numpy.temporal.blocks import Block, batches, blocks, choose
from trackmarshal.backends.numpy.temporal.carrier import MARGIN, VERDICT, Bound, Carrier, Rows
from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray, Windows


def always(sat: BoolArray, margin: FloatArray, w: Windows) -> Bound:
    """The minimum over every window (historically, when w is past); True and +inf over an empty one.

    sat, margin: (..., n) of bool and float64; a NaN in margin, which the caller rules out, would spread to
    all windows that hold it.
    Returns (sat, margin), (..., asked), in the order of the timeline.
    """
    found = extrema([(sat, VERDICT), (margin, MARGIN)], w, least=True)
    return found[0], found[1]


def eventually(sat: BoolArray, margin: FloatArray, w: Windows) -> Bound:
    """The maximum over every window (once, when w is past); False and -inf over an empty one.

    Otherwise as `always`.
    """
    found = extrema([(sat, VERDICT), (margin, MARGIN)], w, least=False)
    return found[0], found[1]


def extrema(given: Sequence[tuple[Rows, Carrier]], w: Windows, *, least: bool) -> list[Rows]:
    """The meet or the join over every window of values (..., n) of some carriers; neutral over an empty one. Windows are cut into blocks once for all."""
    found: list[Rows] = []
    sides: list[Side] = []
    for values, carrier in given:
        better, neutral = (carrier.meet, carrier.top) if least else (carrier.join, carrier.bottom)
        result, out = carrier.results(values.shape, w, neutral)
        found.append(result)
        sides.append(Side(carrier.rows(values, w), out, carrier, better, neutral))
    if w.unbounded:
        for side in sides:
            _to_the_end(side.rows, side.out, w, side.carrier, side.better)
        return found
    for block in blocks(w):
        for side in sides:
            of_block(block, side)
    return found


class Side(NamedTuple):
    """Values in the windows' direction, where what comes of them goes, and how."""

    rows: Rows
    out: Rows
    carrier: Carrier
    better: np.ufunc
    neutral: float | bool


def of_block(block: Block, side: Side) -> None:
    """Write the extrema over the windows of a block."""
    rows, out, carrier, better, neutral = side
    for batch in batches(len(rows), block.high - block.low):
        spans = carrier.fetch(rows[batch], block.low, block.high, neutral)
        level = 0
        for pick in block.picks:
            while level < pick.level:
                step = 1 << level
                # Into an array of their own: of what overlaps numpy makes a copy first.
                spans = better(spans[:, :-step], spans[:, step:])
                level += 1
            found = better(choose(spans, pick.left), choose(spans, pick.right))
            out[batch, block.first : block.last][:, pick.into] = found


def _to_the_end(rows: Rows, out: Rows, w: Windows, carrier: Carrier, better: np.ufunc) -> None:
    """Write the extrema over all samples from each window's begin to the trace's end."""
    rest = carrier.fetch(rows, 0, w.n, 0)
    better.accumulate(rest[:, ::-1], axis=1, out=rest[:, ::-1])
    from_begin(rest, out, w)


def from_begin(rest: Rows, out: Rows, w: Windows) -> None:
    """Write to every sample with a window what `rest` holds at its begin; leave those without alone."""
    if isinstance(w.begin, int):
        count = max(min(w.asked, w.n - w.begin), 0)
        out[:, :count] = rest[:, w.begin : w.begin + count]
    else:
        begin = w.begin[: w.asked]
        inside = int(np.searchsorted(begin, w.n))
        out[:, :inside] = rest.take(begin[:inside], axis=1)
