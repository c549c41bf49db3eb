"""The samples a window holds: closed edges, truncation, mirrored past, refusals; both evaluators."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
import pytest

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.reference import temporal as reference
from trackmarshal.errors import TrackmarshalError

Members = list[list[int]]
MakeWindows = Callable[[Sequence[float], float | None, float | None, bool], Members]


def by_reference(t: Sequence[float], lower: float | None, upper: float | None, past: bool) -> Members:
    return [list(window) for window in reference.windows(t, lower, upper, past)]


def by_numpy(t: Sequence[float], lower: float | None, upper: float | None, past: bool) -> Members:
    w = temporal.windows(np.array(t, dtype=np.float64), lower, upper, past)
    return [list(range(start, stop)) for start, stop in zip(w.start.tolist(), w.stop.tolist())]


@pytest.fixture(params=[by_reference, by_numpy], ids=["reference", "numpy"])
def members(request: pytest.FixtureRequest) -> MakeWindows:
    make: MakeWindows = request.param
    return make


def test_edges_are_closed_and_truncated(members: MakeWindows) -> None:
    assert members([0.0, 1.0, 2.0, 3.0], 1.0, 2.0, False) == [[1, 2], [2, 3], [3], []]


def test_past_windows_mirror(members: MakeWindows) -> None:
    assert members([0.0, 1.0, 2.0, 3.0], 1.0, 2.0, True) == [[], [0], [0, 1], [1, 2]]


def test_uneven_samples_count_by_time(members: MakeWindows) -> None:
    t = [0.0, 0.5, 0.75, 4.0, 4.5]
    assert members(t, 0.0, 0.75, False) == [[0, 1, 2], [1, 2], [2], [3, 4], [4]]
    assert members(t, 0.25, 0.5, True) == [[], [0], [1], [], [3]]


def test_without_bounds_the_window_reaches_from_the_sample_to_the_end(members: MakeWindows) -> None:
    t = [0.0, 1.0, 5.0]
    assert members(t, None, None, False) == [[0, 1, 2], [1, 2], [2]]
    assert members(t, None, None, True) == [[0], [0, 1], [0, 1, 2]]
    assert members(t, 1.0, None, False) == [[1, 2], [2], []]
    assert members(t, None, 1.0, True) == [[0], [0, 1], [2]]


def test_zero_bounds_hold_the_sample_alone(members: MakeWindows) -> None:
    assert members([0.0, 0.1, 0.7], 0.0, 0.0, False) == [[0], [1], [2]]
    assert members([0.0, 0.1, 0.7], 0.0, 0.0, True) == [[0], [1], [2]]


def test_a_window_beyond_the_horizon_is_empty(members: MakeWindows) -> None:
    assert members([0.0, 1.0, 2.0], 9.0, 10.0, False) == [[], [], []]
    assert members([0.0, 1.0, 2.0], 9.0, 10.0, True) == [[], [], []]


def test_edges_are_what_the_float_sum_says(members: MakeWindows) -> None:
    # 0.1 + 0.2 is 0.30000000000000004, past 0.3, and 0.3 - 0.1 is 0.19999999999999998, which misses 0.2.
    assert members([0.1, 0.3], 0.2, 0.2, False) == [[], []]
    assert members([0.1, 0.3], 0.0, 0.2, False) == [[0, 1], [1]]
    assert members([0.2, 0.3], 0.1, 1.0, True) == [[], []]
    assert members([0.2, 0.3], 0.0, 0.1, True) == [[0], [0, 1]]


def test_empty_and_single_timelines(members: MakeWindows) -> None:
    assert members([], 0.0, 1.0, False) == []
    assert members([], None, None, True) == []
    assert members([3.0], 0.0, 1.0, True) == [[0]]


@pytest.mark.parametrize("t", [[1.0, 0.0], [0.0, math.nan, 1.0], [math.nan], [0.0, math.inf]])
def test_times_that_step_back_are_refused(members: MakeWindows, t: list[float]) -> None:
    with pytest.raises(TrackmarshalError) as refused:
        members(t, 0.0, 1.0, False)
    assert refused.value.code == "D181"


@pytest.mark.parametrize("bounds", [(2.0, 1.0), (-1.0, 1.0), (math.nan, 1.0), (0.0, math.nan), (None, -1.0)])
def test_bounds_that_hold_no_window_are_refused(
    members: MakeWindows, bounds: tuple[float | None, float | None]
) -> None:
    with pytest.raises(TrackmarshalError) as refused:
        members([0.0, 1.0], *bounds, False)
    assert refused.value.code == "D182"


def test_refusals_are_explained() -> None:
    assert set(reference.CODES) == {"D181", "D182"}
    assert all(title and explanation for title, explanation in reference.CODES.values())


def test_equidistant_samples_are_recognised() -> None:
    t = np.arange(100, dtype=np.float64)
    assert temporal.windows(t, 3.0, 10.0, False).uniform
    assert temporal.windows(t, 3.0, 10.0, True).uniform
    assert not temporal.windows(t * t, 3.0, 10.0, False).uniform
    assert temporal.windows(t * t, 0.0, None, False).uniform


def test_times_of_another_type_or_shape_are_refused() -> None:
    with pytest.raises(TypeError):
        temporal.windows(np.zeros((2, 2)), None, None, False)
    with pytest.raises(TypeError):
        temporal.windows(np.arange(3), None, None, False)  # type: ignore[arg-type]
