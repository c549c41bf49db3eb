"""What happens until the next decision: who turns into somebody beside it is unsafe, wherever that one was when he was seen, and whichever corner meets
him; so is who drives through one who stands, however far apart samples are.

Made up, on a straight road; what happens is worked out with shapely, of bodies and places alone.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import pytest
import shapely

from support.agreement import unsafe
from support.dense.sweep import corners
from support.length import at_length
from support.supervised import shipped
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.verifies("S-1-A-2")

LENGTH, WIDTH, OTHER_WIDTH = 4.7, 2.8, 2.0
#: s until the next decision, at the latest.
NEXT = 0.25
X = np.arange(-300.0, 900.0, 5.0)
TRACK = {"left": np.stack([X, 0.0 * X + 8.0], axis=1), "right": np.stack([X, 0.0 * X - 8.0], axis=1)}
NOBODY = {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")}


class Traffic(NamedTuple):
    """Ours begins at 0 and turns with so many m/s^2; where the other one is now, and how long ago both were seen. step: from sample to sample, s."""

    v: float
    turns: float
    x: float
    y: float
    other: float
    age: float
    own_age: float
    step: float = 0.05

    def bodies(self) -> tuple[Any, Any]:
        t = np.arange(0.0, NEXT, 0.01)
        ours = corners(self.v * t, self.turns * t**2 / 2, self.turns * t / self.v, LENGTH, WIDTH)
        others = corners(self.x + self.other * t, np.full(len(t), self.y), 0.0 * t, LENGTH, OTHER_WIDTH)
        return shapely.polygons(ours), shapely.polygons(others)

    def meet(self) -> bool:
        return bool(shapely.intersects(*self.bodies()).any())

    def deep(self) -> bool:
        """Whether they meet by more than a straight line between samples may miss."""
        ours, others = self.bodies()
        return bool((shapely.area(shapely.intersection(ours, others)) > 0.01).any())

    def case(self) -> dict[str, Any]:
        t = np.arange(0.0, 0.5 + self.step, self.step)
        heading = self.turns * t / self.v
        plan = {
            "t": t, "s": self.v * t, "x": self.v * t, "y": self.turns * t**2 / 2, "heading": heading, "kappa": np.full(len(t), self.turns / self.v**2),
            "v": np.full(len(t), self.v), "a": 0.0 * t,
        }  # fmt: skip
        ego = {"x": -self.v * self.own_age, "y": 0.0, "heading": 0.0, "v": self.v, "age": self.own_age}
        there = {
            "x": self.x - self.other * self.age, "y": self.y, "heading": 0.0, "v": self.other, "length": LENGTH, "width": OTHER_WIDTH,
            "age": self.age,
        }  # fmt: skip
        objects = {name: np.array([value]) for name, value in there.items()}
        signals = {"plan": plan, "driving": plan, "ego": ego, "objects": objects, "obstacles": NOBODY, "track": TRACK, "emergency": False}  # fmt: skip
        return {"signals": signals}


OTHERS = {rule.name for rule in shipped().rules if rule.module == "supervisor.collision"} - {"rss_eq1"}


def fired(traffic: list[Traffic], rules: set[str] = OTHERS) -> list[set[str]]:
    """By case the rules about others that are violated."""
    judge = Evaluator(shipped(), sorted(rules), "numpy")
    return unsafe(judge, judge.read_all([each.case() for each in traffic]))


@pytest.mark.parametrize("count", [300, at_length(3000)])
def test_nobody_turns_into_who_is_beside_it(count: int) -> None:
    rng = np.random.default_rng(count)
    traffic = []
    for _ in range(count):
        v, side = rng.uniform(15.0, 60.0), rng.choice([-1.0, 1.0])
        ages = rng.choice([0.0, 0.05, 0.1], 2)
        y = side * ((WIDTH + OTHER_WIDTH) / 2 + rng.uniform(0.0, 0.4))
        x = rng.uniform(0.05 - LENGTH, LENGTH - 0.05)
        traffic.append(Traffic(v, side * rng.uniform(4.0, 12.0), x, y, v * rng.uniform(0.6, 1.6), *ages))
    met = [each for each in traffic if each.meet()]
    assert len(met) > count / 4
    assert not [each for each, rules in zip(met, fired(met)) if not rules]


@pytest.mark.parametrize("count", [300, at_length(3000)])
def test_a_corner_that_comes_round_meets_nobody(count: int) -> None:
    """Slowly, where a body turns the most; everything is seen at once."""
    rng = np.random.default_rng(count)
    traffic = []
    for _ in range(count):
        v, side = rng.uniform(4.0, 20.0), rng.choice([-1.0, 1.0])
        y = side * ((WIDTH + OTHER_WIDTH) / 2 + rng.uniform(0.2, 0.8))
        x = rng.uniform(0.05 - LENGTH, LENGTH - 0.05)
        turns = side * rng.uniform(0.2, 1.0) * min(12.0, v**2 / 11.0)
        traffic.append(Traffic(v, turns, x, y, v * rng.uniform(0.6, 1.6), 0.0, 0.0))
    met = [each for each in traffic if each.meet()]
    assert len(met) > count / 6
    assert not [each for each, rules in zip(met, fired(met)) if not rules]


@pytest.mark.parametrize("step", [0.05, 0.12, 0.2, 0.3, 0.4])
def test_nobody_who_stands_is_driven_through_however_far_samples_are_apart(step: float) -> None:
    rng = np.random.default_rng(5)
    traffic = []
    for _ in range(300):
        v, side = rng.uniform(5.0, 25.0), rng.choice([-1.0, 1.0])
        x, y = rng.uniform(0.0, v * NEXT + LENGTH), side * rng.uniform(1.0, (WIDTH + OTHER_WIDTH) / 2 + 0.3)
        traffic.append(
            Traffic(v, side * rng.uniform(0.0, 1.0) * min(6.0, v**2 / 11.0), x, y, 0.0, 0.0, 0.0, step)
        )
    met = [each for each in traffic if each.meet()]
    assert len(met) > 100
    assert not [
        each for each, rules in zip(met, fired(met, {"driving_collision"})) if not rules and each.deep()
    ]


@pytest.mark.parametrize("age", [0.0, 0.05, 0.1])
def test_who_is_behind_then_and_now_answers_for_the_room(age: float) -> None:
    """Bumper to bumper, in the line of ours and beside it; both were seen at one time."""
    behind = [
        Traffic(v, 0.0, -LENGTH - gap, y, v * faster, age, age)
        for v in (15.0, 60.0) for gap in (0.5, 5.0) for y in (0.0, 2.6) for faster in (1.0, 1.05)
    ]  # fmt: skip
    assert not any(fired(behind))
