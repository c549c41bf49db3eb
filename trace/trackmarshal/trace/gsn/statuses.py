"""How far elements are supported: each as far as the worst of what supports it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from trackmarshal.trace.gsn.case import RESERVED, SUPPORTED, UNSUPPORTED, Case, Element, worst
from trackmarshal.trace.gsn.kinds import BESIDE, COUNTER, OPEN, UPHELD


def with_statuses(case: Case) -> Case:
    """The argument with the status of every goal, strategy and solution. Raises ValueError for an unknown kind of elements."""
    found: dict[str, str] = {}
    for id_ in below_first(case):
        found[id_] = _status(case, case.elements[id_], found)
    elements = {id_: e._replace(status=found[id_]) for id_, e in case.elements.items()}
    return replace(case, elements=elements)


def defeated(case: Case, id_: str) -> bool:
    """Whether a defeater of an element was upheld."""
    return _challenged(case, id_, UPHELD)


def _challenged(case: Case, id_: str, state: str) -> bool:
    counters = (case.elements.get(link.source) for link in case.into.get(id_, ()) if link.kind == "challenges")  # fmt: skip
    return any(counter is not None and counter.state == state for counter in counters)


def _status(case: Case, element: Element, found: Mapping[str, str]) -> str:
    if element.kind in BESIDE or element.kind in COUNTER:
        return ""
    own = _own(case, element, found)
    # A claim holds in its context, under its assumptions: what is said against one of these is said against the claim.
    held = [element.id, *case.targets(element.id, "in_context_of")]
    if any(defeated(case, id_) for id_ in held):
        return UNSUPPORTED
    return worst([own, RESERVED]) if any(_challenged(case, id_, OPEN) for id_ in held) else own


def _own(case: Case, element: Element, found: Mapping[str, str]) -> str:
    """Without what is said against it."""
    match element.kind:
        case "solution":
            return element.leaf if element.evidence and element.leaf else UNSUPPORTED
        case "goal" | "strategy":
            if element.undeveloped:
                return element.leaf or UNSUPPORTED
            # what is not there, or stands in a circle with it, supports nothing
            below = [found.get(target, UNSUPPORTED) or UNSUPPORTED for target in case.targets(element.id, "supported_by")]  # fmt: skip
            return worst(below) if below else UNSUPPORTED
        case other:
            raise ValueError(f"unknown kind of elements {other!r}")


def below_first(case: Case) -> list[str]:
    """All elements so that what supports one comes before it, without recursion; in circles the first one come to comes last."""
    order: list[str] = []
    seen: set[str] = set()
    for start in case.elements:
        if start in seen:
            continue
        seen.add(start)
        path = [start]
        ways = [iter(case.targets(start, "supported_by"))]
        while path:
            target = next(ways[-1], None)
            if target is None:
                ways.pop()
                order.append(path.pop())
            elif target not in seen and target in case.elements:
                seen.add(target)
                path.append(target)
                ways.append(iter(case.targets(target, "supported_by")))
    return order


def way_down(case: Case, top: str) -> list[str]:
    """From an element to the first leaf that keeps it from being supported as far as it could be, by ids."""
    path, seen = [top], {top}
    while True:
        here = case.elements[path[-1]]
        worse = (t for t in case.targets(here.id, "supported_by") if t in case.elements and t not in seen)
        following = next((t for t in worse if case.elements[t].status == here.status), None)
        if following is None or here.status == SUPPORTED:
            return path
        path.append(following)
        seen.add(following)


__all__ = ["below_first", "defeated", "way_down", "with_statuses"]
