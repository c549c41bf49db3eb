"""What is driven: a state machine of four states, as a table and pure functions (S-1-B-1; docs/supervisor.md)."""

# implements S-1-B-1: what is driven is a table of twelve entries, and nothing else

from __future__ import annotations

import math
from dataclasses import dataclass

from trackmarshal.runtime.contract.cycles import STORED
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door.door import Pose, holds
from trackmarshal.runtime.plan import Plan

#: States.
NO_EMERGENCY_YET = "no_emergency_yet"
DRIVE = "drive"
PREVIOUS_EMERGENCY = "previous_emergency"
NO_SAFE_TRAJECTORY = "no_safe_trajectory"
STATES = (NO_EMERGENCY_YET, DRIVE, PREVIOUS_EMERGENCY, NO_SAFE_TRAJECTORY)

#: What is so in a cycle: it is safe; it is not, and the stored emergency trajectory holds, is lost, or there is none.
SAFE, HOLDS, LOST, NONE = "safe", "holds", "lost", "none"

NEXT = {
    (NO_EMERGENCY_YET, SAFE): DRIVE,
    (NO_EMERGENCY_YET, NONE): NO_EMERGENCY_YET,
    (DRIVE, SAFE): DRIVE,
    (DRIVE, HOLDS): PREVIOUS_EMERGENCY,
    (DRIVE, LOST): NO_SAFE_TRAJECTORY,
    (PREVIOUS_EMERGENCY, SAFE): DRIVE,
    (PREVIOUS_EMERGENCY, HOLDS): PREVIOUS_EMERGENCY,
    (PREVIOUS_EMERGENCY, LOST): NO_SAFE_TRAJECTORY,
    (NO_SAFE_TRAJECTORY, SAFE): DRIVE,
    (NO_SAFE_TRAJECTORY, NONE): NO_SAFE_TRAJECTORY,
}


@dataclass(frozen=True, slots=True)
class Held:
    """All that is kept from cycle to cycle: the state, the stored emergency trajectory, and when the car was last seen on it.

    about: the step that it is of.
    """

    state: str = NO_EMERGENCY_YET
    stored: Plan | None = None
    confirmed: float = -math.inf
    about: int = -1


def advance(
    held: Held, about: int, emergency: Plan | None, now: float, pose: Pose | None, limits: Limits
) -> tuple[Held, str]:
    """What is held after a step, and why a stored trajectory may not be driven ("" where it may, or where it need not).

    emergency: the cycle's emergency trajectory if and only if the cycle is safe. now: NaN where the clock is wrong.
    Raises KeyError for what the table does not know: it cannot occur.
    """
    if emergency is not None:
        return Held(NEXT[held.state, SAFE], emergency, now, about), ""
    if held.stored is None:
        return Held(NEXT[held.state, NONE], about=about), "none_stored"
    confirmed, reason = examine(held.stored, held.confirmed, now, pose, limits)
    if reason:
        return Held(NEXT[held.state, LOST], about=about), reason
    return Held(NEXT[held.state, HOLDS], held.stored, confirmed, about), ""


def examine(
    stored: Plan, confirmed: float, now: float, pose: Pose | None, limits: Limits
) -> tuple[float, str]:
    """Whether a stored trajectory may be driven now: when the car was last seen on it, and why not ("" where it may)."""
    due = None if pose is None else stored.station(pose.t)
    spot = None
    if pose is not None and due is not None:
        spot = stored.nearest(pose.x, pose.y, due - limits.apart, due + limits.apart)
    given = {"now": now, "end": stored.end, "posed": 0, "paced": 0, "away": 0.0, "turn": 0.0}
    given |= {"speed": 0.0, "planned": 0.0}
    if pose is not None and spot is not None:
        given |= {"posed": 1, "away": spot.away, "turn": pose.heading - spot.heading}
        if pose.v is not None:
            given |= {"paced": 1, "speed": pose.v, "planned": spot.v}
        confirmed = max(confirmed, pose.t)
    given["confirmed"] = confirmed
    for demand in STORED:
        if not holds(demand, given, limits):
            return confirmed, demand.fault
    return confirmed, ""
