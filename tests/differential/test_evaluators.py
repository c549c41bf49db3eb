"""The two evaluators on generated specs and inputs: one meaning.

Verdicts are equal, and margins are the same doubles (NaN equal to NaN), as are witnesses,
units, reasons and series; where rules use functions of libm (sin, pow and their like), of which numpy has its own code, in two ways:
with both evaluators on one libm everything is equal to the last bit all the same; and with each on its own, where the
functions stand so that errors do not grow, margins differ by no more than 1e-11 of the largest number computed on the way,
and verdicts not at all unless the margin is that near to zero. Geometry takes sines and cosines of headings; where numpy's are
not libm's, it is held against the reference on one libm.

TRACKMARSHAL_GENERATED=N generates N specs with inputs, and prints what came of them.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from unittest import mock

import pytest
from hypothesis import given, settings

from property.strategies.specs import repeatable, subjects
from support.agreement import (
    Measured,
    check_sound,
    compiled,
    differences,
    near_differences,
    one_libm,
    outcomes,
    read,
    results,
    same,
    same_trigonometry,
)
from support.generated import RandomChoices, Subject, subject
from support.length import amount
from trackmarshal.backends.numpy import places
from trackmarshal.backends.results import outcome
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.verdict import CaseResult

pytestmark = pytest.mark.verifies("S-1-B-1")


@dataclass(frozen=True)
class Kind:
    """What is generated, and how it is compared."""

    inexact: str = "no"
    geometry: bool = False
    one_libm: bool = False

    def disagreements(self, made: Subject, counts: Counter[str]) -> list[str]:
        """Where the evaluators differ on a subject, and what is wrong with both."""
        with ExitStack() as stack:
            if self.one_libm:
                stack.enter_context(one_libm())
            spec = compiled(made.text)
            cases = read(spec, made.cases)
            pairs = list(
                zip(cases, results(spec, cases, "reference"), results(spec, cases, "numpy"), strict=True)
            )
            found = _alone(Evaluator(spec, None, "numpy"), [(case, right) for case, _, right in pairs])
            if self.geometry:  # as numpy judges many footprints
                stack.enter_context(mock.patch.object(places, "MANY", 0))
                pairs += [(*pair[:2], result) for pair, result in zip(pairs, results(spec, cases, "numpy"))]
            for case, left, right in pairs:
                near = self.inexact == "gentle"
                found += near_differences(spec, case, left, right) if near else differences(left, right)
                found += check_sound(case, left)
                counts.update(rule.verdict for rule in left.rules.values())
                counts["faulty cases"] += bool(case.faults)
            counts.update(
                {
                    "specs": 1,
                    "rules": len(spec.rules),
                    "cases": len(cases),
                    "refused cases": len(made.cases) - len(cases),
                }
            )
        return found


def _alone(evaluator: Evaluator, pairs: Sequence[tuple[Frame, CaseResult]]) -> list[str]:
    """Where numpy says of a case by itself, which may leave out what no rule asks about, something else than among others."""
    found = []
    for case, among in pairs:
        for name, (verdict, margin) in outcomes(evaluator, [case])[0].items():
            said = among.rules[name]
            if verdict != said.verdict or not same(margin, said.margin):
                found.append(
                    f"{name} alone: {verdict} {margin!r}, among others: {said.verdict} {said.margin!r}"
                )
    return found


KINDS = {
    "exact": Kind(),
    "one libm": Kind("any", one_libm=True),
    "own libm": Kind("gentle"),
    "geometry": Kind(geometry=True, one_libm=not same_trigonometry()),
    "everything": Kind("any", geometry=True, one_libm=True),
}
GENERATED = int(os.environ.get("TRACKMARSHAL_GENERATED", "100"))


@pytest.mark.parametrize("name", KINDS)
def test_generated_specs_mean_the_same_to_both(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    kind, counts, found = KINDS[name], Counter[str](), []
    share = -(-GENERATED // len(KINDS))
    for seed in range(share):
        # Every kind has seeds of its own, so that no two are about the same specs.
        made = subject(
            RandomChoices(share * list(KINDS).index(name) + seed),
            inexact=kind.inexact,
            geometry=kind.geometry,
        )
        broken = kind.disagreements(made, counts)
        if broken:
            found.append((made.text, broken))
    if GENERATED > 1000:
        with capsys.disabled():
            print(
                f"\n{name}: {', '.join(f'{count} {what}' for what, count in counts.items())}, {len(found)} disagreements"
            )
    assert not found, f"{len(found)} of {share}, the first: {found[0][1]}\n{found[0][0]}"
    assert counts["specs"] == share
    assert all(
        counts[verdict] > counts["cases"] / 20
        for verdict in ("satisfied", "violated", "undefined", "inactive")
    )


def test_how_far_libms_are_let_apart_grows_with_what_is_computed_on_the_way() -> None:
    """Nothing computed, nothing let pass: a tolerance of 0 failed in one generated spec of 2,000."""
    spec = compiled(
        'module a\nsignal ego : state { v: m/s }\nrule slow "made up"\n  require tanh(ego.v / 1 m/s) * (ego.v * 1000) <= 1 m/s\n'
    )
    (case,) = read(spec, [{"signals": {"ego": {"v": 3.0}}}])
    values = Measured(spec, case)
    outcome(spec.rules[0], case, values)
    assert values.largest == 3000.0


@settings(repeatable, max_examples=amount(30, 60))
@given(subjects())
def test_drawn_specs_mean_the_same_to_both(made: Subject) -> None:
    assert not KINDS["exact"].disagreements(made, Counter())


@settings(repeatable, max_examples=amount(20, 40))
@given(subjects(geometry=True, inexact="any"))
def test_drawn_specs_with_geometry_mean_the_same_to_both(made: Subject) -> None:
    assert not KINDS["everything"].disagreements(made, Counter())
