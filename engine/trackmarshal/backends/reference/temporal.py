"""Temporal operators in plain Python, as the language defines them: a loop over the window of every sample.

A value along a timeline is a pair of lists, (sat, margin), one entry a sample; margins may be infinite, never
NaN, and operators return 0.0 for -0.0. As slow as windows are long: the oracle of the other evaluators.
Source: the language's temporal operators (section 5 of its definition).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import TypeAlias

from trackmarshal.errors import TrackmarshalError

#: Error codes of the temporal operators of all evaluators: code -> (title, explanation).
CODES: dict[str, tuple[str, str]] = {
    "D181": (
        "times of a timeline step back",
        "Temporal operators find the samples of a window by their times, so the timeline of a rule needs a"
        " time for every sample, finite, and not before that of the one before it. A step"
        " back or a missing time leaves open which samples a window holds; nothing is evaluated on such a"
        " timeline.",
    ),
    "D182": (
        "bounds of a temporal operator hold no window",
        "The bounds [a, b] of a temporal operator are durations with 0 <= a <= b: how far from the current"
        " sample the window begins and ends. A negative, missing or reversed bound would make the window"
        " empty and the operator true or false for no reason in the data, so it is refused. Bounds that come"
        " from parameters are checked when the parameters are known.",
    ),
}

#: A formula's value along a timeline: (sat, margin).
Bound: TypeAlias = tuple[list[bool], list[float]]


def windows(
    t: Sequence[float],
    lower: float | None,
    upper: float | None,
    past: bool,
    ends: Sequence[float] | None = None,
) -> list[range]:
    """For every sample the samples its window holds: t[k] + lower <= t[j] <= t[k] + upper.

    Past windows mirrored: t[k] - upper <= t[j] <= t[k] - lower. t: never decreasing; ends: when samples end that are no moments but
    gaps, of which a part in the window is enough; lower, upper: in the same unit, None: from the sample itself, to the end (start) of the trace.
    Raises D181 on times and D182 on bounds that mean nothing.
    """
    if not all(map(math.isfinite, t)) or not all(earlier <= later for earlier, later in pairwise(t)):
        raise TrackmarshalError("D181", "the times of a timeline are not finite, or step back")
    a, b = 0.0 if lower is None else lower, math.inf if upper is None else upper
    if not 0.0 <= a <= b:
        raise TrackmarshalError("D182", f"[{a:g}, {b:g}] is no window: 0 <= lower <= upper does not hold")
    e = t if ends is None else ends
    return [_past_window(t, e, k, a, b) if past else _future_window(t, e, k, a, b) for k in range(len(t))]


def _future_window(t: Sequence[float], e: Sequence[float], k: int, a: float, b: float) -> range:
    """The samples j with t[k] + a <= e[j] and t[j] <= t[k] + b; none lies before k."""
    start = k
    while start < len(t) and not t[k] + a <= e[start]:
        start += 1
    stop = start
    while stop < len(t) and t[stop] <= t[k] + b:
        stop += 1
    return range(start, stop)


def _past_window(t: Sequence[float], e: Sequence[float], k: int, a: float, b: float) -> range:
    """The samples j with t[k] - b <= e[j] and t[j] <= t[k] - a; none lies after k."""
    last = k
    while last >= 0 and not t[last] <= t[k] - a:
        last -= 1
    before = last
    while before >= 0 and t[k] - b <= e[before]:
        before -= 1
    return range(before + 1, last + 1)


def always(sat: Sequence[bool], margin: Sequence[float], w: Sequence[range]) -> Bound:
    """The minimum over every window (historically, when w is past); True and +inf over an empty one."""
    return (
        [all(sat[j] for j in window) for window in w],
        [min((margin[j] for j in window), default=math.inf) + 0.0 for window in w],
    )


def eventually(sat: Sequence[bool], margin: Sequence[float], w: Sequence[range]) -> Bound:
    """The maximum over every window (once, when w is past); False and -inf over an empty one."""
    return (
        [any(sat[j] for j in window) for window in w],
        [max((margin[j] for j in window), default=-math.inf) + 0.0 for window in w],
    )


def until(
    p_sat: Sequence[bool],
    p_margin: Sequence[float],
    q_sat: Sequence[bool],
    q_margin: Sequence[float],
    w: Sequence[range],
) -> Bound:
    """max over the samples j of k's window of min(q[j], min of p over k..j-1); False, -inf over none."""
    return _held(p_sat, p_margin, q_sat, q_margin, w, step=+1)


def since(
    p_sat: Sequence[bool],
    p_margin: Sequence[float],
    q_sat: Sequence[bool],
    q_margin: Sequence[float],
    w: Sequence[range],
) -> Bound:
    """max over the samples j of k's window of min(q[j], min of p over j+1..k); False, -inf over none."""
    return _held(p_sat, p_margin, q_sat, q_margin, w, step=-1)


def _held(
    p_sat: Sequence[bool],
    p_margin: Sequence[float],
    q_sat: Sequence[bool],
    q_margin: Sequence[float],
    w: Sequence[range],
    *,
    step: int,
) -> Bound:
    """Walk from every sample to the far end of its window, with p over the samples already passed."""
    sat, margin = [], []
    for k, window in enumerate(w):
        held_sat, held, best_sat, best = True, math.inf, False, -math.inf
        far = k if not window else window[-1] if step > 0 else window[0]
        for j in range(k, far + step, step):
            if j in window:
                best_sat = best_sat or (held_sat and q_sat[j])
                best = max(best, min(held, q_margin[j]))
            held_sat = held_sat and p_sat[j]
            held = min(held, p_margin[j])
        sat.append(best_sat)
        margin.append(best + 0.0)
    return sat, margin


def shift(sat: Sequence[bool], margin: Sequence[float], step: int, weak: bool) -> Bound:
    """The value one sample later (step +1: next) or earlier (-1: previous).

    Outside the trace False and -inf, or True and +inf when weak.
    """
    if step not in (1, -1):
        raise ValueError(f"next is a step of +1, previous one of -1; not {step}")
    n = len(sat)
    return (
        [sat[k + step] if 0 <= k + step < n else weak for k in range(n)],
        [
            (margin[k + step] if 0 <= k + step < n else math.inf if weak else -math.inf) + 0.0
            for k in range(n)
        ],
    )
