"""A declaration run: motions, candidates, ground truth, and the checks that nothing declared is impossible."""

from __future__ import annotations

import math
from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.generate.boxes import Box, separation
from trackmarshal.scenarios.generate.declaration import Declaration, Driver
from trackmarshal.scenarios.generate.document import Item
from trackmarshal.scenarios.generate.knots import linear
from trackmarshal.scenarios.generate.limits import Vehicle
from trackmarshal.scenarios.generate.motion import Motion, Profile, State
from trackmarshal.scenarios.generate.planner import Planner
from trackmarshal.scenarios.generate.road import Backwards
from trackmarshal.scenarios.generate.static_truth import Scene, static_truth
from trackmarshal.scenarios.generate.takeup_truth import takeup_truth
from trackmarshal.scenarios.ground_truth import LaneState, encounter, worst
from trackmarshal.scenarios.recording import COLUMNS, Columns, Cycle, Recording
from trackmarshal.scenarios.trajectory import wrap

#: The ground truth looks at this many steps between two samples of a trajectory.
FINER = 4
#: Decimals of what is written; curvature is multiplied by squares of speeds.
_DECIMALS = {"kappa": 9}


def run(declared: Declaration, shown: str) -> Recording:
    """Generate all cycles; raises D152 where the declaration asks for something impossible."""
    times = declared.times
    end = times[-1] + declared.horizon
    vehicle = declared.ego.vehicle
    scene = _scene(declared)
    try:
        ego = _motion(declared, declared.ego, end)
        states = [ego.at(t) for t in times]
        planner = Planner(ego, declared.horizon, declared.braking, declared.mistakes, declared.step)
        for t in times:
            for place in (ego.at(t), ego.at(t + declared.horizon)):
                _check_driven(place, scene)
        for t in _demanding(declared.ego, end):
            _check_driven(ego.at(t), scene)
    except TrackmarshalError as error:
        raise _placed(error, declared.ego.item) from error
    others = [_Encounter(declared, driver) for driver in declared.others]
    cycles: list[Cycle] = []
    static: list[bool | None] = []
    for i, (t, state) in enumerate(zip(times, states)):
        mistake = planner.mistake(t)
        try:
            plans = planner.plans(t, declared.points, declared.braking.points)
            whole = planner.plans(
                t, *(1 + FINER * (n - 1) for n in (declared.points, declared.braking.points))
            )
            if mistake is None:
                for name, plan in plans.items():
                    vehicle.check_plan(f"the {name} trajectory at t = {t:g} s", plan.columns)
        except TrackmarshalError as error:
            raise _placed(error, declared.ego.item if mistake is None else mistake.item) from error
        aside = linear(declared.pose_error, t)
        truths = [static_truth(plans.values(), whole.values(), scene), _misplaced(aside, vehicle)]
        if declared.takeup is not None:
            driven, fallback = (plan.columns for plan in whole.values())
            truths.append(takeup_truth(driven, fallback, vehicle, declared.takeup))
        static.append(worst(truths))
        objects = [other.reported(i) for other in others]
        candidates = {name: _columns(plan.columns) for name, plan in plans.items()}
        cycles.append(Cycle(t, _rounded(_ego(state, aside)), objects, candidates))
    speed = {} if declared.speed is None else {"v_event": declared.speed}
    because = dict.fromkeys(speed, "the event's limit")
    return Recording(
        name=declared.name,
        source=shown,
        cycles=tuple(cycles),
        track=declared.road.borders(),
        params={**vehicle.params, **speed, **declared.params},
        tables={**vehicle.tables, **declared.tables},
        obstacles=[
            {"id": obstacle.id, **_rounded(box._asdict())}
            for obstacle, box in zip(declared.obstacles, scene.obstacles)
        ],
        ground_truth={
            "dynamic": tuple(worst([other.truth(i, states) for other in others]) for i in range(len(times))),
            "static": tuple(static),
        },
        use=declared.use,
        notes=declared.notes,
        because={**because, **declared.because},
        in_si=frozenset(vehicle.in_si | {("params", name) for name in speed})
        - {("params", name) for name in declared.params}
        - {("tables", name) for name in declared.tables},
        of_specs="\n".join(repr(car.vehicle) for car in (declared.ego, *declared.others) if car.vehicle.spec),
        generated=True,
    )


def _scene(declared: Declaration) -> Scene:
    boxes = []
    for obstacle in declared.obstacles:
        x, y, heading = declared.road.pose(obstacle.s)
        x, y = x - obstacle.d * math.sin(heading), y + obstacle.d * math.cos(heading)
        boxes.append(Box(x, y, heading, obstacle.length, obstacle.width))
    return Scene(declared.ego.vehicle, declared.road, boxes, declared.zones, declared.speed)


def _check_driven(place: State, scene: Scene) -> None:
    """What is driven has to be possible; it may be against the rules."""
    vehicle = scene.vehicle
    vehicle.check_state("the car under test", place, scene.road)
    box = Box(place.x, place.y, place.heading, vehicle.length, vehicle.width)
    if any(separation(box, obstacle) <= 0.0 for obstacle in scene.obstacles):
        message = f"the car under test: drives into an obstacle at s = {place.s:.1f} m"
        raise TrackmarshalError("D152", message, help="move aside earlier, or move the obstacle")


def _demanding(driver: Driver, end: float) -> list[float]:
    """Times up to the end at which a declared motion asks for most: the corners of its acceleration, and the eighths of its moves.

    Cycles may miss them: a move that takes as long as from one cycle to the next begins and ends in one, and asks for nothing there.
    """
    corners = [time for time, _ in driver.acceleration]
    inside = [
        move.begin + (move.end - move.begin) * eighth / 8.0 for move in driver.moves for eighth in range(1, 8)
    ]
    return sorted(t for t in (*corners, *inside) if 0.0 <= t <= end)


def _motion(declared: Declaration, driver: Driver, end: float) -> Motion:
    """A car's motion; of an oncoming one, on the road the other way."""
    profile, road = Profile(driver.v, driver.acceleration), declared.road
    if not driver.oncoming:
        return Motion(road, profile, driver.moves, driver.start, end)
    moves = [move._replace(to=-move.to) for move in driver.moves]
    s, d = driver.start
    return Motion(Backwards(road), profile, moves, (road.length - s, -d), end)


class _Encounter:
    """Another car: where it is in every cycle, checked; what is heard of it; and the truth about it."""

    def __init__(self, declared: Declaration, driver: Driver) -> None:
        self._driver = driver
        self._declared = declared
        try:
            motion = _motion(declared, driver, declared.times[-1])
            self.states = [self._along_the_road(motion.at(t)) for t in declared.times]
            between = [self._along_the_road(motion.at(t)) for t in _demanding(driver, declared.times[-1])]
            for state in (*self.states, *between):
                driver.vehicle.check_state(f"the car `{driver.id}`", state, declared.road)
        except TrackmarshalError as error:
            raise _placed(error, driver.item) from error

    def _along_the_road(self, state: State) -> State:
        """The state in coordinates of the road, whichever way the car goes."""
        if not self._driver.oncoming:
            return state
        return state._replace(
            s=self._declared.road.length - state.s, d=-state.d, s_rate=-state.s_rate, d_rate=-state.d_rate
        )

    def _heard(self, i: int) -> int:
        """The cycle of the last message that has come in by cycle i."""
        times = self._declared.times
        for begin, end in self._driver.silent:
            if begin < times[i] < end:
                return max(k for k in range(i + 1) if times[k] <= begin)
        return i

    def reported(self, i: int) -> dict[str, Any]:
        """The car as an object of cycle i."""
        heard, times = self._heard(i), self._declared.times
        return _object(self._driver, self.states[heard], times[i] - times[heard] + self._declared.age)

    def truth(self, i: int, egos: list[State]) -> bool | None:
        """Free while what is heard is old, and unsafe when the car has left the place that it is reported at."""
        ego, vehicle = self._declared.ego.vehicle, self._driver.vehicle
        truths = [encounter(_lane(egos[i], ego), _lane(self.states[i], vehicle), ego.stopping)]
        heard = self._heard(i)
        if heard != i:
            now, then = (
                Box(state.x, state.y, state.heading, vehicle.length, vehicle.width)
                for state in (self.states[i], self.states[heard])
            )
            truths.append(None if separation(now, then) < 0.0 else False)
        return worst(truths)


def _misplaced(aside: float, vehicle: Vehicle) -> bool | None:
    """The truth about a pose that is reported `aside` m to the left: unsafe when the car does not even overlap it."""
    if aside == 0.0:
        return True
    return None if abs(aside) < vehicle.width else False


def _placed(error: TrackmarshalError, item: Item) -> TrackmarshalError:
    """The error with the place in the declaration."""
    return item.wrong(error.message, error.help or "", error.code)


def _lane(state: State, vehicle: Vehicle) -> LaneState:
    reach, side = vehicle.extents(state.tilt)
    return LaneState(state.s, state.d, state.s_rate, state.d_rate, reach, side)


def _ego(state: State, aside: float) -> dict[str, float]:
    """The pose as localisation reports it, as of now, `aside` m to the left of where the car is."""
    ego = {name: getattr(state, name) for name in ("x", "y", "heading", "kappa", "v", "a")}
    ego["x"] -= aside * math.sin(state.heading)
    ego["y"] += aside * math.cos(state.heading)
    ego["age"] = 0.0
    return ego


def _object(driver: Driver, state: State, age: float) -> dict[str, Any]:
    numbers = {
        "x": state.x,
        "y": state.y,
        "heading": state.heading,
        "v": state.v,
        "length": driver.vehicle.length,
        "width": driver.vehicle.width,
        "age": age,
    }
    return {"id": driver.id, **_rounded(numbers)}


def _rounded(numbers: dict[str, float]) -> dict[str, float]:
    return {
        name: round(wrap(value) if name == "heading" else value, _DECIMALS.get(name, 6)) + 0.0
        for name, value in numbers.items()
    }


def _columns(plan: Columns) -> Columns:
    columns = {name: [round(x, _DECIMALS.get(name, 6)) + 0.0 for x in plan[name]] for name in COLUMNS}
    columns["heading"] = [round(wrap(value), 6) + 0.0 for value in plan["heading"]]
    # The generated road has the vehicle's grip everywhere, and perception knows it.
    columns["grip"] = [1.0] * len(plan["t"])
    return columns
