"""What the page of a run says: pictures at two sizes, firings, margins, and every picture in words."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from trackmarshal.trace.report.firings import firing_rows
from trackmarshal.trace.report.reading import Rule, Run, number
from trackmarshal.trace.report.scores import score_rows, scores, size_rows
from trackmarshal.trace.report.settings import setting_rows
from trackmarshal.trace.report.stepper import stepper_data
from trackmarshal.trace.report.svg import margin_plot, poses, scene, score, timeline, view
from trackmarshal.trace.report.tables import (
    fault_rows,
    margin_rows,
    position_rows,
    ranges,
    timeline_rows,
    truth_rows,
)
from trackmarshal.trace.report.words import (
    clock,
    count,
    decided_by,
    listed,
    measured,
    plain,
    spoken_unit,
)

#: Moments that are shown from near.
MOST_MOMENTS = 4


def run_context(run: Run, titles: Mapping[str, str]) -> dict[str, Any]:
    """All that the template of a run page needs; titles of requirements by id."""
    found = scores(run, titles)
    plotted = sorted((r for r in run.rules if r.matters), key=lambda r: (r.first, r.nearness))
    return {
        "run": run,
        "record": run.record,
        "state": state(run),
        "titles": titles,
        "times": f"{clock(run.t[0])} to {clock(run.t[-1])} {run.time_unit}" if run.cycles else "",
        "timeline": _both(lambda layout: timeline.timeline(run, layout, titles)) if run.cycles else None,
        "timeline_words": list(timeline_rows(run)),
        "scene": tuple("".join(scene.scenes(run, frame)) for frame in (view.WIDE, view.NARROW))
        if _drawable(run)
        else None,
        "spacing": plain(poses.spacing(run)),
        "far": plain(poses.FAR),
        "positions": list(position_rows(run)),
        "moments": list(_moments(run)),
        "beginnings": len(run.beginnings()),
        "score": _both(lambda layout: score.score_figure(run, found, layout, f"s{layout.width:.0f}"))
        if run.cycles
        else None,
        "score_rows": list(score_rows(run, found)),
        "sizes": list(size_rows(run)),
        "truth_rows": list(truth_rows(run)),
        "faults": {
            name: list(fault_rows(run, entry["faults"]))
            for name, entry in run.record["candidates"].items()
            if entry["faults"]
        },
        "settings": setting_rows(run),
        "plots": [_plot(run, rule, number) for number, rule in enumerate(plotted)],
        "calm": [row for rule in run.rules if not rule.matters and (row := _calm(rule)) is not None],
        "silent": [rule for rule in run.rules if not rule.matters and _calm(rule) is None],
        "firings": list(firing_rows(run)),
        "truths": [truth_words(run, truth) for truth in run.record["truths"]],
        "data": stepper_data(run, found) if run.cycles else None,
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
        first += (
            f"; in {none} of them no safe trajectory is known."
            if none
            else ": the last safe emergency trajectory is."
        )
    fired = run.fired
    if fired:
        names = (
            listed([rule.name for rule in fired[:3]])
            if len(fired) <= 3
            else f"{', '.join(rule.name for rule in fired[:3])} and {len(fired) - 3} more"
        )
        first += f" {names} fired, first at {clock(fired[0].first)} s."
    kinds = [truth["kind"] for truth in run.record["truths"] if not truth["inside"]]
    outside = [kind if kind.startswith("rule ") else f"{kind} rules" for kind in kinds]
    if outside:
        return f"{first} The verdicts of the {listed(outside)} lie outside the ground truth."
    uncovered = run.record.get("uncovered", ())
    if uncovered:
        first += f" No ground truth was declared of {listed(list(uncovered))}."
    if run.record["truths"]:
        return f"{first} All judged verdicts lie inside the ground truth."
    return f"{first} The recording has no ground truth to hold that against."


def truth_words(run: Run, truth: Mapping[str, Any]) -> dict[str, Any]:
    """One kind of ground truth: inside or outside, with the stretches in which it was not met."""
    return {
        "kind": truth["kind"], "inside": truth["inside"], "judged": truth["judged"],
        "missed": _listed(ranges(run, truth["missed"])), "alarms": _listed(ranges(run, truth["false_alarms"])),
        "wrong": len(truth["missed"]) + len(truth["false_alarms"]),
    }  # fmt: skip


def _listed(found: Sequence[str]) -> str:
    shown = ", ".join(found[:12])
    return f"{shown} and {len(found) - 12} more" if len(found) > 12 else shown


def _plot(run: Run, rule: Rule, number_: int) -> dict[str, Any]:
    letters = {letter for lane in rule.lanes.values() for letter in lane.verdict}
    return {
        "rule": rule,
        "unit": spoken_unit(rule.unit) if rule.unit != "1" else "",
        "pictures": _both(
            lambda layout: margin_plot.margin_plot(run, rule, layout, f"m{layout.width:.0f}-{number_}")
        ),
        "rows": list(margin_rows(run, rule)),
        "inactive": "i" in letters,
        "least": _least(rule),
    }


def _calm(rule: Rule) -> dict[str, Any] | None:
    """The least margin of a rule that stayed away from its bound; None where it never had one."""
    found = _least(rule)
    return None if found is None else {"rule": rule, **found}


def _least(rule: Rule) -> dict[str, Any] | None:
    moments = [
        (number(lane.least["margin"]), candidate, lane.least)
        for candidate, lane in rule.lanes.items()
        if lane.least is not None
    ]
    if not moments:
        return None
    _, candidate, moment = min(moments, key=lambda item: item[0])
    return {
        "margin": measured(moment), "exact": moment["margin"], "candidate": candidate,
        "t": clock(number(moment["t"])), "by": decided_by(moment),
    }  # fmt: skip


def _moments(run: Run) -> Iterator[dict[str, Any]]:
    """The first cycles in which a rule fires for the first time, from near."""
    for index, found in list(run.beginnings().items())[:MOST_MOMENTS]:
        # The point that decided is known of a firing's worst cycle; it is marked where that is this one.
        where = [
            binder for _, _, f in found if f["worst"]["cycle"] == index for binder in f["worst"]["where"]
        ]
        unlike = list({(b["name"], b["value"], b["x"], b["y"]): b for b in where}.values())
        pictures = [scene.moment(run, index, unlike, frame) for frame in (view.WIDE_NEAR, view.NARROW_NEAR)]
        names = list(dict.fromkeys(rule.name for rule, _, _ in found))
        if pictures[0] is not None:
            yield {
                "pictures": pictures,
                "t": clock(run.t[index]),
                "rules": listed(names),
                "one": len(names) == 1,
            }


def _drawable(run: Run) -> bool:
    return any(poses.ego_pose(run, i) is not None for i in range(run.cycles))


def _both(draw: Any) -> tuple[str, str]:
    """A picture for wide screens and paper, and one for phones."""
    return draw(timeline.WIDE), draw(timeline.NARROW)
