"""What rests on what, and the order that follows: first what others rest on."""

from __future__ import annotations

import heapq
from collections import defaultdict
from collections.abc import Iterator, Mapping

from trackmarshal.trace.graph.graph import Graph, Key, holds

#: Kinds of links of which the source rests on the target: it was made with it in view, and is suspect when it changes.
_SOURCE = frozenset({
    "found_at", "derived_from", "refines", "achieves", "prevents", "arises_from", "operates_in", "satisfies", "assuming", "uses", "tests", "result",
    "shows", "replays", "evaluates", "challenges", "confirms", "implements", "evidence", "backed_by", "excuses", "independence", "examines", "reviews",
})  # fmt: skip
#: And those of which the target rests on the source.
_TARGET = frozenset({"leads_to", "allocated_to", "used_for"})
#: Kinds in the order of the V-model, for what does not rest on each other; others come last.
_RANKS = (
    "engine", "project", "stage", "gate", "subsystem", "interface", "issue", "operational design domain", "hazard", "safety goal", "requirement", "design element",
    "limit", "signal", "parameter", "table", "place", "constraint", "assumption", "rule", "code", "test", "result", "scenario", "campaign", "run", "fault", "external test",
    "document", "analysis", "waiver", "review", "baseline",
)  # fmt: skip


def rests_on(graph: Graph, key: Key) -> Iterator[Key]:
    """What a node rests on directly."""
    for link in graph.out_of(key):
        if link.kind in _SOURCE and holds(link):
            yield link.target
    for link in graph.into(key):
        if link.kind in _TARGET and holds(link):
            yield link.source


def resting(graph: Graph, key: Key) -> Iterator[Key]:
    """What rests on a node directly."""
    for link in graph.into(key):
        if link.kind in _SOURCE and holds(link):
            yield link.source
    for link in graph.out_of(key):
        if link.kind in _TARGET and holds(link):
            yield link.target


def rank(key: Key) -> tuple[int, str, str]:
    """Where a node stands among those that it does not rest on."""
    kind, id_ = key
    return (_RANKS.index(kind) if kind in _RANKS else len(_RANKS), kind, id_)


def order(below: Mapping[Key, set[Key]]) -> dict[Key, int]:
    """By node its place, so that each comes after all that it rests on (`below`); what rests on itself, however far around, by `rank`."""
    above: dict[Key, list[Key]] = defaultdict(list)
    waiting: dict[Key, int] = {}
    for key, under in below.items():
        known = {one for one in under if one in below and one != key}
        waiting[key] = len(known)
        for one in known:
            above[one].append(key)
    ready = [rank(key) for key, number in waiting.items() if not number]
    heapq.heapify(ready)
    # Members of circles never become ready by themselves: the first of those that are left opens its circle.
    left = sorted((rank(key) for key in below), reverse=True)
    places: dict[Key, int] = {}
    while len(places) < len(below):
        if ready:
            _, *named = heapq.heappop(ready)
        else:
            _, *named = left.pop()
        key = (named[0], named[1])
        if key in places:
            continue
        places[key] = len(places)
        for one in above[key]:
            waiting[one] -= 1
            if not waiting[one] and one not in places:
                heapq.heappush(ready, rank(one))
    return places
