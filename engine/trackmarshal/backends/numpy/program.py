"""Rules as a straight-line program over arrays: each shared node is one step, computed once for a whole batch."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.backends.numpy.curves import Curve
from trackmarshal.backends.numpy.logic import AT_LEAST, Side, Value
from trackmarshal.backends.numpy.steps import Step, independent, step
from trackmarshal.backends.numpy.views import CaseView
from trackmarshal.backends.results import case_result
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.case import Case
from trackmarshal.runtime.verdict import CaseResult

_VERDICTS = np.array(["satisfied", "undefined", "violated", "inactive"])
_SATISFIED, _UNDEFINED, _VIOLATED, _INACTIVE = range(4)


class Program:
    """The compiled rules; `run` evaluates them on a batch of cases."""

    def __init__(self, spec: Spec, rules: Sequence[RuleInfo]) -> None:
        self.spec = spec
        self.rules = [rule for rule in rules if rule.formula is not None]
        self.rows = {rule.name: row for row, rule in enumerate(self.rules)}
        self.slots: dict[ir.IR, int] = {}
        self.rank = 1
        self._steps: list[Step] = []
        #: Steps whose values no case changes unless it overrides a parameter.
        self._fixed_steps: set[int] = set()
        for rule in self.rules:
            for root in (rule.formula, rule.active):
                if root is not None:
                    self._emit(root)
        self._curves = {name: Curve(table.knots, table.values) for name, table in spec.tables.items()}
        everywhere = list(enumerate(self._steps))
        fixed = self._compute(
            [None] * len(self._steps), [e for e in everywhere if e[0] in self._fixed_steps], self._batch(())
        )
        # numpy takes arrays without axes faster than numbers.
        self._fixed = [np.array(value) if isinstance(value, np.float64) else value for value in fixed]
        self._everywhere = everywhere
        self._varying = [e for e in everywhere if e[0] not in self._fixed_steps]

    def run(self, cases: Sequence[Case]) -> Run:
        """Evaluate all rules on all cases."""
        batch = self._batch(cases)
        steps = self._everywhere if batch.overridden else self._varying
        return Run(self, batch, self._compute(self._fixed.copy(), steps, batch))

    def _batch(self, cases: Sequence[Case]) -> Batch:
        return Batch(self.spec, cases, self.rank, self._curves)

    @staticmethod
    def _compute(values: list[Any], steps: Sequence[tuple[int, Step]], batch: Batch) -> list[Any]:
        # Undefined values are part of the language: divisions by zero and NaN are no cause for warnings.
        with np.errstate(all="ignore"):
            for slot, step in steps:
                values[slot] = step(batch, values)
        return values

    def _emit(self, root: ir.IR) -> None:
        """Steps for a node and all below it, children first; iterative, so depth is no limit."""
        stack: list[tuple[ir.IR, bool]] = [(root, False)]
        while stack:
            node, ready = stack.pop()
            if node in self.slots:
                continue
            for child in node.children():
                if isinstance(child, ir.Axis):
                    self.rank = max(self.rank, child.level + 2)
            inputs = [child for child in node.children() if isinstance(child, (ir.Num, ir.Formula))]
            if not ready:
                stack.append((node, True))
                stack.extend((child, False) for child in reversed(inputs))
                continue
            at = tuple(self.slots[child] for child in inputs)
            slot = self.slots[node] = len(self._steps)
            self._steps.append(step(node, at))
            if independent(node) and self._fixed_steps.issuperset(at):
                self._fixed_steps.add(slot)


class Run:
    """The values of a program for one batch."""

    def __init__(self, program: Program, batch: Batch, values: list[Any]) -> None:
        self.program = program
        self.batch = batch
        self.values = values
        self._closed: dict[ir.IR, tuple[list[Any], ...]] = {}

    def of(self, node: ir.IR) -> Any:
        """The array, or the Value, of a node."""
        return self.values[self.program.slots[node]]

    def closed(self, node: ir.Formula) -> tuple[list[Any], ...]:
        """A formula without free variables in every case: worst sat, worst margin, best sat, best margin."""
        known = self._closed.get(node)
        if known is None:
            value: Value = self.of(node)
            worst = self._listed(value.worst)
            best = worst if value.best is value.worst else self._listed(value.best)
            known = self._closed[node] = (*worst, *best)
        return known

    def _listed(self, side: Side) -> tuple[list[Any], list[Any]]:
        return self._per_case(side.sat).tolist(), self._per_case(side.margin).tolist()

    def _per_case(self, array: Any) -> Any:
        """(cases,) of a closed formula's array."""
        flat = array.ravel()
        return flat if flat.size == self.batch.size else np.repeat(flat, self.batch.size)

    def verdicts(self, rule: RuleInfo) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """(cases,) verdict names and (cases,) margins of a rule, without witnesses."""
        row = self.program.rows[rule.name]
        verdicts, margins = self._verdicts
        return verdicts[row], margins[row]

    @cached_property
    def _verdicts(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """The same of all rules, (rules, cases)."""
        rules, cases = self.program.rules, self.batch.cases
        values: list[Value] = [self.of(rule.formula) for rule in rules]  # type: ignore[arg-type]
        worst = self._sides([value.worst for value in values])
        best = worst if all(v.best is v.worst for v in values) else self._sides([v.best for v in values])
        sat, margin = (worst[0], best[0]), (worst[1], best[1])
        code = np.where(sat[0], _SATISFIED, np.where(sat[1], _UNDEFINED, _VIOLATED))
        margins = np.where(sat[0], margin[0], np.where(sat[1], np.nan, margin[1]))
        ranged = [row for row, rule in enumerate(rules) if rule.active is not None]
        if ranged:
            active, _ = self._sides([self.of(rules[row].active).best for row in ranged])  # type: ignore[arg-type]
            empty = np.zeros(code.shape, dtype=np.bool_)
            empty[ranged] = ~active
            code[empty], margins[empty] = _INACTIVE, np.inf
        for index, case in enumerate(cases):
            if case.unusable:
                blocked = [case.blocks(rule.reads) for rule in rules]
                code[blocked, index], margins[blocked, index] = _UNDEFINED, np.nan
        return _VERDICTS.take(code), margins

    def _sides(self, sides: Sequence[Side]) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """(rules, cases) of whether formulas hold, and of their margins."""
        margin = np.concatenate([self._per_case(side.margin) for side in sides]).reshape(len(sides), -1)
        sat = margin >= 0.0
        for row, side in enumerate(sides):
            if not side.says & AT_LEAST:
                sat[row] = self._per_case(side.sat)
        return sat, margin

    def results(self, series: bool = False) -> Iterator[CaseResult]:
        """The results of every case, with witnesses."""
        for index, case in enumerate(self.batch.cases):
            yield case_result(self.program.rules, case, CaseView(self, index), series)


def evaluate(
    spec: Spec, rules: Sequence[RuleInfo], cases: Sequence[Case], series: bool = False
) -> Iterator[CaseResult]:
    """Evaluate rules on cases, all at once."""
    return Program(spec, rules).run(cases).results(series)
