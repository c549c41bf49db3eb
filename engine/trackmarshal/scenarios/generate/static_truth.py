"""The static ground truth of a cycle: are its trajectories possible, on the road, clear of obstacles, within the limits?

From the generated motion itself: unsafe is what its samples, which a supervisor gets, break clearly; safe is what it
keeps to between the samples too; what lies between is free.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from trackmarshal.scenarios.generate.boxes import Box, separation
from trackmarshal.scenarios.generate.candidates import Plan
from trackmarshal.scenarios.generate.limits import TOLERANCE, Vehicle
from trackmarshal.scenarios.generate.road import Road

#: A limit is clearly broken when it is exceeded by this share of it.
SHARE = 0.02
#: Lengths (m) and speeds (m/s) are clearly wrong by this much.
CLEAR = 0.1


class Zone(NamedTuple):
    """Where a lower speed limit holds, in coordinates of the road: s and d in m, from and to; speed in m/s."""

    s: tuple[float, float]
    d: tuple[float, float]
    speed: float

    def holds(self, s: float, d: float, grown: float, lap: float | None) -> bool:
        """Does it hold at this place, the zone being `grown` m wider on every side? On a closed road, after so many m it does again."""
        begin, end = self.s[0] - grown, self.s[1] + grown
        if lap is not None:
            s = begin + (s - begin) % lap
        return begin <= s <= end and self.d[0] - grown <= d <= self.d[1] + grown


class Scene(NamedTuple):
    """What a trajectory of the vehicle has to keep to; speed in m/s is the event's limit, None for none."""

    vehicle: Vehicle
    road: Road
    obstacles: list[Box]
    zones: list[Zone]
    speed: float | None


def static_truth(samples: Iterable[Plan], whole: Iterable[Plan], scene: Scene) -> bool | None:
    """True (safe), False (unsafe) or None (free) of a cycle's trajectories.

    samples: as a supervisor gets them; whole: the same ones with many more samples.
    """
    if any(excess > band for plan in samples for excess, band in _excesses(plan, scene, -CLEAR)):
        return False
    if any(excess > TOLERANCE for plan in whole for excess, _ in _excesses(plan, scene, CLEAR)):
        return None
    return True


def _excesses(plan: Plan, scene: Scene, grown: float) -> Iterator[tuple[float, float]]:
    """By how much each demand of each sample is too much, and from where on that is clear."""
    vehicle, columns = scene.vehicle, plan.columns
    lap = scene.road.length if scene.road.closed else None
    for i, place in enumerate(plan.places):
        v, a, kappa = columns["v"][i], columns["a"][i], columns["kappa"][i]
        for _, value, limit in vehicle.demands(v, a, kappa):
            yield value - limit, SHARE * limit
        yield -v, CLEAR
        if scene.speed is not None:
            yield v - scene.speed, CLEAR
        for zone in scene.zones:
            if zone.holds(place.s, place.d, grown, lap):
                yield v - zone.speed, CLEAR
        right, left = scene.road.edges(place.s)
        _, side = vehicle.extents(place.tilt)
        # `grown` asks for that much more room than there is, or is content with less.
        yield right + side + grown - place.d, 0.0
        yield place.d + side + grown - left, 0.0
        for obstacle in scene.obstacles:
            box = Box(place.x, place.y, place.heading, vehicle.length, vehicle.width)
            yield grown - separation(box, obstacle), 0.0
