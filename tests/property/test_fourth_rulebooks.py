"""Rulebooks by the fourth evaluator: from the text of rules, rulebooks and candidates to what is better and what is chosen, by every evaluator."""

from __future__ import annotations

import itertools
import math
import random
from collections import Counter
from typing import Any

import pytest

import trackmarshal as tm
from support.fourth.meaning import Clause, Formula, judged
from support.fourth.ranking import Book, Violation, book, violation
from support.fourth.running import scales
from support.fourth.writing import Writer
from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import Evaluator, loads

SEEDS = amount(range(42, 54), range(400))
NAMES = tuple(f"f{number}" for number in range(6))
C = pytest.param(
    "c", marks=[pytest.mark.acceptance, pytest.mark.skipif(compiler() is None, reason="no C compiler")]
)
#: Who breaks this contract, is judged all the same, and ranks as one of whom nothing is known.
BOUNDED = "mass: kg", "mass: kg in [-100, 100]"


def books(dice: random.Random) -> list[Book]:
    first = book(dice, "first", NAMES[: dice.randint(2, 5)])
    second = book(dice, "second", NAMES, first)
    return [first, second, book(dice, "third", NAMES, dice.choice([first, second]))]


def written(seed: int) -> tuple[Writer, str, dict[str, tuple[list[Clause], Formula]]]:
    """Exact, so that no order is a matter of rounding."""
    writer = Writer(seed, "alone", True)
    rules, lines = dict[str, tuple[list[Clause], Formula]](), []
    for name in NAMES:
        text, clauses, require = writer.rule(name, 2)
        rules[name] = clauses, require
        advisory = writer.dice.random() < 0.3
        lines.append(text.replace("\n", "\n  severity advisory\n", 1) if advisory else text)
    lines.append('rule weighed "x" require abs(ego.mass) >= 0 kg')
    text = "\n".join([*writer.declared, *lines]) + "\n"
    head, rest = text.split("signal ego", 1)
    return writer, head + "signal ego" + rest.replace(*BOUNDED, 1), rules


def test_what_contradicts_itself_is_refused() -> None:
    seen = Counter[str]()
    rules = "".join(f'rule {name} "x" require e\n' for name in NAMES)
    for seed in range(amount(60, 3000)):
        made = books(random.Random(seed))
        text = f"module m\nevent e\n{rules}" + "\n".join(one.text for one in made) + "\n"
        expected = [one.codes for one in made]
        try:
            loads(text)
            codes = set[str]()
        except Diagnostics as error:
            codes = {one.code for one in error.items}
        assert bool(codes) == any(expected), (codes, expected, text)
        assert codes <= set().union(*expected), (codes, expected, text)
        seen.update(codes or {"fine"})
    assert set(seen) == {"fine", "E216", "E245", "E246"}, seen


@pytest.mark.parametrize("backend", ["numpy", "reference", C])
def test_what_is_better(backend: str) -> None:
    seen = Counter[str]()
    for seed in SEEDS if backend != "c" else SEEDS[::10]:
        writer, text, rules = written(seed)
        made = [one for one in books(writer.dice) if not one.codes]
        made = [one for one in made if one.base is None or one.base in made]
        spec = loads(text + "\n".join(one.text for one in made) + "\n")
        evaluator = Evaluator(spec, backend=backend)
        results, candidates = [], list[dict[str, Violation]]()
        for _ in range(6):
            given, meant = writer.cycle()
            broken = writer.dice.random() < 0.15 and isinstance(given["ego"].get("mass"), float)
            if broken:
                given["ego"]["mass"] = meant["ego"]["mass"] = 1000.0
            results.append(evaluator.case({"signals": given}))
            said = dict[str, Violation]()
            for name, (clauses, require) in rules.items():
                env: dict[str, Any] = {
                    "cycles": [meant],
                    "k": 0,
                    "scales": scales(writer, clauses, require),
                }
                said[name] = (2, math.inf) if broken else violation(*judged(clauses, require, env))
            candidates.append(said)
        sizes = {name: of_one(writer, require) for name, (_, require) in rules.items()}
        for one in made:
            ranks = tm.rulebook(spec, one.name)
            for (i, mine), (j, theirs) in itertools.permutations(enumerate(candidates), 2):
                found = tm.compare(ranks, results[i], results[j]).outcome
                ours = one.outcome(mine, theirs, sizes)
                assert found == ours, (seed, one.text, i, j, found, ours, mine, theirs, text)
                seen[found] += 1
            runs = [slice(0, 2), slice(2, 4), slice(4, 6)]  # over the cycles of a run, the worst counts
            worst = [{name: max(said[name] for said in candidates[run]) for name in NAMES} for run in runs]
            for many, kept in ((results, candidates), ([results[run] for run in runs], worst)):
                best = list(tm.choose(ranks, many).best)
                assert best == one.best(kept, sizes), (seed, one.text, best, kept, text)
    assert set(seen) == {"better", "worse", "equal", "incomparable"}, seen


def of_one(writer: Writer, require: Formula) -> float:
    """The scale of a rule's dimension; 1 of several, as their margins are divided already."""
    dims = {one for one in require.dims if one is not None}
    return writer.scales.get(dims.pop(), 1.0) if len(dims) == 1 else 1.0
