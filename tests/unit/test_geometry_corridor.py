"""What a vehicle sweeps, inside corridors: values worked out by hand, for both implementations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.bodies import BOTH, Geometry, Pose
from support.tracks import eight, loop, oval
from trackmarshal.runtime.geometry import Corridor, Polygon
from trackmarshal.runtime.geometry.region import POINTS_AT_ONCE

CAR = (4.0, 2.0)
LEFT = [(0.0, 5.0), (50.0, 5.0), (100.0, 5.0)]
RIGHT = [(0.0, -5.0), (40.0, -5.0), (100.0, -5.0)]
NAN = math.nan

both = pytest.mark.parametrize("geometry", BOTH.values(), ids=BOTH.keys())


def stand(x: float, y: float, heading: float = 0.0) -> tuple[Pose, Pose]:
    return (x, y, heading), (x, y, heading)


@both
@pytest.mark.parametrize(
    ("poses", "margin"),
    [
        (stand(50.0, 0.0), 4.0),  # the sides are the nearest: 5 - 1
        (stand(50.0, 1.5), 2.5),
        (stand(50.0, -3.0), 1.0),
        (stand(50.0, 0.0, math.pi), 4.0),
        (stand(5.0, 0.0), 3.0),  # the end of the corridor is a border: 5 - 2
        (stand(50.0, 4.0), 0.0),  # touching is inside
        (stand(2.0, 4.0), 0.0),  # in the corner
        (stand(50.0, 4.25), -0.25),
        (stand(50.0, 5.0), -1.0),
        (stand(50.0, 5.75), -1.75),
        (stand(1.0, 0.0), -1.0),  # over the end
        (stand(50.0, 100.0), -96.0),  # wholly outside: its farther corners
        (stand(-100.0, 0.0), -102.0),
        (((20.0, 0.0, 0.0), (23.0, 2.0, 0.0)), 2.0),  # swept: as near as the nearer pose
        (((20.0, -3.0, 0.0), (23.0, 4.5, 0.0)), -0.5),
        (((90.0, 0.0, 0.0), (130.0, 0.0, 0.0)), -32.0),  # a stride out of the end, longer than any cell
    ],
)
def test_in_a_straight_corridor(geometry: Geometry, poses: tuple[Pose, Pose], margin: float) -> None:
    assert geometry.inside(LEFT, RIGHT, *poses, CAR) == pytest.approx(margin, abs=1e-12)
    assert geometry.inside(RIGHT, LEFT, *poses, CAR) == pytest.approx(margin, abs=1e-12)
    ring = [*LEFT, *RIGHT[::-1]]
    assert geometry.inside_polygon(ring, *poses, CAR) == pytest.approx(margin, abs=1e-12)


@both
def test_exactly_on_the_border_is_inside_and_a_hair_beyond_is_not(geometry: Geometry) -> None:
    assert geometry.inside(LEFT, RIGHT, *stand(50.0, 4.0), CAR) == 0.0
    assert geometry.inside(LEFT, RIGHT, *stand(50.0, math.nextafter(4.0, 5.0)), CAR) < 0.0
    assert geometry.inside(LEFT, RIGHT, *stand(50.0, math.nextafter(4.0, 3.0)), CAR) > 0.0


@both
def test_a_corner_that_touches_a_slanted_border(geometry: Geometry) -> None:
    # The corner (2, 1) of a car at the origin lies on x + 2 y = 4, through (4, 0) and (0, 2).
    ring = [(-10.0, 7.0), (-10.0, -10.0), (10.0, -10.0), (10.0, -3.0)]
    assert geometry.inside_polygon(ring, *stand(0.0, 0.0), CAR) == 0.0


@both
def test_a_bulge_between_the_corners_is_found(geometry: Geometry) -> None:
    left = [(0.0, 5.0), (49.0, 5.0), (50.0, 0.75), (51.0, 5.0), (100.0, 5.0)]
    assert geometry.inside(left, RIGHT, *stand(50.0, 0.0), CAR) == pytest.approx(-0.25, abs=1e-12)
    # Between the poses only: at rest in either, the car is clear of it.
    assert geometry.inside(left, RIGHT, *stand(46.0, 0.0), CAR) > 0.0
    assert geometry.inside(left, RIGHT, *stand(54.0, 0.0), CAR) > 0.0
    assert geometry.inside(left, RIGHT, (46.0, 0.0, 0.0), (54.0, 0.0, 0.0), CAR) == pytest.approx(
        -0.25, abs=1e-12
    )


@both
def test_a_post_between_two_samples_is_found(geometry: Geometry) -> None:
    # 0.2 m wide, in the gap that a car of 2 m length leaves between samples 2.5 m apart.
    left = [(0.0, 5.0), (49.9, 5.0), (49.9, 0.9), (50.1, 0.9), (50.1, 5.0), (100.0, 5.0)]
    car = (2.0, 2.0)
    assert geometry.inside(left, RIGHT, *stand(48.75, 0.0), car) > 0.0
    assert geometry.inside(left, RIGHT, *stand(51.25, 0.0), car) > 0.0
    swept = geometry.inside(left, RIGHT, (48.75, 0.0, 0.0), (51.25, 0.0, 0.0), car)
    assert swept == pytest.approx(-0.1, abs=1e-12)


@both
def test_a_wall_right_through_the_car_without_a_point_in_it(geometry: Geometry) -> None:
    # A sliver of a wedge, its tip beyond the car: all corners are inside, no border vertex is in the car.
    left = [(0.0, 5.0), (49.999, 5.0), (50.0, -3.0), (50.001, 5.0), (100.0, 5.0)]
    margin = geometry.inside(left, RIGHT, *stand(50.0, 0.0), CAR)
    assert margin == pytest.approx(-1.0, abs=1e-3)  # the middle of the stretch inside is 1 m deep
    # So thin that its depth vanishes, it still counts.
    assert geometry.inside(left, RIGHT, *stand(52.0, 0.0), CAR) < 0.0


@both
def test_round_a_hole_is_not_inside(geometry: Geometry) -> None:
    outer = [(-50.0, -50.0), (50.0, -50.0), (50.0, 50.0), (-50.0, 50.0)]
    post = [(-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1)]
    for left, right in ((outer, post), (post, outer), (outer[::-1], post), (post[::-1], outer)):
        assert geometry.inside(left, right, *stand(0.0, 0.0), CAR, True) == pytest.approx(-0.9, abs=1e-12)
        assert geometry.inside(left, right, (-3.0, 0.0, 0.0), (3.0, 0.0, 0.0), CAR, True) == pytest.approx(
            -0.9
        )
        assert geometry.inside(left, right, *stand(0.0, 1.1), CAR, True) == pytest.approx(0.0, abs=1e-12)
        assert geometry.inside(left, right, *stand(5.0, 0.0), CAR, True) == pytest.approx(2.9)
        assert geometry.inside(left, right, *stand(55.0, 0.0), CAR, True) == pytest.approx(-7.0)
    assert geometry.inside(outer, [(x * 100, y * 100) for x, y in post], *stand(0.0, 0.0), CAR, True) == -8.0


@both
def test_a_closed_track_has_no_ends(geometry: Geometry) -> None:
    (left, right), poses = loop(oval, 200, 4.0, 6.0)
    for here, there in zip(poses[::20], [*poses[1::20]]):
        assert geometry.inside(left, right, here, there, CAR, True) == pytest.approx(3.0, abs=0.2)
    assert geometry.inside(left, right, poses[-1], poses[0], CAR, True) == pytest.approx(3.0, abs=0.2)
    assert geometry.inside([*left, left[0]], [*right, right[0]], poses[-1], poses[0], CAR, True) > 2.8
    assert geometry.inside(left, right, *stand(0.0, 0.0), CAR, True) < -50.0


@both
def test_a_figure_of_eight_is_a_track(geometry: Geometry) -> None:
    (left, right), poses = loop(eight, 120, 5.0, 6.0)
    assert geometry.fault(left, right, True) is None
    assert geometry.inside(left, right, poses[0], poses[1], CAR, True) > 3.0
    for here, there in zip(poses, [*poses[1:], poses[0]]):
        assert geometry.inside(left, right, here, there, CAR, True) > 3.0, here
    # In the middle of the crossing there is more room than either branch alone has; beside it there is grass.
    assert geometry.inside(left, right, *stand(-1.0, 0.0, math.pi / 2), CAR, True) > 0.0
    assert geometry.inside(left, right, *stand(60.0, 0.0), CAR, True) < -20.0
    assert geometry.inside(left, right, *stand(0.0, 25.0), CAR, True) < -10.0
    assert geometry.inside(right, left, poses[3], poses[4], CAR, True) > 3.0


@both
@pytest.mark.parametrize(
    ("left", "right", "closed", "fault"),
    [
        ([(0.0, 5.0)], RIGHT, False, "left border has fewer than 2 distinct points"),
        (LEFT, [(0.0, -5.0), (0.0, -5.0)], False, "right border has fewer than 2 distinct points"),
        (LEFT, [], False, "right border has fewer than 2 distinct points"),
        (LEFT[:2], RIGHT, True, "left border has fewer than 3 distinct points"),
        (
            [(0.0, 5.0), (NAN, 5.0)],
            RIGHT,
            False,
            "left border: point 1 is (nan, 5), not finite or beyond 1e+09 m",
        ),
        (
            LEFT,
            [(0.0, -5.0), (1.0, -math.inf)],
            False,
            "right border: point 1 is (1, -inf), not finite or beyond 1e+09 m",
        ),
        (
            [(0.0, 5.0), (2e9, 5.0)],
            RIGHT,
            False,
            "left border: point 1 is (2e+09, 5), not finite or beyond 1e+09 m",
        ),
        (
            [(0.0, 5.0), (20.0, 5.0), (20.0, 9.0), (10.0, 9.0), (10.0, 4.0), (90.0, 4.0)],
            RIGHT,
            False,
            "left border crosses itself near (10.000, 5.000)",
        ),
        (
            [(0.0, 5.0), (50.0, -9.0), (100.0, 5.0)],
            RIGHT,
            False,
            "left border meets right border near (35.714, -5.000)",
        ),
        (
            [(0.0, 5.0), (50.0, -5.0), (100.0, 5.0)],
            RIGHT,
            False,
            "left border meets right border near (50.000, -5.000)",
        ),
        (
            LEFT,
            RIGHT[::-1],
            False,
            "end of the corridor crosses itself near (50.000, 0.000), as the borders run in opposite directions",
        ),
        (  # in a bend
            [(0.0, 5.0), (50.0, 5.0), (90.0, 50.0), (90.0, 90.0)],
            [(100.0, 90.0), (100.0, 45.0), (55.0, -5.0), (0.0, -5.0)],
            False,
            "left border meets end of the corridor near (9.474, 5.000), as the borders run in opposite directions",
        ),
        (
            [(0.0, 5.0), (50.0, 5.0), (20.0, 5.0)],
            RIGHT,
            False,
            "left border folds back on itself near (50.000, 5.000)",
        ),
        (LEFT, LEFT, False, "left border meets right border near (50.000, 5.000)"),
        (  # a lap whose first points are repeated
            [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0), (0.0, 0.0)],
            [(-9.0, -3.0), (18.0, -3.0), (18.0, 18.0), (-9.0, -3.0)],
            False,
            "left border ends where it begins, at (0.000, 0.000), and the corridor is not closed",
        ),
        (
            LEFT,
            [(0.0, -5.0), (9.0, -9.0), (0.0, -5.0)],
            False,
            "right border ends where it begins, at (0.000, -5.000), and the corridor is not closed",
        ),
        (
            [(0.0, 0.0), (9.0, 0.0), (9.0, 9.0)],
            [(20.0, 0.0), (29.0, 0.0), (29.0, 9.0)],
            True,
            "neither border encloses the other: the left one begins at (0.000, 0.000), the right one at (20.000, 0.000)",
        ),
    ],
)
def test_what_makes_a_corridor_unusable(geometry: Geometry, left, right, closed: bool, fault: str) -> None:  # type: ignore[no-untyped-def]
    assert geometry.fault(left, right, closed) == fault
    assert math.isnan(geometry.inside(left, right, *stand(50.0, 0.0), CAR, closed))


@both
def test_borders_that_cross_without_being_an_eight_are_a_fault(geometry: Geometry) -> None:
    (left, right), _ = loop(oval, 60, 4.0, 6.0)
    glitch = [*left[:20], left[22], left[21], left[20], *left[23:]]
    fault = geometry.fault(glitch, right, True)
    assert fault is not None
    assert fault.startswith("left border ")
    crossing = [*left[:20], *right[20:30], *left[30:]]
    mirrored = [*right[:20], *left[20:30], *right[30:]]
    assert "meets" in str(geometry.fault(crossing, mirrored, True))


@both
def test_repeated_points_are_dropped(geometry: Geometry) -> None:
    left = [LEFT[0], LEFT[0], LEFT[1], LEFT[1], LEFT[1], LEFT[2]]
    assert geometry.fault(left, RIGHT) is None
    assert geometry.inside(left, RIGHT, *stand(50.0, 1.5), CAR) == geometry.inside(
        LEFT, RIGHT, *stand(50.0, 1.5), CAR
    )
    nearly = [LEFT[0], (5e-324, 5.0), LEFT[1], (50.0 - 1e-12, 5.0), LEFT[2]]
    assert geometry.fault(nearly, RIGHT) is None
    assert geometry.inside(nearly, RIGHT, *stand(50.0, 1.5), CAR) == geometry.inside(
        LEFT, RIGHT, *stand(50.0, 1.5), CAR
    )
    # A corridor may narrow down to a point.
    assert geometry.fault([(0.0, 5.0), (50.0, 0.0)], [(0.0, -5.0), (50.0, 0.0)]) is None


@both
@pytest.mark.parametrize("bad", [NAN, math.inf, -math.inf, 1e200])
def test_unusable_poses_and_sizes_have_no_margin(geometry: Geometry, bad: float) -> None:
    fine = [50.0, 0.0, 0.0, 52.0, 0.0, 0.0]
    for index in range(6):
        numbers = [*fine[:index], bad, *fine[index + 1 :]]
        assert math.isnan(geometry.inside(LEFT, RIGHT, tuple(numbers[:3]), tuple(numbers[3:]), CAR))  # type: ignore[arg-type]
    for body in ((bad, 2.0), (4.0, bad), (0.0, 2.0), (4.0, 0.0), (-4.0, 2.0), (4.0, -1.0)):
        assert math.isnan(geometry.inside(LEFT, RIGHT, *stand(50.0, 0.0), body))
    assert math.isnan(geometry.zone((bad, 0.0), [*LEFT, *RIGHT[::-1]]))
    assert math.isnan(geometry.zone((0.0, bad), [*LEFT, *RIGHT[::-1]]))


@both
def test_far_from_the_origin_nothing_is_lost(geometry: Geometry) -> None:
    x, y = 5.6e6, 4.3e6  # as map coordinates are
    left, right = [(a + x, b + y) for a, b in LEFT], [(a + x, b + y) for a, b in RIGHT]
    assert geometry.inside(left, right, (x + 20, y, 0.0), (x + 22, y + 1.5, 0.0), CAR) == pytest.approx(
        2.5, abs=1e-8
    )
    assert geometry.inside(left, right, *stand(x + 50, y + 4.25), CAR) == pytest.approx(-0.25, abs=1e-8)


def test_a_scribble_is_refused() -> None:
    points = np.random.default_rng(0).uniform(-100.0, 100.0, (3000, 2))
    fault = Polygon(points).fault
    assert fault is not None
    assert fault.startswith("polygon crosses itself near (")


@both
def test_lengths_that_are_no_vehicle(geometry: Geometry) -> None:
    assert math.isnan(geometry.inside(LEFT, RIGHT, *stand(50.0, 0.0), (1e-7, 2.0)))
    assert geometry.inside(LEFT, RIGHT, *stand(50.0, 0.0), (1e-6, 1e-6)) == pytest.approx(5.0)


def test_prepared_borders_cannot_be_changed() -> None:
    left = np.array(LEFT)
    corridor = Corridor(left, RIGHT)
    before = corridor.margin_inside(*stand(50.0, 0.0)[0], *stand(50.0, 0.0)[1], *CAR)
    left[:, 1] = 2.0  # the caller's array is not the corridor's
    assert corridor.margin_inside(*stand(50.0, 0.0)[0], *stand(50.0, 0.0)[1], *CAR) == before
    with pytest.raises(ValueError, match="read-only"):
        corridor.left[0, 0] = 1.0


@both
def test_zones(geometry: Geometry) -> None:
    zone = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (5.0, 5.0), (0.0, 10.0)]
    for points in (zone, zone[::-1], [*zone, zone[0]]):
        assert geometry.zone((5.0, 2.0), points) == 2.0
        assert geometry.zone((5.0, -2.0), points) == -2.0
        assert geometry.zone((5.0, 7.0), points) == pytest.approx(-math.sqrt(2.0))
        assert geometry.zone((5.0, 5.0), points) == 0.0  # on a corner
        assert geometry.zone((10.0, 3.0), points) == 0.0  # on a side
        assert geometry.zone((13.0, 14.0), points) == -5.0
        assert geometry.zone((-3.0, -4.0), points) == -5.0
        assert geometry.zone((9.0, 8.5), points) > 0.0
    assert geometry.zone_fault(zone) is None
    assert (
        geometry.zone_fault([(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)])
        == "polygon crosses itself near (1.000, 1.000)"
    )
    assert geometry.zone_fault(zone[:2]) == "polygon has fewer than 3 distinct points"
    assert math.isnan(geometry.zone((1.0, 1.0), zone[:2]))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf, 1e30])
@pytest.mark.parametrize("corners", [4, 40])
def test_points_of_a_zone_among_many_are_as_if_alone(bad: float, corners: int) -> None:
    """Whatever the number of corners, which decides how the nearest side is found, and of points, which are taken in parts."""
    angles = np.linspace(0.0, 2.0 * np.pi, corners, endpoint=False)
    zone = Polygon(np.stack([9.0 * np.cos(angles), 7.0 * np.sin(angles)], axis=1))
    x, y = np.random.default_rng(1).uniform(-12.0, 12.0, (2, POINTS_AT_ONCE + 50))
    x[3] = x[-1] = y[7] = y[POINTS_AT_ONCE + 1] = bad
    together = zone.signed_distance(x, y)
    assert np.flatnonzero(np.isnan(together)).tolist() == [3, 7, POINTS_AT_ONCE + 1, x.size - 1]
    some = [0, 3, 7, 8, POINTS_AT_ONCE - 1, POINTS_AT_ONCE, POINTS_AT_ONCE + 1, x.size - 1]
    alone = [zone.signed_distance(x[k], y[k])[0] for k in some]
    np.testing.assert_array_equal(together[some], alone)
