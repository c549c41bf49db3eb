"""Results of cases with verdicts and margins from C; what decided, where, is found by the reference's values."""

from __future__ import annotations

import math
from collections.abc import Sequence

from trackmarshal.backends import results
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.backends.witness import Descent
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.verdict import CaseResult, RuleResult

Outcomes = dict[str, tuple[str, float]]


def case_result(
    spec: Spec, rules: Sequence[RuleInfo], case: Case, outcomes: Outcomes, series: bool
) -> CaseResult:
    """The results of rules on one case."""
    values = Reference(spec, case)
    found = {rule.name: _rule_result(rule, case, values, *outcomes[rule.name], series) for rule in rules}
    return CaseResult(case.id, found, tuple(str(fault) for fault in case.faults))


def _rule_result(
    rule: RuleInfo, case: Case, values: Reference, verdict: str, margin: float, series: bool
) -> RuleResult:
    if case.blocks(rule.reads):
        return results.rule_result(rule, case, values, series)
    points = results._series(rule, values, series)
    if verdict == "inactive":
        return RuleResult(rule.name, verdict, math.inf, rule.unit, None, "nothing in its range", points)
    assert rule.formula is not None
    witness = Descent(values).find(rule.formula)
    unit = rule.unit if rule.unit != "mixed" else witness.unit if witness is not None else "1"
    reason = (values.geometry_fault(rule.formula) or "") if verdict == "undefined" else ""
    return RuleResult(rule.name, verdict, margin, unit, witness, reason, points)
