"""What definitions come to, each once for the same arguments: rules call the same ones of the same things again and again."""

from __future__ import annotations

from collections.abc import Hashable
from typing import NamedTuple

from trackmarshal import typed
from trackmarshal.typed.base import Typed

#: What is compared by what it says. Whatever holds a formula is not, nor is a difference: messages point to where that stands, each to its own.
_PLAIN = frozenset({
    typed.State, typed.Variable, typed.Sample, typed.ParameterRecord, typed.Signal, typed.Field, typed.Parameter, typed.Literally,
    typed.Pi, typed.Negative, typed.Member, typed.MemberField, typed.PlacedLine, typed.SignalLine, typed.Border,
    typed.Corridor,
})  # fmt: skip
#: What stands for something that was bound elsewhere, and is the same only where that is; for nothing, in a definition that is checked by itself.
_NAMED = frozenset({
    typed.NamedNumber, typed.NamedRecord, typed.NamedSignal, typed.NamedMember, typed.NamedLine, typed.NamedArea,
})  # fmt: skip


class Place(NamedTuple):
    """A definition's name with its module, how many ranges stand around the call, along which timeline, and its arguments as `Shared.argument` gives them."""

    definition: str
    level: int
    timeline: typed.TimeAxis
    arguments: tuple[typed.Value, ...]


class Made(NamedTuple):
    """What a definition came to, of how many definitions that is made, and how many of them are inside each other."""

    value: typed.CalledNumber | typed.CalledFormula
    expansions: int
    depth: int


class Shared:
    """Of one compilation."""

    def __init__(self) -> None:
        self._arguments: dict[Hashable, typed.Value] = {}
        self._ranges: dict[Hashable, typed.Range] = {}
        #: What was made without a word: a warning belongs to each call.
        self.made: dict[Place, Made] = {}

    def argument(self, value: typed.Value) -> typed.Value:
        """The first value that was given and says the same."""
        return self._arguments.setdefault(_said(value), value)

    def range(self, range_: typed.Range) -> typed.Range:
        """The first range of a rule's clauses that says the same: what a rule says of its variables is what another one says of them."""
        return self._ranges.setdefault((_said(range_.domain), range_.names, range_.depth), range_)


def _said(node: Typed) -> Hashable:
    """What a node says, wherever it stands; where that is not looked at, the node, which is equal to itself alone."""
    kind, fields = type(node), node.__dict__
    if kind in _NAMED and fields["value"] is not None:
        return kind, *[fields[name] if name == "value" else _held(fields[name]) for name in kind.compared]
    return (kind, *[_held(fields[name]) for name in kind.compared]) if kind in _PLAIN else node


def _held(value: object) -> Hashable:
    if isinstance(value, Typed):
        return _said(value)
    # Symbols, signals and shapes are there once, and as long as the value that is kept.
    return value if value is None or isinstance(value, str | int | float | tuple) else id(value)
