"""Signed distances of swept hulls from boxes and from each other, worked out by hand, for both implementations."""

from __future__ import annotations

import math

import numpy as np
import pytest

from support.bodies import BOTH, Geometry
from trackmarshal.runtime.geometry import boxes_clear, sweeps_clear

CAR = (4.0, 2.0)
ORIGIN = (0.0, 0.0, 0.0)

both = pytest.mark.parametrize("geometry", BOTH.values(), ids=BOTH.keys())


@both
@pytest.mark.parametrize(
    ("there", "box", "size", "margin"),
    [
        (ORIGIN, (10.0, 0.0, 0.0), CAR, 6.0),
        (ORIGIN, (0.0, 7.0, 0.0), CAR, 5.0),
        (ORIGIN, (7.0, 6.0, 0.0), CAR, 5.0),  # corner to corner: 3, 4
        (ORIGIN, (4.0, 0.0, 0.0), CAR, 0.0),  # touching
        (ORIGIN, (4.0, 2.0, 0.0), CAR, 0.0),  # corners touching
        (ORIGIN, (3.5, 0.5, 0.0), CAR, -0.5),
        (ORIGIN, (3.5, 1.75, 0.0), CAR, -0.25),
        (ORIGIN, ORIGIN, CAR, -2.0),  # to the side
        (ORIGIN, (0.5, 0.0, 0.0), (0.2, 0.2), -1.1),  # a post inside: out with it, and its own half width
        (ORIGIN, (4.0, 0.0, math.pi / 4), (2.0, 2.0), 2.0 - math.sqrt(2.0)),
        ((0.0, 0.0, math.pi), (0.0, 7.0, 0.0), CAR, 5.0),
        ((10.0, 0.0, 0.0), (5.0, 0.0, 0.0), (0.2, 0.2), -1.1),  # a post between two poses
        ((10.0, 0.0, 0.0), (5.0, 3.0, 0.0), CAR, 1.0),
        ((10.0, 10.0, 0.0), (0.0, 8.0, 0.0), (2.0, 2.0), (8.0 - 3.0 - 1.0 - 1.0) / math.sqrt(2.0)),
    ],
)
def test_from_a_box(geometry: Geometry, there, box, size, margin: float) -> None:  # type: ignore[no-untyped-def]
    assert geometry.clear(ORIGIN, there, CAR, box, size) == pytest.approx(margin, abs=1e-12)
    assert geometry.clear(there, ORIGIN, CAR, box, size) == pytest.approx(margin, abs=1e-12)


@both
def test_from_what_another_vehicle_sweeps(geometry: Geometry) -> None:
    # It crosses our way between the two samples, and is beside it in both.
    assert geometry.clear(ORIGIN, (10.0, 0.0, 0.0), CAR, (5.0, 6.0, 0.0), CAR) == pytest.approx(4.0)
    crossing = geometry.clear_of_sweep(ORIGIN, (10.0, 0.0, 0.0), CAR, (5.0, 6.0, 0.0), (5.0, -6.0, 0.0), CAR)
    assert crossing == pytest.approx(-8.0)  # along our way, out in front of or behind it
    follow = geometry.clear_of_sweep(ORIGIN, (10.0, 0.0, 0.0), CAR, (20.0, 0.0, 0.0), (40.0, 5.0, 0.2), CAR)
    assert follow == pytest.approx(6.0)


@both
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_unusable_numbers_have_no_margin(geometry: Geometry, bad: float) -> None:
    fine = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 4.0, 2.0, 9.0, 0.0, 0.0, 4.0, 2.0]
    for index in range(len(fine)):
        n = [*fine[:index], bad, *fine[index + 1 :]]
        assert math.isnan(
            geometry.clear(
                (n[0], n[1], n[2]), (n[3], n[4], n[5]), (n[6], n[7]), (n[8], n[9], n[10]), (n[11], n[12])
            )
        )
    assert math.isnan(geometry.clear(ORIGIN, ORIGIN, CAR, (9.0, 0.0, 0.0), (0.0, 1.0)))
    assert math.isnan(geometry.clear(ORIGIN, ORIGIN, (4.0, -2.0), (9.0, 0.0, 0.0), CAR))


def test_arguments_broadcast() -> None:
    x = np.arange(3.0)[:, None]
    box_x = np.array([10.0, 20.0, 30.0, np.nan])
    margins = boxes_clear(
        x, 0.0, 0.0, x + 1.0, 0.0, 0.0, 4.0, 2.0, box_x, 0.0, 0.0, [4.0, 2.0, 4.0, 4.0], 2.0
    )
    assert margins.shape == (3, 4)
    assert margins[:, :3] == pytest.approx(
        np.array([[5.0, 16.0, 25.0], [4.0, 15.0, 24.0], [3.0, 14.0, 23.0]])
    )
    assert np.isnan(margins[:, 3]).all()
    assert boxes_clear(*ORIGIN, *ORIGIN, *CAR, np.empty(0), 0.0, 0.0, *CAR).shape == (0,)
    assert sweeps_clear(x, 0.0, 0.0, x, 0.0, 0.0, *CAR, box_x, 0.0, 0.0, box_x, 9.0, 0.0, *CAR).shape == (
        3,
        4,
    )
