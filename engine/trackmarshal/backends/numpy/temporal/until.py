"""until and since over every window, by doubling pairs of spans.

For the span of L samples from i let U be `p until q` inside the span and P the minimum of p over it. Then for
2 L samples from i they are max(U(i), min(P(i), U(i + L))) and min(P(i), P(i + L)). Two spans cover a window,
and they may overlap: what the later one says of a q in both is no more than what the earlier one says.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from trackmarshal.backends.numpy.temporal.blocks import Block, batches, blocks, choose, cuts
from trackmarshal.backends.numpy.temporal.carrier import MARGIN, VERDICT, Bound, Carrier, Rows
from trackmarshal.backends.numpy.temporal.extrema import Side, extrema, from_begin, of_block
from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray, Windows


def until(
    p_sat: BoolArray, p_margin: FloatArray, q_sat: BoolArray, q_margin: FloatArray, w: Windows
) -> Bound:
    """max over the samples j of k's window of min(q[j], min of p over k..j-1).

    False and -inf over an empty window. All arrays (..., n), bool and float64, margins free of NaN. Returns
    (sat, margin), (..., asked), in the order of the timeline. Raises ValueError on past windows.
    """
    if w.past:
        raise ValueError("`until` looks ahead: its windows are not past")
    found = held([(p_sat, q_sat, VERDICT), (p_margin, q_margin, MARGIN)], w)
    return found[0], found[1]


def since(
    p_sat: BoolArray, p_margin: FloatArray, q_sat: BoolArray, q_margin: FloatArray, w: Windows
) -> Bound:
    """max over the samples j of k's window of min(q[j], min of p over j+1..k): `until` back."""
    if not w.past:
        raise ValueError("`since` looks back: its windows are past")
    found = held([(p_sat, q_sat, VERDICT), (p_margin, q_margin, MARGIN)], w)
    return found[0], found[1]


def held(given: Sequence[tuple[Rows, Rows, Carrier]], w: Windows) -> list[Rows]:
    """`p until q` in the windows' direction, of some carriers' p and q. Windows are cut into blocks once for all."""
    found: list[Rows] = []
    sides: list[_Side] = []
    for one, other, carrier in given:
        p, q = np.broadcast_arrays(one, other)
        result, out = carrier.results(p.shape, w, carrier.bottom)
        found.append(result)
        sides.append(_Side(carrier.rows(p, w), carrier.rows(q, w), out, carrier))
    if w.unbounded:
        for p, q, out, carrier in sides:
            from_begin(_to_the_end(p, q, carrier), out, w)
    else:
        for block in blocks(w):
            for side in sides:
                _of_block(block, side)
    leading = not (isinstance(w.begin, int) and w.begin == 0)
    # Where p holds everywhere by no less than what is found, it does on the way to the windows, too.
    if leading and any(_below(p, out, carrier) for p, _, out, carrier in sides):
        leads = extrema(
            [(np.broadcast_arrays(p, q)[0], carrier) for p, q, carrier in given], w.lead(), least=True
        )
        for result, lead, (_, _, carrier) in zip(found, leads, given):
            carrier.meet(result, lead, out=result)
    return found


#: After every so many doublings it is asked whether longer spans say more, first of one of so many samples; of few samples that takes longer
#: than to go on.
LOOK, FEW = 3, 64


class _Side(NamedTuple):
    """p and q in the windows' direction, and where what comes of them goes."""

    p: Rows
    q: Rows
    out: Rows
    carrier: Carrier


def _of_block(block: Block, side: _Side) -> None:
    """Write `p until q` inside the windows of a block, counted from their begins."""
    p, q, out, carrier = side
    for batch in batches(len(p), block.high - block.low):
        spans = carrier.fetch(q[batch], block.low, block.high, carrier.bottom)
        holds = carrier.fetch(p[batch], block.low, block.high, carrier.top)
        level, settled, looks = 0, False, spans.size > FEW * FEW
        if looks and not _below(holds, spans, carrier):
            # Where p holds everywhere by no less than any q, that is the greatest q.
            of_block(block, Side(q[batch], out[batch], carrier, carrier.join, carrier.bottom))
            continue
        for pick in block.picks:
            while level < pick.level and not settled:
                settled = (
                    looks
                    and level % LOOK == 0
                    and _settled(spans[:, : block.begins], holds[:, : block.begins])
                )
                if not settled:
                    spans, holds = _doubled(spans, holds, 1 << level, carrier)
                    level += 1
            found = choose(spans, pick.left)
            if not settled:
                later = carrier.meet(choose(holds, pick.left), choose(spans, pick.right))
                found = carrier.join(found, later)
            out[batch, block.first : block.last][:, pick.into] = found


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
                spans[:, :-step], holds[:, :-step] = _doubled(spans, holds, step, carrier)
                step *= 2
            carrier.join(spans, carrier.meet(holds, carry), out=rest[batch, first:last])
            carry = rest[batch, first : first + 1]
    return rest


def _below(p: Rows, q: Rows, carrier: Carrier) -> bool:
    """Whether anywhere p holds by less than q may somewhere."""
    return not p.min(initial=carrier.top) >= q.max(initial=carrier.bottom)


def _settled(spans: Rows, holds: Rows) -> bool:
    """Whether no longer spans from the same samples say more: nowhere does p hold throughout by more than what is reached. Mostly a few tell that not."""
    few = slice(None, None, FEW)
    return bool((holds[:, few] <= spans[:, few]).all() and (holds <= spans).all())


def _doubled(spans: Rows, holds: Rows, step: int, carrier: Carrier) -> tuple[Rows, Rows]:
    """From spans of `step` samples to spans of twice as many, of those that do not reach beyond the buffer's end.

    In arrays of their own: of what overlaps numpy makes a copy first.
    """
    later = carrier.meet(holds[:, :-step], spans[:, step:])
    return carrier.join(spans[:, :-step], later, out=later), carrier.meet(holds[:, :-step], holds[:, step:])
