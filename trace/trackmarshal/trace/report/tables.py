"""Pictures in words: the tables that say the same as scene, timeline and margin plots."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.trace.report.reading import CANDIDATES, DECISIONS, Lane, Rule, Run, number, stretches
from trackmarshal.trace.report.svg import poses
from trackmarshal.trace.report.words import clock, count, interval, quantity

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
                    f"{name}: {', '.join(parts[letter][:20])}{f' and {len(parts[letter]) - 20} more' if len(parts[letter]) > 20 else ''}"
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
    """Stretches in which both verdicts of a rule stay as they are, with how far its margins go in each: at most MOST_ROWS."""
    letters = zip(*(_letters(run, rule.lanes.get(candidate)) for candidate in CANDIDATES))
    found = [(first, last) for _, first, last in stretches(letters)]
    lanes = [rule.lanes.get(candidate) for candidate in CANDIDATES]
    for first, last in found[:MOST_ROWS]:
        yield [
            interval(run.t[first], run.t[last]),
            *(_margin_words(lane, first, last, rule.unit) for lane in lanes),
        ]
    if len(found) > MOST_ROWS:
        first = found[MOST_ROWS][0]
        rest = count(len(found) - MOST_ROWS, "more stretch", "more stretches")
        yield [
            f"{interval(run.t[first], run.t[-1])}: {rest}",
            *(_margin_words(lane, first, run.cycles - 1, rule.unit) for lane in lanes),
        ]


def _letters(run: Run, lane: Lane | None) -> str:
    return "-" * run.cycles if lane is None else lane.verdict


def _margin_words(lane: Lane | None, first: int, last: int, unit: str) -> str:
    """What a candidate's margin does from one cycle to another: its ends, and the least one where that is neither."""
    letters = "-" if lane is None else lane.verdict[first : last + 1]
    said = " and ".join(name for letter, name in _SPOKEN.items() if letter in letters)
    if lane is None or not set(letters) & set("sv"):
        return said
    margins = [m for m in lane.margin[first : last + 1] if not math.isnan(m)]
    if not margins:
        return said
    ends = [quantity(m, unit) for m in (margins[0], margins[-1])]
    words = ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}"
    least = quantity(min(margins), unit)
    words += "" if least in ends else f", least {least}"
    return f"{words}{f' {said}' if said else ''}"


#: What is said of a letter; nothing of what simply holds.
_SPOKEN = {"v": "violated", "u": "undefined", "o": "open", "i": "inactive", "-": "none"}


def truth_rows(run: Run) -> Iterator[dict[str, str]]:
    """The ground truth, kind by kind: when it asks for what, and when the verdicts are otherwise."""
    names = {True: "must be safe", False: "must be unsafe", None: "either"}
    told = {truth["kind"]: truth for truth in run.record["truths"]}
    for kind, truth in run.truth.items():
        if any(value is not None for value in truth):
            words = [
                f"{names[value]}: {interval(run.t[first], run.t[last])}"
                for value, first, last in stretches(truth)
            ]
            found = told.get(kind)
            wrong = [
                f"{name}: {', '.join(ranges(run, found[field]))}"
                for field, name in (("missed", "missed"), ("false_alarms", "false alarm"))
                if found is not None and found[field]
            ]
            said = (
                "not judged: it is about none of the rules" if found is None else "; ".join(wrong) or "inside"
            )
            more = f"; {len(words) - MOST_ROWS} more" if len(words) > MOST_ROWS else ""
            yield {"kind": kind, "words": "; ".join(words[:MOST_ROWS]) + more, "verdict": said}


def ranges(run: Run, times: Sequence[Any]) -> list[str]:
    """Times of cycles, those of consecutive ones together: `10.4 to 12.1`."""
    wanted = [number(t) for t in times]
    places = {number(t): i for i, t in enumerate(run.record["t"])}
    if any(t not in places for t in wanted):  # no number, or of no cycle
        return [clock(t) for t in wanted]
    found = {places[t] for t in wanted}
    there = stretches(i in found for i in range(run.cycles))
    return [interval(run.t[first], run.t[last]) for value, first, last in there if value]


def fault_rows(run: Run, faults: Sequence[Mapping[str, Any]]) -> Iterator[dict[str, str]]:
    """Breaches of the input contract, consecutive cycles with the same ones together: at most MOST_ROWS."""
    rows: list[tuple[int, int, list[str]]] = []
    for fault in faults:
        cycle, said = int(fault["cycle"]), list(fault["faults"])
        if rows and rows[-1][1] == cycle - 1 and rows[-1][2] == said:
            rows[-1] = rows[-1][0], cycle, said
        else:
            rows.append((cycle, cycle, said))
    for first, last, said in rows[:MOST_ROWS]:
        more = f"; {len(said) - 5} more" if len(said) > 5 else ""
        yield {
            "when": f"{interval(run.t[first], run.t[last])} {run.time_unit}",
            "said": "; ".join(said[:5]) + more,
        }
    if len(rows) > MOST_ROWS:
        first = rows[MOST_ROWS][0]
        yield {
            "when": f"{interval(run.t[first], run.t[rows[-1][1]])} {run.time_unit}",
            "said": f"in {len(rows) - MOST_ROWS} more stretches",
        }
