"""Fallbacks that move over in a bend, beside one who keeps to his line: what he drives is counted along that line, which is longer outside and
shorter inside than the middle of the road.

Made up, on a ring; what happens is worked out with shapely, of bodies and places alone.
"""

from __future__ import annotations

import math
from functools import cache
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

LENGTH, WIDTH, OTHER_WIDTH = 4.7, 2.8, 2.0
#: m; how far apart samples are, and how far the borders are from the middle.
STEP, HALF = 2.0, 9.0
#: m/s^2 that tyres do, and s of response.
GRIP, RESPONSE = 12.6, 0.2
#: From when on one ahead brakes and how hard, and what he speeds up by before that, for no longer than the response.
AHEAD = [(0.0, 13.0, 0.0), (0.0, 8.0, 0.0), (0.0, 4.0, 0.0), (9.0, 0.0, 0.0), (9.0, 0.0, 6.0)]
#: The same of one behind, who has seen at once that ours brakes; the age of what was seen is a time in which he does not know it.
BEHIND = [(RESPONSE, 13.0, 6.0), (RESPONSE, 13.0, 0.0)]
NOBODY = {name: np.zeros(0) for name in ("x", "y", "heading", "length", "width")}
Floats = NDArray[np.float64]


class Ring(NamedTuple):
    """A road that turns to the left; stations are those of its middle, offsets to the left."""

    radius: float

    def at(self, station: Any, offset: Any) -> tuple[Any, Any, Any]:
        turned = station / self.radius
        return (
            (self.radius - offset) * np.sin(turned),
            self.radius - (self.radius - offset) * np.cos(turned),
            turned,
        )

    @property
    def track(self) -> dict[str, Any]:
        places = np.linspace(0.0, math.tau * self.radius, int(2 * self.radius), endpoint=False)
        return {
            side: np.stack(self.at(places, offset)[:2], axis=1) for side, offset in (("left", HALF), ("right", -HALF))
        } | {"closed": True}  # fmt: skip


class Fallback:
    """Braking evenly from a speed to rest, over to an offset on the way."""

    def __init__(
        self, ring: Ring, v: float, brakes: float, offset: float, aside: float, begin: float, over: float
    ) -> None:
        self.v, self.brakes, self.offset, self.lasts = v, brakes, offset, v / brakes
        way = v**2 / 2 / brakes
        station = np.linspace(0.0, 1.6 * way + 5.0, 4000)
        share = np.clip((station - begin) / over, 0.0, 1.0)
        self._x, self._y, _ = ring.at(
            station, offset + aside * share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        )
        self._s = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(self._x), np.diff(self._y)))])
        dx, dy = (np.gradient(each, self._s, edge_order=2) for each in (self._x, self._y))
        self._heading = np.unwrap(np.arctan2(dy, dx))
        bend = np.gradient(self._heading, self._s, edge_order=2)
        bend[:2] = bend[2]
        squares = np.maximum(v**2 - 2 * brakes * self._s, 0.0)
        self.asks = math.hypot(float((np.abs(bend) * squares).max()), brakes)
        s = np.append(np.arange(0.0, way - 0.01, STEP), way)
        left = np.sqrt(np.maximum(v**2 - 2 * brakes * s, 0.0))
        x, y, heading, kappa = (
            np.interp(s, self._s, each) for each in (self._x, self._y, self._heading, bend)
        )
        self.plan = {
            "t": (v - left) / brakes, "s": s, "x": x, "y": y, "heading": heading, "kappa": kappa, "v": left, "a": np.full(len(s), -brakes),
        }  # fmt: skip

    def bodies(self, t: Floats) -> Any:
        s = self.v * t - self.brakes * t**2 / 2
        x, y, heading = (np.interp(s, self._s, each) for each in (self._x, self._y, self._heading))
        return shapely.polygons(corners(x, y, heading, LENGTH, WIDTH))


class Other(NamedTuple):
    """Who keeps to an offset; where he was seen, and how long ago."""

    station: float
    offset: float
    v: float
    age: float

    def bodies(self, ring: Ring, t: Floats, late: float, brakes: float, faster: float) -> Any:
        knows = RESPONSE + self.age
        late, t = late + self.age, t + self.age
        gains = np.minimum(np.minimum(t, late), knows)
        before, after = np.minimum(t, late), np.maximum(t - late, 0.0)
        v = self.v + faster * min(late, knows)
        after = np.minimum(after, v / brakes if brakes > 0.0 else np.inf)
        way = self.v * before + faster * gains * (before - gains / 2) + v * after - brakes * after**2 / 2
        along = self.station + way * ring.radius / (ring.radius - self.offset)
        return shapely.polygons(corners(*ring.at(along, np.full(len(t), self.offset)), LENGTH, OTHER_WIDTH))


Case = tuple[Ring, Fallback, Other]


@cache
def made(count: int, behind: bool) -> list[Case]:
    """One line of both is far from the middle of the road: ahead it is that of the other one, outside, and behind inside."""
    rng, found = np.random.default_rng(count + behind), list[Case]()
    while len(found) < count:
        ring, v = Ring(rng.uniform(40.0, 160.0)), rng.uniform(10.0, 45.0)
        own, brakes = rng.uniform(-4.0, 4.0), rng.uniform(4.0, 11.0)
        line = rng.uniform(3.5, 7.5) * (1.0 if behind or rng.random() < 0.3 else -1.0)
        end = v**2 / 2 / brakes
        if abs(line - own) < (WIDTH + OTHER_WIDTH) / 2 + 0.5 or end > 2.0 * ring.radius:
            continue
        over = rng.uniform(max(8.0, 0.6 * v), max(20.0, end))
        fallback = Fallback(
            ring, v, brakes, own, line + rng.uniform(-1.0, 1.0) - own, rng.uniform(0.0, 0.5 * end), over
        )
        fast = rng.uniform(0.8, 1.8) if behind else rng.uniform(0.2, 1.1)
        station = -LENGTH - rng.uniform(0.5, 1.5 * v) if behind else rng.uniform(0.0, 0.9 * end)
        other = Other(
            station, line, min(fast * v, math.sqrt(GRIP * (ring.radius - line))), 0.1 * float(rng.integers(2))
        )
        if fallback.asks <= GRIP:
            found.append((ring, fallback, other))
    return found


def case(ring: Ring, fallback: Fallback, other: Other) -> dict[str, Any]:
    x, y, heading = ring.at(0.0, fallback.offset)
    ego = {"x": x, "y": y, "heading": float(fallback.plan["heading"][0]), "v": fallback.v}
    x, y, heading = ring.at(other.station, other.offset)
    there = {
        "x": x,
        "y": y,
        "heading": heading,
        "v": other.v,
        "age": other.age,
        "length": LENGTH,
        "width": OTHER_WIDTH,
    }
    objects = {name: np.array([value]) for name, value in there.items()}
    signals = {"plan": fallback.plan, "driving": fallback.plan, "ego": ego, "objects": objects, "obstacles": NOBODY, "track": ring.track, "emergency": True}  # fmt: skip
    return {"signals": signals}


def meet(ring: Ring, fallback: Fallback, other: Other, ways: Any) -> bool:
    lasts = max(fallback.lasts, 0.4 + (other.v + 2.0) / 13.0) if other.station < 0.0 else fallback.lasts
    t = np.arange(0.0, lasts, 0.02)
    ours = fallback.bodies(np.minimum(t, fallback.lasts))
    return any(bool(shapely.intersects(ours, other.bodies(ring, t, *way)).any()) for way in ways)


@pytest.mark.parametrize("behind", [False, True])
@pytest.mark.parametrize("count", [60, at_length(1500)])
def test_nobody_is_met_who_keeps_to_his_line(count: int, behind: bool) -> None:
    rules = {rule.name for rule in shipped().rules if rule.module == "supervisor.collision"} - {"rss_eq1"}
    judge = Evaluator(shipped(), sorted(rules), "numpy")
    cases = made(count, behind)
    found = unsafe(judge, judge.read_all([case(*each) for each in cases]))
    safe = [one for one, said in zip(cases, found, strict=True) if not said]
    assert len(safe) > count / 8
    assert not [
        (ring.radius, fallback.offset, fallback.v, other)
        for ring, fallback, other in safe
        if meet(ring, fallback, other, BEHIND if behind else AHEAD)
    ]
