"""What is swept along many samples, which C goes through stretch by stretch and looks for what is near in short numbers: as numpy says it."""

from __future__ import annotations

import cmath
import math
import random
from collections import Counter
from functools import cache
from itertools import accumulate, pairwise
from typing import Any

import pytest

from support.agreement import one_libm
from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

TEXT = """module timelines

signal plan : trajectory { t: s increasing, x: m, y: m, heading: rad, kappa: 1/m }
signal track : corridor { left: polyline, right: polyline }

rule curves "along curves"
  for all p in plan
  require swept_footprint(p, 4 m, 2 m) inside track

rule hulls "straight on"
  for all p in plan
  require swept_hull(p, 4 m, 2 m) inside track
"""


@cache
def evaluators() -> dict[str, Evaluator]:
    spec = loads(TEXT)
    return {name: Evaluator(spec, None, name) for name in ("numpy", "c")}


def plan(r: random.Random, samples: int) -> dict[str, list[float]]:
    """A way of bends, forwards or backwards, with stops; where it goes and how it is bent need not fit."""
    ahead = r.choice([0.0, r.uniform(-3.0, 3.0)])
    x, y, heading = 0.0, 0.0, ahead
    back, off = r.choice([0.0, 0.0, math.pi]), r.choice([0.0, 0.0, 0.0, 0.001, 0.01, 0.2])
    kappa, step = 0.0, 1.0
    columns: dict[str, list[float]] = {name: [] for name in ("x", "y", "heading", "kappa")}
    for _ in range(samples):
        if r.random() < 0.3:
            kappa, step = r.choice([0.0, 0.02, -0.05, 0.08]), r.choice([0.0, 1e-7, 0.1, 1.0, 2.5, 4.0])
        if abs(heading - ahead) > 0.7:
            kappa = math.copysign(kappa, ahead - heading)
        direction = -1.0 if back else 1.0
        told = (
            x,
            y,
            heading + back + off * r.uniform(-1.0, 1.0),
            direction * kappa + off * r.uniform(-1.0, 1.0),
        )
        for column, value in zip(columns.values(), told):
            column.append(value)
        turn = kappa * step
        x, y = x + step * math.cos(heading + turn / 2.0), y + step * math.sin(heading + turn / 2.0)
        heading += turn
    return columns


def track(r: random.Random, way: dict[str, list[float]]) -> dict[str, Any]:
    """An open road along the way, wide, with teeth that come so near, some of them almost equally near."""
    deep = r.choice([1.5, 1.0, 0.5, 0.2, 0.05, -0.3])
    gone = [0.0, *accumulate(math.dist(a, b) for a, b in pairwise(zip(way["x"], way["y"])))]
    rows = list(zip(gone, way["x"], way["y"]))
    places, last = [rows[0]], rows[-1]
    for row in rows:
        if row[0] - places[-1][0] > 1.0 and last[0] - row[0] > 1.0:
            places.append(row)
    places.append(last if last[0] > 1.0 else (1.0, last[1] + 1.0, last[2]))
    sides: list[list[list[float]]] = [[], []]
    for k, ((_, x0, y0), (_, x1, y1)) in enumerate(pairwise(places)):
        long = math.dist((x0, y0), (x1, y1))
        dx, dy = (x1 - x0) / long, (y1 - y0) / long
        shares = [r.uniform(0.1, 0.9) * long]
        shares = [-30.0, *shares] if k == 0 else shares
        shares = [*shares, long + 30.0] if k == len(places) - 2 else shares
        for side, sign in zip(sides, (1.0, -1.0)):
            for share in shares:
                tooth = r.random() < 0.2
                away = 1.0 + deep + r.choice([0.0, 1e-6, -1e-6, 1e-5, 0.3]) if tooth else r.uniform(3.5, 5.0)
                side.append([x0 + share * dx - sign * away * dy, y0 + share * dy + sign * away * dx])
    return {"left": sides[0], "right": sides[1]}


def case(seed: int) -> dict[str, Any]:
    r = random.Random(seed)
    way = plan(r, r.choice([3, 12, 40, 70]))
    far = r.choice([0.0, 0.0, 3e5])
    road = {name: [[x + far, y - far] for x, y in side] for name, side in track(r, way).items()}
    way["x"], way["y"] = [x + far for x in way["x"]], [y - far for y in way["y"]]
    return {"signals": {"plan": {"t": [0.1 * k for k in range(len(way["x"]))], **way}, "track": road}}


def test_no_sample_of_many_is_left_out() -> None:
    """Where corners of two poses lie on one line, last digits are a matter of rounding (docs/geometry.md); C looks in short numbers, which are a million
    times as coarse."""
    cases = [case(seed) for seed in range(amount(100, 1000))]
    with one_libm():
        said = {name: made.evaluate(made.read_all(cases)) for name, made in evaluators().items()}
    seen: Counter[str] = Counter()
    for found, expected in zip(said["c"], said["numpy"], strict=True):
        for name, one in found.rules.items():
            wanted = expected.rules[name]
            assert one.verdict == wanted.verdict, found.id
            assert one.margin == pytest.approx(wanted.margin, rel=0.0, abs=1e-9, nan_ok=True), found.id
            seen[one.verdict] += 1
    assert min(seen["satisfied"], seen["violated"]) > 50, seen


@pytest.mark.parametrize("steps", [[0.5] * 120, [2.5] * 24, [20.0] * 3])
def test_a_car_that_leaves_the_road_is_as_far_out_as_in_the_end(steps: list[float]) -> None:
    """Straight over the border, to where no border is near any more: nothing that is near is not nothing that is wrong. Its front ends 62 m north, the
    road 10 m."""
    y = [0.0, *accumulate(steps)]
    columns = {"x": [0.0] * len(y), "y": y, "heading": [math.pi / 2] * len(y), "kappa": [0.0] * len(y)}
    road = {"left": [[-200.0, 10.0], [200.0, 10.0]], "right": [[-200.0, -10.0], [200.0, -10.0]]}
    signals = {"plan": {"t": [0.1 * k for k in range(len(y))], **columns}, "track": road}
    for made in evaluators().values():
        for one in made.case({"signals": signals}).rules.values():
            assert one.verdict == "violated"
            assert one.margin == pytest.approx(-52.0)


def test_what_is_nearer_counts_however_little_nearer_it_is() -> None:
    """The right border by 0.02 mm, against the line where the road begins, which is looked at first. Of borders of 6 km, short numbers tell less apart:
    these leave out what is farther than they may be wrong by."""
    r, ahead = random.Random(5), 0.7 - math.pi
    cases = []
    for _ in range(60):
        origin = complex(r.uniform(-500.0, 500.0), r.uniform(-500.0, 500.0))

        def placed(u: float, v: float, origin: complex = origin) -> list[float]:
            place = origin + complex(u, v) * cmath.rect(1.0, ahead)
            return [place.real, place.imag]

        left, right = ([placed(u, v) for u in (-3.00002, 100.0, 3000.0, 6000.0)] for v in (4.0, -2.0))
        x, y = zip(*(placed(0.5 * k, 0.0) for k in range(4)))
        plan = {"t": [0.1 * k for k in range(4)], "x": x, "y": y, "heading": [ahead] * 4, "kappa": [0.0] * 4}
        cases.append({"signals": {"plan": plan, "track": {"left": left, "right": right}}})
    made = evaluators()["c"]
    for one in made.evaluate(made.read_all(cases)):
        for rule in one.rules.values():
            assert rule.margin == pytest.approx(1.0, abs=1e-7)
