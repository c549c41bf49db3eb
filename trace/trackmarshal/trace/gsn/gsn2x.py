"""The argument as YAML that gsn2x reads: one file a module, named after it. What gsn2x does not know stands beside what it does, as texts."""

from __future__ import annotations

from typing import Any

import yaml

from trackmarshal.trace.gsn.case import Case, Element, Module

#: The kinds of elements as gsn2x calls them, and the first letters of ids that mean them there; longer ones first.
TYPES = {
    "counter solution": ("CounterSolution", "CSn"),
    "counter goal": ("CounterGoal", "CG"),
    "solution": ("Solution", "Sn"),
    "goal": ("Goal", "G"),
    "strategy": ("Strategy", "S"),
    "context": ("Context", "C"),
    "assumption": ("Assumption", "A"),
    "justification": ("Justification", "J"),
}
_NAMES = {"supported_by": "supportedBy", "in_context_of": "inContextOf", "challenges": "challenges"}


def render(case: Case, module: Module) -> str:
    """A module as YAML, in the order of the argument; elements of other modules are named by their ids alone, as gsn2x wants it."""
    data: dict[str, Any] = {"module": {"name": module.name, "brief": module.title}}
    for element in case.members.get(module.name, ()):
        data[element.id] = _element(case, element)
    return yaml.dump(
        data, Dumper=yaml.CSafeDumper, sort_keys=False, allow_unicode=True, width=120, default_flow_style=False
    )  # fmt: skip


def _element(case: Case, element: Element) -> dict[str, Any]:
    said: dict[str, Any] = {"text": element.text}
    if read_off(element.id) != element.kind:
        said["nodeType"] = TYPES[element.kind][0]
    for kind, name in _NAMES.items():
        targets = list(dict.fromkeys(case.targets(element.id, kind)))
        if targets:
            said[name] = targets
    if element.undeveloped:
        said["undeveloped"] = True
    if any(case.elements[k.source].state == "upheld" for k in case.into.get(element.id, ()) if k.kind == "challenges" and k.source in case.elements):  # fmt: skip
        said["defeated"] = True
    points: dict[str, Any] = {}
    for point in case.points:
        if point.at == element.id:
            points[point.id] = point.to or point.at
    if points:
        said["acp"] = points
    beside = {"status": element.status, "state": element.state, "place": str(element.place or "")}
    said.update({name: text for name, text in beside.items() if text})
    if element.evidence:
        said["evidence"] = "\n".join(f"{e.kind} {e.name}: {e.status}, sha256 {e.sha256}" for e in element.evidence)  # fmt: skip
    return said


def read_off(id_: str) -> str:
    """The kind that gsn2x reads off an id; empty where it reads none."""
    return next((kind for kind, (_, letters) in TYPES.items() if id_.startswith(letters)), "")


__all__ = ["TYPES", "read_off", "render"]
