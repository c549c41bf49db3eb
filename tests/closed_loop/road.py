"""A track: borders, and its race line by station."""

from __future__ import annotations

import math
from bisect import bisect_right
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from closed_loop import places
from support.race_line import read
from support.tracks import race_line

Point = tuple[float, float]


class Spot(NamedTuple):
    """A place on the race line: m, rad from +x, and the speed there, m/s."""

    x: float
    y: float
    heading: float
    v: float


@dataclass(frozen=True)
class Road:
    """left, right: closed borders, m. stations: of the race line's samples, m, from 0 up to below `length`."""

    name: str
    left: tuple[Point, ...]
    right: tuple[Point, ...]
    stations: tuple[float, ...]
    spots: tuple[Spot, ...]
    length: float

    @classmethod
    def of(cls, name: str) -> Road:
        """A track of the shared data."""
        (left, right), _ = race_line(places.race_line(name))
        lap = read(places.race_line(name))
        spots = [Spot(*values) for values in zip(lap["x"], lap["y"], lap["heading"], lap["v"])]
        steps = [math.dist(p[:2], q[:2]) for p, q in zip(spots, spots[1:] + spots[:1])]
        stations = [sum(steps[:i]) for i in range(len(steps))]
        return cls(name, tuple(left[:-1]), tuple(right[:-1]), tuple(stations), tuple(spots), sum(steps))

    def spot(self, station: float) -> Spot:
        """The race line at a station, straight between samples; stations go on from lap to lap."""
        s = station % self.length
        i = bisect_right(self.stations, s) - 1
        end = self.stations[i + 1] if i + 1 < len(self.stations) else self.length
        share = (s - self.stations[i]) / (end - self.stations[i])
        p, q = self.spots[i], self.spots[(i + 1) % len(self.spots)]
        turn = math.remainder(q.heading - p.heading, math.tau)
        return Spot(
            p.x + share * (q.x - p.x),
            p.y + share * (q.y - p.y),
            math.remainder(p.heading + share * turn, math.tau),
            p.v + share * (q.v - p.v),
        )

    def nearest(self, x: float, y: float) -> float:
        """The station of the race line's sample nearest to a point."""
        return min(zip(self.stations, self.spots), key=lambda pair: math.dist(pair[1][:2], (x, y)))[0]

    @cached_property
    def signal(self) -> dict[str, object]:
        """The signal `track` of a cycle."""
        import trackmarshal as tm

        return {"left": tm.line(self.left), "right": tm.line(self.right), "closed": True}
