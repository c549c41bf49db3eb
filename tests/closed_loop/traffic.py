"""The others: cars on the race line that go at a share of its speed, or as they are told; and the world that a fault may look at."""

from __future__ import annotations

from dataclasses import dataclass

from closed_loop.message import Object
from closed_loop.road import Road

LENGTH, WIDTH = 4.7, 2.0


@dataclass
class Other:
    """A car. station: m along the race line; share of the line's speed, or a speed of its own, m/s."""

    id: str
    station: float
    share: float = 0.0
    speed: float | None = None
    #: Who is told of it.
    told: frozenset[str] = frozenset(("planner", "supervisor"))

    def drive(self, road: Road, seconds: float) -> None:
        """Drives on."""
        self.station += seconds * self.v(road)

    def v(self, road: Road) -> float:
        """Its speed, m/s."""
        return self.share * road.spot(self.station).v if self.speed is None else self.speed

    def seen(self, road: Road) -> Object:
        """It as an object of a cycle."""
        spot = road.spot(self.station)
        return {"id": self.id, "x": spot.x, "y": spot.y, "heading": spot.heading, "v": self.v(road),
                "length": LENGTH, "width": WIDTH, "age": 0.0}  # fmt: skip


@dataclass
class World:
    """The road, the others, where the car is (its station on the race line), its speed, and how far its approved emergency trajectory goes."""

    road: Road
    others: list[Other]
    station: float
    v: float
    stopping: float = 0.0
