"""What names stand for where a piece of a formula is written: variables, definitions that are written out, names that are taken."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from trackmarshal import typed
from trackmarshal.reading.layout import Layout
from trackmarshal.reading.names import Kind, Names
from trackmarshal.reading.terminal import text


class Scope:
    """The names of one rule; expand: definitions are written out."""

    def __init__(self, expand: bool = False) -> None:
        self.names = Names()
        self.expand = expand
        #: How many definitions are written out around a place: there, names are what was given; outside, they are `let`s.
        self.inside = 0
        #: What variables are called, by range and offset; and what is called so where we are.
        self._variables: dict[tuple[typed.Range, int], str] = {}
        self._bound: list[str] = []

    @contextmanager
    def entered(self) -> Iterator[None]:
        """In a definition that is written out: its names are what was given."""
        self.inside += 1
        yield
        self.inside -= 1

    @contextmanager
    def left(self) -> Iterator[None]:
        """Back where something was given to a definition."""
        self.inside -= 1
        yield
        self.inside += 1

    @contextmanager
    def given(self) -> Iterator[None]:
        """Where what a name stands for is written: back outside, for a name of a definition."""
        before, self.inside = self.inside, max(self.inside - 1, 0)
        yield
        self.inside = before

    def named(self, kind: Kind, symbol: typed.Symbol) -> Layout:
        return self.names.of(kind, symbol.qualified, symbol.name)

    def local(self, name: str) -> Layout:
        return self.names.of("local", name, name)

    @contextmanager
    def binding(self, range_: typed.Range) -> Iterator[None]:
        """The variables of a range have names, while something below it is written."""
        before = len(self._bound)
        for offset, name in enumerate(map(self._unlike, range_.names)):
            while name in self._bound:
                name += "′"
            self._variables[(range_, offset)] = name
            self._bound.append(name)
        yield
        del self._bound[before:]

    def keep(self, range_: typed.Range) -> None:
        """The variables of a clause, which are bound in all clauses below it."""
        for offset, name in enumerate(map(self._unlike, range_.names)):
            self._variables[(range_, offset)] = name
            self._bound.append(name)

    def _unlike(self, name: str) -> str:
        """The name of a variable, with a prime where something else is shown so, as a parameter of a module that the rule does not see."""
        return f"{name}′" if text(self.local(name)).endswith("′") else name

    def let(self, name: str) -> Layout:
        """The name that a `let` gives."""
        self._bound.append(name)
        return self.local(name)

    @contextmanager
    def apart(self) -> Iterator[None]:
        """Where the rule's own variables are not known: in a definition by itself."""
        bound, self._bound = self._bound, []
        yield
        self._bound = bound

    def variable(self, range_: typed.Range, offset: int) -> str:
        """What a variable is called here; its own name in a definition by itself, where nothing is bound."""
        return self._variables.get((range_, offset), range_.names[offset])
