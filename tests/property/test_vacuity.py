"""What is warned of as vacuous is so: on made-up specs with inputs that keep the contract, by the reference's verdicts."""

from __future__ import annotations

from collections import Counter

import pytest

from support.agreement import read, results
from support.generated import RandomChoices, subject
from support.length import amount
from trackmarshal.semantics.compile import compile_text
from trackmarshal.semantics.warnings.vacuity import AlwaysHolds, NeverHolds

pytestmark = pytest.mark.verifies("S-1-B-1")


def _wrong(found: AlwaysHolds | NeverHolds, verdict: str) -> bool:
    """Whether a verdict cannot be where nothing is sought (`exists`): a demand that is always met is not violated, one that never is is not
    satisfied, and where nothing is in the range, or a rule never applies, nothing violates it."""
    if found.consequence == "nothing is left out":
        return False
    return verdict == ("satisfied" if (found.code, found.what) == ("W305", "this demand") else "violated")


def test_warned_rules_say_nothing() -> None:
    seen: Counter[str] = Counter()
    wrong: list[str] = []
    for seed in range(amount(150, 3000)):
        made = subject(RandomChoices(seed), inexact="any")
        compiled = compile_text(made.text)
        warned = [found for found in compiled.found if isinstance(found, (AlwaysHolds, NeverHolds))]
        if not warned:
            continue
        cases = read(compiled.spec, made.cases)
        judged = results(compiled.spec, cases, "reference", series=False)
        for found in warned:
            (rule,) = [
                rule
                for rule in compiled.spec.rules
                if rule.typed is not None and rule.typed.span.start <= found.span.start < rule.typed.span.end
            ]
            if "exists" in rule.text or "∃" in rule.text:
                continue
            for case, result in zip(cases, judged, strict=True):
                if not case.faults:
                    verdict = result.rules[rule.name].verdict
                    seen[f"{found.code} {found.what}"] += 1
                    if _wrong(found, verdict):
                        wrong.append(f"seed {seed}: {found.message}, and is {verdict}: {rule.text}")
    assert wrong == []
    assert seen.keys() >= {
        "W305 this condition", "W305 this demand", "W306 this demand", "W306 this exception",
    }  # fmt: skip
