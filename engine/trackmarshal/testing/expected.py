"""What a test expects: a verdict, a margin with its tolerance, and where the rule is decided."""

from __future__ import annotations

import math
from typing import NamedTuple
from weakref import WeakKeyDictionary

from trackmarshal.diagnostics.base import close_matches
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.margins import SCALED, margin_shown, margin_units, own_unit
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.verdict import VERDICTS
from trackmarshal.syntax import ast
from trackmarshal.syntax.ast import span_of
from trackmarshal.testing.constants import Constants, index_of, special
from trackmarshal.testing.errors import BadExpectation
from trackmarshal.units import NUMBER, parse_shown, show


class Expectation(NamedTuple):
    """In SI; unit: of the margin, where a rule's comparisons are in several; at: the index or the id that `binder` has."""

    verdict: str
    margin: float | None
    tolerance: float
    unit: str | None
    binder: str | None
    at: str | None


class Expected(Constants):
    """Reads what a test expects of a rule, which may have errors of its own (None, or without a formula)."""

    kind = BadExpectation

    def of(self, expect: ast.Expect, rule: RuleInfo | None) -> Expectation:
        (margin, unit), (tolerance, other), at, _ = self.expressions.all(
            lambda: (None, None) if expect.margin is None else self._margin(expect.margin, rule),
            lambda: (0.0, None) if expect.tolerance is None else self._tolerance(expect.tolerance, rule),
            lambda: self._at(expect, rule),
            lambda: self._verdict(expect),
        )
        if margin is not None and expect.verdict == "undefined" and not math.isnan(margin):
            assert expect.margin is not None
            self.fail(span_of(expect.margin), "an undefined rule has no margin", "expect the verdict only")
        if unit is not None and other is not None and unit != other:
            assert expect.tolerance is not None
            problem = f"a margin in {unit} has no tolerance in {other}"
            self.fail(span_of(expect.tolerance), problem, f"write it in {unit}")
        return Expectation(expect.verdict, margin, tolerance, unit or other, expect.binder, at)

    def _verdict(self, expect: ast.Expect) -> None:
        if expect.verdict not in VERDICTS:
            known = f"a verdict is {', '.join(VERDICTS[:-1])} or {VERDICTS[-1]}"
            problem = f"`{expect.verdict}` is no verdict that a test can expect"
            word = expect.span.word(expect.verdict)
            self.fail(word, problem, close_matches(expect.verdict, VERDICTS) or known)

    def _at(self, expect: ast.Expect, rule: RuleInfo | None) -> str | None:
        """The index, or the id of an object, at which the rule is expected to be decided."""
        if expect.at is None or expect.binder is None:
            return None
        if rule is not None and rule.formula is not None:
            variables = variables_of(rule.formula)
            if expect.binder not in variables:
                known = "it has " + (", ".join(variables) or "none")
                problem = f"`{rule.name}` has no variable `{expect.binder}`"
                word = expect.span.word(expect.binder)
                self.fail(word, problem, close_matches(expect.binder, variables) or known)
        if expect.at.startswith('"'):
            return expect.at.strip('"')
        index = index_of(expect.at)
        if index is None:
            self.fail(expect.span.word(expect.at), "an index is a whole number, from 0")
        return str(index)

    def _tolerance(self, value: ast.Expr, rule: RuleInfo | None) -> tuple[float, str | None]:
        tolerance, unit = self._margin(value, rule)
        if not 0.0 <= tolerance < math.inf:
            self.fail(span_of(value), "a tolerance is finite and not negative")
        return tolerance, unit

    def _margin(self, value: ast.Expr, rule: RuleInfo | None) -> tuple[float, str | None]:
        """A margin in SI and, where the rule's comparisons are in several units, its unit; None for 0, which is 0 in any."""
        word = special(value)
        if word is not None:
            return word, None
        if rule is None or rule.formula is None:
            return 0.0, None
        if own_unit(rule.unit):
            what, written = f"the margin of `{rule.name}`", margin_shown(rule.formula, rule.unit)
            return self.constant(value, what, parse_shown(rule.unit), written)[0], None
        number, dimension = self.constant(value, f"the margin of `{rule.name}`")
        unit, units = show(dimension), margin_units(rule.formula)
        if dimension == NUMBER and (number == 0.0 or rule.unit == SCALED):
            return number, None
        if unit not in units:
            listed = " and ".join(sorted(units))
            given = unit if dimension != NUMBER else "plain numbers"
            problem = f"no comparison of `{rule.name}` is in {given}"
            self.fail(span_of(value), problem, f"its comparisons are in {listed}; 0 needs no unit")
        if rule.unit == SCALED:
            return number / dict(self.spec.scales).get(unit, 1.0), unit
        return number, unit


#: By formula: a rule has many tests.
_VARIABLES: WeakKeyDictionary[ir.IR, tuple[str, ...]] = WeakKeyDictionary()


def variables_of(formula: ir.Formula) -> tuple[str, ...]:
    """What a formula binds, in order, each once."""
    known = _VARIABLES.get(formula)
    if known is None:
        names: dict[str, None] = {}
        for node in ir.below(formula):
            if isinstance(node, ir.Quantify):
                names.update(dict.fromkeys(node.names))
            elif isinstance(node, ir.At):
                names[node.name] = None
        known = _VARIABLES[formula] = tuple(names)
    return known
