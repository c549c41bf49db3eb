"""Drives of real vehicles: how often rules fired, by hour and by kilometre, and how near each came to firing."""

from __future__ import annotations

import math
from collections.abc import Iterator

from trackmarshal.records.runs import DriveFacts, LeastMargin, RunSummary
from trackmarshal.trace.case.model import Block, Code, Fixed, Given, Line, Number, Status
from trackmarshal.trace.case.writing import Writing, given, joined
from trackmarshal.trace.graph.graph import Node
from trackmarshal.trace.report.words import clock

#: How sure one may be of what a drive bounds, in percent.
_SURE = 95
#: What is said of a run that contradicts its ground truth, or is otherwise than it is to be.
_CONTRADICTS = frozenset({"T243", "T244", "T245"})


def field(writing: Writing) -> Iterator[Block]:
    """Each run of a log of a real vehicle."""
    origins = {str(one.path): one for one in writing.given.project.scenarios if one.origin == "field"}
    runs = [run for run in writing.given.runs if run.scenario in origins]
    if not runs:
        yield writing.missing("field.none")
    for run in runs:
        title: Line = (Given(origins[run.scenario].title or run.scenario),)
        blocks = (
            [writing.missing("field.no_drive")]
            if run.drive is None
            else list(_drive(writing, run, run.drive))
        )
        yield writing.part(title, blocks, level=3)


def _drive(writing: Writing, run: RunSummary, drive: DriveFacts) -> Iterator[Block]:
    node = writing.graph.nodes["run", run.scenario]
    fired = sum(drive.firings.values())
    rates = writing.line(
        "field.rates", hour=_number(run, "per hour", fired / drive.hours), km=_number(run, "per km", fired / drive.km) if drive.km > 0 else Fixed("–")
    )  # fmt: skip
    most = at_most(fired, 1 - _SURE / 100)
    bound = writing.line(
        "field.bound", hour=_number(run, "at most per hour", most / drive.hours), km=_number(run, "at most per km", most / drive.km) if drive.km > 0 else Fixed("–"),
        sure=_number(run, "confidence", _SURE),
    )  # fmt: skip
    facts: list[tuple[str, Line]] = [
        ("label.outcome", (came_to(writing, node),)),
        ("label.hours", (writing.said_number(node, "hours"), Fixed(" h"))),
        ("label.way", (writing.said_number(node, "km"), Fixed(" km"))),
        ("label.cycles", (writing.said_number(node, "cycles"),)),
        ("label.firings", (writing.said_number(node, "firings"),)),
        ("label.rates", rates),
        ("label.bound", bound),
        ("label.firing", joined([(Code(rule), Fixed(" "), _number(run, f"firings {rule}", number)) for rule, number in sorted(drive.firings.items())])),
        ("label.silent", joined([given(rule) for rule in _silent(run)])),
    ]  # fmt: skip
    yield writing.facts(facts)
    yield writing.table((("column.rule", 3.0), ("column.candidate", 1.5), ("column.least", 2.0), ("column.when_found", 1.5)), (
        [
            (Code(one.rule),), given(one.candidate),
            (writing.said_number(node, f"least {one.rule} {one.candidate}"),), (_at(run, one), Fixed(" s")),
        ]
        for one in drive.least
    ))  # fmt: skip


def came_to(writing: Writing, run: Node) -> Status:
    """What a run came to: one that contradicts what it is to show has failed, and has not just been made."""
    wrong = {
        str(finding.subject) for finding in writing.given.matrix.findings if finding.code in _CONTRADICTS
    }
    return Status("failed" if run.id in wrong else run.attributes["outcome"])


def at_most(events: int, risk: float) -> float:
    """How many events are to be expected at most of as much as was seen, where it had so few: those of which so few are seen with this probability, if each comes by itself."""
    low, high = 0.0, events + 10.0 + 10.0 * math.sqrt(events + 1)
    for _ in range(100):
        middle = (low + high) / 2
        seen = sum(
            math.exp(number * math.log(middle) - middle - math.lgamma(number + 1))
            for number in range(events + 1)
        )
        low, high = (middle, high) if seen > risk else (low, middle)
    return high


def _silent(run: RunSummary) -> list[str]:
    """Rules that had nothing to say in any cycle: of them the drive shows nothing."""
    return [
        facts.rule
        for facts in run.rules
        if not any(
            number
            for count in facts.counts.values()
            for verdict, number in count.items()
            if verdict != "inactive"
        )
    ]


def _at(run: RunSummary, one: LeastMargin) -> Number:
    """When it was: a drive takes hours, and four digits of seconds name another moment."""
    return Number(f"drive/{run.scenario}/t {one.rule} {one.candidate}", clock(one.t))


def _number(run: RunSummary, what: str, value: float) -> Number:
    return Number(f"drive/{run.scenario}/{what}", f"{value:.4g}")


__all__ = ["at_most", "field"]
