"""A declaration run: motions, candidates, ground truth, and the checks that nothing declared is impossible."""

from __future__ import annotations

from typing import Any

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.generate.candidates import driving, emergency, path_curvature
from trackmarshal.scenarios.generate.declaration import Declaration, Driver
from trackmarshal.scenarios.generate.limits import Vehicle
from trackmarshal.scenarios.generate.motion import Motion, Profile, State
from trackmarshal.scenarios.ground_truth import LaneState, envelope, worst
from trackmarshal.scenarios.recording import COLUMNS, Columns, Cycle, Recording
from trackmarshal.scenarios.trajectory import wrap

#: Decimals of what is written; curvature is multiplied by squares of speeds.
_DECIMALS = {"kappa": 9}


def run(declared: Declaration, shown: str) -> Recording:
    """Generate all cycles; raises D152 where the declaration asks for something impossible."""
    times = declared.times
    end = times[-1] + declared.horizon
    try:
        ego = _motion(declared, declared.ego, end)
        states = [ego.at(t) for t in times]
        kappa = path_curvature(ego)
    except TrackmarshalError as error:
        raise _placed(error, declared.ego) from error
    moves = [_states(declared, other) for other in declared.others]
    cycles: list[Cycle] = []
    for i, (t, state) in enumerate(zip(times, states)):
        try:
            plans = {
                "driving": driving(ego, t, declared.points, declared.horizon),
                "emergency": emergency(ego, t, declared.braking, kappa),
            }
            for place in (state, ego.at(t + declared.horizon)):
                declared.ego.vehicle.check_state("the car under test", place, declared.road.width)
            for name, plan in plans.items():
                declared.ego.vehicle.check_plan(f"the {name} trajectory at t = {t:g} s", plan)
        except TrackmarshalError as error:
            raise _placed(error, declared.ego) from error
        objects = [_object(d, places[i], declared.age) for d, places in zip(declared.others, moves)]
        candidates = {name: _columns(plan) for name, plan in plans.items()}
        cycles.append(Cycle(t, _rounded(_ego(state)), objects, candidates))
    vehicle = declared.ego.vehicle
    return Recording(
        name=declared.name,
        source=shown,
        cycles=tuple(cycles),
        track=declared.road.borders(),
        params={**vehicle.params, **declared.params},
        tables={**vehicle.tables, **declared.tables},
        ground_truth=_truth(declared, states, moves),
        use=declared.use,
        notes=declared.notes,
    )


def _motion(declared: Declaration, driver: Driver, end: float) -> Motion:
    profile = Profile(driver.v, driver.acceleration)
    return Motion(declared.road, profile, driver.moves, driver.start, end)


def _states(declared: Declaration, driver: Driver) -> list[State]:
    """The states of another car in every cycle, checked."""
    try:
        motion = _motion(declared, driver, declared.times[-1])
        states = [motion.at(t) for t in declared.times]
        for state in states:
            driver.vehicle.check_state(f"the car `{driver.id}`", state, declared.road.width)
    except TrackmarshalError as error:
        raise _placed(error, driver) from error
    return states


def _placed(error: TrackmarshalError, driver: Driver) -> TrackmarshalError:
    """The error with the place of the driver's declaration."""
    return driver.item.wrong(error.message, error.help or "", error.code)


def _truth(
    declared: Declaration, states: list[State], moves: list[list[State]]
) -> dict[str, tuple[bool | None, ...]]:
    """Dynamic by the envelope of every other car; static safe throughout, because the checks have passed."""
    egos = [_lane(state, declared.ego.vehicle) for state in states]
    envelopes = [
        envelope(declared.times, egos, [_lane(p, d.vehicle) for p in places], declared.ego.vehicle.brake)
        for d, places in zip(declared.others, moves)
    ]
    dynamic = tuple(worst([e.truth(t) for e in envelopes]) for t in declared.times)
    return {"dynamic": dynamic, "static": (True,) * len(declared.times)}


def _lane(state: State, vehicle: Vehicle) -> LaneState:
    reach, side = vehicle.extents(state.tilt)
    return LaneState(state.s, state.d, state.s_rate, state.d_rate, reach, side)


def _ego(state: State) -> dict[str, float]:
    return {name: getattr(state, name) for name in ("x", "y", "heading", "kappa", "v", "a")}


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
    return columns
