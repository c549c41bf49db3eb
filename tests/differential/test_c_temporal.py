"""Temporal operators in generated C against the reference: long timelines, all kinds of windows, ties, missing values."""

from __future__ import annotations

import math
import os
import random
import struct

import pytest

from support.agreement import compiled, outcomes
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.program import CProgram
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

HEAD = """module temporal

signal log : series { t: s increasing, p: 1, q: 1, hot: bool }

"""
WINDOWS = (
    "",
    "[0 s, 0 s]",
    "[0 s, 1 s]",
    "[0.3 s, 2 s]",
    "[1.5 s, 1.5 s]",
    "[2 s, 7 s]",
    "[0 s, 1000 s]",
    "[5 s, 1000 s]",
)
#: Looked at from the first sample, in the middle, and at every sample.
WRAPS = ("{}", "eventually[3 s, 3.4 s] ({})", "always ({} or p.hot)", "eventually ({} and p.q > 1)")


#: In how many of these ways each formula stands.
WRAPPED = int(os.environ.get("TRACKMARSHAL_WRAPS", "1"))


def spec_text() -> str:
    formulas = []
    for window in WINDOWS:
        formulas += [f"{op}{window} (p.p > 0)" for op in ("always", "eventually", "historically", "once")]
        formulas += [f"((p.p > -1) {op}{window} (p.q > 0.5))" for op in ("until", "since")]
    formulas += [
        "rising(p.p > 0)",
        "falling(p.p > 0)",
        "(next (p.p > 0))",
        "(previous p.hot)",
        "(weak next (p.p > 0))",
    ]
    formulas += [
        "always[0 s, 1 s] ((p.p > 0) implies eventually[0.2 s, 1 s] ((p.q > 0) since[0 s, 2 s] p.hot))"
    ]
    rules = []
    for number, formula in enumerate(formulas):
        for wrap_number, wrap in [*enumerate(WRAPS), *enumerate(WRAPS)][number % len(WRAPS) :][:WRAPPED]:
            rules.append(
                f'rule r{number}_{wrap_number} "made up"\n  along log as p\n  require {wrap.format(formula)}\n'
            )
    return HEAD + "\n".join(rules)


def bits(x: float) -> bytes:
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def test_every_sample_of_a_window() -> None:
    """One case a sample, in which it alone is hot: from the first sample, and over all of them, the worst one hides the others."""
    held = [f"((p.p > -1) {op}{window} (p.q > 0.5))" for op in ("until", "since") for window in WINDOWS[2:4]]
    spec = compiled(
        HEAD
        + "\n".join(
            f'rule r{number} "made up"\n  along log as p\n  require eventually ({formula} and p.hot)\n'
            for number, formula in enumerate(held)
        )
    )
    evaluator = Evaluator(spec, None, "reference")
    r = random.Random(3)
    times = [0.1 * n for n in range(60)]
    # Good for long: what is no part of a window any more shows only then.
    p, q = (
        [r.uniform(*((-3, -1.1) if r.random() < 0.06 else (3, 5))) * sign for _ in times] for sign in (1, -1)
    )
    cases = [
        evaluator.read({"id": n, "signals": {"log": {"t": times, "p": p, "q": q, "hot": [k == n for k in range(60)]}}})
        for n in range(60)
    ]  # fmt: skip
    run = outcomes(CProgram(spec, evaluator.rules), cases)
    for said, expected in zip(run, evaluator.evaluate(cases), strict=True):
        for name, wanted in expected.rules.items():
            verdict, margin = said[name]
            assert (verdict, bits(margin)) == (wanted.verdict, bits(wanted.margin)), name


def test_windows() -> None:
    spec = compiled(spec_text())
    evaluator = Evaluator(spec, None, "reference")
    program = CProgram(spec, evaluator.rules)
    cases = []
    for seed in range(6):
        r = random.Random(seed)
        count = r.choice([1, 2, 7, 60, 90])
        times = [0.0]
        while len(times) < count:
            times.append(times[-1] + r.choice([0.1, 0.1, 0.3, 1.0, 0.05]))
        ties = r.random() < 0.5
        p, q = ([float(r.randint(-2, 2)) if ties else r.gauss(0, 1) for _ in times] for _ in "pq")
        hot: list[bool | None] = [r.random() < 0.2 for _ in times]
        if r.random() < 0.5:
            p[r.randrange(count)] = math.nan
            hot[r.randrange(count)] = None
        cases.append(
            evaluator.read({"id": seed, "signals": {"log": {"t": times, "p": p, "q": q, "hot": hot}}})
        )
    run = outcomes(program, cases)
    found = []
    for index, expected in enumerate(evaluator.evaluate(cases)):
        for rule in evaluator.rules:
            verdict, margin = run[index][rule.name]
            wanted = expected.rules[rule.name]
            if verdict != wanted.verdict or bits(margin) != bits(wanted.margin):
                found.append(
                    f"case {index} {rule.name}: {verdict} {margin!r} | {wanted.verdict} {wanted.margin!r}"
                )
    assert not found
