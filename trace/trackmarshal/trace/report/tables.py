"""Pictures in words: the tables that say the same as scene, timeline and margin plots."""

from __future__ import annotations

import math
from collections.abc import Iterator

from trackmarshal.trace.report.reading import CANDIDATES, DECISIONS, Lane, Rule, Run, number, stretches
from trackmarshal.trace.report.svg import poses
from trackmarshal.trace.report.words import clock, interval, quantity

#: Rows of one table.
MOST_ROWS = 40


def timeline_rows(run: Run) -> Iterator[dict[str, str]]:
    """Per rule and candidate: when it was not simply satisfied."""
    for requirement, rules in run.by_requirement().items():
        for rule in rules:
            for candidate, lane in rule.lanes.items():
                parts: dict[str, list[str]] = {}
                for letter, first, last in stretches(lane.verdict):
                    parts.setdefault(letter, []).append(interval(run.t[first], run.t[last]))
                spoken = [
                    f"{name}: {', '.join(parts[letter][:20])}{' …' if len(parts[letter]) > 20 else ''}"
                    for letter, name in (
                        ("v", "violated"),
                        ("u", "undefined"),
                        ("o", "open"),
                        ("i", "inactive"),
                        ("-", "no trajectory"),
                    )
                    if letter in parts
                ]
                words = "; ".join(spoken) if spoken else "satisfied throughout"
                yield {"requirement": requirement, "rule": rule.name, "candidate": candidate, "words": words}


def position_rows(run: Run) -> Iterator[dict[str, str]]:
    """Where everybody is at the marked cycles."""
    others = poses.object_poses(run)
    marked = poses.marked_cycles(run)
    for i in marked[:: max(1, math.ceil(len(marked) / MOST_ROWS))]:
        ego = poses.ego_pose(run, i)
        spoken = [
            f"{name}: {found[i].x:.1f}, {found[i].y:.1f}" for name, found in others.items() if i in found
        ]
        yield {
            "t": clock(run.t[i]),
            "ego": "unknown" if ego is None else f"{ego.x:.1f}, {ego.y:.1f}",
            "v": quantity(number(run.record["ego"]["v"][i]), "", 3),
            "others": "; ".join(spoken[:8]) + (f"; {len(spoken) - 8} more" if len(spoken) > 8 else "")
            or "none",
            "decision": DECISIONS[run.decision[i]],
        }


def margin_rows(run: Run, rule: Rule) -> Iterator[list[str]]:
    """Time and the margin of each candidate, at most MOST_ROWS evenly spaced cycles and the worst one of each candidate."""
    kept = set(range(0, run.cycles, max(1, math.ceil(run.cycles / MOST_ROWS))))
    kept |= {lane.least["cycle"] for lane in rule.lanes.values() if lane.least is not None}
    for i in sorted(kept):
        yield [
            clock(run.t[i]),
            *(_margin_words(rule.lanes.get(candidate), i, rule.unit) for candidate in CANDIDATES),
        ]


def _margin_words(lane: Lane | None, index: int, unit: str) -> str:
    letter = "-" if lane is None else lane.verdict[index]
    if lane is None or letter == "-":
        return "none"
    if letter in "sv":
        return quantity(lane.margin[index], unit) + (" violated" if letter == "v" else "")
    return {"u": "undefined", "i": "inactive", "o": "open"}[letter]
