"""What is driven: a state machine of four states, as a table and pure functions (S-1-B-1; docs/supervisor.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door import Pose
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
class Memory:
    """All that is kept from cycle to cycle: the state, the stored emergency trajectory, and when the car was last seen on it."""

    state: str = NO_EMERGENCY_YET
    stored: Plan | None = None
    confirmed: float = -math.inf


def advance(
    memory: Memory, emergency: Plan | None, now: float, pose: Pose | None, limits: Limits
) -> tuple[Memory, str]:
    """The memory after a cycle, and why nothing stored is driven ("" where it is, or need not be).

    emergency: the emergency trajectory of the cycle, if and only if the cycle is safe. now: NaN where the clock is wrong.
    Raises KeyError for what the table does not know: it cannot occur.
    """
    if emergency is not None:
        return Memory(NEXT[memory.state, SAFE], emergency, now), ""
    if memory.stored is None:
        return Memory(NEXT[memory.state, NONE]), "none_stored"
    confirmed, reason = examine(memory.stored, memory.confirmed, now, pose, limits)
    if reason:
        return Memory(NEXT[memory.state, LOST]), reason
    return Memory(NEXT[memory.state, HOLDS], memory.stored, confirmed), ""


def examine(
    stored: Plan, confirmed: float, now: float, pose: Pose | None, limits: Limits
) -> tuple[float, str]:
    """Whether a stored trajectory may be driven now: when the car was last seen on it, and why not ("" where it may)."""
    if now > stored.end:
        return confirmed, "expired"
    planned = None if pose is None else stored.pose(pose.t)
    if planned is not None and pose is not None:
        away = math.hypot(pose.x - planned[0], pose.y - planned[1])
        turned = abs(math.remainder(pose.heading - planned[2], math.tau))
        if not (away <= limits.apart and turned <= limits.turned):
            return confirmed, "apart"
        confirmed = max(confirmed, pose.t)
    if not now - confirmed <= limits.blind:
        return confirmed, "unconfirmed"
    return confirmed, ""
