"""A comparison as text, as JSON, and as a comment for a merge request."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Sequence
from typing import Any

from trackmarshal.comparing.changes import EQUAL, GONE, NEW, Flip, Moment, RuleChange
from trackmarshal.comparing.decisions import DecisionChange
from trackmarshal.comparing.pairs import Comparison
from trackmarshal.ir.margins import undecided
from trackmarshal.units import moment as clocked
from trackmarshal.units import written

#: Spans that are told one by one.
_SPANS = 3


def text(made: Comparison) -> list[str]:
    """Lines for a terminal: what differs, then how many rules do not."""
    lines = []
    for rule in _differing(made):
        lines.append(f"{_name(rule)}: {_said(rule)}")
        lines += [f"  {flip}" for flip in map(_flip, rule.flips)]
        if rule.margins is not None:
            lines.append(f"  margins {moved(rule)}")
    lines += [f"decision: {_decision(one)}" for one in made.decisions]
    return [*lines, _sum(made)]


def markdown(made: Comparison) -> list[str]:
    """Lines of a comment for a merge request: a table of what differs, with where under it."""
    lines = ["### What the edit changes on recordings", "", _sum(made)]
    differing = _differing(made)
    if differing:
        lines += ["", "| rule | is now | verdicts turned | margins, new less old |", "|---|---|---|---|"]
    for rule in differing:
        turned = "; ".join(f"{count} {_cell(way)}" for way, count in _ways(rule.flips).items()) or "none"
        lines.append(
            f"| {_cell(_name(rule))} | {_cell(_said(rule))} | {turned} | {_cell(moved(rule)) if rule.margins else ''} |"
        )
    where = [f"- {_cell(rule.name)}: {_cell(_flip(flip))}" for rule in differing for flip in rule.flips]
    where += [f"- decision: {_cell(_decision(one))}" for one in made.decisions]
    if where:
        lines += ["", "<details><summary>Where</summary>", "", *where, "", "</details>"]
    return lines


def data(made: Comparison) -> dict[str, Any]:
    """Plain data for strict JSON: numbers in SI, times in s."""
    return {
        "equal": made.equal,
        "rules": [_rule(rule) for rule in made.rules],
        "decisions": [
            {"recording": one.recording, "old": one.old, "new": one.new, "cycles": one.cycles, "spans": [list(span) for span in one.spans]}
            for one in made.decisions
        ],
    }  # fmt: skip


def to_json(made: Comparison) -> str:
    """One line of JSON."""
    return json.dumps(data(made), ensure_ascii=True, allow_nan=False)


def _rule(rule: RuleChange) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": rule.name,
        "word": rule.word,
        "unit": rule.unit,
        "cycles": rule.cycles,
        "changed": rule.changed,
    }
    if rule.was:
        entry["was"] = rule.was
    if rule.severity is not None:
        entry["severity"] = {"old": rule.severity[0], "new": rule.severity[1]}
    if rule.word in (NEW, GONE):
        entry["unsafe"] = rule.unsafe
    if rule.undecided:
        entry["undecided"] = rule.undecided
    entry["flips"] = [
        {"recording": one.recording, "candidate": one.candidate, "old": one.old, "new": one.new, "cycles": one.cycles, "spans": [list(span) for span in one.spans]}
        for one in rule.flips
    ]  # fmt: skip
    if rule.margins is not None:
        m = rule.margins
        entry["margins"] = {
            "cycles": m.cycles, "least": m.least, "median": m.median, "most": m.most, "least_at": _at(m.least_at), "most_at": _at(m.most_at),
        }  # fmt: skip
    return entry


def _at(moment: Moment) -> dict[str, Any]:
    return {"recording": moment.recording, "t": moment.t, "candidate": moment.candidate}


def _differing(made: Comparison) -> list[RuleChange]:
    return [rule for rule in made.rules if rule.word != EQUAL or rule.changed or rule.was or rule.severity]


def _name(rule: RuleChange) -> str:
    return f"{rule.name} (was {rule.was})" if rule.was else rule.name


def _said(rule: RuleChange) -> str:
    if rule.word in (NEW, GONE):
        return f"{rule.word}, against a candidate in {rule.unsafe} of {rule.cycles} cycles"
    severity = (
        f", {rule.severity[0] or 'decisive'} before and {rule.severity[1] or 'decisive'} now"
        if rule.severity
        else ""
    )
    undecided = f", {rule.undecided} more are undecided at the end" if rule.undecided else ""
    return f"{rule.word}{severity}, {rule.changed} of {rule.cycles} cycles differ{undecided}"


def _flip(flip: Flip) -> str:
    return f"{flip.recording}, {flip.candidate}: {flip.old} -> {flip.new} in {flip.cycles} cycles, {_spans(flip.spans)}"


def _decision(one: DecisionChange) -> str:
    what = f"{one.old} -> {one.new}" if one.old != one.new else f"{one.old} of another cycle"
    return f"{one.recording}: {what} in {one.cycles} cycles, {_spans(one.spans)}"


def _spans(spans: Sequence[tuple[float, float]]) -> str:
    shown = ", ".join(f"{clocked(a)} to {clocked(b)}" if a != b else clocked(a) for a, b in spans[:_SPANS])
    return f"{shown} s" + (f" and {len(spans) - _SPANS} more times" if len(spans) > _SPANS else "")


def moved(rule: RuleChange) -> str:
    """How the margins of a rule moved, and where; raises ValueError where they did not, or nobody knows."""
    m = rule.margins
    if m is None:
        raise ValueError(f"{rule.name} has no margins that moved")

    unit = undecided(rule.unit)

    def at(value: float, moment: Moment) -> str:
        return f"{_signed(value, unit)} ({moment.recording}, {moment.candidate}, {clocked(moment.t)} s)"

    return f"by {at(m.least, m.least_at)} to {at(m.most, m.most_at)}, median {_signed(m.median, unit)}, in {m.cycles} cycles"


def _signed(value: float, unit: str) -> str:
    return ("+" if value > 0 and math.isfinite(value) else "") + written(value, unit)


def _ways(flips: Iterable[Flip]) -> dict[str, int]:
    ways: dict[str, int] = {}
    for flip in flips:
        way = f"{flip.old} -> {flip.new}"
        ways[way] = ways.get(way, 0) + flip.cycles
    return ways


def _sum(made: Comparison) -> str:
    counts: dict[str, int] = {}
    for rule in made.rules:
        counts[rule.word] = counts.get(rule.word, 0) + 1
    cycles = sum(one.cycles for one in made.decisions)
    said = ", ".join(f"{count} {word}" for word, count in counts.items()) or "none"
    return f"rules: {said}; decisions differ in {cycles} cycles"


def _cell(text: str) -> str:
    """Text in which Markdown sees nothing but text."""
    for char in "\\`*_{}[]<>#|~":
        text = text.replace(char, f"\\{char}")
    return "".join(char if char.isprintable() else " " for char in text)
