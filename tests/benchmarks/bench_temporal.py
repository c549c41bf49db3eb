"""How long the temporal operators take on a long timeline: median CPU seconds, by operator."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

from trackmarshal.backends.numpy import temporal

SAMPLES = 1_000_000
PERIOD = 0.01  # s


def measure(samples: int = SAMPLES, repeats: int = 5) -> dict[str, float]:
    """Median CPU seconds of each operator on so many samples, its windows included.

    Samples are equidistant up to rounding, or (`jittered`) up to 30 %; windows hold about 1000 samples.
    """
    rng = np.random.default_rng(1)
    uniform: temporal.FloatArray = np.arange(samples, dtype=np.float64) * PERIOD
    jittered: temporal.FloatArray = np.cumsum(PERIOD * (1.0 + 0.3 * rng.random(samples)), dtype=np.float64)
    p, q = rng.normal(size=samples), rng.normal(size=samples)
    p_sat, q_sat = p >= 0.0, q >= 0.0

    def bounded(t: temporal.FloatArray) -> None:
        temporal.always(p_sat, p, temporal.windows(t, 0.0, 10.0, False))

    def nested(t: temporal.FloatArray) -> None:
        inner = temporal.eventually(p_sat, p, temporal.windows(t, 0.0, 5.0, False))
        temporal.always(*inner, temporal.windows(t, 0.0, 10.0, False))

    def response(t: temporal.FloatArray) -> None:
        later_sat, later = temporal.eventually(q_sat, q, temporal.windows(t, 0.0, 10.0, False))
        answered = ~p_sat | later_sat, np.maximum(-p, later)
        temporal.always(*answered, temporal.windows(t, None, None, False))

    def held(t: temporal.FloatArray) -> None:
        temporal.until(p_sat, p, q_sat, q, temporal.windows(t, 0.0, 10.0, False))

    def held_later(t: temporal.FloatArray) -> None:
        temporal.until(p_sat, p, q_sat, q, temporal.windows(t, 2.0, 10.0, False))

    def held_to_the_end(t: temporal.FloatArray) -> None:
        temporal.until(p_sat, p, q_sat, q, temporal.windows(t, None, None, False))

    def held_before(t: temporal.FloatArray) -> None:
        temporal.since(p_sat, p, q_sat, q, temporal.windows(t, 0.0, 10.0, True))

    cases: dict[str, Callable[[temporal.FloatArray], None]] = {
        "always[0, 10 s]": bounded,
        "always[0, 10 s] eventually[0, 5 s]": nested,
        "always (p implies eventually[0, 10 s] q)": response,
        "until[0, 10 s]": held,
        "until[2, 10 s]": held_later,
        "until": held_to_the_end,
        "since[0, 10 s]": held_before,
    }
    result = {name: _median(case, uniform, repeats) for name, case in cases.items()}
    return result | {f"{name}, jittered": _median(case, jittered, repeats) for name, case in cases.items()}


def _median(case: Callable[[temporal.FloatArray], None], t: temporal.FloatArray, repeats: int) -> float:
    """Median CPU seconds of a case after one run to warm up."""
    case(t)
    spent = []
    for _ in range(repeats):
        begin = time.process_time()
        case(t)
        spent.append(time.process_time() - begin)
    return statistics.median(spent)


if __name__ == "__main__":
    for name, seconds in measure().items():
        print(f"{seconds * 1e3:8.1f} ms  {name}")
