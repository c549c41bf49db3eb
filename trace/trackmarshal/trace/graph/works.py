"""Works that rules cite as their source, as far as the project declares what is in them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from trackmarshal.trace.findings import Finding
from trackmarshal.trace.graph.graph import Graph, Node
from trackmarshal.trace.graph.said import called

#: Behind the title of a work: `eq 2, 3`.
_EQUATIONS = re.compile(r"eq (\d+(?:, ?\d+)*)")


def cited(source: str, works: Iterable[Node]) -> Iterator[str]:
    """The declared works that a source begins with, by the title that the `reference` of a spec gives them."""
    for work in works:
        if source == work.title or source.startswith(f"{work.title}, "):
            yield work.id


def check(graph: Graph) -> Iterator[Finding]:
    """T170 for equations that a work does not have, T178 for a work that nothing cites: its title is by what rules do."""
    for work in graph.by_kind.get("work", ()):
        if not any(link.kind == "cites" for link in graph.into(work.key)):
            message = f"{called(work.key)} is cited by nothing"
            help_ = (
                f"give it the title that the `reference` of a spec has, or strike it; it is `{work.title}`"
            )
            yield Finding("T178", "warning", message, work.place, help_, work.id)
    for link in graph.of_kind("cites"):
        work, node = graph.nodes[link.target], graph.nodes[link.source]
        match = _EQUATIONS.match(node.attributes.get("source", "").removeprefix(f"{work.title}, "))
        last = work.attributes.get("equations")
        if match is None or last is None:
            continue
        beyond = [number for number in re.findall(r"\d+", match[1]) if not 1 <= int(number) <= int(last)]
        if beyond:
            said = f"equation {beyond[0]}" if len(beyond) == 1 else f"equations {', '.join(beyond)}"
            message = f"{called(node.key)} cites {said} of `{work.id}`, which has {last}"
            also = ((work.place, "declared here"),) if work.place is not None else ()
            help_ = "correct the number, or what is declared of the work"
            yield Finding("T170", "error", message, link.place, help_, node.id, also, (work.id,))


__all__ = ["check", "cited"]
