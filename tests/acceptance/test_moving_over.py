"""Fallbacks that move over, beside one who keeps to his line: who is safe by the rules meets nobody, whether that one drives on, brakes or speeds up;
and nobody behind who has seen at once that ours brakes.

Made up, on a straight road: what happens is worked out with shapely, of bodies and places alone.
"""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import Any, NamedTuple

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from support.agreement import unsafe
from support.dense.sweep import corners
from support.length import at_length
from support.supervised import shipped
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.verifies("S-1-A-2")

BESIDE, BEHIND = "fallback_line", "fallback_cut_in"
LENGTH, WIDTH, OTHER_WIDTH = 4.7, 2.8, 2.0
#: How far apart samples are, m.
STEP = 2.0
#: What the other one does: from when on, how hard it brakes; and what it speeds up by in 0.2 s before that.
SOME = [(0.0, 13.0, 0.0), (0.0, 4.0, 0.0), (9.0, 0.0, 0.0), (9.0, 0.0, 6.0)]
ALL = [*SOME, *product((0.0, 0.5, 1.0, 2.0), (2.0, 4.0, 8.0, 13.0), (0.0, 6.0))]
AMOUNTS = [(300, SOME), pytest.param(3000, ALL, marks=pytest.mark.acceptance)]
#: What one behind does who has seen at once that ours brakes: from when on and how hard it brakes, and what it speeds up by before that.
REACTS = [(0.2, 13.0, 6.0), (0.2, 13.0, 0.0), (0.1, 13.0, 0.0)]

X = np.arange(-300.0, 900.0, 5.0)
TRACK = {"left": np.stack([X, 0.0 * X + 8.0], axis=1), "right": np.stack([X, 0.0 * X - 8.0], axis=1)}
NOBODY = {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")}
Floats = NDArray[np.float64]


class Fallback:
    """Braking evenly from a speed to rest, over so far, to a line `aside` of the present one, between two places of the road."""

    def __init__(self, v: float, end: float, aside: float, begin: float, over: float) -> None:
        self._x = np.linspace(0.0, end, 4000)
        share = np.clip((self._x - begin) / over, 0.0, 1.0)
        self._y = aside * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        self._slope = aside / over * 30.0 * share**2 * (1.0 - share) ** 2
        bend = aside / over**2 * 60.0 * share * (1.0 - share) * (1.0 - 2.0 * share)
        self._s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self._x), np.diff(self._y)))])
        self.v, self.brakes = v, v**2 / 2 / self._s[-1]
        self.lasts = v / self.brakes
        x = np.append(np.arange(0.0, end - 0.01, STEP), end)
        s, y, slope, bend = (
            np.interp(x, self._x, column) for column in (self._s, self._y, self._slope, bend)
        )
        left = np.sqrt(np.maximum(v**2 - 2 * self.brakes * s, 0.0))
        self.plan = {
            "t": (v - left) / self.brakes, "s": s, "x": x, "y": y, "heading": np.arctan(slope), "kappa": bend / (1.0 + slope**2) ** 1.5, "v": left,
            "a": np.full(len(s), -self.brakes),
        }  # fmt: skip

    def bodies(self, t: Floats) -> Any:
        s = self.v * t - self.brakes * t**2 / 2
        x, y, slope = (np.interp(s, self._s, column) for column in (self._x, self._y, self._slope))
        return shapely.polygons(corners(x, y, np.arctan(slope), LENGTH, WIDTH))


class Other(NamedTuple):
    """Who drives along the road, so far ahead and to the left."""

    x: float
    y: float
    v: float

    @property
    def moved_over(self) -> Other:
        """By half of the room that is left beside ours."""
        room = max(abs(self.y) - (WIDTH + OTHER_WIDTH) / 2, 0.0)
        return self._replace(y=float(self.y - np.sign(self.y) * room / 2))

    def bodies(self, t: Floats, late: float, brakes: float, faster: float) -> Any:
        v = self.v + faster * min(late, 0.2)
        before, after = np.minimum(t, late), np.maximum(t - late, 0.0)
        after = np.minimum(after, v / brakes if brakes > 0.0 else np.inf)
        gained = faster * np.minimum(before, 0.2) * (before - np.minimum(before, 0.2) / 2)
        x = self.x + self.v * before + gained + v * after - brakes * after**2 / 2
        return shapely.polygons(corners(x, np.full(len(t), self.y), np.zeros(len(t)), LENGTH, OTHER_WIDTH))


@cache
def made(count: int, behind: bool = False) -> list[tuple[Fallback, Other]]:
    rng = np.random.default_rng(count + behind)
    found = []
    for _ in range(count):
        v, brakes = rng.uniform(15.0, 60.0), rng.uniform(3.0, 11.0)
        end = v**2 / 2 / brakes
        over = rng.uniform(max(10.0, 0.7 * v), max(30.0, end))
        aside = rng.choice([-1.0, 1.0]) * rng.uniform(0.0, 6.0)
        other = Other(rng.uniform(-8.0, 0.9 * end), rng.uniform(-6.5, 6.5), rng.uniform(0.6, 1.1 * v))
        if behind:
            y = rng.choice([-1.0, 1.0]) * rng.uniform((WIDTH + OTHER_WIDTH) / 2 + 0.11, 6.5)
            other = Other(-LENGTH - rng.uniform(0.0, 2.0 * v), y, rng.uniform(0.5 * v, 2.0 * v))
        found.append((Fallback(v, end, aside, rng.uniform(0.0, 0.7 * end), over), other))
    return found


@cache
def fired(count: int, behind: bool = False) -> list[set[str]]:
    """By case the rules about others that are violated."""
    return judged([case(*each) for each in made(count, behind)])


def judged(cases: list[dict[str, Any]]) -> list[set[str]]:
    """By case the rules about others that are violated."""
    rules = {rule.name for rule in shipped().rules if rule.module == "supervisor.collision"} - {"rss_eq1"}
    judge = Evaluator(shipped(), sorted(rules), "numpy")
    return unsafe(judge, judge.read_all(cases))


def case(fallback: Fallback, other: Other, width: float = OTHER_WIDTH) -> dict[str, Any]:
    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "v": fallback.v}
    there = {**other._asdict(), "heading": 0.0, "length": LENGTH, "width": width}
    objects = {name: np.array([value]) for name, value in there.items()}
    signals = {"plan": fallback.plan, "driving": fallback.plan, "ego": ego, "objects": objects, "obstacles": NOBODY, "track": TRACK, "emergency": True}  # fmt: skip
    return {"signals": signals}


def meet(fallback: Fallback, other: Other, ways: Any) -> bool:
    """Whether both touch before ours stands, and who is behind before it stands as well, whatever the other one does of that."""
    t = np.arange(0.0, fallback.lasts, 0.02)
    if other.x + LENGTH <= 0.0:
        t = np.arange(0.0, max(fallback.lasts, 0.2 + (other.v + 1.2) / 13.0), 0.02)
    ours = fallback.bodies(np.minimum(t, fallback.lasts))
    return any(bool(shapely.intersects(ours, other.bodies(t, *way)).any()) for way in ways)


@pytest.mark.parametrize(("count", "ways"), AMOUNTS)
def test_nobody_is_met_who_keeps_to_his_line(count: int, ways: Any) -> None:
    """But who is behind: the rear vehicle is responsible (A-REAR-VEHICLE)."""
    safe = [each for each, said in zip(made(count), fired(count)) if not said and each[1].x + LENGTH > 0.0]
    assert len(safe) > count / 4
    met = [
        (fallback.plan["y"][-1], fallback.v, other) for fallback, other in safe if meet(fallback, other, ways)
    ]
    assert not met


@pytest.mark.parametrize(("count", "ways"), AMOUNTS)
def test_who_is_stopped_by_this_rule_alone_mostly_meets_somebody(count: int, ways: Any) -> None:
    """In his line, or where he has moved over by his half of the room. The rest is steps of the trajectory, of which the whole counts, and what no way of
    braking that is tried here comes to.
    """
    alone = [each for each, said in zip(made(count), fired(count)) if said == {BESIDE}]
    assert len(alone) > count / 20
    assert sum(
        meet(ours, other, ways) or meet(ours, other.moved_over, ways) for ours, other in alone
    ) > 0.7 * len(alone)


@pytest.mark.parametrize("count", [200, at_length(2000)])
def test_two_abreast_that_fall_back_at_once_do_not_meet(count: int) -> None:
    """Both are supervised, each fallback is safe beside a car that keeps to its line, and what takes the view from one takes it from the other, too."""
    rng = np.random.default_rng(count)
    pairs = []
    for _ in range(count):
        y = rng.uniform(WIDTH / 2 + 0.1, 6.4)
        places = (0.0, y), (rng.uniform(-0.9 * LENGTH, 0.9 * LENGTH), -y)
        both, v = [], rng.uniform(15.0, 60.0)
        for side in (-1.0, 1.0):
            end = v**2 / 2 / rng.uniform(3.0, 11.0)
            over = rng.uniform(max(10.0, 0.7 * v), max(30.0, end))
            both.append(Fallback(v, end, side * y * rng.uniform(0.0, 1.3), rng.uniform(0.0, 0.4 * end), over))
        pairs.append((both, places))
    cases = []
    for both, places in pairs:
        for (ours, theirs), (here, there) in ((both, places), (both[::-1], places[::-1])):
            one = case(ours, Other(*there, theirs.v), WIDTH)
            signals = one["signals"]
            signals["ego"] |= dict(zip("xy", here))
            signals["plan"] = signals["driving"] = {
                **ours.plan,
                "x": ours.plan["x"] + here[0],
                "y": ours.plan["y"] + here[1],
            }
            cases.append(one)
    said = judged(cases)
    safe = [pair for pair, first, second in zip(pairs, said[::2], said[1::2]) if not first | second]
    assert len(safe) > count / 8
    met = []
    for both, places in safe:
        t = np.arange(0.0, max(each.lasts for each in both), 0.02)
        bodies = [
            shapely.transform(each.bodies(np.minimum(t, each.lasts)), lambda points, at=at: points + at)
            for each, at in zip(both, places)
        ]
        if shapely.intersects(*bodies).any():
            met.append(places)
    assert not met


@pytest.mark.parametrize("count", [300, at_length(3000)])
def test_nobody_behind_is_cut_off_who_reacts_at_once(count: int) -> None:
    safe = [each for each, said in zip(made(count, True), fired(count, True)) if not said]
    assert len(safe) > count / 2
    assert not [other for fallback, other in safe if meet(fallback, other, REACTS)]


@pytest.mark.parametrize("count", [300, at_length(3000)])
def test_who_is_stopped_for_somebody_behind_mostly_cuts_him_off(count: int) -> None:
    """The rest is the step in which the trajectory comes into his line, of which the whole counts."""
    alone = [each for each, said in zip(made(count, True), fired(count, True)) if said == {BEHIND}]
    assert len(alone) > count / 30
    assert sum(meet(*each, REACTS) for each in alone) > 0.7 * len(alone)
