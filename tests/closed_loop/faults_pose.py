"""Faults of the localisation: everybody who uses it gets them, unless it says otherwise."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from closed_loop.executing import Sensed
from closed_loop.fault import PLANNER, Fault


def beside(pose: Sensed, left: float) -> Sensed:
    """A pose so many m to the left."""
    return replace(pose, x=pose.x - left * math.sin(pose.heading), y=pose.y + left * math.cos(pose.heading))


def _ago(past: Sequence[Sensed], seconds: float) -> Sensed:
    return past[max(len(past) - 1 - round(seconds / 0.01), 0)]


class Jump(Fault):
    id, group, requirement = "L-01", "pose", "S-1-A-3"
    title = "The pose jumps 3 m to the left"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        return beside(past[-1], 3.0)


class PlannersJump(Fault):
    id, group, requirement = "L-02", "pose", "S-1-A-3"
    title = "The planner gets a pose 20 m behind the car, nobody else"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        pose = past[-1]
        if who != PLANNER:
            return pose
        return replace(
            pose, x=pose.x - 20.0 * math.cos(pose.heading), y=pose.y - 20.0 * math.sin(pose.heading)
        )


class Stuck(Fault):
    id, group, requirement = "L-03", "pose", "S-1-A-3"
    title = "The pose stands still, with fresh stamps"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        return _ago(past, since)


class Old(Fault):
    id, group, requirement = "L-04", "pose", "S-1-A-3"
    title = "The pose is 0.3 s old, and says so"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        return replace(_ago(past, 0.3), age=0.3)


class Askew(Fault):
    id, group, requirement = "L-05", "pose", "S-1-A-3"
    title = "The heading is off by 0.5 rad"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        return replace(past[-1], heading=past[-1].heading + 0.5)


class NoPose(Fault):
    id, group, requirement = "L-06", "pose", "S-1-B-9"
    title = "The pose is not a number"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        return Sensed(math.nan, math.nan, math.nan, math.nan)


class Creeping(Fault):
    id, group, requirement = "A-01", "pose", "S-1-A-3"
    title = "The pose drifts to the left by 0.5 m a second, for 4 s"
    beyond = "A-LOCALISATION"

    def sensed(self, who: str, since: float, past: Sequence[Sensed]) -> Sensed:
        return beside(past[-1], 0.5 * min(since, 4.0))


FAULTS = (Jump, PlannersJump, Stuck, Old, Askew, NoPose, Creeping)
