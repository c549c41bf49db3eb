"""Which nodes of the link graph mean something else than before."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple

from trackmarshal.trace.baseline.changes import changes
from trackmarshal.trace.baseline.content import UNREVIEWED
from trackmarshal.trace.graph.fingerprints import fingerprint
from trackmarshal.trace.graph.graph import Key
from trackmarshal.trace.graph.kinds import NODES
from trackmarshal.trace.impact.resting import rank
from trackmarshal.trace.impact.version import Version

#: What the baseline calls things that the graph calls otherwise.
_KINDS = {"param": "parameter", "evidence": "document"}
#: Nodes of which all that counts is what they say, which is in the graph.
_OF_GRAPH = ("issue",)


class Changed(NamedTuple):
    """A node, or a setting of the project, that is new, gone, or means something else.

    how: "new", "gone" or "changed". what: in words, one for each difference. weaker: whether less is demanded or shown, or that is not known.
    """

    key: Key
    how: str
    what: tuple[str, ...]
    weaker: bool


def changed(before: Version, now: Version) -> list[Changed]:
    """All of them, in the order of the V-model. Titles, reasons, layout and comments do not count."""
    said: dict[Key, list[tuple[str, str, bool]]] = defaultdict(list)
    for one in changes(before.content, now.content, missed=False):
        if one.kind in (UNREVIEWED, "external-tests", *_OF_GRAPH):
            continue  # which reviews fall is told by itself, texts are below, and reports are of no revision
        how = "changed" if one.field else "gone" if one.before else "new"
        said[_key(one.kind, one.name)].append((how, str(one).removeprefix(f"{one.key}: "), one.weaker))
    for key, how, what in (*_texts(before, now), *_code(before, now)):
        said[key].append((how, what, how != "new"))
    found = []
    for key, each in sorted(said.items(), key=lambda item: rank(item[0])):
        # A document that counts at two stages, and now at one, has changed.
        how = each[0][0] if len({one for one, _, _ in each}) == 1 else "changed"
        texts = dict.fromkeys(text for _, text, _ in each) if how == "changed" else {}
        found.append(Changed(key, how, tuple(texts), any(weaker for _, _, weaker in each)))
    return found


def _key(kind: str, name: str) -> Key:
    called = _KINDS.get(kind, kind.replace("-", " "))
    if called == "document":
        name = name.rpartition(" at ")[0]
    return (called if called in NODES else kind, name)


def _texts(before: Version, now: Version) -> Iterator[tuple[Key, str, str]]:
    for kind in _OF_GRAPH:
        old = {node.key: fingerprint(node) for node in before.graph.by_kind.get(kind, ())}
        new = {node.key: fingerprint(node) for node in now.graph.by_kind.get(kind, ())}
        for key in sorted(old.keys() | new.keys()):
            if old.get(key) != new.get(key):
                yield (
                    key,
                    "new" if key not in old else "gone" if key not in new else "changed",
                    "its text changed",
                )


def _code(before: Version, now: Version) -> Iterator[tuple[Key, str, str]]:
    for file in sorted(before.code.keys() | now.code.keys()):
        if before.code.get(file) != now.code.get(file):
            how = "new" if file not in before.code else "gone" if file not in now.code else "changed"
            yield ("code", file), how, "its source changed"
