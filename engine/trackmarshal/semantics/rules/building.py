"""Rules and assumptions as evaluators take them: checked, typed, lowered, and looked at for what they hardly mean."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.description import describe
from trackmarshal.ir.interning import Interner
from trackmarshal.ir.margins import MIXED, SCALED, margin_unit, measured_units
from trackmarshal.ir.reads import reads
from trackmarshal.ir.spec import ADVISORY, CourseInfo, RuleInfo
from trackmarshal.lowering.rules import Lowered, lower_rule
from trackmarshal.semantics.advice.starting import never_starts
from trackmarshal.semantics.advice.vacuity import vacuous
from trackmarshal.semantics.errors.names import UnknownName, UnknownReference
from trackmarshal.semantics.expressions.context import Context
from trackmarshal.semantics.overrun import misused, misused_along
from trackmarshal.semantics.rules.clauses import typed_rule
from trackmarshal.semantics.rules.placement import check_placement
from trackmarshal.semantics.rules.traces import traces
from trackmarshal.semantics.warnings.codes import WARNINGS
from trackmarshal.semantics.warnings.vacuity import AllowsNothing, UnusedVariable
from trackmarshal.syntax import ast

if TYPE_CHECKING:
    from trackmarshal.semantics.expressions.checking import Expressions

#: So many levels of a rule's core every pass and every evaluator can go down, the stack of whoever calls them counted.
MOST_LEVELS = 300


class RuleBuilder:
    """Turns one declaration into a RuleInfo; what is wrong goes to the expressions' diagnostics."""

    def __init__(self, expressions: Expressions, ctx: Context, interner: Interner) -> None:
        self.x = expressions
        self.ctx = ctx
        self.interner = interner

    def build(self, item: ast.Rule | ast.Assume, assumptions: set[str]) -> RuleInfo | None:
        """The rule; None where an error keeps it from having a meaning."""
        try:
            return self._built(item, assumptions)
        except RecursionError:  # no clause is deep, and what a chain of `let` comes to is
            self.x.too_deep(item.span.head)
            return None

    def _built(self, item: ast.Rule | ast.Assume, assumptions: set[str]) -> RuleInfo | None:
        kind = "rule" if isinstance(item, ast.Rule) else "assume"
        before = len(self.x.found)
        check_placement(item, self.x.found)
        said = traces(item, assumptions, self.ctx.scope, self.x.found)
        rule = typed_rule(item, self.x, self.ctx)
        # An unknown name may be the variable that is not used, misspelt.
        if any(isinstance(d, UnknownName) for d in self.x.found[before:]):
            self.x.found[before:] = [d for d in self.x.found[before:] if not isinstance(d, UnusedVariable)]
        core: Lowered | None = None
        if rule is not None and not any(d.level == "error" for d in self.x.found[before:]):
            core = lower_rule(rule, self.interner)
            if self.interner.depth(core.formula) > MOST_LEVELS:
                self.x.too_deep(item.span.head)
                return None
            self.x.found += vacuous(core, rule, self.x.bounds)
            parts = core.formula, core.active
            over_run = misused(*parts) if core.along is None else misused_along(core.along, *parts)
            if over_run is not None:
                self.x.found.append(over_run)
            elif said.severity != ADVISORY:  # one that never decides keeps nobody from driving
                self.x.found += never_starts(core, rule, self.x.bounds.params)
        self._allow(item, before)
        if any(d.level == "error" for d in self.x.found[before:]):
            return None
        if rule is None and kind == "rule":
            return None
        unit = margin_unit(core.formula if core else None)
        if rule is not None and core is not None and unit == MIXED:
            measured = measured_units(core.formula)
            if len(measured) > 1 and any(self.x.scales.get(each, 1.0) != 1.0 for each in measured):
                core, unit = lower_rule(rule, self.interner, self.x.scales), SCALED
        formula, active, along = (core.formula, core.active, core.along) if core else (None, None, None)
        course = None if along is None else self.x.courses.get(along.signal)
        return RuleInfo(
            item.name, kind, item.title, self.ctx.scope.module, formula, active, along, unit, *said, _read(formula, course),
            fingerprint(item, formula, course), item.span.head, rule, item.span.text.rstrip(),
            () if core is None else core.names, course,
        )  # fmt: skip

    def _allow(self, item: ast.Rule | ast.Assume, before: int) -> None:
        """Leave out the warnings that the rule allows, and report what it allows for nothing."""
        known = WARNINGS - {"W303", "W304"}
        allowed = [code for clause in item.clauses if isinstance(clause, ast.Allow) for code in clause.codes]
        names = {code.name for code in allowed}
        given = {d.code for d in self.x.found[before:] if d.level == "warning"}
        self.x.found[before:] = [
            d for d in self.x.found[before:] if d.level != "warning" or d.code not in names & known
        ]
        for code in allowed:
            if code.name not in known:
                hint = close_matches(code.name, known) or f"the warnings are {', '.join(sorted(known))}"
                self.x.found.append(
                    UnknownReference(code.span, f"`{code.name}` is no warning that can be allowed", hint)
                )
            elif code.name not in given and not any(d.level == "error" for d in self.x.found[before:]):
                self.x.found.append(AllowsNothing(code.span, code.name))


def _read(formula: ir.Formula | None, course: CourseInfo | None) -> frozenset[tuple[str, str]]:
    """Which fields of which signals a rule reads; of a course, those of what it joins."""
    found = reads(formula)
    if course is None:
        return found
    own = {field for signal, field in found if signal == course.signal.name}
    joined = {(signal, field) for signal in (course.lived, course.planned) for field in own}
    both = {(course.planned, "t"), (course.planned, ""), (course.lived, "")}
    return frozenset({pair for pair in found if pair[0] != course.signal.name} | joined | both)


def fingerprint(item: ast.Item, formula: ir.Formula | None, course: CourseInfo | None = None) -> str:
    """A hash of what the rule says: its syntax tree (so layout and comments don't count) and all it is made of."""
    digest = hashlib.sha256(repr(item).encode())
    if formula is not None:
        digest.update(describe(formula).encode())
    if course is not None:
        digest.update(repr(course).encode())
    return digest.hexdigest()
