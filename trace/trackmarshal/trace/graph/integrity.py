"""Integrity levels along the graph: from hazards over goals and requirements down to design elements, decomposed ones included."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from trackmarshal.trace.findings import Finding, error
from trackmarshal.trace.graph.graph import Graph, Key, Node
from trackmarshal.trace.graph.said import LEVEL, asil, called

#: The method of analyses that argue for independence.
_INDEPENDENCE = "dependent failures"

_NAMES = {number: name for name, number in LEVEL.items()}


def by_table_4(severity: str, exposure: str, controllability: str) -> str:
    """The ASIL of a hazardous event by ISO 26262-3, table 4: S0 to S3, E0 to E4, C0 to C3.

    The classes of the table add up: S3 with E4 and C3 is D, and each class less in one of them is one level less. Class 0 of any needs no ASIL.
    Raises ValueError for other classes.
    """
    classes = []
    for name, letter, most in ((severity, "S", 3), (exposure, "E", 4), (controllability, "C", 3)):
        if len(name) != 2 or name[0] != letter or not name[1].isdecimal() or int(name[1]) > most:
            raise ValueError(f"{name!r} is no class from {letter}0 to {letter}{most}")
        classes.append(int(name[1]))
    return _NAMES[max(0, sum(classes) - 6)] if all(classes) else "QM"


def check(graph: Graph) -> Iterator[Finding]:
    """T143 and T158 to T164."""
    yield from _hazards(graph)
    yield from _goals(graph)
    decomposed: list[Node] = []
    for node in graph.by_kind.get("requirement", ()):
        yield from _requirement(graph, node)
        if node.demanded and "(" in node.attributes["asil"]:
            decomposed.append(node)
    yield from _decomposed(graph, decomposed)
    yield from _unrated(graph)


def _unrated(graph: Graph) -> Iterator[Finding]:
    """T164 for elements that have no level: whether they meet what is allocated to them, or are what two parts stand and fall with (T162), nobody knows."""
    for element in graph.by_kind.get("design element", ()):
        allocated = [
            graph.nodes[link.source] for link in graph.into(element.key) if link.kind == "allocated_to"
        ]
        wanted = [node for node in allocated if node.demanded and asil(node, 0) > 0]
        if wanted and asil(element) is None:
            most = max(wanted, key=lambda node: asil(node, 0))
            message = f"{called(element.key)} does not say to which ASIL it is developed, and `{most.id}`, allocated to it, has {most.attributes['asil']}"
            yield Finding("T164", "warning", message, element.place, "add `asil`", element.id, about=tuple(node.id for node in wanted))  # fmt: skip


def _above(graph: Graph, node: Node, kind: str) -> list[Node]:
    """What a node has links of a kind to, where that is there."""
    if not graph.of_kind(kind):
        return []
    return [
        graph.nodes[link.target]
        for link in graph.out_of(node.key)
        if link.kind == kind and link.target in graph.nodes
    ]


def _hazards(graph: Graph) -> Iterator[Finding]:
    for hazard in graph.by_kind.get("hazard", ()):
        classes = [hazard.attributes.get(name, "") for name in ("severity", "exposure", "controllability")]
        if not all(classes) or asil(hazard) is None:
            continue  # reported where it was read
        level = by_table_4(*classes)
        if hazard.attributes["asil"] != level:
            message = f"{called(hazard.key)} has ASIL {hazard.attributes['asil']}; {', '.join(classes)} make it {level}"
            yield error(
                "T158", message, hazard.place, f"write `asil: {level}`, or classify it anew", hazard.id
            )


def _goals(graph: Graph) -> Iterator[Finding]:
    for goal in graph.by_kind.get("safety goal", ()):
        for hazard in _above(graph, goal, "prevents"):
            if asil(goal, 4) < asil(hazard, 0):
                message = f"{called(goal.key)} has ASIL {goal.attributes['asil']}, below {called(hazard.key)}, which it prevents, with {hazard.attributes['asil']}"
                yield error(
                    "T159", message, goal.place, "a goal has the highest ASIL of its hazards", goal.id
                )


def _requirement(graph: Graph, node: Node) -> Iterator[Finding]:
    """What is above a requirement has no higher level, and what it is allocated to no lower one."""
    own = asil(node)
    if own is None:
        return
    written = node.attributes["asil"]
    if "(" not in written:  # decomposed levels lie below their parent's on purpose
        for parent in _above(graph, node, "refines"):
            if own < asil(parent, 0):
                message = f"`{node.id}` has ASIL {written}, below `{parent.id}`, which it refines, with {parent.attributes['asil']}"
                help_ = "raise it, or write the decomposition, such as `B(D)`"
                yield _at_asil(graph, "T143", message, node, parent, help_)
    for goal in _above(graph, node, "achieves"):
        if own >= asil(goal, 0):
            continue
        message = f"`{node.id}` has ASIL {written}, below {called(goal.key)}, which it serves, with {goal.attributes['asil']}"
        if "(" not in written:
            yield _at_asil(graph, "T160", message, node, goal, "raise it, or decompose it, such as `B(D)`")
        elif not any(_serves(graph, whole, goal) for whole in _wholes(graph, node)):
            message += "; neither what it is a part of serves it, nor enough of the other parts"
            help_ = f"name `{goal.id}` under `achieves` of the requirement that was decomposed"
            yield _at_asil(graph, "T160", message, node, goal, help_)
    for element in _above(graph, node, "allocated_to"):
        level = asil(element)
        if level is not None and level < own:
            message = f"{called(element.key)} is developed to ASIL {element.attributes['asil']}, and `{node.id}`, allocated to it, has {written}"
            yield error(
                "T164", message, element.place, "raise it, or allocate the requirement elsewhere", element.id
            )


def _wholes(graph: Graph, node: Node) -> list[Node]:
    """The demanded requirements that a requirement is a part of, however far up."""
    found: dict[Key, Node] = {}
    todo = [node]
    while todo:
        for parent in _above(graph, todo.pop(), "refines"):
            if parent.demanded and parent.key not in found:
                found[parent.key] = parent
                todo.append(parent)
    return list(found.values())


def _serves(graph: Graph, whole: Node, goal: Node) -> bool:
    """Whether a requirement serves a goal at its level: it says so, or those of its parts that do make that together, each counted once."""
    if goal in _above(graph, whole, "achieves"):
        return asil(whole, 0) >= asil(goal, 0)
    if "(" in whole.attributes["asil"] and any(up.demanded for up in _above(graph, whole, "refines")):
        return False  # what it is a part of has all of its parts, and others
    level, seen, todo = 0, {whole.key}, [whole.key]
    while todo:
        for key in [link.source for link in graph.into(todo.pop()) if link.kind == "refines"]:
            part = graph.nodes[key]
            if key in seen or not part.demanded or "(" not in part.attributes["asil"]:
                continue
            seen.add(key)
            if goal in _above(graph, part, "achieves"):
                level += asil(part, 0)
            else:
                todo.append(key)
    return level >= asil(goal, 0)


def _at_asil(graph: Graph, code: str, message: str, node: Node, above: Node, help_: str) -> Finding:
    also = (
        ()
        if above.place is None
        else ((graph.asil_places.get(above.key, above.place), f"ASIL of `{above.id}`"),)
    )
    place = graph.asil_places.get(node.key, node.place)
    return Finding(code, "error", message, place, help_, node.id, also, (above.id,))


def _of_parts(graph: Graph, message: str, parent: Node, help_: str) -> Finding:
    """T161, which is about the parts too, and about what was one."""
    parts = (link.source[1] for link in graph.into(parent.key) if link.kind == "refines")
    return Finding(
        "T161", "error", message, parent.place, help_, parent.id, about=tuple(dict.fromkeys(parts))
    )


def _decomposed(graph: Graph, nodes: Sequence[Node]) -> Iterator[Finding]:
    """Whether decomposed requirements add up to what they refine, keep its level in brackets, and are argued to be independent."""
    parts: dict[Key, list[Node]] = {}
    for node in nodes:
        above = [parent for parent in _above(graph, node, "refines") if parent.demanded]
        if not above:
            message = f"`{node.id}` has the decomposed ASIL {node.attributes['asil']}, and refines nothing that was decomposed"
            place = graph.asil_places.get(node.key, node.place)
            yield error("T163", message, place, "name it under `refines`", node.id)
        for parent in dict.fromkeys(n.key for n in above):
            parts.setdefault(parent, []).append(node)
    for parent, own in parts.items():
        yield from _adds_up(graph, graph.nodes[parent], own)


def _adds_up(graph: Graph, parent: Node, parts: Sequence[Node]) -> Iterator[Finding]:
    own = asil(parent)
    if own is None:
        return
    written = parent.attributes["asil"]
    original = written.partition("(")[2].rstrip(")") or written
    for part in parts:
        kept = part.attributes["asil"].partition("(")[2].rstrip(")")
        if kept != original:
            message = f"`{part.id}` has ASIL {part.attributes['asil']}, and `{parent.id}`, of which it is a part, {written}"
            help_ = f"the level before the decomposition stays in brackets: `{part.attributes['asil'].partition('(')[0]}({original})`"
            yield _at_asil(graph, "T163", message, part, parent, help_)
    total = sum(asil(part, 0) for part in parts)
    said = " + ".join(f"{part.attributes['asil']} (`{part.id}`)" for part in parts[:6]) + (
        " ..." if len(parts) > 6 else ""
    )
    if len(parts) == 1 and total < own:
        message = f"the ASIL of `{parent.id}`, {written}, is decomposed into {said} alone"
        yield _of_parts(graph, message, parent, "a decomposition has at least two parts")
    elif total < own:
        message = f"the ASIL of `{parent.id}`, {written}, is decomposed into {said}, which is too little"
        help_ = f"with QM 0, A 1, B 2, C 3 and D 4, the parts make {total}, and {written.partition('(')[0]} is {own}"
        yield _of_parts(graph, message, parent, help_)
    yield from _independent(graph, parent, parts)


def _independent(graph: Graph, parent: Node, parts: Sequence[Node]) -> Iterator[Finding]:
    """T162: somebody argues by an analysis of dependent failures that the parts are independent, and no element fails two of them."""
    message = f"the ASIL of `{parent.id}` is decomposed, and "
    named = [link.target for link in graph.out_of(parent.key) if link.kind == "independence"]
    there = [graph.nodes[key] for key in dict.fromkeys(named) if key in graph.nodes]
    help_ = "name an analysis of dependent failures under `independence`"
    if not named:
        message += "no analysis argues that the parts are independent"
        yield error("T162", message, parent.place, help_, parent.id)
    elif there and not any(node.attributes.get("method") == _INDEPENDENCE for node in there):
        said = ", ".join(f"`{node.id}` ({node.attributes.get('method', '')})" for node in there)
        message += f"what it names under `independence` is no analysis of dependent failures: {said}"
        yield error("T162", message, parent.place, help_, parent.id)
    for number, one in enumerate(parts):
        for other in parts[number + 1 :]:
            yield from _apart(graph, parent, one, other)


def _apart(graph: Graph, parent: Node, one: Node, other: Node) -> Iterator[Finding]:
    """T162 of two parts of which one has no element that is not the other's too, and not developed to the level of the whole."""
    first, second = (
        {node.key: node for node in _above(graph, part, "allocated_to")} for part in (one, other)
    )
    common = {key: node for key, node in first.items() if key in second}
    if not common or len(common) < min(len(first), len(second)):
        return
    for element in common.values():
        level = asil(element)
        if level is not None and level < asil(parent, 0):
            message = f"`{one.id}` and `{other.id}`, parts of `{parent.id}` with {parent.attributes['asil']}, both stand and fall with {called(element.key)}, which is developed to {element.attributes['asil']}"
            help_ = f"allocate them to elements that cannot fail together, or develop `{element.id}` to the level of the whole"
            yield error("T162", message, one.place, help_, parent.id)


__all__ = ["by_table_4", "check"]
