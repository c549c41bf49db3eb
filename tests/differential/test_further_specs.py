"""Specs of what is seldom used together, in three evaluators, to the bit, alone and among others: see `support/generated/further.py`."""

from __future__ import annotations

import os
from collections import Counter

import pytest

from support.agreement import check_sound, compiled, differences, one_libm, outcomes, read, results, same
from support.generated import RandomChoices
from support.generated.further import further
from support.length import amount
from trackmarshal.backends.c import build
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir import nodes as ir
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.verdict import CaseResult

pytestmark = pytest.mark.verifies("S-1-B-1")

#: TRACKMARSHAL_GENERATED=N compares N of them by two evaluators, and one in twenty with C.
GENERATED = int(os.environ.get("TRACKMARSHAL_GENERATED", amount(20, 400)))
#: What no other generated spec has.
OWN = {"GridLookup", "Tallied", "is"}


def _apart(evaluator: Evaluator, case: Frame, expected: CaseResult) -> list[str]:
    """Where an evaluator says of a case by itself something else; what generated C has no numbers for, it refuses (E473)."""
    try:
        (said,) = outcomes(evaluator, [case])
    except TrackmarshalError as error:
        if error.code != "E473":
            raise
        return []
    wanted = {name: (rule.verdict, rule.margin) for name, rule in expected.rules.items()}
    return [
        f"case {case.id} {name}: {verdict} {margin!r} | {wanted[name]}"
        for name, (verdict, margin) in said.items()
        if verdict != wanted[name][0] or not same(margin, wanted[name][1])
    ]


def test_they_mean_the_same_to_all(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build, "FAST", ("-O0",))
    found, made, verdicts = list[str](), Counter[str](), Counter[str]()
    for seed in range(GENERATED):
        subject = further(RandomChoices(seed))
        spec = compiled(subject.text)
        made.update(
            "is" if isinstance(node, ir.Compare) and node.op == "is" else type(node).__name__
            for rule in spec.rules for root in rule.roots for node in ir.below(root)
        )  # fmt: skip
        cases = read(spec, subject.cases)
        backends = ["numpy", *(["c"] if seed % 20 == 0 and build.compiler() is not None else [])]
        with one_libm():
            expected = results(spec, cases, "reference")
            for one, other in zip(expected, results(spec, cases, "numpy"), strict=True):
                found += [f"seed {seed}: {each}" for each in differences(one, other)]
            for case, one in zip(cases, expected, strict=True):
                found += [f"seed {seed}: {each}" for each in check_sound(case, one)]
                verdicts.update(rule.verdict for rule in one.rules.values())
            for backend in backends:
                alone = Evaluator(spec, None, backend)
                for case, one in zip(cases, expected, strict=True):
                    found += [f"seed {seed} {backend}: {each}" for each in _apart(alone, case, one)]
    assert not found, f"{len(found)} differences: {found[:5]}"
    assert made.keys() >= OWN
    assert min(verdicts[each] for each in ("satisfied", "violated", "undefined", "inactive")) >= GENERATED / 4
