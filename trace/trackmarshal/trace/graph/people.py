"""What people did: when, who, and of which version of a thing."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import date

from trackmarshal.trace.findings import Finding, error, warning
from trackmarshal.trace.graph.fingerprints import version
from trackmarshal.trace.graph.graph import Graph
from trackmarshal.trace.graph.kinds import LINKS
from trackmarshal.trace.graph.said import called
from trackmarshal.trace.model import Entry, Project

#: What has an owner: of these a review tells whether its reader is another person. Of an analysis those who made it are known.
_OWNED = frozenset(LINKS["owned_by"].sources)


def check(graph: Graph, project: Project, today: date) -> Iterator[Finding]:
    """T165 to T168, T179: dates in the future, reviews by owners, of other versions, open ones, and of what nobody answers for."""
    for entry in project.entries:
        node = graph.nodes[entry.kind, str(entry.id)]
        if entry.made is not None and entry.made > today:
            message = f"{called(node.key)} was made on {entry.made}, which has not come yet"
            yield error("T165", message, entry.id.place, "correct the day", entry.id)
        if entry.kind == "review":
            yield from _review(graph, entry)


def _review(graph: Graph, entry: Entry) -> Iterator[Finding]:
    me = ("review", str(entry.id))
    readers = {link.target for link in graph.out_of(me) if link.kind == "made_by"}
    for link in graph.out_of(me):
        node = graph.nodes.get(link.target)
        if link.kind != "reviews" or node is None:
            continue
        owners = {other.target for other in graph.out_of(node.key) if other.kind in ("owned_by", "made_by")}
        begun = str(node.attributes.get("made", ""))
        if link.state == "covers" and entry.made is not None and entry.made.isoformat() < begun:
            message = (
                f"`{entry.id}` is a review of {entry.made}, and {called(node.key)} was made on {begun} only"
            )
            yield error("T165", message, link.place, "correct the day", entry.id)
        for owner in sorted(owners & readers):
            message = f"`{entry.id}` is a review of {called(node.key)} by {called(owner)}, who answers for it"
            yield error("T166", message, link.place, "a second person reviews", entry.id)
        if (
            node.kind in _OWNED
            and not owners
            and link.state == "covers"
            and _accepted(entry)
            and node.demanded
        ):
            message = f"`{entry.id}` is a review of {called(node.key)}, for which nobody answers: whether another person wrote it is not known"
            help_ = "name under its `owner` who wrote it, or answers for it; who that is does not review it"
            yield Finding("T179", "error", message, link.place, help_, node.id, about=(str(entry.id),))
        if link.state == "outdated":
            message = f"{called(node.key)} has changed since the review `{entry.id}`"
            yield warning(
                "T167",
                message,
                link.place,
                f"review it again, then set `fingerprint: '{version(node)}'`",
                entry.id,
            )
    if not _accepted(entry):
        message = f"the review `{entry.id}` is open: something has to change"
        yield warning("T168", message, entry.id.place, "change it, and have it reviewed again", entry.id)


def _accepted(review: Entry) -> bool:
    return review.attributes.get("outcome") != "open"


__all__ = ["check"]
