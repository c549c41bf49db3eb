"""Results of cases with verdicts and margins from C; what decided, where, is found among the numpy evaluator's values."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from trackmarshal.backends import results
from trackmarshal.backends.numpy.program import Run
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.witness import Descent
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.verdict import CaseResult, RuleResult

if TYPE_CHECKING:
    from trackmarshal.backends.c.program import CRun


def case_result(run: CRun, index: int, case: Case, values: Run, series: bool) -> CaseResult:
    """The results of all rules on one case."""
    view = CaseView(values, index)
    found = {rule.name: _rule_result(run, index, case, view, rule, series) for rule in run.program.rules}
    return CaseResult(case.id, found, tuple(str(fault) for fault in case.faults))


def _rule_result(
    run: CRun, index: int, case: Case, view: CaseView, rule: RuleInfo, series: bool
) -> RuleResult:
    if case.blocks(rule.reads):
        return results.rule_result(rule, case, view, series)
    verdict, margin = run.outcome(index, rule)
    points = run.program.along(case, rule) if series and rule.along is not None else None
    if verdict == "inactive":
        return RuleResult(rule.name, verdict, math.inf, rule.unit, None, "nothing in its range", points)
    assert rule.formula is not None
    witness = Descent(view).find(rule.formula)
    unit = rule.unit if rule.unit != "mixed" else witness.unit if witness is not None else "1"
    reason = (view.geometry_fault(rule.formula) or "") if verdict == "undefined" else ""
    shown = results.shown_unit(witness, unit)
    return RuleResult(rule.name, verdict, margin, unit, witness, reason, points, shown)
