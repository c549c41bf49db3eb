"""An argument: elements, links between them, and the modules that they belong to. Words and kinds after the GSN Community Standard, version 3."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from trackmarshal.trace.findings import Finding, Place
from trackmarshal.trace.graph.graph import Key

SUPPORTED, RESERVED, UNSUPPORTED = "supported", "with reservations", "not supported"
#: How far an element is supported, from worst to best.
STATUSES = (UNSUPPORTED, RESERVED, SUPPORTED)


class Evidence(NamedTuple):
    """Something that a solution refers to: what it is, how it stands, and the sha256 of it, empty where that is not known."""

    kind: str
    name: str
    status: str  #: as in a cell of the matrix
    sha256: str
    place: Place | None


class Element(NamedTuple):
    """A node of the argument. `place`: where the thing that it is about stands; `origin`: the template, or the entry, that made it."""

    id: str
    kind: str
    text: str
    place: Place | None
    origin: Place | None
    about: Key | None = None  #: the node of the link graph that it is about
    undeveloped: bool = False
    public: bool = False  #: whether other modules may cite it
    module: str = ""
    evidence: tuple[Evidence, ...] = ()
    leaf: str = ""  #: of evidence and of gaps: how they stand, one of STATUSES
    state: str = ""  #: of counter elements: OPEN, ANSWERED or UPHELD
    status: str = ""  #: of goals, strategies and solutions: one of STATUSES


class Link(NamedTuple):
    """A link of one of LINKS. `cited` is the module in which the target is said to be, where somebody says so."""

    kind: str
    source: str
    target: str
    place: Place | None
    cited: str = ""


class Module(NamedTuple):
    """A part of the argument, drawn as one picture; `root` is the goal that it argues for."""

    name: str
    root: str
    title: str


class Point(NamedTuple):
    """An assurance claim point: at an element, or (`to`) at the link from it to another one."""

    id: str
    at: str
    to: str
    text: str
    place: Place | None


@dataclass(frozen=True)
class Case:
    """An argument. Links may name elements that there are not: `checks` says so."""

    project: str
    elements: Mapping[str, Element]
    links: tuple[Link, ...]
    modules: tuple[Module, ...] = ()
    points: tuple[Point, ...] = ()
    #: What was wrong with making it.
    findings: tuple[Finding, ...] = ()

    @cached_property
    def out(self) -> Mapping[str, Sequence[Link]]:
        """The links that lead from each element, in order."""
        return _by(self.links, "source")

    @cached_property
    def into(self) -> Mapping[str, Sequence[Link]]:
        """The links that lead to each element, in order."""
        return _by(self.links, "target")

    @cached_property
    def members(self) -> Mapping[str, Sequence[Element]]:
        """The elements of each module, in order."""
        table: dict[str, list[Element]] = defaultdict(list)
        for element in self.elements.values():
            table[element.module].append(element)
        return table

    def targets(self, id_: str, kind: str) -> list[str]:
        """The elements that links of a kind lead to from one."""
        return [link.target for link in self.out.get(id_, ()) if link.kind == kind]

    @property
    def tops(self) -> list[Element]:
        """What supports nothing, stands in no context and challenges nothing: one goal, in a sound argument."""
        held = {link.target for link in self.links if link.kind != "challenges"}
        held |= {link.source for link in self.links if link.kind == "challenges"}
        return [e for e in self.elements.values() if e.id not in held]


def _by(links: Sequence[Link], end: str) -> dict[str, list[Link]]:
    table: dict[str, list[Link]] = defaultdict(list)
    for link in links:
        table[getattr(link, end)].append(link)
    return table


def worst(statuses: Sequence[str]) -> str:
    """The worst of some of STATUSES; raises ValueError for others, and for none."""
    return min(statuses, key=STATUSES.index)


def a_kind(kind: str) -> str:
    """A kind of element or thing with its article, as messages call it."""
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"
