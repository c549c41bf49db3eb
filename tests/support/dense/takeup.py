"""Whether an approved emergency trajectory can be taken up while the driving one is followed: the reference of docs/takeup.md.

It takes one cycle's data alone: both candidates, the pose of the car, the road.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from support.dense import braking, curve
from support.dense.car import Car
from support.dense.path import Path, path
from support.dense.recording import Columns, Cycle, Floats
from support.dense.sweep import Road

#: How far beyond its end the path of an emergency trajectory is looked at, m.
BEYOND = 60.0


@dataclass(frozen=True)
class Terms:
    """What is declared. Times s, lengths m, speeds m/s, angles rad.

    ds: how far beyond the emergency trajectory's end the car may come to rest. dv: how much faster than it, at the same station, the car may be
    when it takes it up. beside, turned: pose at the same station. slip, push: how far ahead of the driving trajectory, and how much faster, the car
    may be that follows it (the declared disturbance).
    """

    period: float = 0.1
    longest_gap: float = 0.15
    ds: float = 0.0
    dv: float = 0.0
    beside: float = 0.1
    turned: float = 0.05
    slip: float = 0.0
    push: float = 0.0

    @property
    def window(self) -> float:
        return self.period + self.longest_gap


@dataclass(frozen=True)
class Window:
    """What the car does while it follows the driving trajectory: at times [s], its stations on the emergency path [m] and speeds [m/s]."""

    times: Floats
    stations: Floats
    speeds: Floats
    beside: float
    turned: float
    on: Path


def window(cycle: Cycle, terms: Terms, begin: float | None = None, moments: int = 26) -> Window:
    """begin: the car's station on the driving trajectory at the stamp; default: where that is nearest to the car."""
    driving = path(cycle.candidates["driving"], 1.0)
    on = path(cycle.candidates["emergency"], BEYOND)
    if begin is None:
        begin, _ = driving.nearest(cycle.ego["x"], cycle.ego["y"])
    times = np.linspace(0.0, terms.window, moments)
    follows = driving.after(begin, times)
    spots = zip(driving.at("x", follows), driving.at("y", follows))
    places = [on.nearest(float(x), float(y)) for x, y in spots]
    stations = np.array([station for station, _ in places])
    turns = curve.turned(driving.at("heading", follows) - on.at("heading", stations))
    return Window(
        times,
        stations,
        driving.at("v", follows) + terms.push,
        beside=float(max(abs(side) for _, side in places)),
        turned=float(np.abs(turns).max()),
        on=on,
    )


@dataclass(frozen=True)
class TakeUp:
    """What a cycle needs.

    dv: the most that the car is faster than the emergency trajectory at the same station, m/s. excess: the most that the square of its speed is
    greater, m^2/s^2. beside, turned: the most of the pose. grip: the most that the emergency trajectory asks of the tyres at its samples, to what they
    have, when it is driven with the excess. overrun: how far beyond its end the car then comes to rest, m. on_road: whether it is on the road there.
    """

    dv: float
    excess: float
    beside: float
    turned: float
    grip: float
    overrun: float
    on_road: bool

    def causes(self, terms: Terms) -> frozenset[str]:
        """Why the cycle is refused; none: it is approved."""
        so = {
            "pose": not (self.beside <= terms.beside and self.turned <= terms.turned),
            "speed": not self.dv <= terms.dv,
            "friction": not self.grip <= 1.0,
            "rest": not self.overrun <= terms.ds,
            "border": not self.on_road,
        }
        return frozenset(cause for cause, holds in so.items() if holds)


def take_up(cycle: Cycle, road: Road | None, car: Car, terms: Terms, begin: float | None = None) -> TakeUp:
    """The rule. Driven with the same acceleration at each station, the square of speed keeps its excess; what is left at the end is braked there."""
    seen = window(cycle, terms, begin)
    # The car may be behind or ahead of the driving trajectory: it is held against the emergency one from there to there.
    around = seen.stations + terms.slip * np.linspace(-1.0, 1.0, 5)[:, None]
    planned = seen.on.at("v", around)
    excess = float(max(0.0, (np.square(seen.speeds) - np.square(planned)).max()))
    emergency = cycle.candidates["emergency"]
    late = max(0.0, float(around.max()) - seen.on.end)  # it has stopped before the car is there
    left = car.grip**2 - (excess * seen.on.kappa[-1]) ** 2
    overrun = late + excess / (2.0 * np.sqrt(left)) if left > 0.0 else np.inf
    reaches = min(float(overrun), BEYOND)
    return TakeUp(
        dv=float((seen.speeds - planned).max()),
        excess=excess,
        beside=seen.beside,
        turned=seen.turned,
        grip=used(emergency, float(around.min()), excess, car),
        overrun=float(overrun),
        on_road=road is None or braking.on_road(seen.on, seen.on.end, seen.on.end + reaches, road, car),
    )


def used(emergency: Columns, begin: float, excess: float, car: Car) -> float:
    """The greatest share of the grip that samples ask for, with the square of speed greater by up to the excess: from the last one before a station on.

    An acceleration holds from its sample to the next one, so it is looked at with the speed and the bend of both. Beyond the last sample, where the
    trajectory rests, what is left of the excess is braked otherwise.
    """
    s = np.concatenate([[0.0], np.cumsum(curve.chords(emergency))])
    first = max(0, int(np.searchsorted(s, begin, side="right")) - 1)
    steps = (np.arange(len(s) - 1) >= first) & (np.diff(s) > curve.SAME)
    if not steps.any():
        return 0.0
    square, bends, a = np.square(emergency["v"]), emergency["kappa"], emergency["a"][:-1][steps]
    # What the tyres give is convex in the excess: within the grip without and with all of it, it is so with any part of it.
    ends = [
        car.tyres(np.sqrt(square[end][steps] + more), a, bends[end][steps])
        for end in (slice(-1), slice(1, None))
        for more in (0.0, excess)
    ]
    return float(np.max(ends) / car.grip)


@dataclass(frozen=True)
class Limit:
    """The same without a rule: the car brakes as hard as the tyres allow from the end of the window on. Lengths m, speeds m/s.

    dv, ahead: how much faster, and further on at the same time, the car is then. overrun: where it rests, from the trajectory's end, negative before it.
    asks: the most that the bend asks of the tyres on the way, to their grip. on_road: as far as it comes.
    """

    dv: float
    ahead: float
    overrun: float
    asks: float
    on_road: bool


def at_the_limit(cycle: Cycle, road: Road, car: Car, terms: Terms, begin: float | None = None) -> Limit:
    """What physics allows."""
    seen = window(cycle, terms, begin, moments=2)
    at, v = float(seen.stations[-1]), float(seen.speeds[-1])
    planned = float(seen.on.after(float(seen.stations[0]), terms.window))
    s, _, asks = braking.brake(seen.on, at, v, car)
    rest = float(s[-1])
    within = rest <= seen.on.end or braking.on_road(seen.on, seen.on.end, rest, road, car)
    return Limit(v - float(seen.on.at("v", at)), at - planned, rest - seen.on.end, asks, within)
