"""Of one cycle's footprints those that are nearest by bound alone: the same least margins as of all, to the bit."""

from __future__ import annotations

import math
from unittest import mock

import numpy as np
import pytest
from numpy.typing import NDArray

from trackmarshal.runtime.geometry import Corridor, alone, boxes_clear, clearance, least, least_clear
from trackmarshal.runtime.geometry.approach import Approach
from trackmarshal.runtime.geometry.region import Region
from trackmarshal.runtime.geometry.sweep import Sweeps

Floats = NDArray[np.float64]

BODY = (4.7, 2.0)
COUNT = 30


def ring(radius: float, points: int, waves: float = 0.0) -> Floats:
    angles = np.arange(points) * (2.0 * math.pi / points)
    away = radius * (1.0 + waves * np.sin(3.0 * angles))
    return np.stack([away * np.cos(angles), away * np.sin(angles)], axis=1)


def course(points: int, waves: float, width: float) -> Corridor:
    made = Corridor(ring(60.0 - width / 2, points, waves), ring(60.0 + width / 2, points, waves), closed=True)
    assert made.fault is None
    return made


def trips(generator: np.random.Generator, aside: float) -> Floats:
    """Two ways round the course, poses (6, 2 * COUNT) from pose to pose."""
    made = []
    for _ in range(2):
        at = generator.uniform(0.0, 6.0) + np.arange(COUNT + 1) * generator.uniform(0.0, 0.04)
        away = 60.0 + generator.uniform(-aside, aside) + np.arange(COUNT + 1) * generator.uniform(-0.02, 0.02)
        heading = at + math.pi / 2 + generator.choice([0.0, 0.0, 0.02, 1.0, math.pi / 2])
        poses = np.stack([away * np.cos(at), away * np.sin(at), heading])
        made.append(np.concatenate([poses[:, :-1], poses[:, 1:]]))
    return np.concatenate(made, axis=1)


@pytest.mark.parametrize("kappa", [None, 1.0 / 60.0, 0.03])
@pytest.mark.parametrize(("points", "waves"), [(40, 0.0), (400, 0.0), (150, 0.02)])
def test_least_margins_are_those_of_all(points: int, waves: float, kappa: float | None) -> None:
    generator = np.random.default_rng(1)
    area = course(points, waves, 14.0)
    answered = 0
    for _ in range(40):
        poses = trips(generator, 3.0)
        bends = () if kappa is None else (np.full(poses.shape[1], kappa),) * 2
        body = (*poses, *map(np.array, BODY), *bends)
        counted = np.ones((2, COUNT), dtype=np.bool_)
        counted[1, generator.integers(1, COUNT + 1) :] = False
        found = area.nearest_inside(body, COUNT, counted.ravel())
        truth = np.where(counted, area.margin_inside(*body).reshape(2, COUNT), np.inf)
        if found is None:
            continue
        answered += 1
        assert np.array_equal(found.reshape(2, COUNT).min(axis=1), truth.min(axis=1))
        assert (found.reshape(2, COUNT) >= truth.min(axis=1)[:, None]).all()
        assert (truth.min(axis=1) > 0.0).all()
    assert answered > 20


def test_whoever_touches_the_border_or_is_off_the_course_gets_no_answer() -> None:
    generator = np.random.default_rng(2)
    area = course(200, 0.0, 12.0)
    shares = {True: 0, False: 0}
    for _ in range(200):
        poses = trips(generator, generator.choice([5.0, 20.0]))
        body = (*poses, *map(np.array, BODY))
        counted = np.ones(poses.shape[1], dtype=np.bool_)
        truth = area.margin_inside(*body).reshape(2, -1).min(axis=1)
        found = area.nearest_inside(body, COUNT, counted)
        shares[found is not None] += 1
        if (truth <= 0.0).any():
            assert found is None
        elif found is not None:
            assert np.array_equal(found.reshape(2, -1).min(axis=1), truth)
    assert min(shares.values()) > 20


@pytest.mark.parametrize("spoil", [math.nan, math.inf, 2e9])
@pytest.mark.parametrize("row", range(8))
def test_what_is_none_gets_no_answer(row: int, spoil: float) -> None:
    body = [*trips(np.random.default_rng(3), 1.0), *(np.full(2 * COUNT, size) for size in BODY)]
    area, counted = course(100, 0.0, 14.0), np.ones(2 * COUNT, dtype=np.bool_)
    assert area.nearest_inside(body, COUNT, counted) is not None
    body[row] = body[row].copy()
    body[row][7] = spoil
    assert area.nearest_inside(body, COUNT, counted) is None


def test_ways_with_a_leap_in_between_get_no_answer() -> None:
    poses = trips(np.random.default_rng(4), 1.0)
    area, counted = course(100, 0.0, 14.0), np.ones(2 * COUNT, dtype=np.bool_)
    poses[3:, 5] += 1e-9
    assert area.nearest_inside((*poses, *map(np.array, BODY)), COUNT, counted) is None


def test_few_are_looked_at() -> None:
    poses = trips(np.random.default_rng(5), 1.0)
    area, counted = course(300, 0.0, 14.0), np.ones(2 * COUNT, dtype=np.bool_)
    with (
        mock.patch.object(Region, "margin_inside", side_effect=AssertionError),
        mock.patch.object(least, "alone", wraps=alone) as looked,
    ):
        assert area.nearest_inside((*poses, *map(np.array, BODY)), COUNT, counted) is not None
    assert looked.distance.call_count <= 8


def test_one_pair_in_plain_numbers_is_as_in_arrays() -> None:
    generator = np.random.default_rng(6)
    border = course(90, 0.02, 14.0).border
    assert border is not None
    for _ in range(30):
        sweeps = Sweeps(trips(generator, 3.0), *BODY)
        for row in range(0, sweeps.size, 3):
            k = int(generator.integers(border.size))
            arrays = Approach(border, sweeps.some(np.array([row])), np.array([0]), np.array([k]))
            (distance,), (left,) = arrays.nearest()
            found = alone.distance(border, sweeps, row, k)
            assert found[0] == distance
            assert found[1] in (None, bool(left))


@pytest.mark.parametrize("kappa", [None, 0.01, -0.05])
def test_clear_of_boxes_where_asked_and_as_far_as_it_is_the_least(kappa: float | None) -> None:
    generator = np.random.default_rng(7)
    for _ in range(40):
        shape = 2, 4, COUNT
        poses = trips(generator, 3.0).reshape(6, 2, 1, COUNT)
        boxes = generator.uniform(-70.0, 70.0, (3, 2, 4, 1))
        sizes = generator.choice([0.2, 2.0, 5.0, 60.0], (2, 2, 4, 1))
        spoilt = generator.random() < 0.3
        if spoilt:
            boxes[generator.integers(3), 0, 1] = math.nan
            poses[generator.integers(6), 1, 0, 3] = math.inf
            sizes[generator.integers(2), 1, 2] = generator.choice([0.0, math.nan])
        bends = () if kappa is None else (np.full((2, 1, COUNT), kappa),) * 2
        args = (*poses, *map(np.array, BODY), *boxes, *sizes, *bends)
        truth = boxes_clear(*args)
        asked = generator.random(shape) < generator.choice([0.0, 0.1, 0.9])
        assert np.array_equal(least_clear(args, None, False), truth, equal_nan=True)
        assert np.array_equal(least_clear(args, asked, False), np.where(asked, truth, np.inf), equal_nan=True)
        for mask in (None, asked):
            counted = truth if mask is None else np.where(mask, truth, np.inf)
            found = least_clear(args, mask, True)
            assert np.array_equal(np.isnan(found), np.isnan(counted))
            assert np.array_equal(
                np.fmin.reduce(found, axis=(1, 2)), np.fmin.reduce(counted, axis=(1, 2)), equal_nan=True
            )
            assert ((found == counted) | (found == np.inf) | np.isnan(counted)).all()


def test_of_boxes_far_apart_few_pairs_are_worked_out() -> None:
    poses = trips(np.random.default_rng(8), 0.0).reshape(6, 2, 1, COUNT)
    x, y = poses[0, :, :, :3].swapaxes(1, 2), poses[1, :, :, :3].swapaxes(1, 2) + 3.0
    args = (*poses, *map(np.array, BODY), x, y, x * 0.0, x * 0.0 + 1.0, x * 0.0 + 1.0)
    with mock.patch.object(clearance, "_pairs", wraps=clearance._pairs) as worked_out:
        least_clear(args, None, True)
    assert sum(call.args[2].size for call in worked_out.call_args_list) < 0.7 * 2 * 3 * COUNT
