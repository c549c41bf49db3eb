"""Temporal operators on examples small enough to work out by hand; both evaluators."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from trackmarshal.backends.numpy import temporal
from trackmarshal.backends.reference import temporal as reference

INF = math.inf
T = [0.0, 1.0, 2.0, 3.0]
#: Boundaries where the sign of a margin says nothing: 0 can be true (<=) or false (<).
P = ([True, False, False, True], [2.0, 0.0, -1.0, 0.0])
Q = ([False, False, True, False], [-3.0, -0.5, 4.0, -2.0])


class Evaluator:
    """The operators of one evaluator, on lists."""

    def __init__(self, module: Any) -> None:
        self.module = module
        self.on_arrays = module is temporal

    def __call__(self, name: str, *values: Any, window: Any = None, **options: Any) -> Any:
        if self.on_arrays:
            values = tuple(np.array(value) for value in values)
        if window is not None:
            t = np.array(T) if self.on_arrays else T
            values = (*values, self.module.windows(t, *window))
        sat, margin = getattr(self.module, name)(*values, **options)
        return (sat.tolist(), margin.tolist()) if self.on_arrays else (sat, margin)


@pytest.fixture(params=[reference, temporal], ids=["reference", "numpy"])
def run(request: pytest.FixtureRequest) -> Evaluator:
    return Evaluator(request.param)


def test_always_is_the_minimum_and_every_one(run: Evaluator) -> None:
    assert run("always", *P, window=(0.0, 1.0, False)) == (
        [False, False, False, True],
        [0.0, -1.0, -1.0, 0.0],
    )


def test_eventually_is_the_maximum_and_any(run: Evaluator) -> None:
    assert run("eventually", *P, window=(0.0, 1.0, False)) == (
        [True, False, True, True],
        [2.0, 0.0, 0.0, 0.0],
    )


def test_historically_and_once_look_back(run: Evaluator) -> None:
    assert run("always", *P, window=(0.0, 1.0, True)) == ([True, False, False, False], [2.0, 0.0, -1.0, -1.0])
    assert run("eventually", *P, window=(1.0, 2.0, True)) == (
        [False, True, True, False],
        [-INF, 2.0, 2.0, 0.0],
    )


def test_unbounded_operators_reach_the_ends(run: Evaluator) -> None:
    assert run("always", *P, window=(None, None, False)) == (
        [False, False, False, True],
        [-1.0, -1.0, -1.0, 0.0],
    )
    assert run("eventually", *P, window=(None, None, True)) == ([True] * 4, [2.0] * 4)


def test_empty_windows_are_neutral(run: Evaluator) -> None:
    for past in (False, True):
        beyond = (7.0, 9.0, past)
        assert run("always", *P, window=beyond) == ([True] * 4, [INF] * 4)
        assert run("eventually", *P, window=beyond) == ([False] * 4, [-INF] * 4)
        assert run("since" if past else "until", *P, *Q, window=beyond) == ([False] * 4, [-INF] * 4)


def test_until_needs_p_before_q_only(run: Evaluator) -> None:
    # At 0: q at 2 has p = min(2, 0) before it; at 2: q itself, whatever p is there.
    assert run("until", *P, *Q, window=(0.0, 2.0, False)) == (
        [False, False, True, False],
        [0.0, 0.0, 4.0, -2.0],
    )
    assert run("until", *P, *Q, window=(None, None, False)) == (
        [False, False, True, False],
        [0.0, 0.0, 4.0, -2.0],
    )


def test_until_needs_p_before_its_window_too(run: Evaluator) -> None:
    assert run("until", *P, *Q, window=(2.0, 3.0, False)) == ([False] * 4, [0.0, -2.0, -INF, -INF])
    assert run("until", [True] * 4, [9.0] * 4, *Q, window=(2.0, 3.0, False)) == (
        [True, False, False, False],
        [4.0, -2.0, -INF, -INF],
    )
    assert run("until", *P, *Q, window=(1.0, None, False)) == ([False] * 4, [0.0, 0.0, -2.0, -INF])


def test_since_needs_p_after_q_only(run: Evaluator) -> None:
    assert run("since", *P, *Q, window=(0.0, 2.0, True)) == (
        [False, False, True, True],
        [-3.0, -0.5, 4.0, 0.0],
    )
    assert run("since", *P, *Q, window=(1.0, 1.0, True)) == (
        [False, False, False, True],
        [-INF, -3.0, -1.0, 0.0],
    )


def test_next_and_previous_are_strong_or_weak_outside(run: Evaluator) -> None:
    assert run("shift", *P, step=1, weak=False) == ([False, False, True, False], [0.0, -1.0, 0.0, -INF])
    assert run("shift", *P, step=1, weak=True) == ([False, False, True, True], [0.0, -1.0, 0.0, INF])
    assert run("shift", *P, step=-1, weak=False) == ([False, True, False, False], [-INF, 2.0, 0.0, -1.0])
    assert run("shift", *P, step=-1, weak=True) == ([True, True, False, False], [INF, 2.0, 0.0, -1.0])


def test_zeros_come_out_positive(run: Evaluator) -> None:
    zero = ([False] * 4, [-0.0] * 4)
    window = (0.0, 1.0, False)
    values = [
        run("always", *zero, window=window),
        run("eventually", *zero, window=(None, None, False)),
        run("until", *zero, *zero, window=window),
        run("shift", *zero, step=1, weak=True),
    ]
    assert all(math.copysign(1.0, value) == 1.0 for _, margin in values for value in margin)


def test_a_step_of_two_is_refused(run: Evaluator) -> None:
    with pytest.raises(ValueError, match="step"):
        run("shift", *P, step=2, weak=True)


def test_the_direction_of_windows_is_checked() -> None:
    sat, margin = np.array(P[0]), np.array(P[1])
    past, future = (temporal.windows(np.array(T), 0.0, 1.0, past) for past in (True, False))
    with pytest.raises(ValueError, match="until"):
        temporal.until(sat, margin, sat, margin, past)
    with pytest.raises(ValueError, match="since"):
        temporal.since(sat, margin, sat, margin, future)


def test_arrays_of_another_type_or_length_are_refused() -> None:
    w = temporal.windows(np.array(T), 0.0, 1.0, False)
    sat, margin = np.array(P[0]), np.array(P[1])
    with pytest.raises(TypeError):
        temporal.always(sat[:3], margin[:3], w)
    with pytest.raises(TypeError):
        temporal.always(margin, sat, w)


def test_leading_axes_are_a_batch() -> None:
    rng = np.random.default_rng(3)
    t = np.cumsum(rng.random(9) + 0.1)
    p, q = rng.normal(size=(2, 3, 9)), rng.normal(size=9)
    for past in (False, True):
        w = temporal.windows(t, 0.5, 2.0, past)
        held = temporal.since if past else temporal.until
        sat, margin = held(p >= 0, p, q >= 0, q, w)
        assert margin.shape == p.shape
        for row in np.ndindex(2, 3):
            alone_sat, alone = held(p[row] >= 0, p[row], q >= 0, q, w)
            assert sat[row].tolist() == alone_sat.tolist()
            assert margin[row].tolist() == alone.tolist()


def test_a_nan_never_vanishes() -> None:
    holed = np.array([1.0, math.nan, 3.0, 4.0])
    sat = np.array([True] * 4)
    w = temporal.windows(np.array(T), 0.0, 1.0, False)
    for _, margin in (
        temporal.always(sat, holed, w),
        temporal.eventually(sat, holed, w),
        temporal.until(sat, holed, sat, holed, w),
    ):
        assert np.isnan(margin[:2]).all()
        assert not np.isnan(margin[2:]).any()


def test_inputs_are_left_as_they_were() -> None:
    values = [np.array(column) for column in (*P, *Q)]
    w = temporal.windows(np.array(T), 0.0, 2.0, False)
    temporal.until(values[0], values[1], values[2], values[3], w)
    temporal.always(values[0], values[1], w)
    assert [column.tolist() for column in values] == [*P, *Q]
