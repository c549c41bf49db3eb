"""What rules remember goes on in cycles in which their `whenever` does not hold: made-up runs, the same from every evaluator.

Generated C works out nothing else of a rule in such a cycle.
"""

from __future__ import annotations

import random
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, load

SPEC = """module w

signal ego : state { v: m/s }
signal plan : trajectory { t: s increasing, v: m/s }
signal objects : set of object { x: m }
event e "asked"

state gear : { low, high } starts low
  becomes high from low when ego.v > 3 m/s
    remember top = ego.v
  becomes low from high when ego.v < 1 m/s

state near : { no, yes } for each o in objects starts no
  becomes yes from no when o.x < 2 m
  becomes no from yes when o.x > 5 m

rule counted "1"
  whenever e
  require count(rising(ego.v > 2 m/s)) <= 2

rule before "2"
  whenever e
  require not (once ego.v > 4 m/s)

rule each "3"
  whenever e
  for all o in objects where near(o) is yes
  require time_in(near(o)) <= 0.25 s

rule timeline "4"
  along plan as p
  whenever e
  require always[0 s, 1 s] (p.v < 5 m/s)

rule kept "5"
  whenever e
  require gear is low or gear.top <= 4 m/s

rule lasting "6"
  whenever e and ego.v > 1 m/s
  require (ego.v > 1 m/s) since (ego.v > 3 m/s)

rule pairs "7"
  whenever e
  for all o in objects where o.x < 4 m
  for all p in plan where p.v > o.x * 1 1/s
  require p.v <= 5 m/s or o.x < 2 m
"""


@cache
def evaluator(folder: Path, backend: str) -> Evaluator:
    path = folder / "w.spec"
    path.write_text(SPEC, encoding="utf-8")
    return Evaluator(load([path]), None, backend)


def run(seed: int) -> list[dict[str, Any]]:
    draw = random.Random(seed)
    slow = [0.4, 1.5, 2.5, 3.5, 4.5]
    return [
        {
            "t": 0.1 * k,
            "signals": {
                "ego": {"v": float("nan") if draw.random() < 0.05 else draw.choice(slow)},
                "plan": {"t": [0.0, 0.5, 1.0], "v": [draw.choice([1.0, 6.0]) for _ in range(3)]},
                "objects": [{"id": i, "x": draw.choice([1.0, 3.0, 6.0])} for i in range(draw.randrange(3))],
                "e": draw.random() < 0.4,
            },
        }
        for k in range(12)
    ]


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_every_evaluator_says_the_same(tmp_path_factory: pytest.TempPathFactory) -> None:
    folder, decided = tmp_path_factory.mktemp("whenever"), set()
    for seed in range(amount(15, 1000)):
        found = []
        for backend in ("reference", "numpy", "c"):
            one = evaluator(folder, backend)
            going = one.over_run()
            results = [going.step(one.read(case)) for case in run(seed)]
            found.append(
                [[(r.rule, r.verdict, repr(r.margin)) for r in said.rules.values()] for said in results]
            )
        assert found[0] == found[1] == found[2], seed
        decided |= {(rule, verdict) for cycle in found[0] for rule, verdict, _ in cycle}
    rules = {rule for rule, _ in decided}
    assert len(rules) == 7
    assert {(rule, verdict) for rule in rules for verdict in ("inactive", "satisfied", "violated")} <= decided
