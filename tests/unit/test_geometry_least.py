"""The least margin of many trajectories: the same as of all margins, and for most of them without working those out."""

from __future__ import annotations

import math
from unittest import mock

import numpy as np
import pytest
from numpy.typing import NDArray

from trackmarshal.runtime.geometry import Corridor, least
from trackmarshal.runtime.geometry.curve import MOST, Curves
from trackmarshal.runtime.geometry.region import Region

Floats = NDArray[np.float64]

BODY = (4.7, 2.0)
COUNT = 25


def ring(radius: float, points: int = 400) -> Floats:
    angles = np.arange(points) * (2.0 * math.pi / points)
    return np.stack([radius * np.cos(angles), radius * np.sin(angles)], axis=1)


@pytest.fixture(scope="module")
def course() -> Corridor:
    """A round course, 12 m wide, with a bump on its inner side."""
    left = ring(94.0)
    left[50:53] *= 1.02
    return Corridor(left, ring(106.0), closed=True)


def trip(angle: float, radius: float, drift: float, step: float = 2.0) -> Floats:
    """Poses (3, COUNT) round the course, that get farther from its middle by and by."""
    k = np.arange(COUNT)
    at, away = angle + k * step / radius, radius + drift * k
    return np.stack([away * np.cos(at), away * np.sin(at), at + math.pi / 2])


def judged(
    course: Corridor, trips: list[Floats], kappa: float | None = None
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """All margins, those of the search, and which of these are exact; along curves with a curvature."""
    poses = np.stack(trips)
    before = np.concatenate([poses[:, :, :1], poses[:, :, :-1]], axis=2)
    columns = [*before.swapaxes(0, 1).reshape(3, -1), *poses.swapaxes(0, 1).reshape(3, -1)]
    body = BODY if kappa is None else (*BODY, kappa, kappa)
    truth = course.margin_inside(*columns, *body).reshape(-1, COUNT)
    found, exact = course.least_inside((*columns, *body), COUNT, np.ones(truth.size, dtype=np.bool_))
    return truth, found.reshape(-1, COUNT), exact.reshape(-1, COUNT)


def agreed(truth: Floats, found: Floats, exact: NDArray[np.bool_]) -> None:
    least = np.fmin.reduce(truth, axis=1)
    assert np.array_equal(np.fmin.reduce(found, axis=1), least, equal_nan=True)
    assert np.array_equal(found[exact], truth[exact], equal_nan=True)
    assert (found > least[:, None])[~exact].all()


def test_trajectories_inside(course: Corridor) -> None:
    generator = np.random.default_rng(1)
    found = judged(
        course,
        [trip(a, r, d) for a, r, d in zip(generator.uniform(0, 6, 300), generator.uniform(98, 102, 300), generator.uniform(-0.1, 0.1, 300))],
    )  # fmt: skip
    agreed(*found)
    assert (found[0] > 0.0).all()
    assert found[2].mean() < 0.15


def test_along_curves(course: Corridor) -> None:
    generator = np.random.default_rng(2)
    drawn = [generator.uniform(low, high, 300) for low, high in ((0, 6), (98, 102), (-0.1, 0.1))]
    for step in (1.0, 2.5, 6.0):  # in one piece each; in several
        found = judged(course, [trip(a, r, d, step) for a, r, d in zip(*drawn)], 0.01)
        agreed(*found)
        assert found[2].mean() < 0.2
        assert np.isinf(found[1]).mean() > 0.4  # not even bounds are worked out


@pytest.mark.parametrize(("step", "pieces"), [(0.5, 1), (1.0, 2), (2.0, 4), (6.0, 11)])
def test_along_a_curve_as_near_to_both_borders_all_the_time(
    course: Corridor, step: float, pieces: int
) -> None:
    """Ways are as near as one another, up to what a bound of the whole leaves open: bounded by piece, most are not worked out."""
    trips = [trip(0.02 * k, 100.0, 0.0, step) for k in range(200)]
    first = np.concatenate([trips[0][:, 1], trips[0][:, 2]])[:, None]
    assert Curves(first, np.full((2, 1), 0.01), *BODY).count[0] == pieces
    found = judged(course, trips, 0.01)
    agreed(*found)
    assert found[2].mean() < 0.2


def test_in_tight_bends_few_ways_are_worked_out() -> None:
    """Of up to as many pieces as there are, now and then beside what the curvatures say; as often in a bend as not."""
    generator = np.random.default_rng(3)
    course = Corridor(ring(10.0), ring(22.0), closed=True)
    drawn = [generator.uniform(low, high, 100) for low, high in ((0, 6), (14, 18), (-0.05, 0.05), (0.1, 3.0))]
    trips = [trip(*values) for values in zip(*drawn)]
    sizes = []
    looked_at = Region.margin_along

    def noted(region: Region, curves: Curves) -> Floats:
        sizes.append(curves.size)
        return looked_at(region, curves)

    for kappa in (1 / 16, 0.05):
        truth = judged(course, trips, kappa)[0]
        sizes.clear()
        with mock.patch.object(Region, "margin_along", noted):
            found = judged(course, trips, kappa)
        agreed(*found)
        assert np.array_equal(found[0], truth)
        assert sizes[0] == truth.size  # the truth itself
        assert sum(sizes[1:]) == found[2].sum() < 0.2 * truth.size


@pytest.mark.parametrize("kappa", [0.01, 0.012, -0.03])
@pytest.mark.parametrize("step", [0.5, 1.0, 3.0, 9.0])
def test_no_bound_is_above_the_margin_and_those_by_piece_are_close(step: float, kappa: float) -> None:
    """Also where curvatures contradict the way, which is then wide."""
    course = Corridor(ring(94.0), ring(106.0), closed=True)
    generator = np.random.default_rng(4)
    drawn = [generator.uniform(*ends, 40) for ends in ((0, 6), (97, 103))]
    poses = np.concatenate([trip(angle, radius, 0.0, step) for angle, radius in zip(*drawn)], axis=1)
    ways = np.concatenate([poses[:, :-1], poses[:, 1:]])
    ways = ways[:, np.arange(1, ways.shape[1] + 1) % COUNT != 0]  # none from one trip to the next
    count = ways.shape[1]
    region, bends = course._region, np.full((2, count), kappa)
    assert region is not None
    truth = region.margin_along(Curves(ways, bends, *BODY))
    inside = truth > 0.0
    assert inside.mean() > 0.5
    margin, exact = np.empty(count), np.zeros(count, dtype=np.bool_)
    search = least._Search(region, ways, *BODY, bends, 1, np.ones(count, dtype=np.bool_), margin, exact)
    assert not exact.any()
    assert (margin <= truth)[inside].all()
    rough = margin.copy()
    search._bound(np.arange(count), MOST)
    assert (margin <= truth)[inside].all()
    assert (margin >= rough)[inside].all()
    assert (truth - margin)[inside].max() < 0.003
    several = Curves(ways, bends, *BODY).count > least.FEW
    if several.any():
        assert (truth - rough)[inside & several].min() > 0.003


def test_along_curves_that_leave_the_course(course: Corridor) -> None:
    trips = [trip(0.1 * k, 100.0, (0.02 - 0.04 * (k % 2)) * k, 1.0 + 0.1 * k) for k in range(60)]
    found = judged(course, trips, 0.01)
    agreed(*found)
    assert (found[0] < 0.0).any(axis=1).sum() > 20


def test_as_near_to_both_borders_all_the_time(course: Corridor) -> None:
    found = judged(course, [trip(0.02 * k, 100.0, 0.0) for k in range(200)])
    agreed(*found)
    assert found[2].mean() < 0.5


def test_trajectories_that_leave_the_course_or_are_beside_it(course: Corridor) -> None:
    trips = [trip(0.1 * k, 100.0, 0.02 * k) for k in range(40)]  # across the outer border, sooner and sooner
    trips += [trip(0.1 * k, 100.0, -0.02 * k) for k in range(40)]
    trips += [trip(0.1 * k, 80.0, 0.0) for k in range(10)]  # never in
    trips += [
        trip(0.1 * k, 80.0 + 40.0 * (k % 2), 0.9 - 1.8 * (k % 2)) for k in range(40)
    ]  # in from beside it
    trips += [trip(0.1 * k, 10.0, 0.0) for k in range(3)]  # far from every border
    trips += [trip(0.1 * k, 3000.0, 0.0) for k in range(3)]
    found = judged(course, trips)
    agreed(*found)
    assert (found[0] < 0.0).any(axis=1).sum() > 80


def test_a_jump_off_the_course_and_back_meets_no_border(course: Corridor) -> None:
    """Hulls that do not begin where the one before ends: one lies beside the course, as far from the border as the others."""
    poses = trip(0.3, 100.0, 0.0)
    before = np.concatenate([poses[:, :1], poses[:, :-1]], axis=1)
    both = np.stack([before, poses])
    both[:, :2, 12] *= 0.88
    columns = [*both[0], *both[1]]
    truth = course.margin_inside(*columns, *BODY)
    found, exact = course.least_inside((*columns, *BODY), COUNT, np.ones(COUNT, dtype=np.bool_))
    assert truth.min() == truth[12] < -1.0
    agreed(truth[None], found[None], exact[None])


def test_positions_that_are_none(course: Corridor) -> None:
    trips = [trip(0.1 * k, 100.0, 0.02) for k in range(20)]
    for k, value in enumerate((math.nan, math.inf, 1e12)):
        trips[5 * k][k, 7] = value
    trips[19][:] = math.nan
    truth, found, exact = judged(course, trips)
    agreed(truth, found, exact)
    assert np.array_equal(np.isnan(found), np.isnan(truth))


def test_what_is_padding_does_not_count(course: Corridor) -> None:
    poses = np.stack([trip(0.3, 100.0, 0.5), trip(0.9, 100.0, -0.5)], axis=1).reshape(3, -1)
    counted = np.tile(np.arange(COUNT) < 5, 2)
    truth = course.margin_inside(*poses, *poses, *BODY)
    found, exact = course.least_inside((*poses, *poses, *BODY), COUNT, counted)
    for row in (slice(0, 5), slice(COUNT, COUNT + 5)):
        assert found[row].min() == truth[row].min() > truth.min()
        assert (exact[row] | (found[row] > truth[row].min())).all()
    assert np.isinf(found[~counted]).all()


def test_vehicles_of_different_sizes(course: Corridor) -> None:
    poses = np.stack([trip(0.1 * k, 100.0, 0.05) for k in range(30)], axis=1).reshape(3, -1)
    length, width = np.repeat(np.linspace(1.0, 12.0, 30), COUNT), np.linspace(0.5, 3.0, 30 * COUNT)
    truth = course.margin_inside(*poses, *poses, length, width)
    found, exact = course.least_inside(
        (*poses, *poses, length, width), COUNT, np.ones(truth.size, dtype=np.bool_)
    )
    agreed(truth.reshape(-1, COUNT), found.reshape(-1, COUNT), exact.reshape(-1, COUNT))


def test_groups_are_searched_a_few_at_a_time(course: Corridor) -> None:
    trips = [trip(0.1 * k, 100.0, 0.01 * k) for k in range(30)]
    whole = judged(course, trips)
    with mock.patch.multiple(least, KEPT=70, AT_ONCE=33):
        parts = judged(course, trips)
    for one, other in zip(whole, parts):
        assert np.array_equal(one, other)


def test_an_unusable_course_has_no_margin() -> None:
    course = Corridor([[0, 0], [9, 9]], [[0, 9], [9, 0]])
    found, exact = course.least_inside((*np.zeros((6, 4)), *BODY), 2, np.ones(4, dtype=np.bool_))
    assert np.isnan(found).all()
    assert exact.all()
