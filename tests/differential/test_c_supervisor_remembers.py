"""A Supervisor in generated C whose rules remember decides what the one in Python decides: over gaps, refused cycles and stored trajectories."""

from __future__ import annotations

import os
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

from support.length import amount, at_length
from support.pairs import Pair, generated
from support.remembering import NAMES, NAMES_OF_PAIRS, remembering
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator
from trackmarshal.runtime.verdict import VERDICTS

pytestmark = [pytest.mark.skipif(compiler() is None, reason="no C compiler"), pytest.mark.verifies("S-1-B-1")]

#: A fiftieth of those of the Supervisor whose rules remember nothing: each takes three times as long, and what made-up specs
#: remember is compared elsewhere by the thousand (property/test_forgetting.py, differential/test_c_forgetting.py).
RUNS = max(amount(2, 8), int(os.environ.get("TRACKMARSHAL_RUNS", "0")) // 50)
PARTS = amount(1, 4)


@cache
def evaluator(folder: Path, pairs: bool = False) -> Evaluator:
    return Evaluator(remembering(folder / str(pairs), pairs))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("specs")


@pytest.mark.parametrize("pairs", [at_length(False), True], ids=["elements", "pairs"])
@pytest.mark.parametrize("part", range(PARTS))
def test_generated_runs(part: int, pairs: bool, folder: Path) -> None:
    """TRACKMARSHAL_RUNS=50*N makes N runs of 50 cycles with faults of every kind; pairs: with rules of pairs of elements, too, else a quarter
    of the runs: those rules are among the others."""
    names = NAMES + NAMES_OF_PAIRS * pairs
    verdicts, driven = Counter[tuple[str, str]](), Counter[str]()
    for seed in range(part, RUNS if pairs else max(2 * PARTS, RUNS // 4), PARTS):
        pair = Pair(evaluator(folder, pairs))
        for given, readings in generated(seed):
            try:
                decision = pair.step(given, *readings)
            except AssertionError as error:
                raise AssertionError(f"run {seed}, {given!r:.300}") from error
            driven[decision.driven.candidate if decision.driven is not None else "nothing"] += 1
            if decision.judged is not None:
                for name in names:
                    number = next(i for i, rule in enumerate(pair.c.rules) if rule.name == name)
                    for rated in decision.judged.rated.values():
                        verdicts[name, VERDICTS[rated.verdicts[number]]] += 1
    assert min(driven[name] for name in ("driving", "emergency", "nothing")) > 0
    assert {name for name, verdict in verdicts if verdict == "undefined"}
    assert {name for name, _ in verdicts} == set(names)
