"""A planner that proposes whatever it likes, in a car that follows to the millimetre, on a winding road among others that keep to their lines.

Nothing of it is the product's but the Supervisor that is asked: what happens is worked out with shapely, of bodies and places alone.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray

import trackmarshal as tm
from support.dense.sweep import corners
from trackmarshal.ir.spec import Spec

Floats = NDArray[np.float64]
#: s; what lies between is looked at in steps of `TICK`.
CYCLE, TICK = 0.1, 0.02
NOBODY = {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")}


class Cars(NamedTuple):
    """What the car under test and others are: m; what tyres do at most, what the one and the others speed up by, m/s^2; m/s.

    What is wanted of them is in proportion to what the shipped vehicle can do.
    """

    length: float = 4.7
    width: float = 2.8
    other_width: float = 2.0
    grip: float = 13.0
    drives: float = 6.0
    speeds_up: float = 6.0
    fastest: float = 60.0
    samples: int = 50

    @property
    def share(self) -> float:
        return self.grip / 13.0


SHIPPED = Cars()


class Road:
    """A closed road by the stations of its middle."""

    def __init__(self, rng: np.random.Generator) -> None:
        angle = np.linspace(0.0, math.tau, 6001)
        waves = rng.uniform(0.0, 0.25) * np.cos(2 * angle) + rng.uniform(0.0, 0.1) * np.cos(
            rng.integers(3, 6) * angle + rng.uniform(0.0, math.tau)
        )
        points = rng.uniform(60.0, 300.0) * (1.0 + waves) * np.array([np.cos(angle), np.sin(angle)])
        along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(points)))])
        self.length, self.half = float(along[-1]), rng.uniform(5.0, 9.0)
        self._s = np.linspace(0.0, self.length, len(angle))
        self._x, self._y = (np.interp(self._s, along, each) for each in points)
        dx, dy = (np.roll(each[:-1], -1) - np.roll(each[:-1], 1) for each in (self._x, self._y))
        heading = np.unwrap(np.arctan2(dy, dx))
        self._heading = np.append(heading, heading[0] + math.tau)
        self.bend = np.gradient(self._heading, self._s)
        places = np.arange(0.0, self.length, 4.0)
        self.borders = [np.stack(self.at(places, side * self.half)[:2], axis=1) for side in (1.0, -1.0)]
        inner, outer = sorted((shapely.Polygon(border) for border in self.borders), key=shapely.area)
        self.surface = outer.difference(inner).buffer(1e-3)

    def at(self, station: Any, offset: Any) -> tuple[Any, Any, Any]:
        """x, y and heading of places."""
        s = np.mod(station, self.length)
        x, y, heading = (np.interp(s, self._s, each) for each in (self._x, self._y, self._heading))
        return x - offset * np.sin(heading), y + offset * np.cos(heading), heading

    def shorter(self, station: float, offset: float) -> float:
        """By what the middle of the road is longer than a line beside it."""
        return float(1.0 - np.interp(station % self.length, self._s, self.bend) * offset)


@dataclass
class State:
    """Of the car along the road: m, m, across to along, m/s."""

    station: float
    offset: float
    slope: float
    v: float


class Way:
    """From a state to another offset, over some of the road, while speeding up or braking evenly: for a time, or to rest."""

    def __init__(
        self, road: Road, begin: State, offset: float, over: float, gain: float, lasts: float | None
    ) -> None:
        v = max(begin.v, 0.3)
        self.v, self.gain = v, gain
        self.lasts = v / -gain if lasts is None else min(lasts, v / -gain if gain < 0.0 else math.inf)
        self.to_rest = lasts is None
        way = max(v * self.lasts + gain * self.lasts**2 / 2, 0.5)
        self._station = begin.station + np.linspace(0.0, 1.3 * way + 5.0, int(way / 0.2) + 40)
        u = np.clip((self._station - begin.station) / over, 0.0, 1.0)
        still = 1.0 - u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
        turns = u - u**3 * (6.0 - 8.0 * u + 3.0 * u**2)
        self._offset = offset + (begin.offset - offset) * still + begin.slope * over * turns
        self._x, self._y, _ = road.at(self._station, self._offset)
        self._s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self._x), np.diff(self._y)))])
        dx, dy = (np.gradient(each, self._s, edge_order=2) for each in (self._x, self._y))
        self._heading = np.unwrap(np.arctan2(dy, dx))
        self._kappa = np.gradient(self._heading, self._s, edge_order=2)
        self._way = min(way, float(self._s[-1]))

    @property
    def tightest(self) -> float:
        return float(np.abs(self._kappa[self._s <= self._way]).max())

    def _driven(self, t: Any) -> Any:
        t = np.minimum(t, self.lasts)
        return np.minimum(self.v * t + self.gain * t**2 / 2, self._way)

    def way(self, t: float) -> float:
        """How far it has led, m."""
        return float(self._driven(t))

    def pose(self, t: Any) -> tuple[Any, Any, Any]:
        s = self._driven(t)
        x, y, heading = (np.interp(s, self._s, each) for each in (self._x, self._y, self._heading))
        return x, y, heading

    def state(self, t: float) -> State:
        s = float(self._driven(t))
        k = min(max(int(np.searchsorted(self._s, s)), 1), len(self._s) - 2)
        slope = (self._offset[k + 1] - self._offset[k - 1]) / (self._station[k + 1] - self._station[k - 1])
        station, offset = (float(np.interp(s, self._s, each)) for each in (self._station, self._offset))
        return State(station, offset, float(slope), max(self.v + self.gain * min(t, self.lasts), 0.0))

    def columns(self, samples: int) -> dict[str, Floats]:
        """So many samples, evenly along the way."""
        s = np.linspace(0.0, self._way, samples)
        v = np.sqrt(np.maximum(self.v**2 + 2 * self.gain * s, 0.0))
        if self.to_rest:
            v[-1] = 0.0
        x, y, heading, kappa = (
            np.interp(s, self._s, each) for each in (self._x, self._y, self._heading, self._kappa)
        )
        return {"t": (v - self.v) / self.gain, "s": s, "x": x, "y": y, "heading": heading, "kappa": kappa, "v": v,
                "a": np.full(samples, self.gain), "grip": np.ones(samples)}  # fmt: skip


@dataclass
class Other:
    """Keeps to its line beside the middle; speeds up and brakes as it likes, and brakes for who is in its line, or comes into it, when it has seen that."""

    station: float
    offset: float
    v: float
    brakes: float
    cars: Cars
    gain: float = 0.0
    warned: bool = False

    def decide(self, rng: np.random.Generator, ego: State, braking: bool) -> None:
        cars = self.cars
        if rng.random() < 0.15:
            self.gain = float(rng.choice([0.0, 0.0, rng.uniform(0.0, cars.speeds_up), -self.brakes]))
        gap = ego.station - self.station - cars.length
        beside = abs(ego.offset - self.offset) - (cars.width + cars.other_width) / 2
        comes = max(beside, 0.0) < 3.0 and braking and ego.slope * np.sign(self.offset - ego.offset) >= -0.01
        needed = 0.3 * (self.v + 1.0) + ((self.v + 1.8) ** 2 - ego.v**2) / (2 * cars.grip)
        near = gap > -cars.length / 2 and (beside < 0.3 or comes) and gap < max(needed, 0.0) + 1.0
        if near:
            self.gain = -cars.grip if self.warned else min(self.gain, 0.0)
        self.warned = near

    def drive(self, road: Road, t: Floats) -> tuple[Any, Any, Any]:
        """Its poses at times from now on, at the last of which it is then."""
        lasts = np.minimum(t, self.v / -self.gain) if self.gain < 0.0 else t
        way = self.v * lasts + self.gain * lasts**2 / 2
        stations = self.station + way / max(road.shorter(self.station, self.offset), 0.2)
        self.station, self.v = float(stations[-1]), max(self.v + self.gain * float(t[-1]), 0.0)
        return road.at(stations, np.full(len(t), self.offset))


@dataclass
class Outcome:
    """What a run came to; `wrong`: what should not have happened, empty where nothing did."""

    wrong: str = ""
    seen: Counter[str] = field(default_factory=Counter)


class Proposals:
    """What the planner wants, from cycle to cycle."""

    def __init__(self, road: Road, rng: np.random.Generator, offset: float, cars: Cars) -> None:
        self._road, self._rng, self._target, self._cars = road, rng, offset, cars

    def of(self, begin: State, others: list[Other]) -> tuple[Way, Way]:
        """A driving and an emergency trajectory."""
        rng, half, grip = self._rng, self._road.half, self._cars.grip
        share, drives = self._cars.share, self._cars.drives / 6.0
        if rng.random() < 0.12:
            beside = (
                rng.uniform(-1.0, 1.0) if rng.random() < 0.8 else rng.choice([-1.0, 1.0])
            )  # which is off the road
            self._target = beside * (half - rng.uniform(0.0, 2.5))
        if rng.random() < 0.05 and others:
            self._target = others[rng.integers(len(others))].offset + rng.uniform(-1.0, 1.0)
        v = max(begin.v, 0.3)
        over = max(rng.choice([9.0, 14.0, 20.0]), v * rng.uniform(1.0, 4.0))
        wanted = (
            [rng.uniform(-8.0 * share, 5.0 * drives), -2.0 * share, 2.0 * drives, drives]
            if v > 4.0
            else [drives, 2.0 * drives, 4.0 * drives]
        )
        driving = Way(self._road, begin, self._target, over, float(rng.choice(wanted)), rng.uniform(1.0, 4.0))
        chance, brakes = rng.random(), rng.uniform(3.0, 12.5) * share
        offset = (
            self._target
            if chance < 0.6
            else begin.offset
            if chance < 0.8
            else rng.uniform(-1.0, 1.0) * (half - rng.uniform(0.0, 2.0))
        )
        if chance >= 0.8:
            over = max(12.0, v * rng.uniform(1.0, 4.0))
        emergency = Way(self._road, begin, offset, over, -brakes, None)
        across = v * v * emergency.tightest
        if math.hypot(brakes, across) > grip - 0.4 * share:
            brakes = max(math.sqrt(max((grip - 0.4 * share) ** 2 - across**2, 0.0)), 2.0 * share)
            emergency = Way(self._road, begin, offset, over, -brakes, None)
        return driving, emergency


def run(
    spec: Spec, seed: int, rules: list[str] | None = None, cars: Cars = SHIPPED, cycles: int = 120
) -> Outcome:
    """Until the car stands, or something is wrong; what the Supervisor decides is driven."""
    rng, now, outcome = np.random.default_rng(seed), [0.0], Outcome()
    road = Road(rng)
    supervisor = tm.supervisor(spec, rules, backend="c", clock=lambda: now[0])
    fast = (
        math.sqrt(9.0 * cars.share / float(np.abs(road.bend).max())) if rng.random() < 0.8 else cars.fastest
    )
    state = State(
        0.0,
        rng.uniform(-1.0, 1.0) * (road.half - 2.2),
        0.0,
        rng.uniform(8.0, max(min(cars.fastest, fast), 9.0)),
    )
    others = [
        Other(rng.choice([-1.0, 1.0, 1.0, 1.0]) * rng.uniform(8.0, 15.0 + 2.0 * state.v), rng.uniform(-1.0, 1.0) * (road.half - 1.2),
              state.v * rng.uniform(0.2, 1.1), float(rng.choice([2.0 * cars.share, 6.0 * cars.share, cars.grip])), cars)
        for _ in range(rng.integers(1, 4))
    ]  # fmt: skip
    track = {side: tm.line(border) for side, border in zip(("left", "right"), road.borders)} | {
        "closed": True
    }
    planner = Proposals(road, rng, state.offset, cars)
    driven: tuple[Way, float] | None = None
    stored: tuple[Way, float] | None = None
    for number in range(cycles):
        t = round(number * CYCLE, 9)
        driving, emergency = planner.of(state, others)
        at = driven or (driving, t)
        ego = dict(zip(("x", "y", "heading"), (float(value) for value in at[0].pose(t - at[1]))))
        poses = [[float(value) for value in road.at(other.station, other.offset)] for other in others]
        x, y, heading = np.array(poses).T
        objects = {"id": [str(k) for k in range(len(others))], "x": x, "y": y, "heading": np.remainder(heading + math.pi, math.tau) - math.pi,
                   "v": np.array([other.v for other in others]), "length": np.full(len(others), cars.length),
                   "width": np.full(len(others), cars.other_width), "age": np.zeros(len(others))}  # fmt: skip
        signals = {"ego": {**ego, "v": state.v, "age": 0.0}, "objects": objects, "obstacles": NOBODY, "track": track}  # fmt: skip
        now[0] = t + 0.01
        given = tm.Cycle(
            number=number,
            t=t,
            signals=signals,
            driving=driving.columns(cars.samples),
            emergency=emergency.columns(cars.samples),
        )
        decision = supervisor.step(given)
        outcome.seen["safe" if decision.safe else "unsafe"] += 1
        if decision.safe:
            driven, stored = (driving, t), (emergency, t)
        elif stored is None:
            return outcome
        else:
            driven = stored
        outcome.wrong = _happens(road, rng, state, driven, t, others, not decision.safe, cars)
        state = driven[0].state(t + CYCLE - driven[1])
        if outcome.wrong or state.v < 0.05:
            break
    outcome.seen["driven"] += 1
    return outcome


def _happens(
    road: Road, rng: np.random.Generator, ego: State, driven: tuple[Way, float], t: float, others: list[Other], falls_back: bool, cars: Cars
) -> str:  # fmt: skip
    """What goes wrong in a cycle."""
    ticks = np.arange(0.0, CYCLE + TICK / 2, TICK)
    own = shapely.polygons(corners(*driven[0].pose(t + ticks - driven[1]), cars.length, cars.width))
    wrong = "" if road.surface.contains(own[-1]) else "off the road"
    for other in others:
        other.decide(rng, ego, falls_back or driven[0].gain < -2.0 * cars.share)
        body = shapely.polygons(corners(*other.drive(road, ticks), cars.length, cars.other_width))
        if shapely.intersects(own, body).any():
            wrong = f"in contact with {other}"
    return wrong
