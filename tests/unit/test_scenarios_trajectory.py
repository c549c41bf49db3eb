"""Arc length and time along trajectories that come without them."""

from __future__ import annotations

import math

import pytest

from trackmarshal.scenarios.trajectory import REST_STEP, complete, first_at_rest, time_along, wrap


def samples(v: list[float], step: float = 2.0) -> dict[str, list[float]]:
    zeros = [0.0] * len(v)
    return {
        "x": [step * i for i in range(len(v))],
        "y": list(zeros),
        "heading": list(zeros),
        "kappa": list(zeros),
        "v": v,
        "a": list(zeros),
    }


def test_time_is_exact_at_constant_acceleration() -> None:
    # v^2 = 400 - 2 * 8 * s, so t = (20 - v) / 8
    s = [2.0 * i for i in range(13)]
    v = [math.sqrt(400.0 - 16.0 * x) for x in s]
    expected = [(20.0 - speed) / 8.0 for speed in v]
    assert time_along(s, v) == pytest.approx(expected, abs=1e-12)


def test_time_goes_on_at_rest() -> None:
    assert time_along([0.0, 1.0, 1.0, 1.0], [2.0, 0.0, 0.0, 2.0]) == pytest.approx(
        [0.0, 1.0, 1.0 + REST_STEP, 1.0 + REST_STEP]
    )


def test_path_beyond_the_first_sample_at_rest_is_dropped() -> None:
    plan, dropped = complete(samples([20.0, 10.0, 0.0, 0.0, 0.0]))
    assert dropped == 2
    assert plan["v"] == [20.0, 10.0, 0.0]
    assert plan["x"] == plan["s"] == [0.0, 2.0, 4.0]
    assert all(len(column) == 3 for column in plan.values())


@pytest.mark.parametrize(
    ("v", "rest"),
    [([5.0, 0.0, 0.0], 1), ([5.0, 0.0, 3.0], None), ([0.0, 0.0], 0), ([1.0], None), ([0.0, math.nan], None)],
)
def test_rest_is_where_nothing_moves_any_more(v: list[float], rest: int | None) -> None:
    assert first_at_rest(v) == rest


def test_a_stop_on_the_way_keeps_all_samples() -> None:
    plan, dropped = complete(samples([5.0, 0.0, 0.0, 3.0]))
    assert dropped == 0
    assert len(plan["t"]) == 4
    assert all(b > a for a, b in zip(plan["t"], plan["t"][1:]))


def test_standing_from_the_start_stays_in_the_first_place() -> None:
    plan, dropped = complete(samples([0.0, 0.0, 0.0]))
    assert dropped == 1
    assert plan["x"] == [0.0, 0.0]
    assert plan["t"] == [0.0, REST_STEP]


def test_a_nan_behind_the_rest_is_not_dropped() -> None:
    given = samples([5.0, 0.0, 0.0])
    given["kappa"][2] = math.nan
    plan, dropped = complete(given)
    assert dropped == 0
    assert math.isnan(plan["kappa"][2])


def test_two_places_in_one_get_one_time() -> None:
    # Data at fault is left for the input contract: times that do not increase.
    plan, _ = complete({**samples([5.0, 5.0]), "x": [1.0, 1.0]})
    assert plan["t"] == [0.0, 0.0]


@pytest.mark.parametrize(
    ("angle", "expected"),
    [(math.pi, math.pi), (-math.pi, math.pi), (3.0 * math.pi, math.pi), (0.5, 0.5), (-4.0, math.tau - 4.0)],
)
def test_wrap(angle: float, expected: float) -> None:
    assert wrap(angle) == pytest.approx(expected)
    assert -math.pi < wrap(angle) <= math.pi


def test_wrap_keeps_nan() -> None:
    assert math.isnan(wrap(math.nan))
    assert math.isnan(wrap(math.inf))
