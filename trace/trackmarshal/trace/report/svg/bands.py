"""Rows of what held when: the model of a timeline, from a run."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from trackmarshal.trace.report.reading import (
    CANDIDATES,
    DECISIONS,
    VERDICTS,
    Rule,
    Run,
    number,
    stretches,
)
from trackmarshal.trace.report.words import clock, decided_by, interval, measured

#: What is written into a stretch, the longest that fits; textures carry the same, so colour never is alone.
_WORDS = {
    "violated": ("violated", "V"),
    "undefined": ("undefined", "?"),
    "open": ("open", "O"),
    "inactive": ("inactive", "·"),
}


@dataclass(frozen=True, slots=True)
class Segment:
    """A stretch of cycles that look alike; `style` is a class of the page's style."""

    style: str
    first: int
    last: int
    words: tuple[str, ...] = ()
    note: str = ""


@dataclass(frozen=True, slots=True)
class Lane:
    """One strip; `mark` stands before it, `flags` are cycles that are pointed at from below."""

    mark: str
    segments: Sequence[Segment]
    flags: Sequence[Segment] = ()


@dataclass(frozen=True, slots=True)
class Row:
    label: str
    note: str
    lanes: Sequence[Lane]


@dataclass(frozen=True, slots=True)
class Group:
    heading: str
    rows: Sequence[Row]


def overall(run: Run) -> Group:
    """Ground truth with what the rules say beside it, each candidate, and the decision."""
    rows = []
    for kind, truth in run.truth.items():
        if any(value is not None for value in truth):
            rows += [_truth_row(run, kind, truth), _kind_row(run, kind, truth)]
    for candidate in CANDIDATES:
        if any(value is not None for value in run.safe[candidate]):
            rows.append(
                Row(
                    f"{candidate} trajectory",
                    f"all rules on the {candidate} trajectory",
                    [Lane("", _safe(run, candidate))],
                )
            )
    rows.append(Row("decision", "what is driven", [Lane("", list(_decisions(run)))]))
    return Group("Overall", rows)


def rule_groups(run: Run, requirement_titles: Mapping[str, str]) -> list[Group]:
    """A group a requirement, a row a rule, a lane a candidate."""
    groups = []
    for requirement, rules in run.by_requirement().items():
        title = requirement_titles.get(requirement, "")
        heading = f"{requirement}{'  ' + title if title else ''}" if requirement else "without a requirement"
        groups.append(Group(heading, [_rule_row(run, rule) for rule in rules]))
    return groups


def _truth_row(run: Run, kind: str, truth: Sequence[bool | None]) -> Row:
    look = {
        True: ("must-safe", ("must be safe", "safe", "S")),
        False: ("must-unsafe", ("must be unsafe", "unsafe", "U")),
        None: ("free", ("either", "")),
    }
    segments = _segments(run, truth, lambda v: look[v][0], lambda v: look[v][1], lambda v: look[v][1][0])
    if kind.startswith("rule "):
        name = kind.removeprefix("rule ")
        return Row(f"truth: {name}", f"what a right verdict of the {kind} is", [Lane("", segments)])
    return Row(f"{kind} ground truth", f"what a right verdict of the {kind} rules is", [Lane("", segments)])


def _kind_row(run: Run, kind: str, truth: Sequence[bool | None]) -> Row:
    unsafe = run.kind_unsafe(kind)
    segments = _segments(
        run,
        unsafe,
        lambda v: "violated" if v else "satisfied",
        lambda v: ("unsafe", "V") if v else ("safe", ""),
        lambda v: "unsafe" if v else "safe",
    )
    judged = any(
        one["kind"] == kind for one in run.record["truths"]
    )  # where it is about none of the rules, none is wrong
    wrong = [
        "" if not judged else "missed" if t is False and not u else "false alarm" if t is True and u else ""
        for t, u in zip(truth, unsafe)
    ]
    flags = [
        s
        for s in _segments(
            run,
            wrong,
            lambda v: "outside" if v else "",
            lambda v: (v,),
            lambda v: f"{v}: outside the ground truth",
        )
        if s.style
    ]
    if kind.startswith("rule "):
        name = kind.removeprefix("rule ")
        return Row(f"verdict: {name}", f"the {kind}, as its truth asks for it", [Lane("", segments, flags)])
    return Row(f"{kind} rules", f"any {kind} rule on any candidate", [Lane("", segments, flags)])


def _safe(run: Run, candidate: str) -> list[Segment]:
    look = {
        True: ("satisfied", ("safe",)),
        False: ("violated", ("unsafe", "V")),
        None: ("absent", ("none", "")),
    }
    return _segments(
        run, run.safe[candidate], lambda v: look[v][0], lambda v: look[v][1], lambda v: look[v][1][0]
    )


def _decisions(run: Run) -> Iterable[Segment]:
    look = {
        "drive": ("drive", ("drive", "D")),
        "previous_emergency": ("previous", ("emergency trajectory kept", "emergency", "E")),
        "no_safe_trajectory": ("nothing", ("none safe", "N")),
    }
    return _segments(run, run.decision, lambda v: look[v][0], lambda v: look[v][1], lambda v: DECISIONS[v])


def _rule_row(run: Run, rule: Rule) -> Row:
    lanes = []
    for candidate, lane in rule.lanes.items():
        worst = {f["cycles"][0]: f["worst"] for f in lane.firings}

        def note(style: str, first: int, worst: Mapping[int, Any] = worst) -> str:
            moment = worst.get(first)
            if moment is None or style not in ("violated", "undefined", "open"):
                return style
            size = (
                ""
                if style == "undefined"
                else f", worst {measured(moment, False)} at {clock(number(moment['t']))} s"
            )
            where = decided_by(moment)
            return f"{style}{size}{'; ' + where if where else ''}"

        segments = [
            Segment(
                VERDICTS[letter], first, last, _WORDS.get(VERDICTS[letter], ()),
                f"{rule.name}, {candidate}, {_when(run, first, last)}: {note(VERDICTS[letter], first)}",
            )
            for letter, first, last in stretches(lane.verdict)
        ]  # fmt: skip
        lanes.append(Lane(candidate[0].upper(), segments))
    label = rule.name + (" (assumed)" if rule.what == "assume" else "")
    return Row(label, rule.title or rule.name, lanes)


def _segments(
    run: Run,
    values: Iterable[Any],
    style: Callable[[Any], str],
    words: Callable[[Any], tuple[str, ...]],
    note: Callable[[Any], str],
) -> list[Segment]:
    return [
        Segment(style(value), first, last, words(value), f"{_when(run, first, last)}: {note(value)}")
        for value, first, last in stretches(values)
    ]


def _when(run: Run, first: int, last: int) -> str:
    return f"{interval(run.t[first], run.t[last])} {run.time_unit}"
