"""Generated C against the reference evaluator, bit for bit: made-up specs with made-up inputs."""

from __future__ import annotations

import math
import struct
from collections import Counter

import pytest

from support.agreement import compiled, read
from support.generated import RandomChoices, subject
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.program import CProgram
from trackmarshal.backends.reference.evaluator import evaluate
from trackmarshal.backends.results import chosen_rules

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def compare(seed: int, seen: Counter[str]) -> list[str]:
    """Where C and the reference differ on one made-up subject, libm's functions included: both call the same ones."""
    made = subject(RandomChoices(seed), inexact="any")
    spec = compiled(made.text)
    rules, cases = chosen_rules(spec, None), read(spec, made.cases)
    run = CProgram(spec, rules).run(cases)
    found = []
    for index, expected in enumerate(evaluate(spec, rules, cases)):
        for rule in rules:
            verdict, margin = run.outcome(index, rule)
            seen[verdict] += 1
            wanted = expected.rules[rule.name]
            if verdict != wanted.verdict or bits(margin) != bits(wanted.margin):
                found.append(
                    f"seed {seed} case {index} {rule.name}: {verdict} {margin!r} | {wanted.verdict} {wanted.margin!r}"
                )
    return found


def test_some_specs() -> None:
    seen: Counter[str] = Counter()
    found = [text for seed in range(30) for text in compare(seed, seen)]
    assert not found
    assert set(seen) == {"satisfied", "violated", "undefined", "inactive"}


@pytest.mark.generated_c
@pytest.mark.parametrize("block", range(10))
def test_many_specs(block: int) -> None:
    seen: Counter[str] = Counter()
    found = [text for seed in range(1000 + 250 * block, 1250 + 250 * block) for text in compare(seed, seen)]
    assert not found
    assert sum(seen.values()) >= 1000
