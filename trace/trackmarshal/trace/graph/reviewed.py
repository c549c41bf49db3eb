"""What no person has reviewed, as it is now: a program can tell that, and never stand in for the person."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.trace.graph.graph import Graph, Key, Node
from trackmarshal.trace.graph.said import LEVEL, asil
from trackmarshal.trace.model import Reviewed, matches


def unreviewed(graph: Graph, asked: Sequence[Reviewed]) -> tuple[Key, ...]:
    """The demanded nodes that are to be reviewed, and that no accepted review of their present version is about; in order."""
    return tuple(dict.fromkeys(_unreviewed(graph, asked)))


def _unreviewed(graph: Graph, asked: Sequence[Reviewed]) -> Iterator[Key]:
    for entry in asked:
        for node in graph.by_kind.get(entry.kind, ()):
            wanted = node.demanded and (not entry.ids or matches(node.id, entry.ids))
            if entry.from_asil and asil(node, -1) < LEVEL[entry.from_asil]:
                wanted = False
            if wanted and not reviewed(graph, node):
                yield node.key


def reviewed(graph: Graph, node: Node) -> bool:
    """Whether the last review of its present version accepted it: who finds it open later, or on the same day, takes that back."""
    last = {"accepted": "", "open": ""}
    for link in graph.into(node.key):
        if link.kind == "reviews" and link.state == "covers":
            review = graph.nodes[link.source].attributes
            outcome = str(review.get("outcome"))
            if outcome in last:
                last[outcome] = max(last[outcome], str(review.get("made", "")))
    return last["accepted"] > last["open"]


__all__ = ["reviewed", "unreviewed"]
