"""Whether the two evaluators agree on a generated subject, and what is true of every result."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from trackmarshal import evaluation
from trackmarshal.backends.numpy import steps
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.backends.reference.functions import Env, Functions, Number
from trackmarshal.backends.results import outcome
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import arithmetic
from trackmarshal.ir import nodes as ir
from trackmarshal.ir.operators import FUNCTIONS
from trackmarshal.ir.spec import RuleInfo, Spec
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.program import SAFE_CODES, Program
from trackmarshal.runtime.verdict import VERDICTS, CaseResult, RuleResult

#: Functions of which the platform's libm and numpy's own code may give neighbouring doubles.
INEXACT = frozenset(name for name, function in FUNCTIONS.items() if function.libm)


@lru_cache(128)
def compiled(text: str) -> Spec:
    """A spec from text, one for all evaluators that are asked about it; raises Diagnostics."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "made.spec"
        path.write_text(text, encoding="utf-8")
        return evaluation.load(
            [path], [], Path(folder)
        )  # places are those in the folder: the same text is the same program


def inexact(rule: RuleInfo) -> bool:
    """Whether a rule computes with functions whose last digit is libm's."""
    roots = [root for root in (rule.formula, rule.active) if root is not None]
    return any(
        isinstance(node, ir.Func) and node.name in INEXACT for root in roots for node in ir.below(root)
    )


#: numpy's names of the functions whose last digit is libm's.
_OF_NUMPY = {"atan2": "arctan2", "pow": "power", "asin": "arcsin", "acos": "arccos"}


@contextmanager
def one_libm() -> Iterator[None]:
    """Within, numpy's inexact functions are those of Python's math module, number by number: nothing excuses a difference."""
    with ExitStack() as stack:
        for name in INEXACT:
            function = np.frompyfunc(
                lambda *args, name=name: arithmetic.apply(name, args), FUNCTIONS[name].arity, 1
            )

            def take(*args: Any, out: Any = None, function: Any = function) -> Any:
                values = np.asarray(
                    function(*(np.asarray(arg, dtype=np.float64) for arg in args)), dtype=np.float64
                )
                if out is None:
                    return values[()]
                out[...] = values
                return out

            # Geometry asks numpy itself, steps have a table of their own (but for `pow`, which does more).
            stack.enter_context(mock.patch.object(np, _OF_NUMPY.get(name, name), take))
            if name != "pow":
                stack.enter_context(mock.patch.dict(steps.CALLS, {name: take}))
        yield


def same_trigonometry() -> bool:
    """Whether numpy's sines and cosines are libm's, as far as a sample of angles can tell."""
    angles = [0.37 * k - 100.0 for k in range(600)]
    return all(np.sin(a) == math.sin(a) and np.cos(a) == math.cos(a) for a in angles)


def results(spec: Spec, cases: Sequence[Frame], backend: str, series: bool = True) -> list[CaseResult]:
    """All rules of a spec on all cases."""
    return list(Evaluator(spec, None, backend).evaluate(cases, series))


def outcomes(program: Program | Evaluator, frames: Sequence[Frame]) -> list[dict[str, tuple[str, float]]]:
    """Verdict and margin of every rule on every case, as a program says them without looking for witnesses."""
    return [
        {
            rule.name: (VERDICTS[code], float(margin))
            for rule, code, margin in zip(
                program.rules, judged.rated[""].verdicts, judged.rated[""].margins, strict=True
            )
        }
        for judged in program.judge_all(frames)
    ]


def said_of(evaluator: Evaluator, raw: object) -> dict[str, tuple[str, float]]:
    """The same on one case from plain data, by itself."""
    with evaluator.alone:
        (found,) = outcomes(evaluator, [evaluator.read(raw)])
    return found


def unsafe(evaluator: Evaluator, frames: Sequence[Frame]) -> list[set[str]]:
    """The rules that make each case unsafe. What decided is not looked for, which takes as long as all the rest."""
    judged = (
        one for start in range(0, len(frames), evaluation.CHUNK) for one in evaluator.judge_all(frames[start : start + evaluation.CHUNK])
    )  # fmt: skip
    return [
        {
            rule.name
            for rule, code in zip(evaluator.rules, one.rated[""].verdicts, strict=True)
            if code not in SAFE_CODES and not rule.advisory
        }
        for one in judged
    ]


def read(spec: Spec, raw: Sequence[dict[str, Any]]) -> list[Frame]:
    """Cases that a spec can read; those that are refused are left out, as `eval` reports them and goes on."""
    reader = Evaluator(spec)
    cases = []
    for case in raw:
        try:
            cases.append(reader.read(case))
        except TrackmarshalError as error:
            if not error.code.startswith("D2"):
                raise
    return cases


def same(a: float, b: float) -> bool:
    """The same double, the sign of zero included; all NaNs are one."""
    return (a == b and math.copysign(1.0, a) == math.copysign(1.0, b)) or (math.isnan(a) and math.isnan(b))


def differences(left: CaseResult, right: CaseResult) -> list[str]:
    """Where two results of a case differ: verdicts, margins, units, witnesses, reasons, series."""
    found = []
    if left.rules.keys() != right.rules.keys() or left.faults != right.faults:
        found.append(f"rules {list(left.rules)} {left.faults} | {list(right.rules)} {right.faults}")
    for name, one in left.rules.items():
        other = right.rules[name]
        if one.verdict != other.verdict or not same(one.margin, other.margin):
            found.append(
                f"case {left.id} {name}: {one.verdict} {one.margin!r} | {other.verdict} {other.margin!r}"
            )
        elif not same_witness(one, other):
            found.append(f"case {left.id} {name}: witness {one.witness} | {other.witness}")
        elif (one.unit, one.reason) != (other.unit, other.reason):
            found.append(f"case {left.id} {name}: {one.unit} {one.reason} | {other.unit} {other.reason}")
        elif not same_series(one, other):
            found.append(f"case {left.id} {name}: series {one.series} | {other.series}")
    return found


#: How far margins may be apart that inexact functions contribute to: this share of the largest number computed on the way.
TOLERANCE = 1e-11


class Measured(Reference):
    """The reference evaluator, which also keeps the magnitude of the largest finite number of any step."""

    def __init__(self, spec: Spec, case: Frame) -> None:
        super().__init__(spec, case, functions=_Noting())
        self.largest = 0.0


class _Noting(Functions):
    """Functions of nodes that tell a case each number on the way."""

    def _number(self, node: ir.Num) -> Number:
        made = super()._number(node)

        def noted(case: Reference, env: Env) -> float:
            value = made(case, env)
            if isinstance(case, Measured) and math.isfinite(value):
                case.largest = max(case.largest, abs(value))
            return value

        return noted


def near_differences(spec: Spec, case: Frame, left: CaseResult, right: CaseResult) -> list[str]:
    """As `differences`, where libm's last digit counts: margins within `TOLERANCE`, verdicts where margins are beyond it."""
    found = []
    for rule in spec.rules:
        one, other = left.rules[rule.name], right.rules[rule.name]
        if not inexact(rule):
            found += differences(
                CaseResult(left.id, {rule.name: one}), CaseResult(left.id, {rule.name: other})
            )
            continue
        values = Measured(spec, case)
        outcome(rule, case, values)
        reach = TOLERANCE * values.largest
        near = same(one.margin, other.margin) or abs(one.margin - other.margin) <= reach
        doubtful = abs(one.margin) <= reach and {one.verdict, other.verdict} <= {"satisfied", "violated"}
        if not near or (one.verdict != other.verdict and not doubtful):
            found.append(
                f"case {left.id} {rule.name}: {one.verdict} {one.margin!r} | {other.verdict} {other.margin!r} +- {reach}"
            )
    return found


def same_witness(one: RuleResult, other: RuleResult) -> bool:
    """Whether two results name the same comparison at the same place, with the same margin."""
    a, b = one.witness, other.witness
    if a is None or b is None:
        return a is b
    return a.binders == b.binders and a.span == b.span and a.unit == b.unit and same(a.margin, b.margin)


def same_series(one: RuleResult, other: RuleResult) -> bool:
    if one.series is None or other.series is None:
        return one.series is other.series
    return (
        one.series[0] == other.series[0]
        and len(one.series[1]) == len(other.series[1])
        and all(map(same, one.series[1], other.series[1]))
    )


def check_sound(case: Frame, result: CaseResult) -> list[str]:
    """What no result may be, whatever the rules: safe on broken data, NaN on a verdict that has a margin."""
    found = []
    if result.safe and (case.faults or case.settings.broken):
        found.append(f"case {case.id} is rated safe with faults {case.faults}")
    for rule in result.rules.values():
        if math.isnan(rule.margin) != (rule.verdict == "undefined"):
            found.append(f"case {case.id} {rule.rule}: {rule.verdict} with margin {rule.margin!r}")
        if rule.verdict not in ("satisfied", "violated", "undefined", "inactive"):
            found.append(f"case {case.id} {rule.rule}: no such verdict {rule.verdict}")
        if result.safe and rule.verdict not in ("satisfied", "inactive"):
            found.append(f"case {case.id} {rule.rule}: {rule.verdict} is rated safe")
    return found
