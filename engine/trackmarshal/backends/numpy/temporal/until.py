"""until and since over every window, by doubling pairs of spans.

For the span of L samples from i let U be `p until q` inside the span and P the minimum of p over it. Then for
2 L samples from i they are max(U(i), min(P(i), U(i + L))) and min(P(i), P(i + L)). Two spans cover a window,
and they may overlap: what the later one says of a q in both is no more than what the earlier one says.
"""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.blocks import batches, blocks, choose, cuts
from trackmarshal.backends.numpy.temporal.carrier import MARGIN, VERDICT, Bound, Carrier, Rows
from trackmarshal.backends.numpy.temporal.extrema import extremum, from_begin
from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray, Windows


def until(
    p_sat: BoolArray, p_margin: FloatArray, q_sat: BoolArray, q_margin: FloatArray, w: Windows
) -> Bound:
    """max over the samples j of k's window of min(q[j], min of p over k..j-1).

    False and -inf over an empty window. All arrays (..., n), bool and float64, margins free of NaN. Returns
    (sat, margin) of their common shape. Raises ValueError on past windows.
    """
    if w.past:
        raise ValueError("`until` looks ahead: its windows are not past")
    return _held(p_sat, q_sat, w, VERDICT), _held(p_margin, q_margin, w, MARGIN)


def since(
    p_sat: BoolArray, p_margin: FloatArray, q_sat: BoolArray, q_margin: FloatArray, w: Windows
) -> Bound:
    """max over the samples j of k's window of min(q[j], min of p over j+1..k): `until` back."""
    if not w.past:
        raise ValueError("`since` looks back: its windows are past")
    return _held(p_sat, q_sat, w, VERDICT), _held(p_margin, q_margin, w, MARGIN)


def _held(p: Rows, q: Rows, w: Windows, carrier: Carrier) -> Rows:
    """`p until q` in the windows' direction."""
    p, q = np.broadcast_arrays(p, q)
    result: Rows = np.full(p.shape, carrier.bottom, dtype=carrier.dtype)
    held, goal, out = carrier.rows(p, w), carrier.rows(q, w), carrier.rows(result, w)
    if w.unbounded:
        from_begin(_to_the_end(held, goal, carrier), out, w)
    else:
        _windowed(held, goal, out, w, carrier)
    if not (isinstance(w.begin, int) and w.begin == 0):
        carrier.meet(result, extremum(p, w.lead(), carrier, carrier.meet, carrier.top), out=result)
    return result


def _windowed(p: Rows, q: Rows, out: Rows, w: Windows, carrier: Carrier) -> None:
    """Write `p until q` inside every window, counted from its begin."""
    for block in blocks(w):
        for batch in batches(len(p), block.high - block.low):
            spans = carrier.fetch(q[batch], block.low, block.high, carrier.bottom)
            holds = carrier.fetch(p[batch], block.low, block.high, carrier.top)
            level = 0
            for pick in block.picks:
                while level < pick.level:
                    _double(spans, holds, 1 << level, carrier)
                    level += 1
                later = carrier.meet(choose(holds, pick.left), choose(spans, pick.right))
                out[batch, block.first : block.last][:, pick.into] = carrier.join(
                    choose(spans, pick.left), later
                )


def _to_the_end(p: Rows, q: Rows, carrier: Carrier) -> Rows:
    """`p until q` from every sample to the trace's end, block by block from there; linear in n."""
    n = p.shape[1]
    rest: Rows = np.empty(p.shape, dtype=carrier.dtype)
    for batch in batches(len(p), n):
        carry: Rows = np.asarray(carrier.bottom)
        for first, last in reversed(cuts(n)):
            spans = carrier.fetch(q[batch], first, last, carrier.bottom)
            holds = carrier.fetch(p[batch], first, last, carrier.top)
            step = 1
            while step < last - first:
                _double(spans, holds, step, carrier)
                step *= 2
            carrier.join(spans, carrier.meet(holds, carry), out=rest[batch, first:last])
            carry = rest[batch, first : first + 1]
    return rest


def _double(spans: Rows, holds: Rows, step: int, carrier: Carrier) -> None:
    """From spans of `step` samples to spans of twice as many, in place, cut off by the buffer's end."""
    later = carrier.meet(holds[:, :-step], spans[:, step:])
    carrier.join(spans[:, :-step], later, out=spans[:, :-step])
    carrier.meet(holds[:, :-step], holds[:, step:], out=holds[:, :-step])
