"""One run: planner, messages, Supervisor, layer below, car and others, in simulated time.

Every 0.1 s the planner gets pose and objects, and plans; what it plans arrives `LATENCY` later at the Supervisor, whose decision the
layer below has in its next step, 0.01 s later at most. The very first plan is there before the run begins.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from closed_loop.adapter import candidate
from closed_loop.car import Build, Car, State
from closed_loop.condition import BEGIN, FAULTS, Condition
from closed_loop.executing import Executing, Sensed
from closed_loop.fault import CAR, PLANNER, SUPERVISOR
from closed_loop.link import PlannerFailed, PlannerProcess
from closed_loop.message import Message, Object
from closed_loop.road import Road
from closed_loop.supervising import Said, Supervising
from closed_loop.traffic import Other, World

#: s; a run ends when the car has stood for `STOOD`, when everything was safe for `SAFE` since the fault began, or after `LONGEST`.
TICK, CYCLE, LATENCY = 0.01, 10, 0.06
STOOD, SAFE, LONGEST = 0.5, 7.0, 40.0
#: A cycle is missed when the last one came longer ago than this, s.
SILENT = 0.17

#: What the planner may ask of the car: less than what the rules allow (13 m/s^2, the drive train's table), so that something is left for
#: taking up emergency trajectories; m/s, m/s^2, m. Until `common` s after the car, the emergency trajectory is the driving one.
PACE: dict[str, Any] = {
    "v_max": 72.0, "along": 11.0, "across": 11.0, "safety_distance": 30.0, "own_emergency": False, "common": 0.3, "wanted": ["straight", "follow", "left", "right"],
    "drive": [[0.0, 5.0], [36.0, 5.0], [40.0, 4.8], [44.0, 4.4], [48.0, 4.0], [52.0, 3.6], [56.0, 3.4], [60.0, 3.2],
              [66.0, 2.7], [72.0, 2.0]],
}  # fmt: skip
#: The share of the race line's speed at which a run begins; the others' share of it.
ENTRY, OTHERS = 0.88, 0.78


@dataclass
class Trace:
    """Everything that happened. poses: (t, x, y, heading, v) of the car every 0.01 s; others: by then, (id, x, y, heading)."""

    poses: list[tuple[float, float, float, float, float]] = field(default_factory=list)
    others: list[list[tuple[str, float, float, float]]] = field(default_factory=list)
    decisions: list[tuple[float, float, Said]] = field(default_factory=list)
    doing: list[tuple[float, str]] = field(default_factory=list)
    messages: list[Message] = field(default_factory=list)
    failed: str = ""
    speed: float = math.nan


def others(road: Road, station: float, v: float) -> list[Other]:
    """Two slower cars ahead: the first as far as takes to follow it, the second 40 m on."""
    slower = v * OTHERS / ENTRY
    first = station + 40.0 + 0.4 * v + max(v * v - slower * slower, 0.0) / 18.0
    return [Other("car1", first, OTHERS), Other("car2", first + 40.0, OTHERS)]


class Run:
    """A run of one condition."""

    def __init__(
        self,
        condition: Condition,
        road: Road,
        planner: PlannerProcess,
        supervise: Callable[[Road], Supervising],
    ) -> None:
        self.road, self.planner = road, planner
        self.fault = FAULTS[condition.fault]()
        v = _entry(road, condition.station)
        begin = condition.station - v[1]
        self.build, self.car = Build(), None
        spot, ahead = road.spot(begin), road.spot(begin + 3.0)
        kappa = math.remainder(ahead.heading - spot.heading, math.tau) / 3.0
        b = self.build
        state = State(
            spot.x, spot.y, spot.heading, v[0], steering=math.atan(b.base * kappa), yaw=v[0] * kappa
        )
        self.car = Car(b, state)
        self.world = World(road, others(road, begin, v[0]) if condition.traffic else [], begin, v[0])
        self.supervisor = supervise(road)
        self.below = Executing(b, spot.x, spot.y, spot.heading)
        self.trace = Trace()
        self._past: list[Sensed] = []
        self._queue: list[Message] = []
        self._arrived = 0.0
        self._began = False

    def go(self) -> Trace:
        """Runs to the end."""
        s = self.car.state
        self.planner.ask("run", pace=PACE)
        spot = self.world.road.spot(self.world.station)
        self.planner.ask("start", x=s.x, y=s.y, heading=_theirs(spot.heading), v=s.along)
        tick, stood, unsafe = 0, 0.0, BEGIN
        while True:
            t = tick * TICK
            since = t - BEGIN
            self._past.append(Sensed(s.x, s.y, s.heading, s.v))
            if since >= -1e-9 and not self._began:
                self._begin()
            if tick % CYCLE == 0:
                self._plan(tick // CYCLE, t)
            if self._decide(t):
                unsafe = max(unsafe, t)
            pose = self.fault.sensed(CAR, since, self._past) if self._began else self._past[-1]
            self.below.locate(pose, s.along, s.across, s.yaw, TICK if tick else 0.0)
            steering, pull = self.below.act(t, s.v)
            if not self.trace.doing or self.trace.doing[-1][1] != self.below.doing:
                self.trace.doing.append((t, self.below.doing))
            self._keep(t)
            stood = stood + TICK if s.standing else 0.0
            if (stood >= STOOD and self._began) or t >= LONGEST or t >= unsafe + SAFE:
                break
            self.car.drive(steering, pull, TICK)
            for other in self.world.others:
                other.drive(self.road, TICK)
            tick += 1
        self.planner.ask("end")
        self.supervisor.close()
        return self.trace

    def _begin(self) -> None:
        s = self.car.state
        self._began = True
        self.trace.speed = s.v
        self.world.station, self.world.v = self.road.nearest(s.x, s.y), s.v
        self.world.stopping = self.trace.messages[-1].emergency["s"][-1]
        self.world.others += self.fault.begins(self.world)

    def _plan(self, number: int, t: float) -> None:
        """The planner plans; its message is under way."""
        if self.trace.failed:
            return
        told = self._told(PLANNER, t)
        pose = self._pose(PLANNER, t)
        theirs = [{**o, "heading": _theirs(o["heading"])} for o in told or ()]
        try:
            raw = self.planner.ask(
                "plan", t=t, objects=theirs,
                ego={"x": pose.x, "y": pose.y, "heading": _theirs(pose.heading), "v": pose.v},
            )  # fmt: skip
        except PlannerFailed as error:
            self.trace.failed = f"{t:.1f}: {error}"
            return
        driving, emergency = (candidate(raw[name], pose.x, pose.y) for name in ("driving", "emergency"))
        message = Message(
            number, t, t + LATENCY if number else 0.0, driving, emergency, self._pose(SUPERVISOR, t),
            *self._reported(t), tuple(raw["said"]), raw["action"],
        )  # fmt: skip
        sent = self.fault.sent(t - BEGIN, message, self.trace.messages) if self._began else [message]
        self.trace.messages.append(message)
        self._queue += sent

    def _decide(self, t: float) -> bool:
        """Gives the Supervisor what has arrived; whether anything was unsafe."""
        if self._began and not self.fault.alive(t - BEGIN):
            return True
        due = sorted((m for m in self._queue if m.arrival <= t + 1e-9), key=lambda m: m.arrival)
        said = []
        for message in due:
            self._queue.remove(message)
            self._arrived = t
            said.append((message.t, self.supervisor.step(message, t)))
        if t - self._arrived > SILENT:
            self._arrived = t - SILENT + CYCLE * TICK
            said.append((math.nan, self.supervisor.silence(t)))
        for stamp, each in said:
            self.below.take(each.given)
            self.trace.decisions.append((t, stamp, each))
        return any(not each.safe for _, each in said)

    def _pose(self, who: str, t: float) -> Sensed:
        return self.fault.sensed(who, t - BEGIN, self._past) if self._began else self._past[-1]

    def _told(self, who: str, t: float) -> tuple[Object, ...] | None:
        objects = tuple(other.seen(self.road) for other in self.world.others if who in other.told)
        return self.fault.seen(who, t - BEGIN, objects) if self._began else objects

    def _reported(self, t: float) -> tuple[tuple[Object, ...] | None, tuple[Object, ...]]:
        """Objects and obstacles for the Supervisor: who stands still is an obstacle, which a trajectory must not touch."""
        told = self._told(SUPERVISOR, t)
        still = tuple(o for o in told or () if o["v"] == 0.0 and math.isfinite(o["x"]))
        obstacles = tuple({k: o[k] for k in ("id", "x", "y", "heading", "length", "width")} for o in still)
        return None if told is None else tuple(o for o in told if o not in still), obstacles

    def _keep(self, t: float) -> None:
        s = self.car.state
        self.trace.poses.append((t, s.x, s.y, s.heading, s.v))
        spots = [(other.id, self.road.spot(other.station)) for other in self.world.others]
        self.trace.others.append([(name, spot.x, spot.y, spot.heading) for name, spot in spots])


def _theirs(heading: float) -> float:
    """A heading as the planner counts it: from +y."""
    return math.remainder(heading - math.pi / 2.0, math.tau) if math.isfinite(heading) else heading


def _entry(road: Road, station: float) -> tuple[float, float]:
    """The speed at which a run begins, and the way from there to where the fault begins, m."""
    way = 0.0
    for _ in range(round(BEGIN / TICK)):  # backwards along the line
        way += TICK * ENTRY * road.spot(station - way).v
    return ENTRY * road.spot(station - way).v, way
