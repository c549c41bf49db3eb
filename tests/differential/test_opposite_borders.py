"""Borders whose points are no pairs, as two tools write them: every evaluator has the same line between them, and it is the one of the road."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.supervised import BACKENDS
from support.tracks import eight, loop, oval
from trackmarshal.evaluation import Evaluator

SPEC = """module example.middle

use prelude.frames

signal ego : state { x: m, y: m, heading: rad }
signal track : corridor { left: polyline, right: polyline }

rule left "Not too far to the left"
  require offset(ego, track) <= 1 m
rule right "Nor to the right"
  require offset(ego, track) >= -1 m
rule ahead "As the road leads"
  require abs(angle_difference(ego.heading, direction(ego, track))) <= 0.1 rad
"""
RULES = ("left", "right", "ahead")
COUNT = 300


def margins(backend: str, left: Any, right: Any, poses: Any, closed: bool) -> Any:
    evaluator = Evaluator(tm.loads(SPEC), backend=backend)
    track = {"left": [list(p) for p in left], "right": [list(p) for p in right], "closed": closed}
    cases = [
        {"signals": {"ego": {"x": x, "y": y, "heading": heading}, "track": track}} for x, y, heading in poses
    ]
    found = evaluator.evaluate(evaluator.read_all(cases))
    return np.array([[one.rules[name].margin for name in RULES] for one in found])


@BACKENDS
@pytest.mark.parametrize(
    ("shift", "turned"),
    [(0, False), (1, False), (40, False), (COUNT // 2, False), (0, True), (COUNT // 3, True)],
)
def test_of_rings(backend: str, shift: int, turned: bool) -> None:
    (left, right), poses = loop(oval, COUNT, 5.0, 5.0)
    other = [*right[shift:], *right[:shift]][:: -1 if turned else 1]
    found = margins(backend, left, other, poses[5::37], True)
    assert np.abs(found[:, :2] - 1.0).max() < 0.7
    assert np.abs(found[:, 2] - 0.1).max() < 0.2
    assert (found == margins("numpy", left, other, poses[5::37], True)).all()


@BACKENDS
def test_of_a_road_with_ends(backend: str) -> None:
    s = np.linspace(0.0, 200.0, 60)
    left, right = np.stack([s, 4.0 + 0.0 * s], axis=1), np.stack([s, -4.0 + 0.0 * s], axis=1)
    for other in (right, right[::-1]):
        assert margins(backend, left, other, [(20.0, 0.5, 0.0)], False).tolist() == [[0.5, 1.5, 0.1]]


@BACKENDS
def test_of_a_point_that_is_repeated_but_for_rounding(backend: str) -> None:
    """A hair behind where it was: that is no step, and the points are pairs all the same."""
    left = [(0.0, 5.0), (8.0, 5.0), (12.0, 5.0), (20.0, 5.0)]
    right = [(0.0, -5.0), (10.0, -9.0), (10.0 - 1e-10, -9.0), (20.0, -5.0)]
    found = margins(backend, left, right, [(10.0, 0.0, 0.0)], False)
    assert found[0].tolist() == pytest.approx([-1.0, 3.0, 0.1])
    found = margins(backend, right[::-1], left[::-1], [(10.0, 0.0, np.pi)], False)
    assert found[0].tolist() == pytest.approx([3.0, -1.0, 0.1])


@BACKENDS
def test_of_a_figure_of_eight(backend: str) -> None:
    (left, right), poses = loop(eight, COUNT, 4.0, 4.0)
    found = margins(backend, left, right, poses[::29], True)
    assert np.abs(found[:, :2] - 1.0).max() < 0.1
