"""Modules that were compiled before, with others: what they say is the same again where all that they see is."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import TYPE_CHECKING

from trackmarshal.source import Span
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.ir.spec import CourseInfo, RuleInfo, SignalType
    from trackmarshal.semantics.compile import Compiled
    from trackmarshal.semantics.modules import Library


class Before:
    """What an earlier compilation, without any finding, knows of the modules of this one.

    A rule rests on its module's text and on those of all modules that it uses, on signals, events, courses and scales, which are one for all
    modules, and on the assumptions that there are. Whether a state is asked for is found out while rules are made: modules with states, and
    those that use them, are left out.
    """

    def __init__(
        self, before: Compiled | None, library: Library, order: Collection[str], signals: Mapping[str, SignalType],
        events: Mapping[str, Span], courses: Mapping[str, CourseInfo], scales: Mapping[str, float],
    ) -> None:  # fmt: skip
        #: The modules whose definitions and rules are known.
        self.modules: set[str] = set()
        self._rules: dict[tuple[str, str], RuleInfo] = {}
        if before is None or before.found or before.failures:
            return
        spec = before.spec
        known = {course.signal.name: course for course in spec.courses}
        alike = (
            all(_same(signal, spec.signals.get(name)) for name, signal in signals.items())
            and all(span is spec.events.get(name) for name, span in events.items())
            and all(course == known.get(name) for name, course in courses.items())
            and dict(spec.scales) == dict(scales)
        )
        if not alike:
            return
        for name in order:  # each after those that it uses
            module, other = library.modules[name], before.library.modules.get(name)
            if (
                other is not None
                and module.tree is other.tree
                and module.path == other.path
                and all(use.name in self.modules for use in module.uses)
                and not any(isinstance(item, ast.State) for item in module.tree.items)
            ):
                self.modules.add(name)
        self._rules = {(rule.module, rule.name): rule for rule in spec.rules}

    def rule(self, module: str, name: str, assumptions: Collection[str]) -> RuleInfo | None:
        """A rule or an assumption as it was made; None where it is to be made now."""
        found = self._rules.get((module, name)) if module in self.modules else None
        if found is None or any(each not in assumptions for each, _ in found.assuming):
            return None
        return found


def _same(signal: SignalType, other: SignalType | None) -> bool:
    """Whether a signal is declared the same, at the same place."""
    return signal == other and (signal.span.file, signal.span.start) == (
        other.span.file,
        other.span.start,
    )
