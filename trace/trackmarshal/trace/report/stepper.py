"""What a run page's script steps through, as JSON."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

from trackmarshal.trace.report.reading import CANDIDATES, DECISIONS, VERDICTS, Lane, Run
from trackmarshal.trace.report.scores import Score
from trackmarshal.trace.report.svg import poses
from trackmarshal.trace.report.words import quantity, spoken_unit, told

#: Cycles that the slider can stop at.
MOST_STOPS = 1500


def stepper_data(run: Run, found: Sequence[Score]) -> str:
    """What the slider needs, as JSON that is safe inside a script element: numbers behind verdicts and scores with the rest."""
    every = range(0, run.cycles, max(1, math.ceil(run.cycles / MOST_STOPS)))
    stops = sorted({*every, *(int(i) for entry in run.record.get("told", ()) for i in entry["cycles"])})
    egos = [poses.ego_pose(run, i) for i in stops]
    others = poses.object_poses(run)
    data = {
        "t": [round(run.t[i], 4) for i in stops],
        "unit": run.time_unit,
        "ego": [_row(pose) for pose in egos],
        "others": [[_row(found[i]) for found in others.values() if i in found] for i in stops],
        "paths": {c: [_short_path(run, c, i) for i in stops] for c in CANDIDATES},
        "decision": [DECISIONS[run.decision[i]] for i in stops],
        "rules": [
            {
                "name": rule.name,
                "unit": "" if rule.unit == "1" else spoken_unit(rule.unit),
                "lanes": [
                    {"c": c, "v": "".join(lane.verdict[i] for i in stops), "m": _unsafe_margins(lane, stops)}
                    for c, lane in rule.lanes.items()
                ],
            }
            for rule in run.rules
            if rule.fired
        ],
        "scores": [_score(score, stops) for score in found],
        **_told(run, stops),
    }
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def _score(score: Score, stops: Sequence[int]) -> dict[str, Any]:
    """Margins by their sizes to three digits, in words where they are infinite, None where there is none."""
    lanes = [
        {
            "c": candidate, "v": "".join(lane.verdict[i] for i in stops), "m": [_short(lane.margin[i]) for i in stops],
            "by": [score.by[candidate][i] for i in stops],
        }
        for candidate, lane in score.lanes.items()
    ]  # fmt: skip
    return {"name": score.requirement, "rules": [rule.name for rule in score.rules], "lanes": lanes}


def _short(margin: float) -> float | str | None:
    if math.isnan(margin):
        return None
    return float(f"{margin:.3g}") if math.isfinite(margin) else quantity(margin, "")


def _told(run: Run, stops: Sequence[int]) -> dict[str, Any]:
    """Lines, each once, and for each rule and candidate by stop its verdict, its margin in words, and the places of its lines."""
    lines: dict[tuple[str, str], int] = {}
    place = {i: stop for stop, i in enumerate(stops)}
    rules = {rule.name: rule for rule in run.rules}
    entries = []
    for entry in run.record.get("told", ()):
        rule = rules[entry["rule"]]
        lane = rule.lanes[entry["candidate"]]
        at = {
            str(place[int(i)]): [
                VERDICTS[lane.verdict[int(i)]],
                quantity(lane.margin[int(i)], rule.unit) if lane.verdict[int(i)] in "sv" else "",
                [lines.setdefault(told(line), len(lines)) for line in said],
            ]
            for i, said in entry["cycles"].items()
        }
        entries.append({"rule": rule.name, "c": entry["candidate"], "at": at, "untold": entry["untold"]})
    return {"lines": list(lines), "told": entries}


def _unsafe_margins(lane: Lane, stops: Sequence[int]) -> dict[str, float | str]:
    """Margins to three digits by number of the stop, where the rule is violated."""
    found: dict[str, float | str] = {}
    for stop, i in enumerate(stops):
        if lane.verdict[i] == "v":
            margin = lane.margin[i]
            found[str(stop)] = float(f"{margin:.3g}") if math.isfinite(margin) else quantity(margin, "")
    return found


def _row(pose: poses.Pose | None) -> list[float] | None:
    if pose is None:
        return None
    values = (pose.x, pose.y, pose.heading, pose.length or 0.0, pose.width or 0.0)
    return [round(value, digits) for value, digits in zip(values, (2, 2, 4, 2, 2))]


def _short_path(run: Run, candidate: str, index: int) -> list[float]:
    """x and y in turn, of every third point and the last one."""
    path = poses.path_of(run, candidate, index)
    return [round(value, 1) for point in (path[:-1:3] + path[-1:]) for value in point]
