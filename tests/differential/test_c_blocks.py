"""Generated C looks for what is near in blocks of 8, 64 and 512 segments: lines and borders of just so many, and of one more or less, in every evaluator."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise
from typing import Any

import pytest

from support.agreement import one_libm
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, loads

pytestmark = pytest.mark.skipif(compiler() is None, reason="no C compiler")

TEXT = """module blocks

signal at : state { x: m, y: m, heading: rad }
signal way : polyline
signal track : corridor { left: polyline, right: polyline }

rule station "how far along" require station(at, way) <= 0 m
rule direction "where it leads" require direction(at, way) <= 0 rad
rule away "how far off" require distance_to(at, way) <= 0 m
rule inside "how far from the borders" require footprint(at, 2 m, 1 m) inside track
rule gap "how far along the ring" require station(at, track) <= 0 m
"""
#: As many segments as blocks have, and one more or less; again as many as there were before.
SIZES = (1, 2, 7, 8, 9, 63, 64, 65, 511, 512, 513, 64, 8)
RING = {"left": [[5, 5], [-5, 5], [-5, -5], [5, -5]], "right": [[1, 1], [-1, 1], [-1, -1], [1, -1]], "closed": True}  # fmt: skip


@cache
def evaluators() -> dict[str, Evaluator]:
    spec = loads(TEXT)
    return {name: Evaluator(spec, None, name) for name in ("reference", "numpy", "c")}


def margins(cases: list[dict[str, Any]]) -> list[dict[str, float]]:
    """What each evaluator says; raises AssertionError where they differ."""
    with one_libm():
        said = {
            name: [{rule: one.margin for rule, one in result.rules.items()} for result in made.evaluate(made.read_all(cases))]
            for name, made in evaluators().items()
        }  # fmt: skip
    assert said["c"] == said["reference"] == said["numpy"]
    return said["c"]


def ends(count: int) -> list[int]:
    """Segments beside the ends of blocks."""
    near = {at + by for at in (0, 8, 64, 512, count) for by in (-2, -1, 0, 1)}
    return sorted(k for k in near if 0 <= k < count)


def test_the_nearest_segment_of_a_line() -> None:
    """Each is the nearest one of some point; of two that are equally near, the first one, also where they are in two blocks."""
    apart = 4.0
    for count in SIZES:
        line = [[apart * k, (-1.0) ** k] for k in range(count + 1)]
        length = math.hypot(apart, 2.0)
        sides = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in pairwise(line)]
        middles = [(apart * (k + 0.5), 0.0) for k in ends(count)]
        corners = [(apart * k, 3.0 * (-1.0) ** k) for k in ends(count) if k > 0]
        said = margins([_case(*point, line, RING) for point in (*middles, *corners)])
        for k, one in zip(ends(count), said):
            assert -one["station"] == pytest.approx(length * (k + 0.5))
            assert -one["direction"] == pytest.approx(sides[k])
        for k, one in zip(ends(count)[1:], said[len(middles) :], strict=True):
            assert -one["station"] == pytest.approx(length * k)
            assert -one["direction"] == pytest.approx(sides[k - 1])


@pytest.mark.parametrize("turned", [False, True])
def test_the_borders_of_a_ring(turned: bool) -> None:
    """Its last segment meets the first one, which is in another block; the inner border begins anywhere in one."""
    for count in (n for n in SIZES if n > 2):
        angles = [2.0 * math.pi * (k + 0.3) / count for k in range(count)]
        radius = max(12.0, count / 2.0)
        outer, inner = (
            [[reach * math.cos(a), reach * math.sin(a)] for a in angles] for reach in (radius * 2.5, radius)
        )
        track = {
            "left": outer if turned else inner,
            "right": inner if turned else outer,
            "closed": True,
        }
        half = math.pi / count
        between = radius * (1.25 * math.cos(half) + 0.5)
        poses = [
            (between * math.cos(a + half), between * math.sin(a + half))
            for a in (angles[k] for k in ends(count))
        ]
        for one in margins([_case(*pose, [[0, 0], [1, 0]], track) for pose in poses]):
            # The middle of the outer side is as far away as the inner corner, but for half a footprint or the way to its own corner.
            assert 0.5 <= (1.25 * math.cos(half) - 0.5) * radius - one["inside"] <= 1.2


def _case(x: float, y: float, way: Any, track: Any) -> dict[str, Any]:
    return {"signals": {"at": {"x": x, "y": y, "heading": 0.7}, "way": way, "track": track}}
