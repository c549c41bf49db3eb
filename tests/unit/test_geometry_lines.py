"""Curvilinear coordinates, gaps, distances and centre lines, worked out by hand, for both implementations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.bodies import BOTH, Geometry
from support.tracks import eight, loop, oval
from trackmarshal.backends.reference import geometry as reference
from trackmarshal.runtime.geometry import Corridor, Polyline, distance_to_paths
from trackmarshal.runtime.geometry.arrays import true_in
from trackmarshal.runtime.geometry.border import Border

BEND = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0)]
SQUARE = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
EAST, NORTH, WEST, SOUTH = 0.0, math.pi / 2, math.pi, -math.pi / 2

both = pytest.mark.parametrize("geometry", BOTH.values(), ids=BOTH.keys())


@both
@pytest.mark.parametrize(
    ("point", "place"),
    [
        ((4.0, 1.0), (4.0, 1.0, EAST)),
        ((4.0, -2.0), (4.0, -2.0, EAST)),
        ((4.0, 0.0), (4.0, 0.0, EAST)),
        ((9.0, 4.0), (14.0, 1.0, NORTH)),
        ((8.0, 2.0), (8.0, 2.0, EAST)),  # as near to either: the first
        ((13.0, -4.0), (10.0, -5.0, EAST)),  # nearest to the corner
        ((-3.0, 2.0), (-3.0, 2.0, EAST)),  # before the start, along the first segment
        ((9.0, 14.0), (24.0, 1.0, NORTH)),  # beyond the end, along the last
        ((10.0, 17.0), (27.0, 0.0, NORTH)),
        ((-50.0, 0.0), (-50.0, 0.0, EAST)),
    ],
)
def test_stations_on_an_open_line(geometry: Geometry, point, place) -> None:  # type: ignore[no-untyped-def]
    assert geometry.project(point, BEND) == pytest.approx(place)


@both
@pytest.mark.parametrize(
    ("point", "place"),
    [
        ((4.0, 1.0), (4.0, 1.0, EAST)),
        ((1.0, 4.0), (36.0, 1.0, SOUTH)),
        ((-1.0, 4.0), (36.0, -1.0, SOUTH)),
        ((-3.0, -4.0), (0.0, -5.0, EAST)),  # the start is at station 0, never at the length
        ((6.0, 9.0), (24.0, 1.0, WEST)),
        ((0.0, 0.0), (0.0, 0.0, EAST)),
    ],
)
def test_stations_on_a_closed_line(geometry: Geometry, point, place) -> None:  # type: ignore[no-untyped-def]
    assert geometry.project(point, SQUARE, True) == pytest.approx(place)
    assert geometry.project(point, [*SQUARE, SQUARE[0]], True) == pytest.approx(place)
    assert geometry.project(point, [SQUARE[0], *SQUARE], True) == pytest.approx(place)


@both
def test_nothing_jumps_across_the_ends(geometry: Geometry) -> None:
    stations = [geometry.project((x, 1.0), BEND)[0] for x in np.linspace(-5.0, 5.0, 41).tolist()]
    assert np.diff(stations) == pytest.approx(0.25)


@both
@pytest.mark.parametrize(
    ("start", "end", "closed", "gap"),
    [
        (5.0, 12.0, False, 7.0),
        (12.0, 5.0, False, -7.0),
        (5.0, 12.0, True, 7.0),
        (38.0, 3.0, True, 5.0),  # over the start
        (3.0, 38.0, True, -5.0),
        (0.0, 20.0, True, 20.0),  # half way round is ahead, from either side
        (20.0, 0.0, True, 20.0),
        (7.0, 7.0, True, 0.0),
        (-90.0, 95.0, True, -15.0),
        (math.nan, 1.0, True, math.nan),
        (1.0, math.inf, True, math.nan),
        (-math.inf, 1.0, False, math.nan),
    ],
)
def test_gaps(geometry: Geometry, start: float, end: float, closed: bool, gap: float) -> None:
    line = SQUARE if closed else BEND
    assert geometry.gap(line, start, end, closed) == pytest.approx(gap, nan_ok=True)


@both
def test_distances(geometry: Geometry) -> None:
    assert geometry.distance((4.0, -3.0), BEND) == 3.0
    assert geometry.distance((13.0, -4.0), BEND) == 5.0
    assert geometry.distance((-3.0, 4.0), BEND) == 5.0  # the line itself ends
    assert geometry.distance((1.0, 5.0), SQUARE) == 5.0
    assert geometry.distance((1.0, 5.0), SQUARE, True) == 1.0


@both
@pytest.mark.parametrize(
    "line",
    [
        [],
        [(1.0, 1.0)],
        [(1.0, 1.0), (1.0, 1.0)],
        [(0.0, 0.0), (math.nan, 1.0)],
        [(0.0, 0.0), (math.inf, 1.0)],
    ],
)
def test_unusable_lines(geometry: Geometry, line) -> None:  # type: ignore[no-untyped-def]
    assert all(math.isnan(number) for number in geometry.project((1.0, 2.0), line))
    assert math.isnan(geometry.distance((1.0, 2.0), line))
    assert math.isnan(geometry.gap(line, 1.0, 2.0))


@both
@pytest.mark.parametrize(
    "point", [(math.nan, 0.0), (0.0, math.nan), (0.0, math.inf), (-math.inf, 0.0), (1e30, 0.0)]
)
def test_unusable_points(geometry: Geometry, point) -> None:  # type: ignore[no-untyped-def]
    assert all(math.isnan(number) for number in geometry.project(point, BEND))
    assert math.isnan(geometry.distance(point, BEND))


def test_a_line_says_what_is_wrong_with_it() -> None:
    assert Polyline([(1.0, 1.0), (1.0, 1.0)]).fault == "line has fewer than 2 distinct points"
    assert Polyline(BEND[:2], True).fault == "line has fewer than 3 distinct points"
    assert (
        Polyline([(0.0, 0.0), (math.nan, 1.0)]).fault
        == "line: point 1 is (nan, 1), not finite or beyond 1e+09 m"
    )
    assert Polyline(BEND).fault is None
    assert Polyline(BEND).length == 20.0
    assert Polyline(SQUARE, True).length == 40.0


def test_unusable_points_do_not_touch_their_neighbours() -> None:
    station, offset, direction = Polyline(BEND).project([4.0, math.nan, 9.0], [1.0, 0.0, 4.0])
    assert station == pytest.approx([4.0, math.nan, 14.0], nan_ok=True)
    assert offset == pytest.approx([1.0, math.nan, 1.0], nan_ok=True)
    assert direction == pytest.approx([EAST, math.nan, NORTH], nan_ok=True)
    assert Polyline(BEND).project([], [])[0].shape == (0,)
    for x, y in (
        ([4.0, 4.0], [1.0, math.nan]),
        ([math.nan, 4.0], [9.0, 9.0]),
        ([-9.0, 9.0], [math.nan, 1.0]),
    ):
        alone = [float(Polyline(BEND).distance(*point)[0]) for point in zip(x, y)]
        assert Polyline(BEND).distance(x, y) == pytest.approx(alone, nan_ok=True)
        assert sum(map(math.isnan, alone)) == 1


@pytest.mark.parametrize("closed", [False, True])
def test_gaps_between_stations_that_are_none(closed: bool) -> None:
    start, end = [0.0, math.nan, 1.0, math.inf, 2.0, math.inf], [3.0, 1.0, math.nan, 1.0, -math.inf, math.inf]
    gap = Polyline(SQUARE, closed).gap(start, end)
    assert gap == pytest.approx([3.0] + [math.nan] * 5, nan_ok=True)


@pytest.mark.parametrize("line", [SQUARE, [(1.0, 1.0)]])
def test_gaps_of_arrays_that_broadcast(line: list[tuple[float, float]]) -> None:
    start, end = np.array([[1.0], [35.0], [math.nan]]), np.array([2.0, 39.0])
    made = Polyline(line, True)
    alone = [[float(made.gap(one, other)[0]) for other in end] for one in start[:, 0]]
    assert made.gap(start, end) == pytest.approx(np.array(alone), nan_ok=True)


@pytest.mark.parametrize("shape", [(0, 3), (1, 1), (4, 7), (90, 5)])
def test_what_is_true_in_a_table_row_by_row(shape: tuple[int, int]) -> None:
    flags = np.arange(shape[0] * shape[1]).reshape(shape) % 3 == 1
    for table in (flags, np.asfortranarray(flags), ~flags, flags & False):
        rows, columns = true_in(table)
        assert list(zip(rows, columns)) == [
            (i, j) for i in range(shape[0]) for j in range(shape[1]) if table[i, j]
        ]


@both
def test_centre_lines(geometry: Geometry) -> None:
    left, right = [(0.0, 4.0), (10.0, 4.0), (20.0, 4.0)], [(0.0, -2.0), (10.0, -2.0), (20.0, -2.0)]
    assert geometry.centre(left, right) == [(0.0, 1.0), (10.0, 1.0), (20.0, 1.0)]
    assert geometry.centre(left, [(-5.0, -2.0), (17.0, -2.0)]) == [(0.0, 1.0), (10.0, 1.0), (18.5, 1.0)]
    (left, right), poses = loop(oval, 400, 4.0, 6.0)
    for (x, y, h), (cx, cy) in zip(poses, geometry.centre(left, right[::-1][:-1], True)):
        assert math.hypot(cx - (x + math.sin(h)), cy - (y - math.cos(h))) < 0.3


@both
@pytest.mark.parametrize("shift", [1, 57, 200, 399])
@pytest.mark.parametrize("turned", [False, True])
def test_borders_that_begin_anywhere_have_the_centre_that_they_have(
    geometry: Geometry, shift: int, turned: bool
) -> None:
    """Two tools, or two files: equally many points are no pairs yet."""
    (left, right), poses = loop(oval, 400, 5.0, 5.0)
    other = [*right[shift:], *right[:shift]][:: -1 if turned else 1]
    found = geometry.centre(left, other, True)
    assert max(math.hypot(x - px, y - py) for (x, y), (px, py, _) in zip(found, poses)) < 1.5


@both
def test_across_a_figure_of_eight_pairs_lead(geometry: Geometry) -> None:
    (left, right), poses = loop(eight, 400, 5.0, 5.0)
    found = geometry.centre(left, right, True)
    assert max(math.hypot(x - px, y - py) for (x, y), (px, py, _) in zip(found, poses)) < 1e-6


def test_the_centre_of_an_unusable_corridor_is_an_unusable_line() -> None:
    centre = Corridor([(0.0, 1.0), (math.nan, 1.0)], [(0.0, -1.0), (1.0, -1.0), (2.0, -1.0)]).centre
    assert centre.fault is not None


@pytest.mark.parametrize("closed", [False, True])
def test_a_corridor_that_lacks_a_border_has_no_centre(closed: bool) -> None:
    there: list[tuple[float, float]] = [(0.0, -1.0), (1.0, -1.0), (2.0, 3.0)]
    for left, right in (([], there), (there, []), ([], [])):
        assert Corridor(left, right, closed).centre.fault is not None


def test_distances_from_the_paths_of_many_cases() -> None:
    path_x = np.array(
        [[0.0, 10.0, 10.0, np.nan], [5.0, 5.0, 7.0, 7.0], [0.0, np.nan, 1.0, 2.0], [3.0, 4.0, 5.0, 6.0]]
    )
    path_y = np.array(
        [[0.0, 0.0, 10.0, np.nan], [5.0, 5.0, 5.0, 5.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]]
    )
    x = np.array([[4.0, 13.0], [6.0, 9.0], [0.0, 0.0], [3.0, 3.0]])
    y = np.array([[-3.0, -4.0], [7.0, 5.0], [0.0, 0.0], [0.0, np.nan]])
    distances = distance_to_paths(x, y, path_x, path_y, np.array([3, 4, 4, 1]))
    assert distances == pytest.approx(
        np.array([[3.0, 5.0], [2.0, 2.0], [np.nan] * 2, [np.nan] * 2]), nan_ok=True
    )


STANDING = {
    "in one place": ([3.0, 3.0, 3.0], [4.0, 4.0, 4.0], 5.0),
    "in one place, up to rounding": ([3.0, 3.0 + 5e-10, 3.0], [4.0, 4.0, 4.0 - 5e-10], 5.0),
    "on the way, and then in one place": ([3.0, 9.0, 9.0, 9.0], [4.0, 4.0, 4.0, 4.0], 5.0),
    "a single sample": ([3.0], [4.0], math.nan),
    "a place that is lost": ([3.0, math.nan, 3.0], [4.0, 4.0, 4.0], math.nan),
    "lost at once": ([math.nan, 3.0], [4.0, 4.0], math.nan),
    "nowhere": ([], [], math.nan),
    "too far away to be a place": ([2e9, 2e9], [4.0, 4.0], math.nan),
}


@pytest.mark.parametrize(("x", "y", "wanted"), STANDING.values(), ids=STANDING)
def test_the_path_of_a_car_that_stands_is_its_place(x: list[float], y: list[float], wanted: float) -> None:
    found = reference.distance_to_path(0.0, 0.0, list(zip(x, y)))
    assert found == pytest.approx(wanted, abs=1e-8, nan_ok=True)
    # Padding, and other cases that move, change nothing.
    paths = [(x, y), ([0.0, 0.0, 1.0, 1.0, 2.0], [1.0] * 5)]
    path_x, path_y = np.full((2, 5), 7.0), np.full((2, 5), 7.0)
    for row, (xs, ys) in enumerate(paths):
        path_x[row, : len(xs)], path_y[row, : len(ys)] = xs, ys
    zero = np.zeros((2, 1))
    many = distance_to_paths(zero, zero, path_x, path_y, np.array([len(x), 5]))
    assert many[:, 0] == pytest.approx(np.array([wanted, 1.0]), abs=1e-8, nan_ok=True)
    alone = distance_to_paths(zero[:1], zero[:1], path_x[:1, : len(x)], path_y[:1, : len(x)], [len(x)])
    assert alone[0, 0] == pytest.approx(wanted, abs=1e-8, nan_ok=True)


@pytest.mark.parametrize("count", [1, 3, 100])
@pytest.mark.parametrize("place", [0, -1])
def test_a_point_that_is_none_is_not_left_out(count: int, place: int) -> None:
    """Whoever asks replaces such points; if one is not, nobody gets fewer answers than points, or another point's."""
    angles = np.arange(200) * (2.0 * math.pi / 200)
    border = Border([np.stack([50.0 * np.cos(angles), 50.0 * np.sin(angles)], axis=1)], closed=True)
    x, y = np.random.default_rng(count).normal(0.0, 30.0, (2, count))
    assert border.nearest(x, y)[1] == pytest.approx(
        np.hypot(x[:, None] - border.ax, y[:, None] - border.ay).min(axis=1), abs=0.8
    )
    x[place] = math.nan
    with pytest.raises(AssertionError, match="nearest"):
        border.nearest(x, y)
