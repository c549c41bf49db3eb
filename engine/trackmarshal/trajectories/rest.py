"""Where a trajectory comes to rest, and what becomes of its tail.

Planners sample their path every so many metres, so the last sample that moves is followed by one at rest a whole step away: at 0.07 m/s
and 2.5 m, that step lasts 71 s. No car brakes so. Cut at rest, a trajectory ends where the car stands if it goes on braking as in the step before.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from trackmarshal.trajectories.along import REST_SPEED, REST_STEP, arc_length, wrap
from trackmarshal.trajectories.columns import Lists

#: At or below this speed, in m/s, a trajectory is on its tail: see `cut`. A step of 2.5 m from here to rest takes two seconds.
TAIL_SPEED = 2.5
#: A way to rest that is no longer than this, in m, gets no sample of its own: the direction between two samples so near is that of their rounding.
SHORTEST = 0.01


class Cut(NamedTuple):
    """A trajectory cut at rest, and how many samples of its tail were dropped."""

    columns: Lists
    dropped: int


def first_at_rest(v: list[float], speed: float = REST_SPEED) -> int | None:
    """Index of the sample from which on none is faster; None where the last one is."""
    index = len(v)
    while index > 0 and abs(v[index - 1]) <= speed:
        index -= 1
    return index if index < len(v) else None


def cut(columns: Lists, speed: float = TAIL_SPEED) -> Cut:
    """Cut a trajectory (x, y, v at least; equally long columns) at rest. Returns new columns.

    The tail begins at the first sample from which on none is faster than `speed`. In it, the trajectory ends

    - with the first sample that stands still (REST_SPEED); what follows is path that the car never drives. A trajectory at rest from its
      start becomes two samples in its first place, REST_STEP apart.
    - Before that, where it brakes less than it did, so that the car would stand before the next sample is reached. At such a sample it moves
      at v, and the step to it has braked at b = (v_before^2 - v^2) / (2 ds): the car goes on braking so, and the trajectory ends with a sample at rest
      v^2 / (2 b) further along the path, v / b later. Where that is less than SHORTEST further, the sample itself is at rest, and the
      step to it takes as much longer as that takes. So the end is never further along the path, or later, than it was.

    Nothing is cut where there is no tail, and where the tail has a number that is not finite: an undefined trajectory stays undefined.
    """
    v = columns["v"]
    tail = first_at_rest(v, speed)
    if tail is None:
        return Cut(dict(columns), 0)
    if not all(math.isfinite(z) for column in columns.values() for z in column[tail:]):
        return Cut(dict(columns), 0)
    still = first_at_rest(v)
    for place in range(max(tail, 1), len(v) if still is None else still):
        braked = _braked(columns, place)
        if braked is not None:
            return braked
    return Cut(dict(columns), 0) if still is None else _still(columns, still)


def _still(columns: Lists, rest: int) -> Cut:
    """The trajectory up to a sample at rest."""
    count = len(columns["v"])
    if 0 < rest == count - 1:
        return Cut(dict(columns), 0)
    if rest > 0:
        return Cut({name: column[: rest + 1] for name, column in columns.items()}, count - rest - 1)
    kept = {name: [column[0], column[0]] for name, column in columns.items()}
    if "t" in columns:
        kept["t"][1] = kept["t"][0] + REST_STEP
    return Cut(kept, max(count - 2, 0))


def _braked(columns: Lists, at: int) -> Cut | None:
    """The trajectory braked to rest from a sample of its tail on; None where it does not brake, or has no reason to stand so soon."""
    v0, v1 = abs(columns["v"][at - 1]), abs(columns["v"][at])
    s = columns["s"] if "s" in columns else arc_length(columns["x"], columns["y"])
    step = s[at] - s[at - 1]
    if not (step > 0.0 and v0 > v1 and math.isfinite(v0)):
        return None
    braking = (v0 * v0 - v1 * v1) / (2.0 * step)
    way = v1 * v1 / (2.0 * braking)
    count = len(columns["v"])
    if way <= SHORTEST:
        kept = {name: column[: at + 1] for name, column in columns.items()}
        if "t" in kept:  # the same way, at constant deceleration to 0 rather than to v1
            before = kept["t"][at - 1]
            kept["t"][at] = before + (kept["t"][at] - before) * (v0 + v1) / v0
        kept["v"][at] = 0.0
        if "a" in kept:
            kept["a"][at] = 0.0
        return Cut(kept, count - at - 1)
    if at + 1 >= count or not way < s[at + 1] - s[at]:
        return None
    share = way / (s[at + 1] - s[at])
    kept = {name: [*column[: at + 1], _between(name, column, at, share)] for name, column in columns.items()}
    kept["v"][-1] = 0.0
    if "a" in kept:
        kept["a"][-2:] = [math.copysign(braking, -columns["v"][at - 1]), 0.0]
    if "t" in kept:
        kept["t"][-1] = kept["t"][at] + v1 / braking
    return Cut(kept, count - at - 1)


def _between(name: str, column: list[float], index: int, share: float) -> float:
    a, b = column[index], column[index + 1]
    return wrap(a + share * wrap(b - a)) if name == "heading" else a + share * (b - a)
