"""What a run page's script steps through, as JSON."""

from __future__ import annotations

import json
import math

from trackmarshal.trace.report.reading import CANDIDATES, DECISIONS, Lane, Run
from trackmarshal.trace.report.svg import poses
from trackmarshal.trace.report.words import quantity

#: Cycles that the slider can stop at.
MOST_STOPS = 1500


def stepper_data(run: Run) -> str:
    """What the slider needs, as JSON that is safe inside a script element."""
    stops = range(0, run.cycles, max(1, math.ceil(run.cycles / MOST_STOPS)))
    egos = [poses.ego_pose(run, i) for i in stops]
    others = poses.object_poses(run)
    data = {
        "t": [round(run.t[i], 4) for i in stops],
        "unit": run.time_unit,
        "ego": [_row(pose) for pose in egos],
        "others": [[_row(found[i]) for found in others.values() if i in found] for i in stops],
        "paths": {c: [_short_path(run, c, i) for i in stops] for c in CANDIDATES},
        "safe": {c: [run.safe[c][i] for i in stops] for c in CANDIDATES},
        "decision": [DECISIONS[run.decision[i]] for i in stops],
        "rules": [
            {
                "name": rule.name,
                "lanes": [
                    {
                        "c": c,
                        "v": "".join(lane.verdict[i] for i in stops),
                        "m": _unsafe_margins(lane, stops, rule.unit),
                    }
                    for c, lane in rule.lanes.items()
                ],
            }
            for rule in run.rules
            if rule.fired
        ],
    }
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _unsafe_margins(lane: Lane, stops: range, unit: str) -> dict[str, str]:
    """Margins in words by number of the stop, where the rule is violated."""
    return {str(n): quantity(lane.margin[i], unit, 3) for n, i in enumerate(stops) if lane.verdict[i] == "v"}


def _row(pose: poses.Pose | None) -> list[float] | None:
    if pose is None:
        return None
    return [
        round(value, 3) for value in (pose.x, pose.y, pose.heading, pose.length or 0.0, pose.width or 0.0)
    ]


def _short_path(run: Run, candidate: str, index: int) -> list[float]:
    path = poses.path_of(run, candidate, index)
    return [
        round(value, 2) for point in path[::2] + (path[-1:] if len(path) % 2 == 0 else []) for value in point
    ]
