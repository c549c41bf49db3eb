"""Several cars on one road, each with a Supervisor and a planner of its own that proposes whatever it likes, each seeing the others as they are.

Each follows what is decided to the millimetre. What happens is worked out with shapely, of bodies and places alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import shapely

import trackmarshal as tm
from support.any_planner import CYCLE, NOBODY, SHIPPED, TICK, Floats, Outcome, Proposals, Road, State, Way
from support.dense.sweep import corners
from trackmarshal.ir.spec import Spec

#: What planners are after: m, m/s and m/s^2 of how they differ from those that propose at random.
KINDS = ("random", "follows", "brakes", "squeezes", "dives", "stops")


class Fallback:
    """Drives on for a cycle, and then as a way to rest: where the car is when the next decision is to fall back."""

    def __init__(self, driving: Way, rest: Way) -> None:
        self._driving, self._rest = driving, rest

    def pose(self, t: Any) -> tuple[Any, Any, Any]:
        before = self._driving.pose(np.minimum(t, CYCLE))
        after = self._rest.pose(np.maximum(t - CYCLE, 0.0))
        x, y, heading = (np.where(np.asarray(t) < CYCLE, a, b) for a, b in zip(before, after))
        return x, y, heading

    def state(self, t: float) -> State:
        state = self._driving.state(t) if t < CYCLE else self._rest.state(t - CYCLE)
        if t - CYCLE >= self._rest.lasts - 1e-9:
            state.v = 0.0
        return state

    def columns(self, samples: int) -> dict[str, Floats]:
        first, then = self._driving.columns(samples), self._rest.columns(samples)
        then["t"], then["s"] = then["t"] + CYCLE, then["s"] + self._driving.way(CYCLE)
        return {name: np.concatenate([column[:1], then[name]]) for name, column in first.items()}


@dataclass
class Car:
    """One of them, with what it follows and since when."""

    name: str
    kind: str
    rng: np.random.Generator
    supervisor: Any
    planner: Proposals
    state: State
    now: list[float]
    follows: list[tuple[float, Way | Fallback, float]] = field(default_factory=list)
    stored: tuple[Fallback, float] | None = None
    target: float = 0.0

    def seen(self, t: float) -> tuple[float, float, float, float]:
        """Its pose and speed at a time that has been."""
        way, begun = next((way, begun) for since, way, begun in reversed(self.follows) if since <= t + 1e-9 or since == 0.0)  # fmt: skip
        x, y, heading = (float(value) for value in way.pose(np.float64(t - begun)))
        return x, y, math.remainder(heading, math.tau), way.state(max(t - begun, 0.0)).v

    def proposes(self, road: Road, others: list[State], brakes: tuple[float, float]) -> tuple[Way, Fallback]:
        """What it is after, but for one cycle in ten; brakes: how hard fallbacks may brake, from and to, m/s^2."""
        rng, state = self.rng, self.state
        v, room = max(state.v, 0.3), road.half - 1.5
        driving, _ = self.planner.of(state, [])
        gap = [math.remainder(other.station - state.station, road.length) for other in others]
        ahead = min((k for k in range(len(gap)) if gap[k] > 0.0), key=lambda k: gap[k], default=None)
        near = others[int(np.argmin(np.abs(gap)))]
        if self.kind != "random" and rng.random() > 0.1 and v > 4.0:
            gain = float(rng.uniform(-3.0, 3.5))
            if self.kind == "follows" and ahead is not None:
                self.target, gain = others[ahead].offset + rng.uniform(-0.1, 0.1), rng.uniform(0.0, 3.5)
            elif self.kind == "brakes":
                gain = float(rng.choice([-12.5, -8.0, 3.5, 3.5, 3.5, 3.5]))
            elif self.kind == "squeezes":
                self.target, gain = near.offset + rng.uniform(-0.5, 0.5), rng.uniform(-1.0, 1.0) + float(np.clip(near.v - v, -3.0, 3.0))  # fmt: skip
            elif self.kind == "dives" and ahead is not None:
                self.target, gain = others[ahead].offset + rng.choice([-3.2, 3.2]), rng.uniform(1.0, 3.5)
            elif self.kind == "stops":
                gain = float(rng.choice([-12.8, -6.0, 2.0, 3.5], p=[0.1, 0.1, 0.4, 0.4]))
            self.target = float(np.clip(self.target, -room, room))
            over = max(9.0, v * rng.uniform(0.8, 2.5))
            driving = Way(road, state, self.target, over, gain, rng.uniform(1.0, 4.0))
        if not self.follows:
            driving = Way(road, state, state.offset, 50.0, 0.5, 3.0)
        begin = driving.state(CYCLE)
        chance = rng.random() if self.follows else 0.0
        offset = begin.offset if chance < 0.4 else rng.uniform(-room, room) if chance < 0.8 else near.offset
        over, hard = max(12.0, v * rng.uniform(0.8, 3.0)), float(rng.uniform(*brakes))
        rest = Way(road, begin, float(np.clip(offset, -room, room)), over, -hard, None)
        across = v * v * rest.tightest
        if math.hypot(hard, across) > 12.6:
            hard = max(math.sqrt(max(12.6**2 - across**2, 0.0)), 2.0)
            rest = Way(road, begin, begin.offset, 2.0 * over, -hard, None)
        return driving, Fallback(driving, rest)


def run(spec: Spec, seed: int, brakes: tuple[float, float], rules: list[str] | None = None) -> Outcome:
    """Until something is wrong, or all stand: at some time what each sends is lost, so that all fall back in one cycle.

    In half of the runs, poses and others are seen late, by up to 0.1 s.
    """
    rng, outcome, cars = np.random.default_rng(seed), Outcome(), SHIPPED
    road = Road(rng)
    late, lost = rng.random() < 0.5, int(rng.integers(5, 40))
    count, most = int(rng.integers(2, 7)), math.sqrt(9.0 / float(np.abs(road.bend).max()))
    v = rng.uniform(8.0, max(min(cars.fastest, most), 9.0))
    track = {side: tm.line(border) for side, border in zip(("left", "right"), road.borders)} | {"closed": True}  # fmt: skip
    team = []
    for k, station in enumerate(np.sort(rng.uniform(0.0, rng.uniform(20.0, 40.0 + 2.0 * v), count))):
        now, own = [0.0], np.random.default_rng([seed, k])
        state = State(
            float(station), rng.uniform(-1.0, 1.0) * (road.half - 1.6), 0.0, v * rng.uniform(0.6, 1.1)
        )
        supervisor = tm.supervisor(spec, rules, backend="c", clock=lambda now=now: now[0])  # type: ignore[misc]
        planner = Proposals(road, own, state.offset, cars)
        team.append(Car(str(k), str(rng.choice(KINDS)), own, supervisor, planner, state, now, target=state.offset))  # fmt: skip
    for number in range(lost + 250):
        t = round(number * CYCLE, 9)
        decided = []
        for car in team:
            others = [other for other in team if other is not car]
            driving, fallback = car.proposes(road, [other.state for other in others], brakes)
            ages = rng.uniform(0.0, CYCLE, 2) if late and number else np.zeros(2)
            if number >= lost:
                ages[1] = 2.0 * CYCLE
            decided.append((car, driving, fallback, _decide(car, others, number, t, driving, fallback, track, road, *ages)))  # fmt: skip
        if not number:
            # Who is not let go at first is not there.
            decided = [one for one in decided if one[3].safe]
            team = [one[0] for one in decided]
            if len(team) < 2:
                return outcome
        for car, driving, fallback, decision in decided:
            outcome.seen["safe" if decision.safe else "unsafe"] += 1
            if decision.safe:
                car.stored = fallback, t
                car.follows.append((t, driving, t))
            elif car.stored is not None and car.follows[-1][1] is not car.stored[0]:
                car.follows.append((t, *car.stored))
        outcome.wrong = _happens(road, team, t)
        if outcome.wrong or (number >= lost and all(car.state.v < 0.05 for car in team)):
            break
    outcome.seen["cars"] += len(team)
    return outcome


def _decide(
    car: Car, others: list[Car], number: int, t: float, driving: Way, fallback: Fallback, track: dict[str, Any], road: Road, own_age: float, age: float
) -> tm.Decision:  # fmt: skip
    def seen(one: Car, when: float) -> tuple[float, float, float, float]:
        if one.follows:
            return one.seen(when)
        x, y, heading = (float(value) for value in road.at(one.state.station, one.state.offset))
        return x, y, math.remainder(heading, math.tau), one.state.v

    ego = dict(zip(("x", "y", "heading", "v"), seen(car, t - own_age)))
    columns = np.array([seen(other, t - age) for other in others]).T
    sizes = {"length": SHIPPED.length, "width": SHIPPED.width, "age": age}
    objects = {"id": [other.name for other in others], **dict(zip(("x", "y", "heading", "v"), columns)),
               **{name: np.full(len(others), value) for name, value in sizes.items()}}  # fmt: skip
    signals = {"ego": {**ego, "age": own_age}, "objects": objects, "obstacles": NOBODY, "track": track}
    plans = driving.columns(50), fallback.columns(50)
    car.now[0] = t + 0.01
    decision: tm.Decision = car.supervisor.step(tm.Cycle(number, t, *plans, signals))
    return decision


def _happens(road: Road, team: list[Car], t: float) -> str:
    """What goes wrong in a cycle."""
    ticks, bodies, wrong = np.arange(0.0, CYCLE + TICK / 2, TICK), [], ""
    for car in team:
        _, way, begun = car.follows[-1]
        bodies.append(shapely.polygons(corners(*way.pose(t + ticks - begun), SHIPPED.length, SHIPPED.width)))
        car.state = way.state(t + CYCLE - begun)
        if not road.surface.contains(bodies[-1][-1]):
            wrong = f"off the road: {car.kind}, {car.state}"
        for other, body in zip(team, bodies[:-1]):
            if shapely.intersects(body, bodies[-1]).any():
                wrong = f"in contact at {t}: {car.kind}, {car.state}, and {other.kind}, {other.state}"
    return wrong
