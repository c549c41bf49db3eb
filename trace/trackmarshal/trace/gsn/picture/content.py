"""What one picture shows: the elements of a module, those of other modules that it cites, and the links between them."""

from __future__ import annotations

from typing import NamedTuple

from trackmarshal.trace.gsn.case import Case, Element, Link, Module


class Shown(NamedTuple):
    """An element in a picture; `away`: it belongs to another module, which is cited."""

    element: Element
    away: bool


class Content(NamedTuple):
    """What a picture shows, in order, and the links whose ends are all in it, each once."""

    module: Module
    shown: dict[str, Shown]
    links: tuple[Link, ...]


def content(case: Case, module: Module) -> Content:
    """The elements of a module, with what they are linked to elsewhere; not what links to them from elsewhere."""
    own = {e.id: Shown(e, False) for e in case.members.get(module.name, ())}
    links = dict.fromkeys(
        link._replace(place=None, cited="") for id_ in own for link in case.out.get(id_, ())
    )
    shown = dict(own)
    for link in links:
        target = case.elements.get(link.target)
        if target is not None and target.id not in shown:
            shown[target.id] = Shown(target, True)
    there = tuple(link for link in links if link.target in shown and link.source != link.target)
    return Content(module, shown, there)


__all__ = ["Content", "Shown", "content"]
