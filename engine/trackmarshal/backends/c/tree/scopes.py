"""Functions while they are written: scopes that are added to in any order, and become statements of the tree when all is there."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from trackmarshal.backends.c.tree.nodes import Expr, Remark, Statement
from trackmarshal.ir import nodes as ir

#: What makes a statement of a scope's body.
Head = Callable[[tuple[Statement, ...]], Statement]


@dataclass(eq=False)
class Scope:
    """Statements of a body; `head` makes the statement that has it, None where there is none and they stand in the scope around it.

    `binds` maps axes to their index here.
    Every statement has a place in the spec ("" where it has none of its own), which is named where it changes.
    """

    head: Head | None = None
    parent: Scope | None = None
    binds: dict[ir.Axis, Expr] = field(default_factory=dict)
    #: What the spec calls the variables of those axes.
    binders: dict[ir.Axis, tuple[str, ...]] = field(default_factory=dict)
    #: What was computed in this scope already.
    known: dict[object, Expr] = field(default_factory=dict)
    #: What is read in this scope alone, and computed in it: it is not always entered.
    own: frozenset[object] = frozenset()
    #: Names declared here, and in scopes inside, in lower case.
    names: set[str] = field(default_factory=set)
    inside: set[str] = field(default_factory=set)
    items: list[tuple[Statement, str] | Scope] = field(default_factory=list)
    #: Inner scopes that are being written; what is added meanwhile stands before them.
    opened: list[Scope] = field(default_factory=list)

    def add(self, statement: Statement, place: str = "") -> None:
        """Append a statement."""
        self._insert((statement, place))

    def _insert(self, item: tuple[Statement, str] | Scope) -> None:
        if self.opened:
            self.items.insert(self.items.index(self.opened[-1]), item)
        else:
            self.items.append(item)

    def open(self, head: Head | None) -> Scope:
        """Append an inner scope; `close` says that it is written."""
        inner = Scope(head, self)
        self._insert(inner)
        self.opened.append(inner)
        return inner

    def close(self, inner: Scope) -> None:
        """End the inner scope that was opened last."""
        last = self.opened.pop()
        if last is not inner:
            raise AssertionError("scopes end in the order in which they were opened, the last one first")

    def end(self, outer: Scope) -> None:
        """End this scope, and those around it that are in an outer one."""
        scope = self
        while scope is not outer:
            assert scope.parent is not None
            scope.parent.close(scope)
            scope = scope.parent

    def chain(self) -> Iterator[Scope]:
        """This scope and those around it, the innermost first."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def take(self, *wanted: str) -> str:
        """Declare a name here: the first of those wanted that nothing has in this scope, around it or inside, else a number is added."""
        if (
            self.head is None and self.parent is not None
        ):  # no braces: its names are those of the scope around it
            return self.parent.take(*wanted)
        around = [scope.names for scope in self.chain()] + [self.inside]
        number = 1
        while True:
            for name in wanted:
                made = name if number == 1 else f"{name}_{number}"
                folded = made.casefold()
                if not any(folded in names for names in around):
                    self.names.add(folded)
                    for scope in self.chain():
                        scope.inside.add(folded)
                    return made
            number += 1

    def statements(self, last: list[str]) -> tuple[Statement, ...]:
        """The statements, with a remark wherever their place in the spec is another one than that of the `last`."""
        found: list[Statement] = []
        for item in self.items:
            if isinstance(item, Scope):
                body = item.statements(last)
                if item.head is not None:
                    found.append(item.head(body))
                else:
                    found += body
                continue
            statement, place = item
            if place and place != last[0]:
                found.append(Remark(place))
                last[0] = place
            found.append(statement)
        return tuple(found)
