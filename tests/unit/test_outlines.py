"""Zones and lines that are none: what is wrong and where, against shapely, which we did not write."""

from __future__ import annotations

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import LineString, Polygon

from support.length import amount
from trackmarshal.backends.reference import geometry
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.outlines import problem

GRID = st.integers(0, 5).map(float)
POINTS = st.lists(st.tuples(GRID, GRID), min_size=2, max_size=8).map(tuple)


@settings(max_examples=amount(100, 500), deadline=None)
@given(POINTS)
def test_zones_are_those_of_shapely(points: tuple[tuple[float, float], ...]) -> None:
    ring = [p for k, p in enumerate(points) if p != points[k - 1]]  # also the last one, where it is the first
    sound = len(ring) >= 3 and Polygon(ring).is_valid
    assert (problem("zone", points, repeated=False) is None) == sound


@settings(max_examples=amount(100, 500), deadline=None)
@given(POINTS)
def test_zones_are_those_that_rules_can_read(points: tuple[tuple[float, float], ...]) -> None:
    assert (problem("zone", points, repeated=False) is None) == (geometry.zone_fault(points) is None)


@settings(max_examples=amount(100, 500), deadline=None)
@given(POINTS)
def test_a_line_lies_nowhere_twice(points: tuple[tuple[float, float], ...]) -> None:
    """What it covers is as long as it is, where it may meet itself in points alone."""
    kept = [p for k, p in enumerate(points) if k == 0 or p != points[k - 1]]
    found = problem("line", points, repeated=False)
    if len(kept) < 2:
        assert found is not None
        return
    parts = [LineString(pair) for pair in zip(kept, kept[1:])]
    twice = any(
        one.intersection(other).length > 1e-9 for k, one in enumerate(parts) for other in parts[k + 1 :]
    )
    assert (found is not None) == twice


@given(POINTS)
def test_the_places_are_points_of_it(points: tuple[tuple[float, float], ...]) -> None:
    for kind in ("zone", "line"):
        found = problem(kind, points)
        if found is not None:
            assert 0 <= found.at < len(points)
            assert found.other is None or (0 <= found.other < len(points) and found.other != found.at)


def test_many_points_take_little_time() -> None:
    ring = tuple(
        (100 * math.cos(k * math.tau / 5000), 100 * math.sin(k * math.tau / 5000)) for k in range(5000)
    )
    assert problem("zone", ring) is None


@pytest.mark.parametrize("backend", ["reference", "numpy"])
@pytest.mark.parametrize(
    "points", [[[0, 0], [9, 9], [9, 0], [0, 9]], [[0, 0], [1, 1], [2, 2]], [[0, 0], [1, 0], [2e9, 2]]]
)
def test_data_that_brings_one_that_is_none(points: list[list[float]], backend: str) -> None:
    spec = loads(
        "module made\nsignal ego : state { x: m, y: m }\nzone z = polygon (0 m, 0 m) (9 m, 0 m) (0 m, 9 m)\n"
        'rule in_z "in the zone"\n  require ego in zone z\n'
    )
    data = {"signals": {"ego": {"x": 1, "y": 1}}}
    found = Evaluator(spec, backend=backend).case({**data, "places": {"z": points}})
    assert found.rules["in_z"].verdict == "undefined"
    assert not found.safe
    twice = {"z": [[0, 0], [0, 0], [9, 0], [0, 9], [0, 0]]}
    assert Evaluator(spec).case({**data, "places": twice}).rules["in_z"].verdict == "satisfied"
