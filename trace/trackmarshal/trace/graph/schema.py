"""Which links nodes need: a schema held against the graph. The one that comes with the program is links.yaml beside this file."""

from __future__ import annotations

from collections.abc import Container, Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

from trackmarshal.trace import tree
from trackmarshal.trace.documents import COUNTS
from trackmarshal.trace.documents_safety import LINK_SCHEMA
from trackmarshal.trace.entries import schema as of_table
from trackmarshal.trace.findings import Finding, did_you_mean, error, warning
from trackmarshal.trace.graph.graph import Graph, Key, Node
from trackmarshal.trace.graph.kinds import LINKS, WAYS
from trackmarshal.trace.graph.said import LEVEL, asil, called
from trackmarshal.trace.model import Condition, Method, Need, Permitted, Project, Schema, Way, matches
from trackmarshal.trace.values import Reader

DEFAULT = Path(__file__).with_name("links.yaml")
#: Codes that an unmet need may have: each says that something is not linked.
CODES = ("T134", "T139", "T150", "T171", "T172", "T202", "T207")


@cache
def default() -> Schema:
    """The schema that comes with the program; raises ValueError if it is damaged."""
    found: list[Finding] = []
    node = tree.parse(DEFAULT.read_bytes(), DEFAULT.name, found)
    table = Reader(DEFAULT.name, found).table(node, LINK_SCHEMA, "the document") if node is not None else None
    if table is None or found:
        raise ValueError(f"{DEFAULT} is damaged: {'; '.join(map(str, found))}")
    return of_table(table)


def of(project: Project) -> Schema:
    """The schema that holds for a project: its own, and of what that leaves out, methods and reviews as they come with the program."""
    own, given = project.schema, default()
    if own is None:
        return given
    methods = given.methods if own.methods is None else own.methods
    return replace(own, methods=methods, reviewed=given.reviewed if own.reviewed is None else own.reviewed)


def check(graph: Graph, project: Project, asking: Asking) -> Iterator[Finding]:
    """What nodes lack, have too much of, or may not have (T134, T139, T150, T154, T155, T202, T207), and what is wrong with the schema (T156)."""
    schema = project.schema or default()
    for need in schema.needs:
        wrong = list(_of_need(need, project))
        yield from wrong
        if not wrong:
            if schema is project.schema:
                yield from _never_asked(need, graph)
            yield from asking.need(need)
    yield from _permitted(graph, schema.permitted)
    yield from _doubled(schema.methods or ())
    for method in schema.methods or ():
        for way in method.any_of:
            yield from _of_way(way, "requirement")


#: The links of which there are as many as persons at their other ends.
_READ = LINKS["reviews"].converse


class Asking:
    """Needs asked of a graph; what several of them want to know is worked out once."""

    def __init__(self, graph: Graph, project: Project) -> None:
        self._graph, self._project = graph, project
        self._reaching: dict[tuple[str, tuple[Condition, ...]], frozenset[Key]] = {}
        self._obsolete = frozenset(key for key, node in graph.nodes.items() if not node.demanded)

    def met(self, node: Node, any_of: Sequence[Way]) -> bool:
        """Whether one of these ways is there for a node."""
        return any(self._number(node, way) >= way.at_least for way in any_of)

    def need(self, need: Need) -> Iterator[Finding]:
        if need.if_any and not self._graph.by_kind.get(need.if_any):
            return
        bounded = any(way.at_most is not None for way in need.any_of)
        patterns = self._patterns(need)
        for node in self._graph.by_kind.get(need.kind, ()):
            if not _asked(node, need) or (patterns is not None and not matches(node.id, patterns)):
                continue
            if not bounded and self.met(node, need.any_of):
                continue  # as nearly all of them
            numbers = [self._number(node, way) for way in need.any_of]
            if not any(number >= way.at_least for number, way in zip(numbers, need.any_of)):
                lacks = " and ".join(
                    _lack(number, way) for number, way in zip(numbers, need.any_of) if not way.every
                )
                every = ", ".join(
                    f"`{name}`" for way in need.any_of if way.every for name in self._wanted(node, way)
                )
                message = _filled(need.says or f"{{it}} has {lacks or every}", node).replace("{every}", every)
                gone = self._gone(node, need.any_of)
                message += "".join(f"; `{name}` is demanded no longer" for name in gone)
                missing = tuple(name for way in need.any_of if way.every for name in self._wanted(node, way))
                yield Finding(
                    str(need.code) or "T150", need.level, message, node.place, _filled(need.help, node), node.id, about=(*missing, *gone)
                )  # fmt: skip
            for way in need.any_of:
                if way.at_most is not None and (number := self._number(node, way, each=True)) > way.at_most:
                    message = f"{called(node.key)} has {_count(number, way)}, at most {way.at_most} may be"
                    yield error("T154", message, node.place, _filled(need.help, node), node.id)

    def _patterns(self, need: Need) -> tuple[str, ...] | None:
        """Ids that the stages of a need ask something of; None where it names no stages."""
        if not (need.stages or need.counts):
            return None
        stages = [s for s in self._project.stages if not need.stages or matches(s.id, need.stages)]
        return tuple(p for s in stages if not need.counts or need.counts in s.counts for p in s.applies_to)

    def _number(self, node: Node, way: Way, each: bool = False) -> int:
        """How often a way is there for a node. each: whoever made a review, for what there are to be no more of."""
        if way.field:
            return int(bool(node.attributes.get(way.field, "").strip()))
        if way.reaches:
            return int(node.key in self._below(str(way.reaches), way.where))
        kind, outward = WAYS[way.link]
        if way.every:
            return int(not self._wanted(node, way))
        if outward:  # as they are written: what is wrong with one of them is told of it
            ends = [
                link.target
                for link in self._graph.out_of(node.key)
                if link.kind == kind and link.state != "outdated" and link.target not in self._withdrawn(node)
            ]
        else:
            ends = [
                link.source
                for link in self._graph.into(node.key)
                if link.kind == kind and link.state == "covers"
            ]
        if not ends or (outward and not (way.kinds or way.where)):
            return len(ends) if len(ends) < 2 else len(set(ends))
        others = [self._graph.nodes[key] for key in dict.fromkeys(ends) if key in self._graph.nodes]
        counted = [
            other
            for other in others
            if other.demanded and (not way.kinds or other.kind in way.kinds) and fits(other, way.where)
        ]
        if way.link == _READ and not each:  # who reads a thing twice is no second reader
            links = (link for review in counted for link in self._graph.out_of(review.key))
            return min(len(counted), len({link.target for link in links if link.kind == "made_by"}))
        return len(counted)

    def _withdrawn(self, node: Node) -> Container[Key]:
        """What is demanded no longer, which is no reason for what still is, and answers nothing of it."""
        return self._obsolete if node.demanded else ()

    def _gone(self, node: Node, any_of: Sequence[Way]) -> list[str]:
        """What a node names under one of these ways, and nobody demands any longer."""
        kinds = {kind for way in any_of if way.link for kind, outward in [WAYS[way.link]] if outward}
        links = [link for link in self._graph.out_of(node.key) if link.kind in kinds]
        return list(dict.fromkeys(k.target[1] for k in links if k.target in self._withdrawn(node)))

    def _wanted(self, node: Node, way: Way) -> list[str]:
        """Nodes that a way with `every` asks for, and that a node is not linked with; of which no integrity level is given, none is."""
        kind, outward = WAYS[way.link]
        own = asil(node, -1)
        links = self._graph.out_of(node.key) if outward else self._graph.into(node.key)
        there = {(link.target if outward else link.source)[1] for link in links if link.kind == kind}
        there.update(node.attributes.get(way.unless, "").split())
        return [
            other.id
            for name in (LINKS[kind].targets if outward else LINKS[kind].sources)
            for other in self._graph.by_kind.get(name, ())
            if other.id not in there and LEVEL.get(other.attributes.get(way.every, ""), own + 1) <= own
        ]

    def _below(self, kind: str, where: tuple[Condition, ...]) -> frozenset[Key]:
        """All nodes that have such a node below them."""
        if (kind, where) not in self._reaching:
            goals = {node.key for node in self._graph.by_kind.get(kind, ()) if fits(node, where)}
            self._reaching[kind, where] = frozenset(self._graph.reaching(goals, down=True))
        return self._reaching[kind, where]


def _asked(node: Node, need: Need) -> bool:
    """Whether a need is asked of a node, as far as the node itself says so."""
    if not (need.obsolete or node.demanded) or (need.ids and not matches(node.id, need.ids)):
        return False
    if need.from_asil and asil(node, -1) < LEVEL[need.from_asil]:
        return False
    return not need.where or fits(node, need.where)


def fits(node: Node, where: Sequence[Condition]) -> bool:
    """Whether all of this is true of a node."""
    return all(matches(node.attributes.get(c.attribute, ""), c.values) for c in where)


def _filled(text: str, node: Node) -> str:
    return text.replace("{it}", called(node.key)).replace("{id}", node.id)


def _lack(number: int, way: Way) -> str:
    where = "".join(f" with `{c.attribute}` {' or '.join(c.values)}" for c in way.where)
    if way.field:
        return f"no `{way.field}`"
    if way.reaches:
        return f"no {way.reaches} below it{where}"
    ends = f" ({', '.join(way.kinds)})" if way.kinds else ""
    if number == 0 and way.at_least == 1:
        return f"no link `{way.link}`{ends}{where}"
    several = " by different persons" if way.link == _READ else ""
    return f"{number} of {way.at_least} links `{way.link}`{several}{ends}{where}"


def _count(number: int, way: Way) -> str:
    return f"{number} links `{way.link}`" if way.link else f"{number} of `{way.reaches or way.field}`"


def _of_way(way: Way, of: str) -> Iterator[Finding]:
    """What is wrong with a way to meet a need of a kind of nodes by itself (T156): it could never be there, or always is."""
    given = [name for name in (way.link, way.reaches, way.field) if name]
    if len(given) != 1:
        yield error("T156", f"a way to meet a need of the {of} is neither a link, nor reached, nor a field, or more than one of them",
                    way.place, "give one of `link`, `reaches` and `field`")  # fmt: skip
    if way.link:
        kind, outward = WAYS[way.link]
        ends = LINKS[kind].sources if outward else LINKS[kind].targets
        if ends and of not in ends:
            known = ", ".join(name for name, (k, out) in WAYS.items() if _has(of, k, out))
            yield error("T156", f"{_a(of)} has no links `{way.link}`", way.link.place, f"it has {known}")
    if way.at_least == 0 and way.at_most is None:
        yield error("T156", "`at_least: 0` is always met", way.place, "strike it, or say `at_most`")
    if (way.every or way.unless) and not (way.every and way.link):
        yield error(
            "T156",
            "`every` and `unless` ask for links, and which is not said",
            way.place,
            "give `link` and `every`",
        )
    if way.at_least > 1 and not way.link:
        yield error("T156", "`at_least` counts links, and there are none here", way.place, "strike it")


def _of_need(need: Need, project: Project) -> Iterator[Finding]:
    """What is wrong with a need by itself (T156): it could never be met, or would never be asked."""
    for way in need.any_of:
        yield from _of_way(way, need.kind)
    if need.code and need.code not in CODES:
        yield error(
            "T156",
            f"`{need.code}` is no code of a link that is missing",
            need.code.place,
            "known are " + ", ".join(CODES),
        )
    if need.counts and need.counts not in COUNTS.choices:
        help_ = did_you_mean(need.counts, COUNTS.choices) or "known are " + ", ".join(COUNTS.choices)
        yield error("T156", f"no stage can count `{need.counts}`", need.place, help_)
    for pattern in need.stages:
        if not any(matches(stage.id, (pattern,)) for stage in project.stages):
            yield error(
                "T156",
                f"`{pattern}` fits no stage",
                pattern.place,
                "known are " + ", ".join(s.id for s in project.stages),
            )


def _never_asked(need: Need, graph: Graph) -> Iterator[Finding]:
    """Conditions that no node of the kind fits, where there are any (T156): they may be misspelt."""
    nodes = graph.by_kind.get(need.kind, ())
    for pattern in need.ids:
        if nodes and not any(matches(node.id, (pattern,)) for node in nodes):
            yield warning(
                "T156",
                f"`{pattern}` fits no {need.kind}",
                pattern.place,
                did_you_mean(pattern, (n.id for n in nodes)),
            )
    asked = [c.attribute for c in need.where] + (["asil"] if need.from_asil else [])
    for attribute in asked:
        if nodes and not any(attribute in node.attributes for node in nodes):
            known = ", ".join(sorted({name for node in nodes for name in node.attributes}))
            yield error(
                "T156", f"no {need.kind} has the attribute `{attribute}`", need.place, f"there are {known}"
            )


def _doubled(methods: Sequence[Method]) -> Iterator[Finding]:
    """T156 for a method that a schema has twice."""
    first: dict[str, Method] = {}
    for method in methods:
        if method.name in first:
            also = ((first[str(method.name)].name.place, "the first one"),)
            message = f"the method `{method.name}` is there twice"
            yield Finding("T156", "error", message, method.name.place, "merge the two", also=also)
        first.setdefault(str(method.name), method)


def _has(node: str, link: str, outward: bool) -> bool:
    ends = LINKS[link].sources if outward else LINKS[link].targets
    return not ends or node in ends


def _a(kind: str) -> str:
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _permitted(graph: Graph, permitted: Sequence[Permitted]) -> Iterator[Finding]:
    by_kind: dict[str, list[Permitted]] = {}
    for entry in permitted:
        by_kind.setdefault(str(entry.link), []).append(entry)
    for kind, entries in by_kind.items():
        for link in graph.of_kind(kind):
            if link.state == "orphaned":
                continue
            if not any(
                matches(link.source[1], e.sources) and matches(link.target[1], e.targets) for e in entries
            ):
                message = f"{called(link.source)} may not have the link `{kind}` to {called(link.target)}"
                allowed = "; ".join(f"from {', '.join(e.sources)} to {', '.join(e.targets)}" for e in entries)
                yield error("T155", message, link.place, f"permitted are links {allowed}", link.source[1])


__all__ = ["CODES", "Asking", "check", "default", "fits", "of"]
