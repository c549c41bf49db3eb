"""Which names a module can see, and what they were declared as."""

from __future__ import annotations

from trackmarshal.diagnostics.base import Diagnostic, close_matches
from trackmarshal.node import Node
from trackmarshal.semantics.errors import Ambiguous, Duplicate, UnknownName
from trackmarshal.source import Span
from trackmarshal.syntax import ast

#: Declarations that put a name into the module's scope, and what messages call them.
KINDS: dict[type[ast.Item], str] = {
    ast.Signal: "signal", ast.Event: "event", ast.Param: "parameter", ast.Table: "table", ast.Place: "place",
    ast.Define: "definition", ast.Reference: "reference", ast.State: "state", ast.Rulebook: "rulebook",
}  # fmt: skip


class Symbol(Node):
    """A declared name: its declaration and the module it stands in."""

    item: ast.Item
    module: str
    qualified: str


class Scope:
    """The names of one module: its own, then those of the modules that it uses."""

    def __init__(self, module: str, found: list[Diagnostic]) -> None:
        self.module = module
        self.own: dict[str, Symbol] = {}
        self.used: dict[str, list[Symbol]] = {}
        self._found = found

    def declare(self, name: str, item: ast.Item) -> None:
        known = self.own.get(name)
        if known is not None:
            self._found.append(Duplicate(_head(item), _head(known.item), KINDS[type(item)], name))
            return
        self.own[name] = Symbol(item, self.module, f"{self.module}.{name}")

    def use(self, other: Scope) -> None:
        for name, symbol in other.own.items():
            symbols = self.used.setdefault(name, [])
            if symbol not in symbols:
                symbols.append(symbol)

    def names(self) -> set[str]:
        return {*self.own, *self.used}

    def find(self, name: str) -> Symbol | None:
        """The symbol, or None; never reports."""
        if name in self.own:
            return self.own[name]
        found = self.used.get(name, [])
        return found[0] if len(found) == 1 else None

    def look_up(self, name: str, span: Span, what: str, extra: set[str]) -> Symbol | Diagnostic:
        """The symbol, or what is wrong with the name; `extra` are other names known at this place."""
        if name in self.own:
            return self.own[name]
        found = self.used.get(name, [])
        if len(found) > 1:
            return Ambiguous(span, found[0].item.__dict__["span"], name)
        if found:
            return found[0]
        return UnknownName(span, what, name, close_matches(name, self.names() | extra))


def _head(item: ast.Item) -> Span:
    """The first line of a declaration: where messages point to it."""
    span: Span = item.__dict__["span"]
    stop = span.file.text.find("\n", span.start)
    return Span(span.file, span.start, min(span.end, stop if stop >= 0 else span.end))
