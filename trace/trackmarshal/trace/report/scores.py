"""How far each requirement is from its limits in every cycle, without a unit: the least of its rules' margins, each by a size of its own."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

from trackmarshal.trace.report.reading import CANDIDATES, Lane, Rule, Run
from trackmarshal.trace.report.words import clock, plain, quantity

#: Letters of verdicts from the worst to the mildest: of several rules, the first of them counts.
_WORST = "vuosi-"


@dataclass(frozen=True, slots=True)
class Size:
    """What margins of a rule are divided by, in the unit in which they are shown, and where that is from."""

    value: float
    source: str


@dataclass(frozen=True, slots=True)
class Score:
    """A requirement over a run. lanes: by candidate the worst verdict of its rules, and the least of their margins by their sizes (NaN: there
    is none); by: by candidate the place of the rule among `rules` that this is of, -1 where it is of none."""

    requirement: str
    title: str
    rules: Sequence[Rule]
    lanes: Mapping[str, Lane]
    by: Mapping[str, Sequence[int]]


def size_of(rule: Rule) -> Size:
    """The scale that the spec declares for what the rule measures; else the median of the sizes of its margins in this run."""
    if rule.scale is not None:
        return Size(rule.scale, "the spec's scale")
    sizes = [abs(m) for lane in rule.lanes.values() for m in lane.measured if m != 0.0]
    return Size(median(sizes), "its median in this run") if sizes else Size(1.0, "no margin but 0")


def still(rule: Rule) -> bool:
    """Whether a rule holds with a margin of 0 wherever it has one: nothing can be seen of it over time."""
    margins = [m for lane in rule.lanes.values() for m in lane.measured]
    letters = {letter for lane in rule.lanes.values() for letter in lane.verdict}
    return bool(margins) and not any(margins) and letters <= set("si-")


def scores(run: Run, titles: Mapping[str, str]) -> list[Score]:
    """All requirements by name; rules without one come last."""
    groups: dict[str, list[Rule]] = {}
    for rule in run.rules:
        for requirement in rule.requirements or ("",):
            groups.setdefault(requirement, []).append(rule)
    named = sorted(groups.items(), key=lambda item: (item[0] == "", item[0]))
    return [_score(run, name, titles.get(name, ""), rules) for name, rules in named]


def _score(run: Run, requirement: str, title: str, rules: Sequence[Rule]) -> Score:
    sizes = [size_of(rule).value for rule in rules]
    shown = [not still(rule) for rule in rules]
    lanes, by = {}, {}
    for candidate in CANDIDATES:
        each = [(place, rule.lanes[candidate]) for place, rule in enumerate(rules) if candidate in rule.lanes]
        if not each:
            continue
        letters = [min(said, key=_WORST.index) for said in zip(*(lane.verdict for _, lane in each))]
        known = [_sized(lane, sizes[place], place) for place, lane in each if shown[place]]
        least = [min(filter(None, of), default=_NONE) for of in zip(*known)] or [_NONE] * run.cycles
        lanes[candidate] = Lane("".join(letters), [margin for margin, _ in least], None, ())
        by[candidate] = [place for _, place in least]
    return Score(requirement, title, rules, lanes, by)


#: The margin of no rule, and its place.
_NONE = (math.nan, -1)


def _sized(lane: Lane, size: float, place: int) -> list[tuple[float, int] | None]:
    """Per cycle the margin of the rule in this place by its size, and the place; None where it has no margin."""
    return [
        (margin / size, place) if letter in "sv" and not math.isnan(margin) else None
        for margin, letter in zip(lane.margin, lane.verdict)
    ]


def score_rows(run: Run, found: Sequence[Score]) -> Iterator[dict[str, Any]]:
    """A row a requirement: its least margin by size, when, on which candidate, by which rule, and what that is in its unit."""
    for score in found:
        least = [
            (margin, i, candidate)
            for candidate, lane in score.lanes.items()
            for i, margin in enumerate(lane.margin)
            if not math.isnan(margin)
        ]
        row = {
            "requirement": score.requirement or "without a requirement",
            "title": score.title,
            "least": "none",
            "when": "",
            "rule": "",
            "margin": "",
        }
        if least:
            margin, i, candidate = min(least, key=lambda each: each[:2])
            rule = score.rules[score.by[candidate][i]]
            row |= {
                "least": quantity(margin, "", 3), "when": f"{clock(run.t[i])} {run.time_unit}, {candidate}", "rule": rule.name,
                "margin": quantity(rule.lanes[candidate].margin[i], rule.unit),
            }  # fmt: skip
        yield row


def size_rows(run: Run) -> Iterator[dict[str, str]]:
    """What 1 is, for each rule that has a margin."""
    for rule in run.rules:
        if any(letter in "sv" for lane in rule.lanes.values() for letter in lane.verdict):
            size = size_of(rule)
            said = "not drawn: its margin is 0 in every cycle" if still(rule) else size.source
            yield {
                "rule": rule.name,
                "size": plain(size.value) if rule.unit == "1" else quantity(size.value, rule.unit),
                "source": said,
            }
