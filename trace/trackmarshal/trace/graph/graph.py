"""The one graph under the matrix: nodes with stable ids, links with a direction, and indices of both."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import NamedTuple

from trackmarshal.trace.findings import Place
from trackmarshal.trace.graph.kinds import LINKS, OBSOLETE

#: A node's kind and id: together they are unique, and the same as long as nobody renames it.
Key = tuple[str, str]


class Node(NamedTuple):
    """A thing that traces to others. `attributes` are texts, such as `status`, `asil`, `stage`, `outcome`. says: what no attribute has of it, and a
    review reads."""

    kind: str
    id: str
    title: str
    place: Place | None
    attributes: Mapping[str, str]
    says: str = ""

    @property
    def key(self) -> Key:
        return (self.kind, self.id)

    @property
    def demanded(self) -> bool:
        """Whether it still counts."""
        return self.attributes.get("status") != OBSOLETE


class Link(NamedTuple):
    """A link where it stands, at its source; its target need not exist (`state`)."""

    kind: str
    source: Key
    target: Key
    state: str  #: one of STATES
    place: Place


class Graph:
    """Nodes by their keys, and links in order; nothing in it changes once it is made.

    Raises ValueError for a link of an unknown kind.
    """

    def __init__(
        self, nodes: Mapping[Key, Node], links: Iterable[Link], asil_places: Mapping[Key, Place] | None = None
    ) -> None:
        self.nodes = nodes
        #: Where the integrity levels of nodes are written.
        self.asil_places = asil_places or {}
        self.links = tuple(links)
        self._out: dict[Key, list[Link]] = defaultdict(list)
        self._in: dict[Key, list[Link]] = defaultdict(list)
        self._kinds: dict[str, list[Link]] = {name: [] for name in LINKS}
        for link in self.links:
            if link.kind not in self._kinds:
                raise ValueError(f"unknown kind of links {link.kind!r}")
            self._kinds[link.kind].append(link)
            self._out[link.source].append(link)
            self._in[link.target].append(link)

    def out_of(self, key: Key) -> Sequence[Link]:
        """The links that stand at a node."""
        return self._out.get(key, ())

    def into(self, key: Key) -> Sequence[Link]:
        """The links that lead to a node."""
        return self._in.get(key, ())

    def of_kind(self, kind: str) -> Sequence[Link]:
        """The links of a kind; raises KeyError for an unknown one."""
        return self._kinds[kind]

    @cached_property
    def by_kind(self) -> Mapping[str, Sequence[Node]]:
        """Nodes by kind, in order."""
        table: dict[str, list[Node]] = defaultdict(list)
        for node in self.nodes.values():
            table[node.kind].append(node)
        return table

    @cached_property
    def by_id(self) -> Mapping[str, Sequence[Node]]:
        """Nodes by id: things of several kinds may share one."""
        table: dict[str, list[Node]] = defaultdict(list)
        for node in self.nodes.values():
            table[node.id].append(node)
        return table

    def steps(self, key: Key, *, down: bool) -> Iterator[tuple[Link, Key]]:
        """The links that lead one level down (or up) from a node, each with the node at its other end; only links that hold."""
        for link in self._in.get(key, ()):
            if LINKS[link.kind].down is not down and holds(link):
                yield link, link.source
        for link in self._out.get(key, ()):
            if LINKS[link.kind].down is down and holds(link):
                yield link, link.target

    def reaching(self, goals: Iterable[Key], *, down: bool) -> set[Key]:
        """All nodes from which one of these is reached going down (or up), themselves included; without recursion."""
        found = set(goals)
        todo = list(found)
        while todo:
            for _, key in self.steps(todo.pop(), down=not down):
                if key not in found:
                    found.add(key)
                    todo.append(key)
        return found


def holds(link: Link) -> bool:
    """Whether both ends of a link stand, and the target asks for it."""
    return link.state in ("covers", "outdated")


__all__ = ["Graph", "Key", "Link", "Node", "holds"]
