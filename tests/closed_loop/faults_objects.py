"""Faults of the perception, and others on the road that the planner does not reckon with."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from closed_loop.fault import SUPERVISOR, Fault
from closed_loop.message import Object
from closed_loop.traffic import Other

if TYPE_CHECKING:
    from closed_loop.traffic import World


def ahead(world: World) -> float:
    """How far ahead something that stands can still be braked for: where the emergency trajectory ends that was planned last, and 10 m more."""
    return world.stopping + 10.0


class Overlooked(Fault):
    id, group, requirement = "O-01", "objects", "S-1-A-2"
    title = "A car stands ahead that the planner is not told of"

    def begins(self, world: World) -> list[Other]:
        return [Other("stopped", world.station + ahead(world), speed=0.0, told=frozenset((SUPERVISOR,)))]


class CutIn(Fault):
    id, group, requirement = "O-02", "objects", "S-1-A-2"
    title = "A car cuts in 8 m ahead, 3 m/s slower"

    def begins(self, world: World) -> list[Other]:
        return [Other("cutting_in", world.station + 12.7, speed=max(world.v - 3.0, 0.0))]


class LostPlace(Fault):
    id, group, requirement = "O-03", "objects", "S-1-B-9"
    title = "The place of an object is not a number, for the Supervisor"

    def seen(self, who: str, since: float, objects: tuple[Object, ...]) -> tuple[Object, ...] | None:
        if who != SUPERVISOR:
            return objects
        lost = {
            "id": "lost",
            "x": math.nan,
            "y": 0.0,
            "heading": 0.0,
            "v": 0.0,
            "length": 4.7,
            "width": 2.0,
            "age": 0.0,
        }
        return (*objects, lost)


class NoList(Fault):
    id, group, requirement = "O-04", "objects", "S-1-B-9"
    title = "The Supervisor gets no list of objects"

    def seen(self, who: str, since: float, objects: tuple[Object, ...]) -> tuple[Object, ...] | None:
        return None if who == SUPERVISOR else objects


class Unseen(Fault):
    id, group, requirement = "A-02", "objects", "S-1-A-1"
    title = "A car stands ahead that nobody is told of"
    beyond = "A-PERCEPTION"

    def begins(self, world: World) -> list[Other]:
        return [Other("unseen", world.station + ahead(world), speed=0.0, told=frozenset())]


FAULTS = (Overlooked, CutIn, LostPlace, NoList, Unseen)
