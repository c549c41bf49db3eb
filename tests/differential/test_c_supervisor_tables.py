"""A Supervisor in generated C with tables of every kind, scales, shapes and records of parameters decides what the one in Python decides."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from support.pairs import Pair, generated
from trackmarshal.backends.c.build import compiler
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, load
from trackmarshal.runtime.frame import Settings

pytestmark = [pytest.mark.skipif(compiler() is None, reason="no C compiler"), pytest.mark.verifies("S-1-B-1")]

SPEC = """module tables_in_c

use supervisor.assumptions
use supervisor.trajectory
use supervisor.interface

scale m/s = 5 m/s

shape reach = { far: m, slow: m/s^2 }

param span : reach = { far: 3 m in [1, 5], slow: 4 m/s^2 }

table limit(s: m) -> m/s = step wrap 50 m
  | 0 m: 20 m/s | 10 m: 30 m/s |

table brake(v: m/s, t: s) -> m/s^2 = linear clamp, step
  | t:      0 s,     1 s
  | 0 m/s:  8 m/s^2, 7 m/s^2
  | 50 m/s: 6 m/s^2, 5 m/s^2 |

constrain brake(0 m/s, 0 s) >= span.slow

rule limits "the limit of the place, and not too far"
  for all   p in plan
  require   p.v <= limit(p.x) and abs(p.x) <= span.far * 1000

rule brakes "as the sheet says"
  for all   p in plan
  require   p.a >= -brake(p.v, p.t)
"""


@pytest.fixture(scope="module")
def evaluator(tmp_path_factory: pytest.TempPathFactory) -> Evaluator:
    path: Path = tmp_path_factory.mktemp("specs") / "tables_in_c.spec"
    path.write_text(SPEC, "utf-8")
    return Evaluator(load([path]))


def test_generated_runs(evaluator: Evaluator) -> None:
    names = ("limits", "brakes")
    verdicts = Counter[tuple[str, int]]()
    for seed in range(4):
        pair = Pair(evaluator)
        for given, readings in generated(seed):
            decision = pair.step(given, *readings)
            if decision.judged is not None:
                for place, rule in enumerate(pair.c.rules):
                    if rule.name in names:
                        for rated in decision.judged.rated.values():
                            verdicts[rule.name, rated.verdicts[place]] += 1
    assert {name for name, _ in verdicts} == set(names)


@pytest.mark.parametrize(
    ("knots", "stands"), [((0.0, 49.0), True), ((0.0, 50.0), False), ((-1.0, 49.0), False)]
)
def test_knots_are_put_in_within_their_period(
    knots: tuple[float, ...], stands: bool, evaluator: Evaluator
) -> None:
    settings = Settings({}, {"tables_in_c.limit": (knots, (20.0, 30.0))}, {})
    if stands:
        assert Pair(evaluator, settings).c is not None
    else:
        with pytest.raises((TrackmarshalError, AssertionError)):
            Pair(evaluator, settings)
