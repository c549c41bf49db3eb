"""Whether speeds and headings of a recording are those of its places from cycle to cycle: a unit that is wrong shows there, and in no rule."""

from __future__ import annotations

import math
from collections.abc import Iterator
from statistics import median
from typing import Any

from trackmarshal.scenarios.recording import Recording

#: Of fewer steps, in which the car or others move, nothing is said.
_FEWEST = 5
#: m/s: of who is slower, and m: of who moves less, noise may be most.
_MOVING, _FAR = 2.0, 0.5
#: Further apart than this factor, speeds and places are of different units: miles per hour are 2.2 times metres per second.
_FACTOR = 2.0
#: rad: further off is another axis or another unit; no car that grips drifts so for half of a drive.
_ASKEW = 0.8


def contradictions(recording: Recording) -> list[str]:
    """What does not fit, in words; empty where all fits, or where too little moves. Medians, which jumps and faults do not shift."""
    found = []
    for who, steps in (
        ("the car", list(_of_car(recording))),
        ("other vehicles", list(_of_others(recording))),
    ):
        ratios = [way / said for way, said, _ in steps if said > 0.0]
        if len(ratios) >= _FEWEST and not 1.0 / _FACTOR <= median(ratios) <= _FACTOR:
            found.append(
                f"{who}: from cycle to cycle, {median(ratios):.2g} times as far as speeds say (median of {len(ratios)} steps): "
                "are stamps in s, places in m, speeds in m/s?"
            )
        askew = [off for way, _, off in steps if way > _FAR]
        if len(askew) >= _FEWEST and median(askew) > _ASKEW:
            found.append(
                f"{who}: headings are {median(askew):.2g} rad off the way from cycle to cycle (median of {len(askew)} steps): "
                "are they in rad, 0 along +x, counter-clockwise?"
            )
    return found


def _of_car(recording: Recording) -> Iterator[tuple[float, float, float]]:
    for before, now in zip(recording.cycles, recording.cycles[1:]):
        yield from _step(before.ego, now.ego, now.t - before.t)


def _of_others(recording: Recording) -> Iterator[tuple[float, float, float]]:
    for before, now in zip(recording.cycles, recording.cycles[1:]):
        known = {each["id"]: each for each in before.objects}
        for each in now.objects:
            if each["id"] in known:
                yield from _step(known[each["id"]], each, now.t - before.t)


def _step(a: dict[str, Any], b: dict[str, Any], dt: float) -> Iterator[tuple[float, float, float]]:
    """How far it is, m; how far speeds say, m, 0 where slow; how much headings are off, rad. Nothing of what is not all there."""
    numbers = [one.get(name, math.nan) for one in (a, b) for name in ("x", "y", "heading", "v")]
    if not all(math.isfinite(number) for number in numbers):
        return
    dx, dy, v = b["x"] - a["x"], b["y"] - a["y"], (a["v"] + b["v"]) / 2
    # half of both turns, as the way from one to the other is between their headings
    middle = a["heading"] + math.remainder(b["heading"] - a["heading"], math.tau) / 2
    travel = math.atan2(dy, dx) - (math.pi if v < 0.0 else 0.0)
    said = abs(v) * dt if abs(v) > _MOVING else 0.0
    yield math.hypot(dx, dy), said, abs(math.remainder(travel - middle, math.tau))
