"""Samples that repeat the one before, to a nanometre, are no part of a path: the same distance from it, to the bit, with every evaluator."""

from __future__ import annotations

import itertools
import random
from functools import cache
from typing import Any

import pytest

import trackmarshal as tm
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator

BACKENDS = ["reference", "numpy", *(["c"] if compiler() is not None else [])]
#: Ways from sample to sample, m: none, none to speak of, around a nanometre, and real ones.
STEPS = (0.0, 1e-300, 1e-170, 1e-12, 4e-10, 9e-10, 1.1e-9, 5e-9, 0.01, 2.5)


@cache
def evaluators() -> list[Evaluator]:
    spec = tm.loads("""
module repeated
signal plan : trajectory { t: s increasing, x: m, y: m }
signal ego : state { x: m, y: m }

rule near "Near the path"
  require distance_to(ego, plan) <= 2 m
""")
    return [Evaluator(spec, None, backend) for backend in BACKENDS]


def margins(plan: list[tuple[float, float]], ego: tuple[float, float]) -> list[str]:
    x, y = (list(column) for column in zip(*plan))
    signals: dict[str, Any] = {
        "plan": {"t": list(map(float, range(len(plan)))), "x": x, "y": y},
        "ego": {"x": ego[0], "y": ego[1]},
    }
    found = [each.case({"signals": signals}).rules["near"] for each in evaluators()]
    assert len({each.verdict for each in found}) == 1
    return [each.margin.hex() for each in found]


@pytest.mark.parametrize("origin", [0.0, 50.0, 1e6])
@pytest.mark.parametrize(("dx", "dy"), [(1.0, 0.0), (-0.6, 0.8)])
def test_distances_from_a_path_that_hardly_moves(origin: float, dx: float, dy: float) -> None:
    rng = random.Random(3)
    for steps in itertools.product(STEPS, repeat=2):
        ways = itertools.accumulate([0.0, *steps, rng.choice(STEPS)])
        plan = [(origin + way * dx, way * dy - origin) for way in ways]
        x, y = rng.choice(plan)
        found = margins(plan, (x + rng.choice((0.0, 1e-9, 2.6)), y + rng.choice((0.0, 2.0, 4.0))))
        assert len(set(found)) == 1, (plan, found)


def by_hand(plan: list[tuple[float, float]], point: tuple[float, float]) -> float:
    """The distance from every segment, by complex numbers."""
    at, places = complex(*point), [complex(*place) for place in plan]

    def apart(one: complex, other: complex) -> float:
        way = other - one
        share = ((at - one) * way.conjugate()).real / abs(way) ** 2 if way else 0.0
        return abs(at - one - min(max(share, 0.0), 1.0) * way)

    return min(map(apart, places, places[1:]))


@pytest.mark.parametrize("origin", [0.0, 1e6])
def test_distances_from_a_path_that_leads_away_and_comes_back(origin: float) -> None:
    """The nearest step is none of the first ones, its ends are far from the point, and most of the others cannot be it."""
    rng = random.Random(5)
    for _ in range(150):
        plan, reach = [(origin, -origin)], rng.choice((0.5, 5.0, 60.0))
        for _ in range(rng.randrange(1, 40)):
            plan.append((plan[-1][0] + rng.uniform(-reach, reach), plan[-1][1] + rng.uniform(-reach, reach)))
        step = rng.randrange(len(plan) - 1)
        share, aside = rng.random(), rng.choice((0.0, 0.3, 30.0))
        ego = tuple(
            one + share * (other - one) + rng.uniform(-aside, aside)
            for one, other in zip(plan[step], plan[step + 1])
        )
        found = margins(plan, (ego[0], ego[1]))
        assert len(set(found)) == 1, (plan, found)
        assert abs(2.0 - float.fromhex(found[0]) - by_hand(plan, (ego[0], ego[1]))) < 1e-9 * max(1.0, origin)
