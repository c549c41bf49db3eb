"""When a supervisor must and may fire on another vehicle: the detection envelope of the paper's section V-D.

Earliest: the other vehicle, frozen where it is, enters the braking distance v^2 / (2 b) in front of the car under
test. Latest: contact results although the car under test brakes at its maximum b while the other keeps its velocity.
Before the earliest time the verdict has to be safe, from the latest on unsafe, between them it is free. Where the
latest lies before the earliest (an oncoming car), the paper leaves no answer: safety comes first, and the verdict
has to be unsafe from the latest on. A car that is not ahead is no concern here: the rear vehicle is responsible.

`encounter` judges each cycle of a recorded encounter, so that a danger that is over is over.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

#: An oncoming car that will pass with less than this between the sides may be fired on, m.
ROOM = 1.0


@dataclass(frozen=True, slots=True)
class LaneState:
    """A vehicle in coordinates of the road: centre s along and d left of the reference line, m, and their rates, m/s.

    reach and side are half the extents of its rectangle along and across the road, m.
    """

    s: float
    d: float
    s_rate: float
    d_rate: float
    reach: float
    side: float


def may_fire(ego: LaneState, other: LaneState, b: float) -> bool:
    """Does the other, frozen, overlap the ego's width within its braking distance in front of its bumper?"""
    gap = other.s - ego.s - other.reach - ego.reach
    abreast = abs(other.d - ego.d) < other.side + ego.side
    return other.s > ego.s and abreast and gap <= ego.s_rate * ego.s_rate / (2.0 * b)


def must_fire(ego: LaneState, other: LaneState, b: float) -> bool:
    """Do the rectangles meet while the ego, keeping its d, brakes at b to rest and the other keeps both its rates?"""
    if other.s <= ego.s:
        return False
    start, end = _window(other.d - ego.d, other.d_rate, other.side + ego.side, ego.s_rate / b)
    if start > end:
        return False
    ahead, rate = other.s - ego.s, other.s_rate - ego.s_rate

    def distance(t: float) -> float:  # between the centres: convex in t
        return ahead + rate * t + 0.5 * b * t * t

    lowest = distance(min(max(-rate / b, start), end))
    highest = max(distance(start), distance(end))
    length = ego.reach + other.reach
    return lowest <= length and highest >= -length


def _window(offset: float, rate: float, width: float, end: float) -> tuple[float, float]:
    """The part of [0, end] in which |offset + rate t| < width; start > end where there is none."""
    if rate == 0.0:
        return (0.0, end) if abs(offset) < width else (1.0, 0.0)
    crossings = sorted(((-width - offset) / rate, (width - offset) / rate))
    return max(0.0, crossings[0]), min(end, crossings[1])


def encounter(ego: LaneState, other: LaneState, b: float) -> bool | None:
    """What the verdict has to be now: True safe, False unsafe, None free.

    An oncoming vehicle is inside the braking distance only after contact is due, so for it the earliest time is another
    one: contact would result although the car under test brakes, at half of what it can, with less than a metre sideways,
    and be it that the other does not go on moving aside.
    """
    if must_fire(ego, other, b):
        return False
    if other.s_rate < 0.0:
        near = replace(other, side=other.side + ROOM)
        free = any(must_fire(ego, at, 0.5 * b) for at in (near, replace(near, d_rate=0.0)))
    else:
        free = may_fire(ego, other, b)
    return None if free else True


def worst(truths: Sequence[bool | None]) -> bool | None:
    """The truth over several other vehicles: unsafe if it is for one, free if it is for one, else safe."""
    if False in truths:
        return False
    return None if None in truths else True
