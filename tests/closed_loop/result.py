"""What a run says: when the Supervisor reacted, what was driven, and what became of the car. Plain data, rounded for keeping."""

from __future__ import annotations

import math
from typing import Any

from closed_loop.car import Build
from closed_loop.condition import BEGIN, FAULTS, Condition
from closed_loop.loop import LATENCY, Trace
from closed_loop.outside import boxes, clearance, outcome, swept
from closed_loop.road import Road

#: On the road and without contact: `drives_on`, nothing was found; `resumed`, it fell back, and what the planner sent was safe again;
#: `stopped`, at rest. Else: `off_road`, `contact`.
DRIVES_ON, RESUMED, STOPPED, OFF, CONTACT = "drives_on", "resumed", "stopped", "off_road", "contact"


def result(condition: Condition, trace: Trace, road: Road) -> dict[str, Any]:
    """The result of a run, for JSON: times in s, lengths in m, speeds in m/s."""
    build, kind = Build(), FAULTS[condition.fault]
    came = outcome(trace, road, build)
    first = next(((t, stamp, s) for t, stamp, s in trace.decisions if not s.safe and t >= BEGIN), None)
    stopped_driving = next((t for t, doing in trace.doing if t >= BEGIN and doing != "drive"), None)
    approved = [s.given.fallback for t, _, s in trace.decisions if s.safe and (first is None or t < first[0])]
    emergency = approved[-1] if approved else None
    reaction = None
    if first is not None:
        t, stamp, said = first
        reaction = {
            "after": round(t - BEGIN - LATENCY, 3), "stamp": None if math.isnan(stamp) else round(stamp, 3),
            "found": list(said.found), "reasons": list(said.reasons[:6]), "state": said.given.state, "lost": said.lost,
        }  # fmt: skip
    return {
        "name": condition.name,
        "fault": condition.fault,
        "group": kind.group,
        "requirement": kind.requirement,
        "beyond": kind.beyond,
        "track": condition.track,
        "traffic": condition.traffic,
        "place": condition.place,
        "speed": round(trace.speed, 2),
        "unsafe_before": sum(not s.safe for t, _, s in trace.decisions if t < BEGIN),
        "reaction": reaction,
        "below": None if stopped_driving is None else round(stopped_driving - BEGIN, 3),
        "driven": [[round(t, 2), doing] for t, doing in trace.doing],
        "outcome": _word(
            came.rest, came.clearance, bool(came.contact), first is None and stopped_driving is None
        ),
        "clearance": round(came.clearance, 3),
        "gap": None if math.isinf(came.gap) else round(came.gap, 3),
        "contact": came.contact,
        "end": round(came.stopped, 2),
        "way": round(came.way, 1),
        "approved_clearance": None if emergency is None else round(_room(emergency, road, build), 3),
        "planner_failed": trace.failed,
        "planner_said": sorted(
            {line for m in trace.messages for line in m.said if "calculation time" not in line}
        ),
    }


def _word(rest: bool, clearance: float, contact: bool, undisturbed: bool) -> str:
    if contact:
        return CONTACT
    if clearance < 0.0:
        return OFF
    if rest:
        return STOPPED
    return DRIVES_ON if undisturbed else RESUMED


def _room(path: dict[str, list[float]], road: Road, build: Build) -> float:
    """The clearance of the body along a trajectory."""
    return clearance(road, boxes(swept(path), build.length, build.width))
