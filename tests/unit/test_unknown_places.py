"""A point of which one coordinate is unknown is neither in an area nor outside of it, wherever the other one is."""

from __future__ import annotations

from functools import cache
from typing import Any

import pytest

from support.supervised import BACKENDS
from trackmarshal.evaluation import Evaluator, loads

pytestmark = pytest.mark.verifies("S-1-A-6", "S-1-B-1")

SIGNALS = """module m
signal plan : trajectory { t: s increasing, x: m, y: m, v: m/s }
signal ego : state { x: m, y: m, v: m/s }
zone pit = polygon (-8, 0) (-2, 0) (-2, 4) (-8, 4)
"""
#: Each is compiled by itself: where one rule asks how far a point is from the area, all others are told so, too.
RULES = {
    "the margin of the car": "require ego in zone pit",
    "the margins of samples": "for all p in plan\n  require p in zone pit",
    "the car, by a guard": "for all p in plan where ego in zone pit\n  require p.v <= 20 m/s",
    "the car, by a guard that is turned": "for all p in plan where not (ego in zone pit)\n  require p.v <= 20 m/s",
    "samples, by a guard": "for all p in plan where p in zone pit\n  require p.v <= 20 m/s",
    "samples, by a guard that is turned": "for all p in plan where not (p in zone pit)\n  require p.v <= 20 m/s",
    "whenever": "whenever ego in zone pit\n  require ego.v >= 20 m/s",
}
#: m; left of the area or below it, within it, right of it or above it; and what nobody knows.
SIDES = (-20.0, 2.0, 20.0)
UNKNOWN = [(None, y) for y in SIDES] + [(x - 7.0, None) for x in SIDES] + [(None, None), (1e300, 2.0)]


@cache
def evaluator(backend: str, rule: str) -> Evaluator:
    return Evaluator(loads(f'{SIGNALS}rule r "x"\n  {rule}\n'), None, backend)


def verdicts(backend: str, rule: str, cases: list[dict[str, Any]]) -> list[str]:
    asked = evaluator(backend, rule)
    read = asked.read_all([{"signals": case} for case in cases])
    return [one.rules["r"].verdict for one in asked.evaluate(read)]


def case(points: list[tuple[Any, Any]]) -> dict[str, Any]:
    """The car at the first point, samples at all of them; each rule is violated where it applies."""
    x, y = zip(*points)
    plan = {"t": list(range(len(x))), "x": x, "y": y, "v": [30.0] * len(x)}
    return {"plan": plan, "ego": {"x": x[0], "y": y[0], "v": 10.0}}


@BACKENDS
@pytest.mark.parametrize("rule", RULES.values(), ids=list(RULES))
def test_one_unknown_coordinate_is_enough(backend: str, rule: str) -> None:
    cases = [case([point]) for point in UNKNOWN]
    # Beside samples of which all is known, and which the rule has nothing against.
    fine = (-5.0, 2.0) if "not" in rule or rule.endswith("p in zone pit") else (20.0, 20.0)
    cases += [case([point, fine]) for point in UNKNOWN]
    assert verdicts(backend, rule, cases) == ["undefined"] * len(cases)
    for one in cases:  # and each by itself
        assert verdicts(backend, rule, [one]) == ["undefined"], one
