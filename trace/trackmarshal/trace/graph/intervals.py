"""Fault-tolerant time intervals, held against how long a Supervisor with the limits of the project may take to answer a fault."""

from __future__ import annotations

import re
from collections.abc import Iterator

from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.conditions import in_si
from trackmarshal.trace.graph.graph import Graph, Node
from trackmarshal.trace.graph.said import called
from trackmarshal.trace.spec import Spec

#: What a safe cycle approved is driven for so long after its stamp, whatever comes next: it may be so old when it arrives, and the next one is waited for.
_ANSWERED = ("oldest", "longest_gap")
#: Sums of decimals that differ by less than this share are the same.
_SAME = 1e-9


def check(graph: Graph, spec: Spec) -> Iterator[Finding]:
    """T173 for goals whose interval is over before a fault is answered, where no analysis leaves that open by the goal's id."""
    limits = [part for part in spec.parts if part.kind == "limit" and part.name in _ANSWERED]
    if len(limits) < len(_ANSWERED):
        return  # nothing was read of specs, which is said there
    answered = sum(_seconds(part.shown) for part in limits)
    said = " and ".join(f"`{part.name}` {part.shown}" for part in limits)
    also = tuple(
        (Place(part.file, part.line, part.column), f"`{part.name}` here") for part in limits if part.file
    )
    for goal in graph.by_kind.get("safety goal", ()):
        tolerance = goal.attributes.get("tolerance", "")
        interval = in_si(tolerance)
        if not interval or _seconds(interval) >= answered * (1 - _SAME) or _left_open(graph, goal):
            continue
        message = (
            f"{called(goal.key)} tolerates a fault for {tolerance}, and until it is answered it may be {answered:g} s from the stamp of the last safe "
            f"cycle ({said})"
        )
        help_ = f"declare limits of the Supervisor that keep it, or have an analysis of the goal or its hazards say under `open` what that means for `{goal.id}`"
        yield Finding("T173", "error", message, goal.place, help_, goal.id, also)


def _seconds(said: str) -> float:
    return float(said.partition(" ")[0])


def _left_open(graph: Graph, goal: Node) -> bool:
    """Whether an analysis of a goal, or of a hazard that it prevents, names it in what it leaves open."""
    about = {goal.key, *(link.target for link in graph.out_of(goal.key) if link.kind == "prevents")}
    return any(
        link.kind == "examines"
        and re.search(rf"(?<![\w-]){re.escape(goal.id)}(?![\w-])", graph.nodes[link.source].attributes.get("open", ""))
        for key in about
        for link in graph.into(key)
    )  # fmt: skip


__all__ = ["check"]
