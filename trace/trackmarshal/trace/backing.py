"""Evidence that a project attaches to assumptions whose specs are not its own, such as those of the library."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from trackmarshal.records.specs import SpecItem
from trackmarshal.trace.findings import Finding, did_you_mean, error
from trackmarshal.trace.model import Backing, Project


def backed(project: Project, items: Iterable[SpecItem], found: list[Finding]) -> list[SpecItem]:
    """The items, assumptions with the evidence and the owner that the project gives them; what their own specs say stands.

    What is given in vain goes to `found`: to nothing (T151), or beside evidence that is there already (T142).
    """
    given: dict[str, Backing] = {}
    made = list(items)
    known = {item.name: item for item in reversed(made) if item.kind == "assume"}
    for entry in project.backing:
        name, item = str(entry.name), known.get(entry.name)
        if item is None:
            message = f"evidence is given to the assumption `{name}`, and there is no such assumption"
            found.append(error("T151", message, entry.name.place, did_you_mean(name, known), name))
        elif item.evidence or name in given:
            has = item.evidence or given[name].evidence
            message = f"evidence is given to the assumption `{name}`, which has some: `{has}`"
            found.append(error("T142", message, entry.name.place, "name it once", name))
        else:
            given[name] = entry
    return [
        replace(item, evidence=str(given[item.name].evidence), owner=given[item.name].owner or item.owner)
        if item.kind == "assume" and item.name in given
        else item
        for item in made
    ]


__all__ = ["backed"]
