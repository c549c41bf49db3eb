"""A Supervisor in generated C whose rules remember decides what the one in Python decides: over gaps, refused cycles and stored trajectories."""

from __future__ import annotations

import os
import shutil
from collections import Counter
from functools import cache
from pathlib import Path

import pytest

import trackmarshal as tm
from support.pairs import Pair, generated
from support.shared import REPOSITORY
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

RUNS = int(os.environ.get("TRACKMARSHAL_RUNS", "16"))
PARTS = 4
RULES = """module remembering.rules
use supervisor.interface

rule was_driven "" require historically[0.02 s, 0.3 s] plan.first.v > 1 m/s
rule turned "" require not once[0 s, 0.2 s] rising(plan.last.kappa > 0.1 1/m)
rule came "" for all o in objects except not previous o.x > ego.x "" require o.x > ego.x - 5 m
rule nearby "" for all o in objects require count(o.x - ego.x < 60 m, last: 0.3 s) <= 4
rule someone "" require once[0 s, 1 s] (exists o in objects: o.v > 10 m/s)
rule went_on "" require ego.v > 5 m/s since[0 s, 2 s] plan.first.t < 0.05 s
rule all_of "" require historically[0 s, 0.25 s] (for all p in plan: p.a <= 20 m/s^2)
rule anew "" require count(ego.y > 1 m, reset: rising(ego.y < 0.8 m)) <= 3
"""


@cache
def evaluator(folder: Path) -> Evaluator:
    own = shutil.copytree(REPOSITORY / "specs", folder / "specs", ignore=shutil.ignore_patterns("*.jsonl*", "*.json"))
    (own / "remembering").mkdir()
    (own / "remembering" / "rules.spec").write_text(RULES, encoding="utf-8")
    return Evaluator(tm.load([own / "supervisor", own / "remembering"]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("specs")


@pytest.mark.parametrize("part", range(PARTS))
def test_generated_runs(part: int, folder: Path) -> None:
    """TRACKMARSHAL_RUNS=N makes N runs of 50 cycles with faults of every kind."""
    own = [line.split()[1] for line in RULES.splitlines() if line.startswith("rule")]
    verdicts, driven = Counter[tuple[str, str]](), Counter[str]()
    for seed in range(part, RUNS, PARTS):
        pair = Pair(evaluator(folder))
        for given, readings in generated(seed):
            try:
                decision = pair.step(given, *readings)
            except AssertionError as error:
                raise AssertionError(f"run {seed}, {given!r:.300}") from error
            driven[decision.driven.candidate if decision.driven is not None else "nothing"] += 1
            if decision.judged is not None:
                for name in own:
                    number = next(i for i, rule in enumerate(pair.c.rules) if rule.name == name)
                    for rated in decision.judged.rated.values():
                        verdicts[name, rated.explain(number, False).verdict] += 1
    assert min(driven[name] for name in ("driving", "emergency", "nothing")) > 0
    assert {name for name, verdict in verdicts if verdict == "undefined"}
    assert {name for name, _ in verdicts} == set(own)
