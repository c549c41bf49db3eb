"""Rules along a course by the fourth evaluator: what was driven, now, and what is planned mean the same to all, whatever is lost, refused, or comes and goes."""

from __future__ import annotations

import math
from typing import Any

import pytest

from support.fourth.meaning import Clause, Formula, course, judged
from support.fourth.running import agree, scales
from support.fourth.writing import JOINED, Writer
from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads

SEEDS = amount(range(22, 36), range(600))
RULES = 3
DEPTH = 3
C = pytest.param(
    "c", marks=[pytest.mark.acceptance, pytest.mark.skipif(compiler() is None, reason="no C compiler")]
)
#: What no rule reads breaks nothing: all that is spoilt is read.
READS = 'rule reads "x" require abs(ego.x) >= 0 m and abs(ego.v) >= 0 m/s and abs(ego.heading) >= 0'
#: A rule of the spec: its clauses, its demand, and whether it is judged at the last sample.
Rule = tuple[list[Clause], Formula, bool]


def written(seed: int) -> tuple[Writer, str, dict[str, Rule], int]:
    writer = Writer(seed, "course", seed % 2 == 0)
    rules, lines = dict[str, Rule](), []
    for number in range(RULES):
        text, clauses, require = writer.rule(f"f{number}", DEPTH)
        rules[f"f{number}"] = clauses, require, "at last" in text
        lines.append(text)
    lasting, ns = writer.dice.choice([("0.1 s", 0.1e9), ("300 ms", 0.3e9), ("0.5 s", 0.5e9), ("10 s", 10e9)])
    driven = f"course driven = ego for {lasting} then plan"
    return writer, "\n".join([*writer.declared, driven, READS, *lines]) + "\n", rules, round(ns)


def cycles(writer: Writer) -> list[tuple[dict[str, Any], dict[str, Any], int, bool]]:
    """A cycle as data and as `meaning` takes it, how many were lost before it, and whether it breaks the contract."""
    dice, found, t, present = writer.dice, [], 0.0, set[int]()
    for number in range(dice.randint(2, 9)):
        lost = dice.choice([0, 0, 0, 0, 1, 2])
        t += dice.choice([0.1, 0.1, 0.2, 0.5, 1.0 / 3.0]) * (1 + lost)
        present ^= {name for name in (1, 2, 3) if dice.random() < 0.3}
        given, meant = writer.cycle(sorted(present))
        shift = dice.choice(
            [0.0, 0.0, 0.0, -0.2, -0.5, 0.05]
        )  # a plan may begin before its stamp, or after it
        given["plan"]["t"] = [one + shift for one in given["plan"]["t"]]
        meant["plan"] = {j: {**one, "t": one["t"] + shift} for j, one in meant["plan"].items()}
        broken = dice.random() < 0.15
        if broken:
            spoilt = dice.choice(["x", "heading", "v"])
            given["ego"][spoilt] = meant["ego"][spoilt] = math.nan
        found.append(
            (
                {"t": t, "id": number, "signals": given},
                {**meant, "stamp": round(t * 1e9), "missed": 0},
                lost,
                broken,
            )
        )
    return found


@pytest.mark.parametrize("backend", ["numpy", "reference", C])
def test_courses(backend: str) -> None:
    seen = set()
    for seed in SEEDS if backend != "c" else SEEDS[::10]:
        writer, text, rules, lasting = written(seed)
        evaluator = Evaluator(loads(text), backend=backend)
        run = evaluator.over_run()
        accepted, missed = list[dict[str, Any]](), 0
        for given, meant, lost, broken in cycles(writer):
            for _ in range(lost):
                run.missed()
            missed += lost
            now = {**meant, "missed": missed if accepted else 0}
            said = run.step(evaluator.read(given)).rules
            every = [*accepted, now]
            items, here = course(every, len(every) - 1, lasting, JOINED)
            for name, (clauses, require, at_last) in rules.items():
                env: dict[str, Any] = {"cycles": every, "k": len(every) - 1, "course": items, "along": "p"}
                env |= {"p": ("course", len(items) - 1 if at_last else here)}
                ours = judged(clauses, require, {**env, "scales": scales(writer, clauses, require)})
                seen.add(ours.verdict)
                about = said[name].verdict, said[name].margin
                assert agree(ours, *about, writer.exact), (seed, name, given["id"], ours, about, text)
            if broken:
                missed += 1
            else:
                accepted, missed = every, 0
    assert seen == {"satisfied", "violated", "inactive", "undefined"}
