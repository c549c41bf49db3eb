"""Compiled rules, and what they come to for a batch of cases."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.numpy.batch import Batch
from trackmarshal.backends.numpy.code import Code
from trackmarshal.backends.numpy.curves import Curve
from trackmarshal.backends.numpy.logic import AT_LEAST, NEITHER, Side, Value, value
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
        formulas, ranges = [rule.formula for rule in self.rules], [rule.active for rule in self.rules]
        self.code = Code([f for f in formulas if f is not None], [f for f in ranges if f is not None])
        self._fixed, self._varying = self.code.functions()
        outputs = {name: place for place, name in enumerate(self.code.outputs)}
        #: By formula: what its margins say, and where they and whether it holds are among the values of a run.
        self.places = {
            node: (formula.says, tuple(outputs[name] for name in formula.names))
            for node, formula in self.code.formulas.items()
        }
        self.outcomes = _Formulas(self.places, formulas)
        self.ranges = _Formulas(self.places, ranges)
        self._curves = {name: Curve(table.knots, table.values) for name, table in spec.tables.items()}
        with np.errstate(all="ignore"):
            # numpy takes arrays without axes faster than numbers.
            self._left = tuple(map(_without_axes, self._fixed(self._batch(()))))

    def run(self, cases: Sequence[Case]) -> Run:
        """Evaluate all rules on all cases."""
        batch = self._batch(cases)
        # Undefined values are part of the language: divisions by zero and NaN are no cause for warnings.
        with np.errstate(all="ignore"):
            left = self._fixed(batch) if batch.overridden else self._left
            return Run(self, batch, self._varying(batch, left))

    def _batch(self, cases: Sequence[Case]) -> Batch:
        return Batch(self.spec, cases, self.code.rank, self._curves)


def _without_axes(value: Any) -> Any:
    return np.array(value) if isinstance(value, np.float64) else value


class _Formulas:
    """Formulas without free variables, some of them rules: where they are among the values of a run."""

    def __init__(
        self, places: Mapping[ir.IR, tuple[int, tuple[int, ...]]], formulas: Sequence[ir.Formula | None]
    ) -> None:
        #: Which of the rules has such a formula.
        self.rows = [row for row, formula in enumerate(formulas) if formula is not None]
        found = [places[formula] for formula in formulas if formula is not None]
        self._margins = [[at[best] for _, at in found] for best in (0, 1)]
        self._strict = [[not says & AT_LEAST] for says, _ in found]
        self._unsaid = [(row, at[2:]) for row, (says, at) in enumerate(found) if says == NEITHER]

    def undefined(self, values: Sequence[Any]) -> bool:
        """Whether one is undefined in some case."""
        return any(values[worst] is not values[best] for worst, best in zip(*self._margins))

    def read(
        self, values: Sequence[Any], best: bool, size: int
    ) -> tuple[NDArray[np.bool_], NDArray[np.float64]]:
        """(formulas, cases) of whether they hold, and of their margins."""
        rows = [_of_cases(values[place], size) for place in self._margins[best]]
        margins = np.concatenate(rows, axis=None).reshape(len(rows), size)
        sat = np.where(self._strict, margins > 0.0, margins >= 0.0)
        for row, places in self._unsaid:
            sat[row] = _of_cases(values[places[best]], size).ravel()
        return sat, margins


def _of_cases(array: Any, size: int) -> Any:
    """A value for every case, of an array without other axes or of one value for all."""
    return array if array.size == size else np.repeat(array, size)


class Run:
    """The values of a program for one batch."""

    def __init__(self, program: Program, batch: Batch, values: tuple[Any, ...]) -> None:
        self.program = program
        self.batch = batch
        self._values = values
        self._made: dict[ir.IR, Value] = {}
        self._closed: dict[ir.IR, tuple[list[Any], ...]] = {}

    def of(self, node: ir.Formula) -> Value:
        """The value of a formula."""
        made = self._made.get(node)
        if made is None:
            says, at = self.program.places[node]
            worst, best, *sats = (self._values[place] for place in at)
            made = self._made[node] = value(worst, best, says, *sats)
        return made

    def closed(self, node: ir.Formula) -> tuple[list[Any], ...]:
        """A formula without free variables in every case: worst sat, worst margin, best sat, best margin."""
        known = self._closed.get(node)
        if known is None:
            worst_side, best_side = self.of(node)
            worst = self._listed(worst_side)
            best = worst if best_side is worst_side else self._listed(best_side)
            known = self._closed[node] = (*worst, *best)
        return known

    def _listed(self, side: Side) -> tuple[list[Any], list[Any]]:
        size = self.batch.size
        return _of_cases(side.sat, size).ravel().tolist(), _of_cases(side.margin, size).ravel().tolist()

    def verdicts(self, rule: RuleInfo) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """(cases,) verdict names and (cases,) margins of a rule, without witnesses."""
        row = self.program.rows[rule.name]
        verdicts, margins = self._verdicts
        return verdicts[row], margins[row]

    @cached_property
    def _verdicts(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
        """The same of all rules, (rules, cases)."""
        rules, values, size = self.program.outcomes, self._values, self.batch.size
        sat, margins = rules.read(values, False, size)
        code = np.where(sat, _SATISFIED, _VIOLATED)
        if rules.undefined(values):
            possible, best = rules.read(values, True, size)
            code[possible & ~sat] = _UNDEFINED
            margins = np.where(sat, margins, np.where(possible, np.nan, best))
        ranged = self.program.ranges
        if ranged.rows:
            active, _ = ranged.read(values, True, size)
            empty = np.zeros(code.shape, dtype=np.bool_)
            empty[ranged.rows] = ~active
            code[empty], margins[empty] = _INACTIVE, np.inf
        for index, case in enumerate(self.batch.cases):
            if case.unusable:
                blocked = [case.blocks(rule.reads) for rule in self.program.rules]
                code[blocked, index], margins[blocked, index] = _UNDEFINED, np.nan
        return _VERDICTS.take(code), margins

    def results(self, series: bool = False) -> Iterator[CaseResult]:
        """The results of every case, with witnesses."""
        for index, case in enumerate(self.batch.cases):
            yield case_result(self.program.rules, case, CaseView(self, index), series)


def evaluate(
    spec: Spec, rules: Sequence[RuleInfo], cases: Sequence[Case], series: bool = False
) -> Iterator[CaseResult]:
    """Evaluate rules on cases, all at once."""
    return Program(spec, rules).run(cases).results(series)
