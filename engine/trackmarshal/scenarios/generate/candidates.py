"""The trajectories that a planner offers in a cycle: driving on as declared, and braking to rest on the same path."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.scenarios.generate.knots import linear
from trackmarshal.scenarios.generate.motion import Motion, Profile, State
from trackmarshal.scenarios.recording import Columns

#: Step in which the braking is integrated, s.
STEP = 0.01


class Braking(NamedTuple):
    """How the emergency trajectory brakes: at most at `deceleration`, with at most `grip` of the tyres, m/s^2, which drag (1/m) helps."""

    points: int
    deceleration: float
    grip: float
    drag: float = 0.0


class Plan(NamedTuple):
    """A trajectory, and where on the road each of its samples lies (of these states, the places alone count)."""

    columns: Columns
    places: list[State]


def driving(motion: Motion, t: float, points: int, horizon: float, own: Profile | None = None) -> Plan:
    """The next `horizon` s on the path of a motion, samples equally long apart.

    The speeds are those of the motion, or of a profile of its `own` that begins at t. Raises D152 where that leads beyond
    either end of the path.
    """
    after = [horizon * i / (points - 1) for i in range(points)]
    begin = motion.profile.at(t)[2]
    if own is None:
        speeds = [motion.profile.at(t + time) for time in after]
        plan = _on_path(motion, [t + time for time in after])
        ways = [way - begin for _, _, way in speeds]
    else:
        speeds = [own.at(time) for time in after]
        ways = [way for _, _, way in speeds]
        if begin + min(ways) < 0.0 or begin + max(ways) > motion.reach:
            message = f"the plan at t = {t:.2f} s goes beyond the path that is driven"
            raise TrackmarshalError("D152", message, help="declare a longer run, or plan slower")
        plan = _on_path(motion, [motion.profile.time_at(begin + way, 0.0, motion.end) for way in ways])
    plan.columns.update(t=after, s=ways, v=[v for _, v, _ in speeds], a=[a for a, _, _ in speeds])
    return plan


#: Braking from some time on, step by step: time, distance, speed, and acceleration until the next step.
Steps = list[tuple[float, float, float, float]]


def emergency(
    motion: Motion,
    t: float,
    braking: Braking,
    kappa: Callable[[float], float],
    steps: Steps | None = None,
) -> Plan:
    """Braking from time t to rest on the path of the declared motion; samples equally long apart, the last at rest.

    `kappa` gives the path's curvature by distance driven. steps: those of `braked`, where they are known. Raises D152 where the bend leaves no grip to
    brake with, or the declared motion ends before the car is at rest.
    """
    steps = braked(motion, t, braking, kappa) if steps is None else steps
    begin = motion.profile.at(t)[2]
    stop, last = steps[-1][0], braking.points - 1
    times = [stop * i / last for i in range(last)]
    samples = [_between(steps, time) for time in times] + [(steps[-1][1], 0.0, steps[-1][3])]
    ends = [motion.profile.time_at(begin + way, t, motion.end) for way, _, _ in samples]
    plan = _on_path(motion, ends)
    ways, speeds, accelerations = (list(column) for column in zip(*samples))
    plan.columns.update(t=[*times, stop], s=ways, v=speeds, a=accelerations)
    return plan


def braked(motion: Motion, t: float, braking: Braking, kappa: Callable[[float], float]) -> Steps:
    """The steps of a braking, however many samples are taken of it; raises D152 as `emergency`."""
    _, v, begin = motion.profile.at(t)
    steps: Steps = [(0.0, 0.0, v, 0.0)]
    while v > 0.0:
        time, way, v, _ = steps[-1]
        left = braking.grip**2 - (v * v * kappa(begin + way)) ** 2
        a = -min(braking.deceleration, math.sqrt(left) + braking.drag * v * v) if left > 0.0 else 0.0
        if a > -0.1:
            message = f"no grip to brake with at t = {t + time:.2f} s: the bend takes {v * v * kappa(begin + way):.1f} m/s^2"
            raise TrackmarshalError(
                "D152", message, help="drive slower, or raise the emergency's share of grip"
            )
        steps[-1] = (time, way, v, a)
        h = min(STEP, -v / a)
        v = v + a * h if h == STEP else 0.0
        steps.append((time + h, way + h * (steps[-1][2] + v) / 2.0, v, a))
    if begin + steps[-1][1] > motion.reach:
        message = f"the braking from t = {t:.2f} s is longer than the driving trajectory"
        raise TrackmarshalError("D152", message, help="lengthen the plan's horizon")
    return steps


def _between(steps: Steps, time: float) -> tuple[float, float, float]:
    """Distance, speed and acceleration at a time before the stop."""
    t0, way, v, a = steps[min(int(time / STEP), len(steps) - 2)]
    h = time - t0
    return way + h * (v + a * h / 2.0), v + a * h, a


def _on_path(motion: Motion, times: list[float]) -> Plan:
    """The geometry of the path at these times of the motion; headings go on without a jump."""
    states = [motion.at(time) for time in times]
    columns = {name: [getattr(state, name) for state in states] for name in ("x", "y", "heading", "kappa")}
    return Plan(columns, states)


def path_curvature(motion: Motion) -> Callable[[float], float]:
    """The path's curvature by distance driven, linear between states 0.1 s apart: for the braking's grip only."""
    count = max(1, math.ceil(motion.end / 0.1))
    times = [motion.end * i / count for i in range(count + 1)]
    return partial(linear, [[motion.profile.at(t)[2], motion.at(t).kappa] for t in times])
