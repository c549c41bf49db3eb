"""next, previous, rising and falling: operators that look at the neighbouring sample."""

from __future__ import annotations

import numpy as np

from trackmarshal.backends.numpy.temporal.carrier import Bound
from trackmarshal.backends.numpy.temporal.windows import BoolArray, FloatArray


def shift(sat: BoolArray, margin: FloatArray, step: int, weak: bool) -> Bound:
    """The value one sample later (step +1: next) or earlier (-1: previous).

    sat, margin: (..., n). Outside the trace False and -inf, or True and +inf when weak.
    """
    if step not in (1, -1):
        raise ValueError(f"next is a step of +1, previous one of -1; not {step}")
    moved_sat, moved = np.full_like(sat, weak), np.full_like(margin, np.inf if weak else -np.inf)
    if step == 1:
        moved_sat[..., :-1] = sat[..., 1:]
        np.add(margin[..., 1:], 0.0, out=moved[..., :-1])
    else:
        moved_sat[..., 1:] = sat[..., :-1]
        np.add(margin[..., :-1], 0.0, out=moved[..., 1:])
    return moved_sat, moved


def rising(sat: BoolArray, margin: FloatArray, opposite_sat: BoolArray, opposite_margin: FloatArray) -> Bound:
    """min(-p[k-1], p[k]) with p[-1] = -inf (False), all arrays (..., n).

    p[k-1], which is negated, comes from the opposite bound: the optimistic one when the pessimistic is asked
    for. Where p is defined everywhere, both bounds are p itself.
    """
    before_sat, before = shift(opposite_sat, opposite_margin, -1, weak=False)
    return sat & ~before_sat, np.minimum(-before, margin) + 0.0


def falling(
    sat: BoolArray, margin: FloatArray, opposite_sat: BoolArray, opposite_margin: FloatArray
) -> Bound:
    """min(p[k-1], -p[k]) with p[-1] = +inf (True); here p[k] is negated and from the opposite bound."""
    before_sat, before = shift(sat, margin, -1, weak=True)
    return before_sat & ~opposite_sat, np.minimum(before, -opposite_margin) + 0.0
