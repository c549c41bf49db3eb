"""Two cars in one race line, of which the one ahead is slower, or comes the wrong way: who falls back as long as the rules let it meets nobody.

All around Berlin's race line, which crosses the road; who is beside whom by offsets from the middle of the road says little there. What happens
is worked out with shapely, of bodies and places alone.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from support import race_line
from support.dense.sweep import corners
from support.length import at_length
from support.shared import shared
from support.supervised import shipped
from trackmarshal.evaluation import Evaluator

pytestmark = pytest.mark.verifies("S-1-A-2")

EGO, BRAKES, LENGTH, WIDTH = 25.0, 7.0, 4.7, 2.0
#: How far ahead the other car is at first, and how far apart samples are, m.
FIRST, STEP = 85.0, 2.0
#: As they were found: safe down to 19 m, and contact at 11 to 18 m/s.
FOUND = [(459, 3.0), (462, 0.6), (522, 0.6)]
SOME, ALL = 97, 4


class Line:
    """The race line by the way along it, over two laps."""

    def __init__(self) -> None:
        lap = race_line.read(shared("data", "tracks", "ltpl_berlin.csv"))
        x, y = (np.array([*lap[name], *lap[name], lap[name][0]]) for name in ("x", "y"))
        self.s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))])
        heading = np.unwrap([*lap["heading"], *lap["heading"], lap["heading"][0]])
        kappa = np.array([*lap["kappa"], *lap["kappa"], lap["kappa"][0]])
        self.columns = {"x": x, "y": y, "heading": heading, "kappa": kappa}

    def at(self, s: Any) -> dict[str, NDArray[np.float64]]:
        return {name: np.interp(s, self.s, column) for name, column in self.columns.items()}


@cache
def line() -> Line:
    return Line()


@cache
def judge() -> Evaluator:
    """Of others, and not of the road: the race line is for a narrower car."""
    rules = {rule.name for rule in shipped().rules if rule.module == "supervisor.collision"}
    return Evaluator(shipped(), sorted(rules - {"rss_eq1", "static_collision"}), "numpy")


@cache
def road() -> Mapping[str, Any]:
    left, right = race_line.borders(shared("data", "tracks", "ltpl_berlin.csv"))
    return {"left": np.array(left), "right": np.array(right), "closed": True}


def fallback(s: float) -> dict[str, NDArray[np.float64]]:
    """Braking from a place of the line on."""
    way = np.append(np.arange(0.0, EGO**2 / 2 / BRAKES - 0.01, STEP), EGO**2 / 2 / BRAKES)
    v = np.sqrt(np.maximum(EGO**2 - 2 * BRAKES * way, 0.0))
    return line().at(s + way) | {"t": (EGO - v) / BRAKES, "s": way, "v": v, "a": np.full(len(v), -BRAKES)}


def objects(s: float, v: float) -> dict[str, NDArray[np.float64]]:
    place = line().at(s)
    given = {name: float(place[name]) for name in ("x", "y", "heading")}
    return {
        name: np.array([value])
        for name, value in (given | {"v": v, "length": LENGTH, "width": WIDTH}).items()
    }


def safe(s: float, other: float, v: float) -> bool:
    plan = fallback(s)
    ego = {name: float(plan[name][0]) for name in ("x", "y", "heading", "v")}
    nobody = {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")}
    signals = {"plan": plan, "driving": plan, "ego": ego, "objects": objects(other, v), "obstacles": nobody, "track": road(), "emergency": True}  # fmt: skip
    return judge().case({"signals": signals}).safe


def last(start: float, v: float, first: float = FIRST) -> tuple[float, float]:
    """Where both are in the last cycle, of those every 0.1 s, in which the emergency trajectory is safe."""
    for k in range(300):
        s, other = start + 0.1 * EGO * k, start + first + 0.1 * v * k
        if not safe(s, other, v):
            return s - 0.1 * EGO, other - 0.1 * v
    raise AssertionError("it is never unsafe")


def meet(start: float, other: float, v: float, brakes: float, late: float = 0.0) -> bool:
    """Whether the emergency trajectory meets the other car, which brakes so hard from so late on, in s."""
    # Of one that does not brake: until we have stood for half a second, as long as it is for us.
    t = np.arange(0.0, 12.0 if brakes > 0.0 else EGO / BRAKES + 0.5, 0.01)
    braking = np.minimum(t, EGO / BRAKES)
    driving = np.minimum(np.maximum(t - late, 0.0), abs(v) / brakes if brakes > 0.0 else np.inf)
    way = abs(v) * (np.minimum(t, late) + driving) - brakes * driving**2 / 2
    ours = line().at(start + EGO * braking - BRAKES * braking**2 / 2)
    theirs = line().at(other + np.sign(v) * way)
    bodies = (
        shapely.polygons(corners(at["x"], at["y"], at["heading"], LENGTH, WIDTH)) for at in (ours, theirs)
    )
    return bool(shapely.intersects(*bodies).any())


def starts(every: int) -> Iterator[int]:
    return iter(range(0, len(line().s) // 2, every))


def approach(index: int, v: float) -> float:
    """How far bumpers are apart, along the line, when it is safe for the last time; nobody is met from there."""
    s, other = last(float(line().s[index]), v)
    for brakes in (0.0, 4.0, 13.0):
        assert not meet(s, other, v, brakes), (index, v, brakes, other - s - LENGTH)
    return other - s - LENGTH


@pytest.mark.parametrize(("index", "v"), FOUND)
def test_ways_in_which_a_car_was_met(index: int, v: float) -> None:
    assert approach(index, v) > EGO**2 / 2 / BRAKES - 3.0


@pytest.mark.parametrize("v", [at_length(0.3), 0.6, at_length(3.0), 8.0])
@pytest.mark.parametrize("every", [SOME, pytest.param(ALL, marks=pytest.mark.acceptance)])
def test_nobody_is_met_wherever_the_approach_is(every: int, v: float) -> None:
    """And no fallback ends much sooner than it has to: 6 m are a step of it, the body's width in a bend, and what drives on in a cycle."""
    spare = [approach(index, v) + v**2 / 26 - EGO**2 / 2 / BRAKES for index in starts(every)]
    assert max(spare) < 8.0


@pytest.mark.parametrize("v", [at_length(3.0), at_length(10.0), at_length(20.0), 35.0])
@pytest.mark.parametrize("every", [SOME, at_length(4 * ALL)])
def test_nobody_is_met_who_comes_the_wrong_way_and_brakes_gently(every: int, v: float) -> None:
    """As RSS takes it, with 4 m/s^2 after 0.2 s. Of 222 such approaches, 79 ended in contact, each car at up to 15 m/s, while offsets from the middle
    of the road alone said who is beside whom."""
    for index in starts(every):
        # Farther away than it may get, or, across a hairpin, as near as it was at first.
        s, other = last(float(line().s[index]), -v, 400.0)
        assert not meet(s, other, -v, 4.0, 0.2), (index, v, other - s - LENGTH)
