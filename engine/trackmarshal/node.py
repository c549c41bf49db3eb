"""Immutable records with typed fields: the base of syntax trees, IR nodes and diagnostics.

A frozen dataclass costs about half a millisecond to declare, and a compiler declares hundreds: this base
declares one in microseconds, and type checkers see the same thing (`dataclass_transform`).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar, dataclass_transform


@dataclass_transform(frozen_default=True, eq_default=True)
class Node:
    """A record whose fields are its class's annotations, in order; equal when all fields but `span` are."""

    #: Names of all fields, in the order of declaration.
    fields: ClassVar[tuple[str, ...]] = ()
    #: Names of the fields that equality and hash compare.
    compared: ClassVar[tuple[str, ...]] = ()
    _known: ClassVar[frozenset[str]] = frozenset()

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        own = (
            n for n, kind in cls.__dict__.get("__annotations__", {}).items() if "ClassVar" not in str(kind)
        )
        cls.fields = tuple(dict.fromkeys((*cls.fields, *own)))
        cls._known = frozenset(cls.fields)
        cls.compared = tuple(name for name in cls.fields if name != "span")

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        values = self.__dict__
        values.update(zip(self.fields, args))
        if not kwargs and len(args) == len(self.fields):  # mostly: everything in order
            return
        values.update(kwargs)
        given = len(args) + len(kwargs)
        if len(values) != len(self.fields) or len(values) != given or not self._known.issuperset(kwargs):
            if len(values) < given:
                raise TypeError(f"{type(self).__name__}: too many values, or one given twice")
            if not self._known.issuperset(kwargs):
                raise TypeError(f"{type(self).__name__}: unknown fields {sorted(set(kwargs) - self._known)}")
            for name in self.fields:
                if name not in values:
                    values[name] = getattr(
                        type(self), name
                    )  # the default, or AttributeError: a missing field

    def __setattr__(self, name: str, value: object) -> None:
        raise AttributeError(f"{type(self).__name__} is immutable: cannot set {name}")

    def __eq__(self, other: object) -> bool:
        if type(self) is not type(other):
            return NotImplemented
        return all(self.__dict__[name] == other.__dict__[name] for name in self.compared)

    def __hash__(self) -> int:
        return hash((type(self).__name__, *(self.__dict__[name] for name in self.compared)))

    def __repr__(self) -> str:
        inner = ", ".join(f"{name}={self.__dict__[name]!r}" for name in self.compared)
        return f"{type(self).__name__}({inner})"

    def children(self) -> list[Node]:
        """The nodes held directly in fields, and in tuples in fields, in order."""
        found, values = [], self.__dict__
        for name in self.compared:
            value = values[name]
            if isinstance(value, Node):
                found.append(value)
            elif isinstance(value, tuple):
                found += [item for item in value if isinstance(item, Node)]
        return found

    def walk(self) -> Iterator[Node]:
        """This node and all below it, parents first; iterative, so depth is no limit."""
        stack: list[Node] = [self]
        while stack:
            node = stack.pop()
            yield node
            stack.extend(reversed(node.children()))
