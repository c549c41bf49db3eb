"""Margins of a rule at every sample of a timeline: of rules along it, and of those for all of its samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from trackmarshal.backends.results import CaseValues
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import Extreme
from trackmarshal.ir.spec import RuleInfo
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import Program

Floats = NDArray[np.float64]


class Sampled:
    """What a rule demands at each sample: `body`, of those for which `guard` holds, wherever all of `whenever` do.

    Raises ValueError for a rule that is about no samples of its own, or about other cycles.
    """

    def __init__(self, rule: RuleInfo) -> None:
        if rule.over_run:
            raise ValueError(f"`{rule.name}` speaks of other cycles, which a case by itself does not have")
        formula, self.whenever = rule.formula, list[ir.Formula]()
        while isinstance(formula, ir.Guarded):
            self.whenever.append(formula.guard)
            formula = formula.body
        self.guard: ir.Formula | None = None
        if rule.course is not None:
            raise ValueError(f"`{rule.name}` speaks of what was driven, which a case by itself does not have")
        if isinstance(formula, ir.At):
            self.axis, self.body = formula.axis, formula.operand
        elif (
            isinstance(formula, ir.Quantify)
            and formula.axis.kind == "samples"
            and formula.extreme is Extreme.LEAST
        ):
            self.axis, self.guard, self.body = formula.axis, formula.guard, formula.body
        else:
            raise ValueError(f"`{rule.name}` does not speak of every sample of a timeline")

    def margins(self, values: CaseValues) -> Floats:
        """(values of the variable,): the margin at each in one case; NaN where undefined, inf where nothing is demanded."""
        worst_sat, worst, best_sat, best = map(np.asarray, values.sides(self.body, self.axis, {}))
        guards: list[tuple[Any, Any]] = []
        for formula in self.whenever:
            truth = values.truth(formula, {})
            guards.append((truth.worst.sat, truth.best.sat))
        if self.guard is not None:
            sides = values.sides(self.guard, self.axis, {})
            guards.append((np.asarray(sides.worst_sat, dtype=bool), np.asarray(sides.best_sat, dtype=bool)))
        for surely, possibly in guards:
            worst_sat, worst = np.where(possibly, worst_sat, True), np.where(possibly, worst, np.inf)
            best_sat, best = np.where(surely, best_sat, True), np.where(surely, best, np.inf)
        margins: Floats = np.where(worst_sat, worst, np.where(best_sat, np.nan, best)) + 0.0  # zero is 0.0
        return margins


def samples(program: Program, rule: RuleInfo, frames: Sequence[Frame]) -> list[Floats]:
    """(samples,) of each frame; of a variable that binds several samples at once, the margin stands at the first of them."""
    sampled = Sampled(rule)
    found = [np.full(frame.count(sampled.axis.signal), np.nan) for frame in frames]
    usable = [place for place, frame in enumerate(frames) if frame.unusable(rule.reads) is None]
    used = [frames[place] for place in usable]
    if not used:
        return found
    rows = _along(program, rule, used)
    if rows is None:
        rows = [sampled.margins(values) for values in _values(program, rule, used)]
    for place, row in zip(usable, rows):
        found[place][: len(row)] = row
        found[place][len(row) :] = np.inf
    return found


def _along(program: Program, rule: RuleInfo, frames: Sequence[Frame]) -> list[Floats] | None:
    """The series of generated code, where it has one; None for any other program or rule."""
    if rule.along is None or program.identity["backend"] != "c":
        return None
    from trackmarshal.backends.c.program import CProgram

    if not isinstance(program, CProgram):  # others of its rules remember
        return None
    return [np.array(program.along(frame, rule)[1], dtype=np.float64) for frame in frames]


def _values(program: Program, rule: RuleInfo, frames: Sequence[Frame]) -> list[CaseValues]:
    """The values of a rule's formulas in each frame: generated code keeps none, so that numpy looks for them."""
    from trackmarshal.backends.numpy.program import NumpyProgram
    from trackmarshal.backends.numpy.views import CaseView
    from trackmarshal.backends.reference.evaluator import Reference
    from trackmarshal.backends.reference.functions import Functions

    match program.identity["backend"]:
        case "reference":
            functions = Functions()
            return [Reference(program.spec, frame, functions=functions) for frame in frames]
        case "numpy" | "c":
            of_arrays = program if isinstance(program, NumpyProgram) else NumpyProgram(program.spec, [rule])
            run = of_arrays.run(frames)
            return [CaseView(run, index) for index in range(len(frames))]
        case other:
            raise AssertionError(f"unknown backend {other}")
