"""Generated C against the reference evaluator, bit for bit: made-up specs with made-up inputs.

TRACKMARSHAL_COMPILED=N compares N of them. One in ten is optimised as a user's program is, the others are not, which
compiles in half the time. Both matter: a compiler's optimiser has been at fault before.
"""

from __future__ import annotations

import math
import os
import struct
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.agreement import compiled, outcomes, read, results
from support.generated import RandomChoices, subject
from support.length import amount
from trackmarshal.backends.c import build
from trackmarshal.backends.results import chosen_rules
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator

pytestmark = [
    pytest.mark.skipif(build.compiler() is None, reason="no C compiler"),
    pytest.mark.verifies("S-1-B-1"),
]

#: A spec is compiled in a tenth of a second: the default is the share for every day.
GENERATED = int(os.environ.get("TRACKMARSHAL_COMPILED", "10"))
PARTS = amount(1, 8)
#: Found wrong once: a series overwritten before it was read; a series that an optimiser took for the one before; a bound
#: of a loop used ahead of it; a variable in a guard taken for the sample of a timeline beside it.
FOUND = (30, 1237, 1896, 6040, 31366, 31507, 31894, 40888)


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def compare(seed: int, seen: Counter[str]) -> list[str]:
    """Where C and the reference differ on one made-up subject, libm's functions included: both call the same ones."""
    made = subject(RandomChoices(seed), inexact="any", geometry=seed % 3 == 1)
    spec = compiled(made.text)
    rules, cases = chosen_rules(spec, None), read(spec, made.cases)
    program = Evaluator(spec, None, "c")  # some cases leave out a curvature, and are swept straight
    found = []
    for index, (case, expected) in enumerate(
        zip(cases, results(spec, cases, "reference", series=False), strict=True)
    ):
        try:
            (run,) = outcomes(program, [case])
        except TrackmarshalError as error:
            if error.code != "E473":
                raise
            seen["refused"] += 1
            continue
        for rule in rules:
            verdict, margin = run[rule.name]
            seen[verdict] += 1
            wanted = expected.rules[rule.name]
            if verdict != wanted.verdict or bits(margin) != bits(wanted.margin):
                found.append(
                    f"seed {seed} case {index} {rule.name}: {verdict} {margin!r} | {wanted.verdict} {wanted.margin!r}"
                )
    return found


@pytest.fixture
def empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A place for thousands of programs that nobody asks for again."""
    monkeypatch.setenv("TRACKMARSHAL_CACHE", str(tmp_path))
    yield tmp_path / "c"
    for file in (tmp_path / "c").glob("*/*"):
        file.unlink()


@pytest.mark.parametrize("part", range(PARTS))
def test_made_up_specs(empty_cache: Path, monkeypatch: pytest.MonkeyPatch, part: int) -> None:
    seen: Counter[str] = Counter()
    found, fast = [], build.FAST
    for seed in (*FOUND, *range(GENERATED))[part::PARTS]:
        monkeypatch.setattr(build, "FAST", fast if seed % 10 == 0 or seed in FOUND else ("-O0",))
        found += compare(seed, seen)
        for file in empty_cache.glob("*/*.so"):
            file.unlink()
    assert not found, f"{len(found)} differences: {found[:5]}"
    share = GENERATED / PARTS
    assert min(seen[verdict] for verdict in ("satisfied", "violated", "undefined", "inactive")) >= share
    assert seen["refused"] <= share / 5
