"""Keys of what specs and reports of tests name: by which kinds the graph knows it."""

from __future__ import annotations

from collections.abc import Iterator

from trackmarshal.records.specs import SpecItem
from trackmarshal.trace.external import External
from trackmarshal.trace.graph.graph import Key

KIND = {"rule": "rule", "assume": "assumption"}
#: What the engine calls what rules read or rest on, and what that is here. Other inputs of a rule are no things with a name.
USED = {
    "param": "parameter",
    "table": "table",
    "place": "place",
    "signal": "signal",
    "constraint": "constraint",
    "rulebook": "rulebook",
}


def external_key(external: External) -> Key:
    """The key of a test of another runner."""
    return ("external test", f"{external.test.suite}: {external.test.name}")


def uses(item: SpecItem) -> Iterator[tuple[str, str]]:
    """The parameters, tables, places and signals that a rule is made of, where the engine says so."""
    for called in sorted(item.inputs):
        kind, _, name = called.partition(" ")
        if kind in USED:
            yield USED[kind], name
