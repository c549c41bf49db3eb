"""Where an expression stands: what it sees, and what is around it."""

from __future__ import annotations

from collections.abc import Mapping

from trackmarshal import typed
from trackmarshal.ir.spec import SignalType
from trackmarshal.node import Node
from trackmarshal.semantics.scope import Scope
from trackmarshal.semantics.values import Local
from trackmarshal.source import Span


class Context(Node):
    """Where an expression stands: the names it sees, how deep it is nested, what its temporal operators range over."""

    scope: Scope
    local: dict[str, Local]
    level: int
    timeline: typed.TimeAxis
    #: The call in the rule's own file, while a definition is written out.
    site: Span | None
    #: Definitions being written out, outermost first.
    stack: tuple[str, ...]

    def bind(
        self, names: Mapping[str, Local], levels: int = 0, timeline: typed.TimeAxis | None = None
    ) -> Context:
        """This context with more local names, and `levels` more axes in use."""
        return Context(
            self.scope,
            {**self.local, **names},
            self.level + levels,
            timeline or self.timeline,
            self.site,
            self.stack,
        )

    def elsewhere(self, scope: Scope, span: Span) -> Context:
        """Where a declaration stands that is used here, at `span`: it sees the names of its own module."""
        return Context(scope, {}, self.level, self.timeline, self.site or span, self.stack)

    def inside(self, scope: Scope, local: dict[str, Local], span: Span, name: str) -> Context:
        """Where the body of a definition stands that is called at `span`: it sees these names, and those of its own module."""
        return Context(scope, local, self.level, self.timeline, self.site or span, (*self.stack, name))


def any_timeline(span: Span) -> typed.TimeAxis:
    """A timeline where only the axis is missing: for definitions, which may use that of a rule, and for what follows an error."""
    domain = typed.Signal(SignalType("", "series", False, (), span), span)
    return typed.Range(domain, ("",), 0, span)
