"""From values of formulas to results of rules: the same for every evaluator."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

from trackmarshal.backends.witness import Descent, Values
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.verdict import CaseResult, RuleResult, Truth, Witness


class CaseValues(Values, Protocol):
    """What a result needs to know of one case from an evaluator."""

    def along(self, node: ir.Formula, axis: ir.Axis, env: dict[int, int]) -> Sequence[Truth]: ...

    def geometry_fault(self, formula: ir.Formula) -> str | None: ...


def case_result(
    rules: Sequence[RuleInfo], case: Case, values: CaseValues, series: bool = False
) -> CaseResult:
    """The results of rules on one case; rules without a formula (assumptions without a monitor) have none."""
    results = {r.name: rule_result(r, case, values, series) for r in rules if r.formula is not None}
    return CaseResult(case.id, results, tuple(str(fault) for fault in case.faults))


def rule_result(rule: RuleInfo, case: Case, values: CaseValues, series: bool = False) -> RuleResult:
    """The result of one rule on one case."""
    formula = rule.formula
    assert formula is not None
    if case.blocks(rule.reads):
        return RuleResult(
            rule.name,
            "undefined",
            math.nan,
            rule.unit,
            None,
            _blocked_reason(rule, case),
            _no_series(rule, case, series),
        )
    if rule.active is not None and not values.truth(rule.active, {}).best.sat:
        return RuleResult(
            rule.name,
            "inactive",
            math.inf,
            rule.unit,
            None,
            "nothing in its range",
            _series(rule, values, series),
        )
    truth = values.truth(formula, {})
    witness = Descent(values).find(formula)
    unit = rule.unit if rule.unit != "mixed" else witness.unit if witness is not None else "1"
    reason = ""
    if truth.verdict == "undefined":
        reason = values.geometry_fault(formula) or ""
    return RuleResult(
        rule.name,
        truth.verdict,
        truth.margin,
        unit,
        witness,
        reason,
        _series(rule, values, series),
        shown_unit(witness, unit),
    )


def shown_unit(witness: Witness | None, unit: str) -> str:
    """The unit in which a rule's margin is shown: the one of the limit that decided, where it measures the same."""
    return witness.shown if witness is not None and witness.unit == unit else ""


def _series(rule: RuleInfo, values: CaseValues, wanted: bool) -> tuple[list[str], list[float]] | None:
    """The formula's value at every sample, for rules that live along a timeline."""
    if not wanted or rule.along is None:
        return None
    assert isinstance(rule.formula, ir.First)
    truths = values.along(rule.formula.operand, rule.along, {})
    return [t.verdict for t in truths], [t.margin for t in truths]


def _no_series(rule: RuleInfo, case: Case, wanted: bool) -> tuple[list[str], list[float]] | None:
    if not wanted or rule.along is None:
        return None
    count = case.counts.get(rule.along.signal, 0)
    return ["undefined"] * count, [math.nan] * count


def _blocked_reason(rule: RuleInfo, case: Case) -> str:
    for fault in case.faults:
        if any(fault.signal == signal and fault.field in ("", name) for signal, name in rule.reads):
            return str(fault)
    return "an input that it reads is unusable"


def chosen_rules(spec: Spec, names: Sequence[str] | None) -> list[RuleInfo]:
    """All rules and monitors of a spec, or the named ones; raises KeyError for an unknown name."""
    if names is None:
        return [rule for rule in spec.rules if rule.formula is not None]
    return [rule for name in names for rule in [_named(spec, name)] if rule.formula is not None]


def _named(spec: Spec, name: str) -> RuleInfo:
    rule = spec.rule(name)
    if rule is None:
        raise KeyError(name)
    return rule
