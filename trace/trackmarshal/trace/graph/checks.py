"""Links by themselves: each leads to something that asks for it, stands once, and leads round in no circle that does harm."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from trackmarshal.trace import cycles
from trackmarshal.trace.findings import Finding, Place, did_you_mean, error, warning
from trackmarshal.trace.graph.graph import Graph, Link
from trackmarshal.trace.graph.kinds import LINKS, Said
from trackmarshal.trace.graph.said import called

#: So many names that lead nowhere are held against all that there are; that takes time in proportion to both.
SUGGESTED = 50


def check(graph: Graph) -> Iterator[Finding]:
    """Loose ends of every kind of links, as `LINKS` says them, and circles."""
    for name, kind in LINKS.items():
        if kind.findings:
            yield from _of_kind(graph, name)
        if kind.circular is not None:
            yield from _around(graph, name, kind.circular)


def _of_kind(graph: Graph, name: str) -> Iterator[Finding]:
    kind = LINKS[name]
    seen: set[tuple[object, object]] = set()
    suggested: dict[str, str] = {}
    for link in graph.of_kind(name):
        source = graph.nodes.get(link.source)
        state = link.state
        if state != "ambiguous":
            state = "twice" if (link.source, link.target) in seen else state
            seen.add((link.source, link.target))
        said = kind.findings.get(state)
        if said is None:
            continue
        if (
            source is not None
            and not source.demanded
            and state != "twice"
            and (kind.down or state == "unwanted")
        ):
            continue  # what is demanded no longer needs nothing below it
        help_ = said.help
        if state == "orphaned" or not said.help:
            wanted = link.target[1]
            if wanted not in suggested and len(suggested) < SUGGESTED:
                there = [n for k in kind.targets for n in graph.by_kind.get(k, ())]
                # Persons are meant by their names, too.
                names = [n.title for n in there if n.kind == "person"]
                suggested[wanted] = did_you_mean(wanted, [*(n.id for n in there), *names])
            help_ = suggested.get(wanted, "") or said.help
        yield _finding(graph, link, said, help_)


def _finding(graph: Graph, link: Link, said: Said, help_: str) -> Finding:
    source, target = graph.nodes.get(link.source), graph.nodes.get(link.target)
    words = {
        "it": called(link.source), "source": link.source[1], "target": link.target[1], "link": link.kind,
        "targets": " or ".join(LINKS[link.kind].targets) or "thing",
        "at": "" if source is None else source.attributes.get("interface", ""),
    }  # fmt: skip
    also: tuple[tuple[Place, str], ...] = ()
    if said.also and target is not None and target.place is not None:
        also = ((target.place, said.also.format(**words)),)
    subject = link.target[1] if said.of_target else link.source[1]
    return Finding(
        said.code, "error", said.message.format(**words), link.place, help_.format(**words), subject, also,
        tuple(name for name in (link.source[1], link.target[1], words["at"]) if name),
    )  # fmt: skip


def _around(graph: Graph, name: str, said: Said) -> Iterator[Finding]:
    """Circles of links of a kind; where there are none, links beside a longer way to the same place."""
    kind = LINKS[name].sources[0]
    parents = {
        node.id: list(dict.fromkeys(link.target[1] for link in graph.out_of(node.key) if link.kind == name))
        for node in graph.by_kind.get(kind, ())
    }
    circles = cycles.cycles(parents)
    for cycle in circles:
        place = graph.nodes[kind, cycle[0]].place
        yield error(
            said.code, said.message.replace("{path}", cycles.shown(cycle)), place, said.help, cycle[0]
        )
    if not circles:
        yield from _redundant(graph, name, parents)


def _redundant(graph: Graph, name: str, parents: Mapping[str, Sequence[str]]) -> Iterator[Finding]:
    """Links past a level: their target is above another target of the same node too. `parents` have no circles."""
    depth: dict[str, int] = {}
    for node in reversed(cycles.children_first(parents)):
        depth[node] = 1 + max((depth[above] for above in parents[node] if above in depth), default=-1)
    for link in graph.of_kind(name):
        above = parents.get(link.source[1], ())
        target = link.target[1]
        if len(above) < 2 or target not in depth or link.state == "ambiguous":
            continue
        way = next(
            (other for other in above if other != target and _above(other, target, parents, depth)), None
        )
        if way is not None:
            message = (
                f"{called(link.source)} has the link `{name}` to `{target}`, to which `{way}` leads already"
            )
            yield warning("T142", message, link.place, "drop the link past the level", link.source[1])


def _above(node: str, target: str, parents: Mapping[str, Sequence[str]], depth: Mapping[str, int]) -> bool:
    """Whether a target is somewhere above a node; nothing as far up as the target is looked at."""
    todo, seen = [node], {node}
    for at in todo:  # grows while it is read
        if target in parents.get(at, ()):
            return True
        more = [up for up in parents.get(at, ()) if depth.get(up, -1) > depth[target] and up not in seen]
        seen.update(more)
        todo += more
    return False


__all__ = ["check"]
