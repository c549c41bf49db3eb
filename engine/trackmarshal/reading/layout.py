"""The layout of a formula: what every way of printing it has in common.

`formulas` makes it of the typed tree, with all parentheses that reading it back takes; `mathml`, `typst` and `terminal` print it, each with
one case a node. It knows no rules, and nothing of what is printed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

from trackmarshal.node import Node

Opening = Literal["(", "[", "|", "⌊", "⌈", "{"]
Closing = Literal[")", "]", "|", "⌋", "⌉", "}"]
#: What closes a fence.
CLOSING: dict[Opening, Closing] = {"(": ")", "[": "]", "|": "|", "⌊": "⌋", "⌈": "⌉", "{": "}"}


class Digits(Node):
    """A number as written, with its unit ("": none)."""

    text: str
    unit: str = ""


class Name(Node):
    """What an author named, or a Greek letter for it: one letter is set in italics, more are upright."""

    text: str


class Word(Node):
    """A fixed word of formulas, upright."""

    text: str


class Sign(Node):
    """An operator between two things, or before one."""

    text: str


class Row(Node):
    """Things beside each other."""

    parts: tuple[Layout, ...]


class Index(Node):
    """Something with an index below: `v` of `p`, `always` with its window."""

    base: Layout
    index: Layout


class Power(Node):
    """A base, in parentheses if it has parts, and an exponent."""

    base: Layout
    exponent: Layout


class Fraction(Node):
    """One thing over another."""

    over: Layout
    under: Layout


class Root(Node):
    """A square root."""

    inside: Layout


class Fence(Node):
    """Something in parentheses, or between bars."""

    opening: Opening
    inside: Layout


class Call(Node):
    """A function with its arguments in parentheses; without arguments, its name alone."""

    head: Layout
    arguments: tuple[Layout, ...]


class Prefix(Node):
    """`−x`, `¬p`, `always p`."""

    sign: Sign | Word | Index
    operand: Layout


class Joined(Node):
    """A sign and what follows it in a chain."""

    sign: Sign | Word | Index
    operand: Layout


class Chain(Node):
    """`a + b − c`, `p ∧ q`, `0 ≤ a ≤ b`: terms with signs between them, read from the left. logic: it joins formulas, each on a line of its own where lines are broken."""

    first: Layout
    rest: tuple[Joined, ...]
    logic: bool = False


class Binder(Node):
    """`∀ p ∈ plan where c: body`."""

    head: Layout
    where: Layout | None
    body: Layout


class Fold(Node):
    """`∑` or `min` with its range below, and of what; a count has no body."""

    head: Sign | Word
    range: Layout
    body: Layout | None


class Branch(Node):
    """What something is where a condition holds; None: elsewhere."""

    value: Layout
    condition: Layout | None


class Branches(Node):
    """What something is, by conditions: the first that holds counts."""

    branches: tuple[Branch, ...]


#: A piece of a formula.
Layout: TypeAlias = (
    Digits | Name | Word | Sign | Row | Index | Power | Fraction | Root | Fence | Call | Prefix | Chain | Binder | Fold | Branches
)  # fmt: skip


class Line(Node):
    """One line of a formula; indent: how far it is moved in, in steps."""

    indent: int
    parts: tuple[Layout, ...]


def listed(pieces: Sequence[Layout]) -> Layout:
    """`a, b, c`."""
    if len(pieces) == 1:
        return pieces[0]
    parts: list[Layout] = [pieces[0]]
    for piece in pieces[1:]:
        parts += [Sign(","), piece]
    return Row(tuple(parts))
