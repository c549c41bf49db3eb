"""Fault-tolerant time intervals against what the limits of a Supervisor come to."""

from __future__ import annotations

import pytest

from trackmarshal.records.specs import SpecPart
from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph import intervals
from trackmarshal.trace.graph.graph import Graph, Link, Node
from trackmarshal.trace.spec import Spec

GOAL, HAZARD, ANALYSIS = ("safety goal", "SG-1"), ("hazard", "H-1"), ("analysis", "AN-1")
HERE = Place("requirements/hazards.yaml", 3, 9)


def found(
    tolerance: str, oldest: str = "0.1 s", gap: str = "0.15 s", left: str = "", of: tuple[str, str] = HAZARD
) -> list[tuple[str, str]]:
    """Codes and messages, where an analysis of something leaves something open."""
    nodes = {
        GOAL: Node("safety goal", "SG-1", "", HERE, {"tolerance": tolerance}),
        HAZARD: Node("hazard", "H-1", "", HERE, {}),
        ("hazard", "H-2"): Node("hazard", "H-2", "", HERE, {}),
        ANALYSIS: Node("analysis", "AN-1", "", HERE, {"open": left}),
    }
    links = [Link("prevents", GOAL, HAZARD, "covers", HERE), Link("examines", ANALYSIS, of, "covers", HERE)]
    parts = [
        SpecPart("limit", name, "f", shown, "specs/limits.spec", 7, 1)
        for name, shown in (("oldest", oldest), ("longest_gap", gap), ("blind", "9 s"))
        if shown
    ]
    spec = Spec((), (), (), (), "", None, (), (), parts)
    return [(one.code, one.message) for one in intervals.check(Graph(nodes, links, {}), spec)]


@pytest.mark.parametrize(
    ("tolerance", "oldest", "gap", "short"),
    [
        ("200 ms", "0.1 s", "0.15 s", True), ("249.9 ms", "0.1 s", "0.15 s", True), ("250 ms", "0.1 s", "0.15 s", False), ("0.25 s", "0.1 s", "0.15 s", False),
        ("300 ms", "0.1 s", "0.2 s", False),  # of which the sum is 0.30000000000000004
        ("200 ms", "0.05 s", "0.15 s", False), ("1 min", "60.5 s", "0.15 s", True), ("200 ms", "0.1 s", "", False),
    ],
)  # fmt: skip
def test_an_interval_is_as_long_as_an_answer_may_take(
    tolerance: str, oldest: str, gap: str, short: bool
) -> None:
    said = found(tolerance, oldest, gap)
    assert [code for code, _ in said] == ["T173"] * short
    for _, message in said:
        assert f"tolerates a fault for {tolerance}" in message
        assert f"`longest_gap` {gap} and `oldest` {oldest}" in message or f"`oldest` {oldest}" in message


@pytest.mark.parametrize(
    ("left", "of", "answered"),
    [
        ("SG-1 is missed by 50 ms.", HAZARD, True), ("SG-1 is missed by 50 ms.", GOAL, True), ("SG-1 is missed by 50 ms.", ("hazard", "H-2"), False),
        ("SG-12 is missed.", HAZARD, False), ("Something else.", HAZARD, False),
    ],
)  # fmt: skip
def test_what_an_analysis_leaves_open_by_its_name_is_said_there(
    left: str, of: tuple[str, str], answered: bool
) -> None:
    assert (found("200 ms", left=left, of=of) == []) is answered
