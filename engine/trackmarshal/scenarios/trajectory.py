"""Arc length and time along sampled trajectories that come without them."""

from __future__ import annotations

import math

from trackmarshal.scenarios.recording import Columns

#: At or below this speed, in m/s, a sample stands still. Recordings write exact zeros.
REST_SPEED = 1e-6
#: Time from one sample to the next while standing still, in s: speeds and distances say nothing about it there.
REST_STEP = 0.1


def arc_length(x: list[float], y: list[float]) -> list[float]:
    """Cumulative length of the polygon through the samples, m, from 0."""
    s = [0.0]
    for i in range(len(x) - 1):
        s.append(s[i] + math.hypot(x[i + 1] - x[i], y[i + 1] - y[i]))
    return s


def time_along(s: list[float], v: list[float]) -> list[float]:
    """Times in s, from 0, at constant acceleration between samples: dt = 2 ds / (|v0| + |v1|).

    REST_STEP where both samples stand still. Two samples in one place with speed get one time: what is wrong there
    is left for the input contract to report.
    """
    t = [0.0]
    for i in range(len(s) - 1):
        speed = abs(v[i]) + abs(v[i + 1])
        t.append(t[i] + (REST_STEP if speed <= 2.0 * REST_SPEED else 2.0 * (s[i + 1] - s[i]) / speed))
    return t


def first_at_rest(v: list[float]) -> int | None:
    """Index of the sample from which on all samples stand still; None where the last one moves."""
    index = len(v)
    while index > 0 and abs(v[index - 1]) <= REST_SPEED:
        index -= 1
    return index if index < len(v) else None


def complete(samples: Columns) -> tuple[Columns, int]:
    """Columns x, y, heading, kappa, v, a completed by t and s, and how many samples were dropped.

    Where a trajectory comes to rest, samples after the first at rest are dropped: their positions are path that the
    vehicle never drives. A trajectory at rest from its start becomes two samples in its first place, REST_STEP apart.
    Samples with a non-finite number in them are never dropped: an undefined trajectory stays undefined.
    """
    count = len(samples["v"])
    rest = first_at_rest(samples["v"])
    dropped = 0
    if rest is not None and rest < count - 1:
        tail = [value for column in samples.values() for value in column[rest:]]
        if all(map(math.isfinite, tail)):
            keep = [*range(rest + 1), *([0] if rest == 0 else [])]
            samples = {name: [column[i] for i in keep] for name, column in samples.items()}
            dropped = count - len(keep)
    s = arc_length(samples["x"], samples["y"])
    return {"t": time_along(s, samples["v"]), "s": s, **samples}, dropped


def wrap(angle: float) -> float:
    """The same angle in (-pi, pi]; NaN stays NaN."""
    wrapped = math.remainder(angle, math.tau) if math.isfinite(angle) else math.nan
    return math.pi if wrapped <= -math.pi else wrapped
