"""What a real planner's trajectories sweep, by the engine and by a dense walk with numpy and shapely that shares nothing with it.

The planner's samples are 2.5 m apart in bends of down to 12 m. On Berlin it passes a border by 5.6 cm, and leaves the road nowhere; the
convex hulls of footprints leave it in 139 of 831 cycles.
"""

from __future__ import annotations

import gzip
import json
import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import shapely
from numpy.typing import NDArray

from support.length import shared_out
from support.shared import shared
from trackmarshal.runtime import geometry as fast

pytestmark = pytest.mark.verifies("S-1-A-2")

BODY = (4.7, 2.8)
#: Steps of the walk between two samples.
STEPS = 25
#: Ways whose hulls are farther from the border than this are of no interest [m].
NEAR = 0.3
Floats = NDArray[np.float64]


@cache
def recorded(path: Path) -> tuple[Floats, Floats, list[Any]]:
    with gzip.open(path, "rt") as file:
        head = json.loads(next(file))
        cycles = [json.loads(line)["candidates"] for line in file]
    assert head["track"]["closed"]
    return np.array(head["track"]["left"]), np.array(head["track"]["right"]), cycles


def columns(cycle: Any) -> Floats:
    """x, y, heading and curvature of all ways of both candidates, at both ends: (8, ways)."""
    ways = []
    for candidate in cycle.values():
        table = np.array([candidate[name] for name in ("x", "y", "heading", "kappa")])
        ways.append(np.concatenate([table[:, :-1], table[:, 1:]]))
    return np.concatenate(ways, axis=1)


def boxes(poses: Floats) -> Any:
    """Rectangles of poses, (3, ...), as shapely's polygons."""
    x, y, heading = poses
    ahead, left = BODY[0] / 2 * np.exp(1j * heading), BODY[1] / 2 * 1j * np.exp(1j * heading)
    corners = np.stack(
        [(x + 1j * y) + a * ahead + b * left for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))], -1
    )
    return shapely.polygons(np.stack([corners.real, corners.imag], axis=-1))


def walked(ways: Floats) -> Floats:
    """Poses on the ways, (3, ways, steps + 1): curvature from that at one end to that at the other. What the walk misses the second
    pose by is spread over it: the planner rounds."""
    x0, y0, heading0, kappa0, x1, y1, heading1, kappa1 = ways
    t = np.linspace(0.0, 1.0, STEPS + 1)
    turn = np.remainder(heading1 - heading0 + math.pi, 2 * math.pi) - math.pi
    length = np.hypot(x1 - x0, y1 - y0) / np.sinc(turn / 2 / math.pi)
    heading = heading0[:, None] + length[:, None] * (
        kappa0[:, None] * t + (kappa1 - kappa0)[:, None] * t * t / 2
    )
    heading += (heading0 + turn - heading[:, -1])[:, None] * t
    step = length / STEPS
    direction = (np.exp(1j * heading[:, 1:]) + np.exp(1j * heading[:, :-1])) / 2
    place = np.concatenate([np.zeros((x0.size, 1)), np.cumsum(direction, axis=1)], axis=1) * step[:, None]
    place += (x0 + 1j * y0)[:, None]
    missed = (x1 + 1j * y1) - place[:, -1]
    assert np.abs(missed).max() < 0.01
    place += missed[:, None] * t
    return np.stack([place.real, place.imag, heading])


@pytest.mark.parametrize(("name", "hulls_out"), shared_out([("berlin", 139), ("modena", 0)], 2))
def test_a_planner_that_stays_on_the_road(name: str, hulls_out: int) -> None:
    left, right, cycles = recorded(shared("data", "planner", f"{name}.tmrec.jsonl.gz"))
    corridor = fast.Corridor(left, right, closed=True)
    border = shapely.MultiLineString([np.vstack([line, line[:1]]) for line in (left, right)])
    shapely.prepare(border)
    counted = [columns(cycle) for cycle in cycles]
    ends = np.cumsum([0, *(part.shape[1] for part in counted)])[:-1]
    ways, which = np.unique(np.concatenate(counted, axis=1), axis=1, return_inverse=True)
    poses, bends = ways[[0, 1, 2, 4, 5, 6]], ways[[3, 7]]
    hull = corridor.margin_inside(*poses, *BODY)
    assert (np.minimum.reduceat(hull[which], ends) < 0.0).sum() == hulls_out
    curve = corridor.margin_inside(*poses, *BODY, *bends)
    assert (curve >= 0.0).all()
    near = (np.minimum(hull, curve) < NEAR).nonzero()[0]
    assert near.size > 100
    dense = shapely.distance(border, boxes(walked(ways[:, near]))).min(axis=1)
    assert dense.min() > 0.05  # none of it is out
    excess = dense - curve[near]
    assert excess.min() >= -1e-6  # nothing is left out
    assert excess.max() <= 0.01
