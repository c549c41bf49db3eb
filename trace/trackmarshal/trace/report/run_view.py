"""What the page of a run says: pictures at two sizes, firings, margins, and every picture in words."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.trace.report.reading import CANDIDATES, DECISIONS, Lane, Rule, Run, number, stretches
from trackmarshal.trace.report.svg import margin_plot, scene, timeline, view
from trackmarshal.trace.report.words import clock, count, decided_by, interval, listed, plain, quantity

#: Firings of one rule on one candidate beyond these are summed up in one row.
MOST_FIRINGS = 12
#: Rows of the tables that say a picture in words.
MOST_ROWS = 40
#: Cycles that the slider can stop at.
MOST_STOPS = 1500


def run_context(run: Run, titles: Mapping[str, str]) -> dict[str, Any]:
    """All that the template of a run page needs; titles of requirements by id."""
    plotted = sorted((r for r in run.rules if r.matters), key=lambda r: (r.first, r.nearness))
    return {
        "run": run,
        "record": run.record,
        "state": state(run),
        "titles": titles,
        "times": f"{clock(run.t[0])} to {clock(run.t[-1])} {run.time_unit}" if run.cycles else "",
        "timeline": _both(lambda layout: timeline.timeline(run, layout, titles)) if run.cycles else None,
        "timeline_words": list(_timeline_words(run)),
        "scene": tuple("".join(scene.scenes(run, frame)) for frame in (view.WIDE, view.NARROW)) if _drawable(run) else None,
        "spacing": plain(scene.spacing(run)),
        "far": plain(scene.FAR),
        "positions": list(_positions(run)),
        "moment": _moment(run),
        "score": _both(lambda layout: margin_plot.score_plot(run, layout)) if run.cycles else None,
        "plots": [_plot(run, rule) for rule in plotted],
        "calm": [row for rule in run.rules if not rule.matters and (row := _calm(rule)) is not None],
        "silent": [rule for rule in run.rules if not rule.matters and _calm(rule) is None],
        "firings": list(firing_rows(run)),
        "truths": [truth_words(truth) for truth in run.record["truths"]],
        "data": _script_data(run) if run.cycles else None,
    }


def state(run: Run) -> str:
    """The run in one sentence."""
    if not run.cycles:
        return "The recording has no cycle: nothing was checked."
    drive = count(run.cycles, "cycle")
    if not run.unsafe_cycles:
        first = f"In all of {drive} the planned trajectory is driven: both candidates are safe."
    else:
        none = sum(decision == "no_safe_trajectory" for decision in run.decision)
        first = f"In {run.unsafe_cycles} of {drive} the planned trajectory is not driven"
        first += f"; in {none} of them no safe trajectory is known." if none else ": the last safe emergency trajectory is."
    fired = run.fired
    if fired:
        names = listed([rule.name for rule in fired[:3]]) if len(fired) <= 3 else f"{', '.join(rule.name for rule in fired[:3])} and {len(fired) - 3} more"
        first += f" {names} fired, first at {clock(fired[0].first)} s."
    outside = [truth["kind"] for truth in run.record["truths"] if not truth["inside"]]
    if outside:
        return f"{first} The verdicts of the {listed(outside)} rules lie outside the ground truth."
    if run.record["truths"]:
        return f"{first} All judged verdicts lie inside the ground truth."
    return f"{first} The recording has no ground truth to hold that against."


def truth_words(truth: Mapping[str, Any]) -> dict[str, Any]:
    """One kind of ground truth: inside or outside, with the times at which it was not met."""
    missed, alarms = ([number(t) for t in truth[name]] for name in ("missed", "false_alarms"))
    return {
        "kind": truth["kind"], "inside": truth["inside"], "judged": truth["judged"],
        "missed": _times(missed), "alarms": _times(alarms), "wrong": len(missed) + len(alarms),
    }  # fmt: skip


def _times(times: Sequence[float]) -> str:
    shown = ", ".join(clock(t) for t in times[:12])
    return f"{shown} and {len(times) - 12} more" if len(times) > 12 else shown


def firing_rows(run: Run) -> Iterator[dict[str, Any]]:
    """A row a firing, in order of time; a rule that flickers gets one row for the rest."""
    rows = []
    for rule in run.rules:
        for candidate, lane in rule.lanes.items():
            for firing in lane.firings[:MOST_FIRINGS]:
                rows.append((firing["cycles"][0], _firing(rule, candidate, firing)))
            rest = lane.firings[MOST_FIRINGS:]
            if rest:
                worst = min(rest, key=lambda f: _sortable(number(f["worst"]["margin"])))
                summed = {**worst, "from": rest[0]["from"], "to": rest[-1]["to"]}
                row = _firing(rule, candidate, summed)
                rows.append((rest[0]["cycles"][0], {**row, "more": f"{count(len(rest), 'more stretch', 'more stretches')} inside this interval"}))
    yield from (row for _, row in sorted(rows, key=lambda item: item[0]))


def _firing(rule: Rule, candidate: str, firing: Mapping[str, Any]) -> dict[str, Any]:
    worst = firing["worst"]
    margin = number(worst["margin"])
    return {
        "rule": rule, "candidate": candidate, "interval": interval(number(firing["from"]), number(firing["to"])),
        "verdicts": " and ".join(firing["verdicts"]), "margin": quantity(margin, worst["unit"]), "exact": worst["margin"],
        "t": clock(number(worst["t"])), "by": decided_by(worst), "span": worst["span"], "line": worst["line"], "more": "",
    }  # fmt: skip


def _sortable(margin: float) -> float:
    return math.inf if math.isnan(margin) else margin


def _plot(run: Run, rule: Rule) -> dict[str, Any]:
    letters = {letter for lane in rule.lanes.values() for letter in lane.verdict}
    return {
        "rule": rule,
        "pictures": _both(lambda layout: margin_plot.margin_plot(run, rule, layout)),
        "rows": list(_margin_rows(run, rule)),
        "inactive": "i" in letters,
        "least": _least(rule),
    }


def _margin_rows(run: Run, rule: Rule) -> Iterator[list[str]]:
    """Time and the margin of each candidate, at most MOST_ROWS evenly spaced cycles and the worst one of each candidate."""
    kept = set(range(0, run.cycles, max(1, math.ceil(run.cycles / MOST_ROWS))))
    kept |= {lane.least["cycle"] for lane in rule.lanes.values() if lane.least is not None}
    for i in sorted(kept):
        yield [clock(run.t[i]), *(_margin_words(rule.lanes.get(candidate), i, rule.unit) for candidate in CANDIDATES)]


def _margin_words(lane: Lane | None, index: int, unit: str) -> str:
    letter = "-" if lane is None else lane.verdict[index]
    if lane is None or letter == "-":
        return "none"
    if letter in "sv":
        return quantity(lane.margin[index], unit) + (" violated" if letter == "v" else "")
    return {"u": "undefined", "i": "inactive", "o": "open"}[letter]


def _calm(rule: Rule) -> dict[str, Any] | None:
    """The least margin of a rule that stayed away from its bound; None where it never had one."""
    found = _least(rule)
    return None if found is None else {"rule": rule, **found}


def _least(rule: Rule) -> dict[str, Any] | None:
    moments = [(number(lane.least["margin"]), candidate, lane.least) for candidate, lane in rule.lanes.items() if lane.least is not None]
    if not moments:
        return None
    margin, candidate, moment = min(moments, key=lambda item: item[0])
    return {
        "margin": quantity(margin, moment["unit"]), "exact": moment["margin"], "candidate": candidate,
        "t": clock(number(moment["t"])), "by": decided_by(moment),
    }  # fmt: skip


def _timeline_words(run: Run) -> Iterator[dict[str, str]]:
    """Per rule and candidate: when it was not simply satisfied."""
    for requirement, rules in run.by_requirement().items():
        for rule in rules:
            for candidate, lane in rule.lanes.items():
                parts: dict[str, list[str]] = {}
                for letter, first, last in stretches(lane.verdict):
                    parts.setdefault(letter, []).append(interval(run.t[first], run.t[last]))
                spoken = [
                    f"{name}: {', '.join(parts[letter][:20])}{' …' if len(parts[letter]) > 20 else ''}"
                    for letter, name in (("v", "violated"), ("u", "undefined"), ("o", "open"), ("i", "inactive"), ("-", "no trajectory"))
                    if letter in parts
                ]
                words = "; ".join(spoken) if spoken else "satisfied throughout"
                yield {"requirement": requirement, "rule": rule.name, "candidate": candidate, "words": words}


def _positions(run: Run) -> Iterator[dict[str, str]]:
    """Where everybody is at the marked cycles."""
    others = scene.object_poses(run)
    marked = scene.marked_cycles(run)
    for i in marked[:: max(1, math.ceil(len(marked) / MOST_ROWS))]:
        ego = scene.ego_pose(run, i)
        spoken = [f"{name}: {poses[i].x:.1f}, {poses[i].y:.1f}" for name, poses in others.items() if i in poses]
        yield {
            "t": clock(run.t[i]),
            "ego": "unknown" if ego is None else f"{ego.x:.1f}, {ego.y:.1f}",
            "v": quantity(number(run.record["ego"]["v"][i]), "", 3),
            "others": "; ".join(spoken[:8]) + (f"; {len(spoken) - 8} more" if len(spoken) > 8 else "") or "none",
            "decision": DECISIONS[run.decision[i]],
        }


def _moment(run: Run) -> dict[str, Any] | None:
    """The cycle in which a rule first fires, from near."""
    found = run.first_firing()
    if found is None:
        return None
    rule, candidate, firing = found
    index = int(firing["cycles"][0])
    # The point that decided is known of the worst cycle only; it is marked where that is the first one.
    where = firing["worst"]["where"] if firing["worst"]["cycle"] == index else []
    pictures = [scene.moment(run, index, where, frame) for frame in (view.WIDE_NEAR, view.NARROW_NEAR)]
    if pictures[0] is None:
        return None
    first = [r for r in run.rules for lane in r.lanes.values() if any(f["cycles"][0] == index for f in lane.firings)]
    names = list(dict.fromkeys(r.name for r in first))
    return {"pictures": pictures, "t": clock(run.t[index]), "rules": listed(names), "candidate": candidate, "one": len(names) == 1}


def _drawable(run: Run) -> bool:
    return any(scene.ego_pose(run, i) is not None for i in range(run.cycles))


def _both(draw: Any) -> tuple[str, str]:
    """A picture for wide screens and paper, and one for phones."""
    return draw(timeline.WIDE), draw(timeline.NARROW)


def _script_data(run: Run) -> str:
    """What the slider needs, as JSON that is safe inside a script element."""
    stops = range(0, run.cycles, max(1, math.ceil(run.cycles / MOST_STOPS)))
    egos = [scene.ego_pose(run, i) for i in stops]
    others = scene.object_poses(run)
    data = {
        "t": [round(run.t[i], 4) for i in stops],
        "unit": run.time_unit,
        "ego": [_row(pose) for pose in egos],
        "others": [[_row(poses[i]) for poses in others.values() if i in poses] for i in stops],
        "paths": {c: [_short_path(run, c, i) for i in stops] for c in CANDIDATES},
        "safe": {c: [run.safe[c][i] for i in stops] for c in CANDIDATES},
        "decision": [DECISIONS[run.decision[i]] for i in stops],
        "rules": [
            {
                "name": rule.name,
                "lanes": [
                    {"c": c, "v": "".join(lane.verdict[i] for i in stops), "m": _unsafe_margins(lane, stops, rule.unit)}
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


def _row(pose: scene.Pose | None) -> list[float] | None:
    if pose is None:
        return None
    return [round(value, 3) for value in (pose.x, pose.y, pose.heading, pose.length or 0.0, pose.width or 0.0)]


def _short_path(run: Run, candidate: str, index: int) -> list[float]:
    path = scene.path_of(run, candidate, index)
    return [round(value, 2) for point in path[::2] + (path[-1:] if len(path) % 2 == 0 else []) for value in point]
