"""What the engine's rules and assumptions are like, beside their links, which the graph holds: their names, their owners, what they decide."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.records.specs import SpecItem
from trackmarshal.trace.findings import Finding, error
from trackmarshal.trace.graph.said import left_to
from trackmarshal.trace.model import Project, Requirement
from trackmarshal.trace.spec import Spec, item_place


def check(project: Project, spec: Spec) -> Iterator[Finding]:
    """What is wrong with rules and assumptions by themselves (T208, T209, T219)."""
    first: dict[str, SpecItem] = {}
    for item in spec.items:
        if item.name in first:
            also = ((item_place(first[item.name]), "declared here first"),)
            message = f"`{item.name}` is declared twice; which of the two counts is open"
            yield Finding("T209", "error", message, item_place(item), "rename one of them", item.name, also)
        first.setdefault(item.name, item)
        if item.kind == "assume":
            yield from _assumption(item)
    for requirement in project.requirements:
        if requirement.demanded:
            yield from _decided(requirement, spec)


def _assumption(item: SpecItem) -> Iterator[Finding]:
    given = (("owner", item.owner), ("monitor", item.monitored), ("evidence", item.evidence))
    lacks = [name for name, there in given if not there]
    if lacks:
        message = f"the assumption `{item.name}` has no {' and no '.join(lacks)}"
        help_ = "an assumption is somebody's, is watched while driving, and is backed by a record"
        yield error("T208", message, item_place(item), help_, item.name)


def _decided(requirement: Requirement, spec: Spec) -> Iterator[Finding]:
    items = spec.by_requirement.get(requirement.id, [])
    if left_to(requirement.asil) and items and all(item.severity == "advisory" for item in items):
        said = "an advisory rule" if len(items) == 1 else "advisory rules"
        message = f"`{requirement.id}` has ASIL {requirement.asil}, and is covered by {said} alone"
        help_ = f"give `{items[0].name}` another severity, or write a rule that decides"
        also = tuple((item_place(item), f"`{item.name}` is advisory") for item in items)
        yield Finding(
            "T219",
            "error",
            message,
            requirement.place,
            help_,
            str(requirement.id),
            also,
            tuple(item.name for item in items),
        )


__all__ = ["check"]
