"""Words for nodes, and their integrity levels."""

from __future__ import annotations

from typing import overload

from trackmarshal.trace.graph.graph import Key, Node

LEVEL = {"QM": 0, "A": 1, "B": 2, "C": 3, "D": 4}
#: Kinds whose ids say by themselves what they are.
_BARE = frozenset({"requirement", "interface"})


def called(key: Key) -> str:
    """A node in a sentence: its kind, and its id in backquotes."""
    kind, id_ = key
    return f"`{id_}`" if kind in _BARE else f"the {kind} `{id_}`"


@overload
def asil(node: Node) -> int | None: ...
@overload
def asil(node: Node, otherwise: int) -> int: ...
def asil(node: Node, otherwise: int | None = None) -> int | None:
    """The integrity level of a node, of a decomposed one what is left to it: QM 0 to D 4; `otherwise` where it has none."""
    level = left_to(node.attributes.get("asil", ""))
    return otherwise if level is None else level


def left_to(asil: str) -> int | None:
    """What a level leaves to do, as it is written: QM 0 to D 4, of `QM(D)` 0; None of what is none."""
    return LEVEL.get(asil.partition("(")[0])


__all__ = ["LEVEL", "asil", "called", "left_to"]
