"""What all nodes of the typed tree are, and what their operators are called as written."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, Self

from trackmarshal.node import Node
from trackmarshal.source import Span

Comparing = Literal["<", "<=", ">", ">=", "==", "!="]
Joining = Literal["and", "or", "implies", "iff", "xor"]
Stepping = Literal["next", "previous"]
Changing = Literal["rising", "falling"]

#: Comparisons of two numbers, as written.
COMPARISONS: tuple[Comparing, ...] = ("<", "<=", ">", ">=", "==", "!=")
#: Connectives of two formulas, as written.
CONNECTIVES: tuple[Joining, ...] = ("and", "or", "implies", "iff", "xor")
#: Steps along a timeline, as written.
STEPS: tuple[Stepping, ...] = ("next", "previous")
#: What tells that a formula became true, or false.
EDGES: tuple[Changing, ...] = ("rising", "falling")


class Typed(Node):
    """A node of the typed tree; equal only to itself: what a name stands for hangs in the tree wherever the name is used."""

    __eq__ = object.__eq__
    __hash__ = object.__hash__

    def at(self, span: Span) -> Self:
        """The same at another place."""
        made = object.__new__(type(self))
        made.__dict__.update(self.__dict__, span=span)
        return made


def below(root: Typed) -> Iterator[Typed]:
    """A node and all below it, parents first and from the left; each shared one once."""
    seen: set[Typed] = set()
    stack: list[Typed] = [root]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            yield node
            stack.extend(reversed([child for child in node.children() if isinstance(child, Typed)]))
