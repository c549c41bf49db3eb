"""Questions to the graph: over which links one thing leads to another."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from trackmarshal.errors import TrackmarshalError
from trackmarshal.trace.findings import did_you_mean
from trackmarshal.trace.graph.graph import Graph, Key, Link
from trackmarshal.trace.graph.kinds import LINKS, NODES
from trackmarshal.trace.model import matches

CODES = {
    "T169": (
        "a question without an answer",
        "`trace --from` and `--to` name kinds of nodes, such as `test` or `safety-goal`, or ids, in which `*` stands for any characters; "
        "`rule:friction` is the one of that kind. Nothing in the project fits, or the answer would be too long to be one.",
    ),
}  # fmt: skip
#: More rows than this are no answer.
ROWS = 100_000


class Step(NamedTuple):
    """One link of a path, and the node that it leads to; `way` is the link's name in this direction."""

    way: str
    link: Link
    node: Key


class Path(NamedTuple):
    """A shortest way from one node to another; `target` is None where there is none."""

    source: Key
    target: Key | None
    steps: tuple[Step, ...]


def named(graph: Graph, word: str) -> list[Key]:
    """The nodes that a word names: a kind, an id or a pattern, or both as in `rule:fric*`. Raises T169 where nothing fits."""
    kind = _kind(word)
    if kind is not None:
        return [node.key for node in graph.by_kind.get(kind, ())]  # none of a kind that there is: an answer
    before, colon, rest = word.partition(":")
    kind = _kind(before) if colon else None
    if kind is not None and rest:
        found = [node.key for node in graph.by_kind.get(kind, ()) if matches(node.id, (rest,))]
    elif "*" in word:
        found = [key for key in graph.nodes if key[0] != "result" and matches(key[1], (word,))]
    else:
        found = [node.key for node in graph.by_id.get(word, ()) if node.kind != "result"]
    if found:
        return found
    help_ = did_you_mean(word, [*graph.by_id, *NODES]) or "kinds are " + ", ".join(NODES)
    raise TrackmarshalError("T169", f"`{word}` is no kind of nodes, and no id in the project", help=help_)


def _kind(word: str) -> str | None:
    said = word.replace("-", " ").replace("_", " ")
    return said if said in NODES else None


def paths(graph: Graph, sources: Sequence[Key], targets: Sequence[Key]) -> list[Path]:
    """For each source the shortest way to each target, all links leading down or all leading up; one without a target where there is none.

    Links that do not hold (orphaned, unwanted, ambiguous) lead nowhere. Raises T169 for more than ROWS.
    """
    wanted = set(targets)
    useful = [(down, graph.reaching(wanted, down=down)) for down in (True, False)]
    found: list[Path] = []
    for source in dict.fromkeys(sources):
        own: dict[Key, Path] = {}
        for down, way in useful:
            if source in way:
                for path in _from(graph, source, wanted, way, down):
                    if path.target is not None:
                        own.setdefault(path.target, path)
        found += [own[key] for key in sorted(own)] or [Path(source, None, ())]
        if len(found) > ROWS:
            raise TrackmarshalError(
                "T169",
                f"the answer has more than {ROWS} rows",
                help="ask for fewer: name an id, or a pattern",
            )
    return found


def _from(graph: Graph, source: Key, wanted: set[Key], useful: set[Key], down: bool) -> Iterator[Path]:
    """Breadth first from a source, over nodes that lead to a target."""
    came: dict[Key, tuple[Key, Link] | None] = {source: None}
    order = [source]
    for key in order:  # grows while it is read
        for link, other in graph.steps(key, down=down):
            if other in useful and other not in came:
                came[other] = (key, link)
                order.append(other)
    for key in order:
        if key in wanted and key != source:
            yield Path(source, key, _steps(came, key))


def _steps(came: dict[Key, tuple[Key, Link] | None], target: Key) -> tuple[Step, ...]:
    steps: list[Step] = []
    at = target
    while (before := came[at]) is not None:
        previous, link = before
        way = link.kind if link.source == previous else LINKS[link.kind].converse
        steps.append(Step(way, link, at))
        at = previous
    return tuple(reversed(steps))


__all__ = ["CODES", "ROWS", "Path", "Step", "named", "paths"]
