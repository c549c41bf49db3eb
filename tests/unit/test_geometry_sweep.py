"""Swept hulls: footprints, hulls against a brute definition, and the corner cases of their construction."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest

from trackmarshal.backends.reference.geometry import footprint
from trackmarshal.backends.reference.geometry.curve import placed
from trackmarshal.backends.reference.geometry.footprint import convex_hull, swept_corners
from trackmarshal.points import Pose
from trackmarshal.runtime.geometry.sweep import Sweeps

BODY = (4.7, 2.0)


def sides(poses: list[tuple[float, ...]], body: tuple[float, float] = BODY) -> list[set[tuple[float, ...]]]:
    """Begin and end of the sides of each hull, rounded, relative to the first pose."""
    table = Sweeps(np.array(poses).T, *body).sides
    return [
        {
            tuple(np.round([x, y, x + gx, y + gy], 9) + 0.0)
            for x, y, gx, gy in table[:4, :, k].T
            if not math.isnan(gx)
        }
        for k in range(len(poses))
    ]


def brute(pose: tuple[float, ...], body: tuple[float, float] = BODY) -> set[tuple[float, ...]]:
    """All ordered pairs of the eight corners that have every other corner on their left."""
    origin = pose[:2]
    corners = footprint(pose[:3], *body, origin) + footprint(pose[3:], *body, origin)  # type: ignore[arg-type]
    found = set()
    for a, b in permutations(corners, 2):
        ex, ey = b[0] - a[0], b[1] - a[1]
        if all(ex * (y - a[1]) - ey * (x - a[0]) > 0.0 for x, y in corners if (x, y) not in (a, b)):
            found.add(tuple(np.round([*a, *b], 9) + 0.0))
    return found


def test_the_corners_of_a_footprint() -> None:
    assert footprint((10.0, 20.0, 0.0), 4.0, 2.0) == [(12.0, 21.0), (8.0, 21.0), (8.0, 19.0), (12.0, 19.0)]
    turned = footprint((0.0, 0.0, math.pi / 2), 4.0, 2.0)
    assert np.array(turned) == pytest.approx(np.array([(-1.0, 2.0), (-1.0, -2.0), (1.0, -2.0), (1.0, 2.0)]))


def swept(pose0: Pose, pose1: Pose, length: float, width: float) -> list[tuple[float, float]]:
    """The hull of what a body sweeps, seen from the first pose."""
    return convex_hull(swept_corners(placed(pose0), placed(pose1), length, width))


def test_a_hull_in_the_reference() -> None:
    assert swept((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 4.0, 2.0) == [
        (-2.0, -1.0),
        (2.0, -1.0),
        (2.0, 1.0),
        (-2.0, 1.0),
    ]
    assert swept((0.0, 0.0, 0.0), (3.0, 0.0, 0.0), 4.0, 2.0) == [
        (-2.0, -1.0),
        (5.0, -1.0),
        (5.0, 1.0),
        (-2.0, 1.0),
    ]
    assert len(swept((1.0, 2.0, 0.0), (1.0, 2.0, 0.7), 4.0, 2.0)) == 8


def test_hulls_of_any_two_poses() -> None:
    generator = np.random.default_rng(7)
    poses = [tuple(p) for p in generator.uniform(-4.0, 4.0, (600, 6)).tolist()]
    for pose, found in zip(poses, sides(poses)):
        assert found == brute(pose), pose


@pytest.mark.parametrize(
    "turn", [0.0, 0.3, math.pi / 4, math.pi / 2, 3 * math.pi / 4, math.pi, -math.pi / 2, -2.5, 40.0]
)
def test_hulls_of_poses_that_are_turned_on_the_spot(turn: float) -> None:
    pose = (3.0, 4.0, 0.2, 3.0, 4.0, 0.2 + turn)
    found = sides([pose])[0]
    aligned = abs(math.sin(2.0 * turn)) < 1e-9 and abs(math.sin(turn)) < 1e-9
    if aligned:
        assert len(found) == 4
    else:
        assert {side[:2] for side in found} == {side[2:] for side in found}
        assert len(found) == 8


def test_a_straight_move_keeps_the_corners_between_in_the_sides() -> None:
    for pose in (
        (0.0, 0.0, 0.0, 3.0, 0.0, 0.0),
        (0.0, 0.0, 0.3, 3.0 * math.cos(0.3), 3.0 * math.sin(0.3), 0.3),
    ):
        ends = sides([pose])[0]
        assert {side[:2] for side in ends} == {side[2:] for side in ends}  # closed
        assert sum(math.hypot(s[2] - s[0], s[3] - s[1]) for s in ends) == pytest.approx(
            2 * (BODY[0] + 3.0 + BODY[1])
        )


@pytest.mark.parametrize("jitter", [0.0, 5e-324, 1e-16, 1e-12, 1e-9, 1e-8, 3e-7])
def test_a_vehicle_that_hardly_moves_sweeps_its_footprint(jitter: float) -> None:
    generator = np.random.default_rng(3)
    for _ in range(50):
        x, y, heading = generator.uniform(-100.0, 100.0, 3)
        dx, dy, turn = generator.uniform(-jitter, jitter, 3)
        table = Sweeps(np.array([[x, y, heading, x + dx, y + dy, heading + turn]]).T, *BODY).sides[:, :, 0]
        lengths = table[5][~np.isnan(table[5])]
        assert (lengths > 1e-8).all()
        assert lengths.sum() == pytest.approx(2 * (BODY[0] + BODY[1]), abs=5e-6)
        # Whatever side is there, the middle of the vehicle is well inside it.
        depth = (table[3] * table[0] - table[2] * table[1]) / table[5]
        assert np.nanmin(depth) == pytest.approx(1.0, abs=5e-6)


def test_other_vehicles_in_one_call() -> None:
    poses = np.array([[0.0, 0.0, 0.0, 3.0, 0.0, 0.0], [math.nan] * 6, [0.0, 0.0, 0.0, 3.0, 0.0, 0.0]]).T
    made = Sweeps(poses, np.array([4.0, 4.0, 10.0]), np.array([2.0, 2.0, 3.0]))
    assert made.usable is not None
    assert made.usable.tolist() == [True, False, True]
    assert made.sides[0, :, [0, 2]].max(axis=1).tolist() == [5.0, 8.0]
