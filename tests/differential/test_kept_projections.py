"""Projections on a line that generated C keeps: of points that share a place in what is kept, come again, or come after another border."""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from support.length import shared_out
from trackmarshal.evaluation import Evaluator, loads

SPEC = """module a
signal points : set of object { x: m, y: m }
signal track : corridor { left: polyline, right: polyline }
rule ahead "where it is along the middle"
  for all p in points
  require station(p, track) < 50 m
rule beside "again, and how far beside"
  for all p in points
  require offset(p, track) + direction(p, track) * 1 m < 2 m
rule pairs "each with each"
  for all p in points
  for all q in points
  require abs(offset(p, track) - offset(q, track)) < 4 m
"""


def ring(radius: float, turn: float, count: int = 90) -> list[list[float]]:
    """Around (3, 0), begun somewhere else each time."""
    angles = [turn + 2 * math.pi * k / count for k in range(count)]
    return [[3.0 + radius * math.cos(a), radius * math.sin(a)] for a in angles]


def points(draw: random.Random) -> list[dict[str, float]]:
    """Near to one another and far apart, on both zeros, the same ones again."""
    found = [{"x": draw.choice([0.0, -0.0, 3.0]), "y": draw.choice([0.0, -0.0, 20.0])} for _ in range(3)]
    for _ in range(40):
        angle, beside = draw.uniform(0.0, 7.0), draw.uniform(-8.0, 8.0)
        found.append({"x": 3.0 + (30.0 + beside) * math.cos(angle), "y": (30.0 + beside) * math.sin(angle)})
        if draw.random() < 0.3:
            found.append({"x": found[-1]["x"], "y": found[-1]["y"] + draw.choice([0.0, 1e-9, 0.01])})
    return found + found[:4]


@pytest.mark.parametrize("seed", shared_out(range(4), 2))
def test_c_says_what_the_reference_does(seed: int) -> None:
    draw = random.Random(seed)
    spec = loads(SPEC)
    reference, c = Evaluator(spec, backend="reference"), Evaluator(spec, backend="c")
    track: dict[str, Any] = {}
    came: list[dict[str, float]] = []
    for cycle in range(8):
        if cycle % 3 == 0:
            turn = draw.uniform(0.0, 6.0)
            track = {"left": ring(24.0, turn), "right": ring(36.0, turn), "closed": True}
        came = [*points(draw), *came[:10]]
        case = {"signals": {"points": came, "track": track}}
        (one,), (other,) = (each.evaluate([each.read(case)]) for each in (reference, c))
        told = [
            {name: (rule.verdict, rule.margin) for name, rule in result.rules.items()}
            for result in (one, other)
        ]
        assert told[1] == told[0]


def test_both_zeros_are_points_of_their_own() -> None:
    """Beyond a corner, the sign of a zero says on which side a point is: what is kept of the one is not that of the other."""
    spec = loads(
        "module a\nsignal points : set of object { x: m, y: m }\nsignal way : polyline\n"
        'rule beside "to the left"\n  for all p in points\n  require offset(p, way) >= 0 m\n'
    )
    way = [[-10.0, 0.0], [0.0, 0.0], [-5.0, 10.0]]
    for zeros in ((0.0, -0.0), (-0.0, 0.0)):
        told = []
        for backend in ("reference", "numpy", "c"):
            evaluator = Evaluator(spec, backend=backend)
            read = [
                evaluator.read({"signals": {"points": [{"x": 5.0, "y": y}], "way": way}})
                for y in (*zeros, *zeros)
            ]
            told.append([result.rules["beside"].margin for result in evaluator.evaluate(read)])
        assert told[1] == told[0]
        assert told[2] == told[0]
        assert set(told[0]) == {5.0, -5.0}
