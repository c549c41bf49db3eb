"""always, eventually and their past mirrors: the extremum of a bound over every window.

Over windows to the trace's end it is accumulated, linear in n. Over any others it is doubled: from the
extrema over all spans of L samples those over 2 L, up to the longest power of two in a window, of which two
cover it; n log(window) operations on neighbouring numbers, which is faster than a deque.
"""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.blocks import batches, blocks, choose
from trackmarshal.backends.numpy.temporal.carrier import MARGIN, VERDICT, Bound, Carrier, Rows
from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray, Windows


def always(sat: BoolArray, margin: FloatArray, w: Windows) -> Bound:
    """The minimum over every window (historically, when w is past); True and +inf over an empty one.

    sat, margin: (..., n) of bool and float64; a NaN in margin, which the caller rules out, would spread to
    all windows that hold it.
    Returns (sat, margin) of the same shape.
    """
    return (
        extremum(sat, w, VERDICT, VERDICT.meet, VERDICT.top),
        extremum(margin, w, MARGIN, MARGIN.meet, MARGIN.top),
    )


def eventually(sat: BoolArray, margin: FloatArray, w: Windows) -> Bound:
    """The maximum over every window (once, when w is past); False and -inf over an empty one.

    Otherwise as `always`.
    """
    return (
        extremum(sat, w, VERDICT, VERDICT.join, VERDICT.bottom),
        extremum(margin, w, MARGIN, MARGIN.join, MARGIN.bottom),
    )


def extremum(values: Rows, w: Windows, carrier: Carrier, better: np.ufunc, neutral: float | bool) -> Rows:
    """`better` (minimum, or, ...) over every window of values (..., n); `neutral` over an empty one."""
    rows = carrier.rows(values, w)
    result: Rows = np.full(values.shape, neutral, dtype=carrier.dtype)
    out = carrier.rows(result, w)
    if w.unbounded:
        _to_the_end(rows, out, w, carrier, better)
        return result
    for block in blocks(w):
        for batch in batches(len(rows), block.high - block.low):
            spans = carrier.fetch(rows[batch], block.low, block.high, neutral)
            level = 0
            for pick in block.picks:
                while level < pick.level:
                    step = 1 << level
                    better(spans[:, :-step], spans[:, step:], out=spans[:, :-step])
                    level += 1
                found = better(choose(spans, pick.left), choose(spans, pick.right))
                out[batch, block.first : block.last][:, pick.into] = found
    return result


def _to_the_end(rows: Rows, out: Rows, w: Windows, carrier: Carrier, better: np.ufunc) -> None:
    """Write the extrema over all samples from each window's begin to the trace's end."""
    rest = carrier.fetch(rows, 0, w.n, 0)
    better.accumulate(rest[:, ::-1], axis=1, out=rest[:, ::-1])
    from_begin(rest, out, w)


def from_begin(rest: Rows, out: Rows, w: Windows) -> None:
    """Write to every sample with a window what `rest` holds at its begin; leave those without alone."""
    if isinstance(w.begin, int):
        out[:, : max(w.n - w.begin, 0)] = rest[:, w.begin :]
    else:
        inside = int(np.searchsorted(w.begin, w.n))
        out[:, :inside] = rest.take(w.begin[:inside], axis=1)
