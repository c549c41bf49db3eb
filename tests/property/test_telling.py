"""What decided a rule can be told of any rule and any case, without an exception and at places that are there."""

from __future__ import annotations

import os

import pytest

from support.agreement import compiled, read
from support.generated import RandomChoices, subject
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.evaluation import Evaluator
from trackmarshal.explaining.telling import behind

#: TRACKMARSHAL_COMPILED=N tells of N made-up specs.
SPECS = int(os.environ.get("TRACKMARSHAL_COMPILED", "20"))
#: A guard that was asked beside a timeline, and had variables of its own; elements of which nobody knows which one is the nearest; two footprints in
#: a quantifier over elements that neither of them is of.
FOUND = (1896, 105, 286)


@pytest.mark.verifies("S-1-B-1")
@pytest.mark.parametrize("backend", ["reference", "numpy"])
def test_made_up_specs(backend: str) -> None:
    told = 0
    for seed in (*FOUND, *range(SPECS)):
        made = subject(RandomChoices(seed), inexact="any", geometry=seed % 3 == 1)
        spec = compiled(made.text)
        cases = read(spec, made.cases)
        evaluator = Evaluator(spec, None, backend)
        for case, said in zip(cases, evaluator.evaluate(cases), strict=True):
            for rule in evaluator.rules:
                result = said.rules[rule.name]
                told += bool(behind(rule, result, Reference(spec, case)))
                for signal, place in result.witness.places if result.witness else ():
                    assert -1 <= place < case.columns[signal].count, (seed, rule.name, signal, place)
    assert told > SPECS
