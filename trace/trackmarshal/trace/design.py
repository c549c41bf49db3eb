"""How the design answers a requirement: elements that say so in a section of their own, and analyses that leave nothing open."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from trackmarshal.trace.files import demanding
from trackmarshal.trace.findings import Place
from trackmarshal.trace.sections import key

if TYPE_CHECKING:
    from trackmarshal.trace.cells import Ground

#: Name, title, status, detail and place of something that counts in a cell.
Said = tuple[str, str, str, str, Place | None]


def elements(ground: Ground, requirement: str) -> Iterator[Said]:
    """The design elements that a requirement is allocated to; each is covered by its own section about this requirement, and by nothing else."""
    for link in ground.out_of(("requirement", requirement), "allocated_to"):
        node = ground.graph.nodes.get(link.target)
        if node is None:
            yield link.target[1], "", "missing", "no such element", link.place
            continue
        paths = [str(k.target[1]) for k in ground.out_of(link.target, "backed_by")]
        with_section = [path for path in paths if ground.hashes.get(key(path, requirement))]
        coming = [path for path in paths if (key(path, requirement), requirement) in ground.outside.denials]
        if coming:
            status, detail = "partial", f"{coming[0]}, section {requirement}, says that it is still to come"
        elif with_section:
            status, detail = "covered", f"{with_section[0]}, section {requirement}"
        elif not paths:
            status, detail = "partial", "no document says how it meets the requirement"
        else:
            status, detail = "partial", f"no section of {', '.join(paths)} is about {requirement}"
        yield node.id, node.title, status, detail, node.place


def analyses(ground: Ground, requirement: str) -> Iterator[Said]:
    """The analyses that argue that what a requirement is decomposed into is independent; one that leaves something open does not show it."""
    for link in ground.out_of(("requirement", requirement), "independence"):
        node = ground.graph.nodes.get(link.target)
        if node is None:
            yield link.target[1], "", "missing", "no such analysis", link.place
            continue
        paths = [str(k.target[1]) for k in ground.out_of(link.target, "backed_by")]
        left = node.attributes.get("open", "")
        if left:
            status, detail = "partial", f"left open: {left}"
        elif not any(map(ground.hashes.get, paths)):
            status, detail = "partial", "its document is not there, or it has none"
        elif all(demanding(path) in ground.hashes for path in paths):
            status, detail = "partial", "its document says what is demanded"
        elif node.attributes.get("outcome") != "complete":
            status, detail = "partial", "its document says that there is none"
        else:
            status, detail = "covered", "nothing is left open"
        yield node.id, node.title, status, detail, node.place


__all__ = ["analyses", "elements"]
