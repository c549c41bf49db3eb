"""Groups: where too many elements stand side by side, goals stand for several of them each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from trackmarshal.trace.gsn.case import Case, Element, Link

#: The most elements that support one; where there are more, goals stand for groups of them.
SIDE_BY_SIDE = 8
GROUPS = "Each of the {number} goals from {first} to {last} is met."


def grouped(case: Case, groups: str) -> Case:
    """The argument with no element that more than SIDE_BY_SIDE others support: groups of nearly equal size, in order, as many levels as it takes.

    groups: what the goal of a group says, in which `{first}`, `{last}` and `{number}` stand for its ends and its size; "" for GROUPS.
    """
    elements = dict(case.elements)
    links: list[Link] = [link for link in case.links if link.kind != "supported_by"]
    for id_ in case.elements:
        row = [link for link in case.out.get(id_, ()) if link.kind == "supported_by"]
        #: Of a goal that stands for a group: its first, its last, and how many there are.
        spans = {link.target: (link.target, link.target, 1) for link in row}
        while len(row) > SIDE_BY_SIDE:
            above = []
            for part in _parts(row):
                held = [spans[link.target] for link in part]
                span = held[0][0], held[-1][1], sum(number for _, _, number in held)
                goal = _goal(elements, case.elements[id_], groups or GROUPS, span)
                elements[goal.id], spans[goal.id] = goal, span
                links += [link._replace(source=goal.id) for link in part]
                above.append(Link("supported_by", id_, goal.id, part[0].place))
            row = above
        links += row
    return replace(case, elements=elements, links=tuple(links))


def _parts(row: Sequence[Link]) -> Iterator[Sequence[Link]]:
    number = -(-len(row) // SIDE_BY_SIDE)
    size, more = divmod(len(row), number)
    start = 0
    for index in range(number):
        stop = start + size + (index < more)
        yield row[start:stop]
        start = stop


def _goal(elements: dict[str, Element], at: Element, groups: str, span: tuple[str, str, int]) -> Element:
    first, last, number = span
    text = groups.replace("{first}", first).replace("{last}", last).replace("{number}", str(number))
    return Element(free(elements, at.id), "goal", text, at.place, at.origin)


def free(elements: dict[str, Element], at: str) -> str:
    """An id for a further goal under an element: the element's, a dot, and the first number that is free."""
    number = 1
    while f"{at}.{number}" in elements:
        number += 1
    return f"{at}.{number}"


__all__ = ["GROUPS", "SIDE_BY_SIDE", "free", "grouped"]
