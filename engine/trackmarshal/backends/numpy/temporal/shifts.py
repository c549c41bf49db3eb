"""next and previous: operators that look at the neighbouring sample."""

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
