"""The dense computation that the rules are held against, on what can be worked out by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from support.dense import braking, curve, physics, rss, sweep
from support.dense.car import Car
from support.dense.path import path
from support.dense.recording import Columns, Recording, warning
from support.length import at_length

CAR = Car(4.7, 2.8, 1160.0, 7.0, 13.0, 0.854, np.array([[0.0, 6.0], [40.0, 4.0]]), 72.0)


def arc(radius: float, length: float, v: float = 10.0, a: float = 0.0) -> Columns:
    """To the left around the origin, from +x on, a sample every 2.5 m."""
    s = np.arange(0.0, length, 2.5)
    turn = s / radius
    flat = {name: np.full_like(s, value) for name, value in (("v", v), ("a", a), ("kappa", 1.0 / radius))}
    return {
        **flat, "s": s, "t": s / v, "x": radius * np.cos(turn), "y": radius * np.sin(turn), "heading": turn + math.pi / 2.0,
    }  # fmt: skip


def ring(inner: float, outer: float) -> Recording:
    turn = np.linspace(0.0, 2.0 * math.pi, 4000, endpoint=False)
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return Recording("ring", inner * circle, outer * circle, closed=True, cycles=())


def test_the_curve_between_samples_of_an_arc_is_the_arc() -> None:
    part = curve.pieces(arc(16.0, 60.0), 126)
    assert np.abs(np.hypot(part.x, part.y) - 16.0).max() < 1e-5
    assert np.abs(part.kappa - 1.0 / 16.0).max() < 1e-4
    assert part.lengths == pytest.approx(2.5, abs=1e-4)


@pytest.mark.parametrize(
    ("inner", "outer", "outside"), [(0.001, 0.001, False), (-0.002, 0.0, True), at_length(0.0, -0.002, True)]
)
def test_a_car_in_a_ring_leaves_the_road_by_its_corners_and_its_inner_side(inner: float, outer: float, outside: bool) -> None:  # fmt: skip
    """Its inner side reaches to R - w/2, its outer corners to the diagonal: a millimetre more is road, two less are not."""
    side = 16.0 - CAR.width / 2.0
    corner = math.hypot(16.0 + CAR.width / 2.0, CAR.length / 2.0)
    place = sweep.road(ring(side - inner, corner + outer))
    assert (sweep.leaves(arc(16.0, 60.0), place, CAR) is not None) == outside


def test_the_hull_of_samples_is_wider_than_what_is_swept() -> None:
    """Else the comparison with rules that sweep straight would say nothing."""
    corners = sweep.along(curve.pieces(arc(16.0, 60.0), 2), CAR)
    hulls = shapely.convex_hull(shapely.multipoints(corners.reshape(len(corners), 8, 2)))
    nearest = min(hull.distance(shapely.Point(0.0, 0.0)) for hull in hulls)
    # Its inner side goes straight from the first footprint's rear corner to the second one's front corner.
    side, half = 16.0 - CAR.width / 2.0, CAR.length / 2.0
    straight = math.hypot(side, half) * math.cos(1.25 / 16.0 + math.atan2(half, side))
    assert nearest == pytest.approx(straight, abs=1e-6)
    assert side - nearest > 0.2


def test_tyres_do_not_carry_what_drag_does() -> None:
    """Modena at 76.6 s: -15.20 m/s^2, of which drag is 2.38."""
    v = math.sqrt(2.38 * CAR.mass / CAR.drag)
    found = physics.at_samples(arc(1e9, 10.0, v, -15.20), CAR)
    assert [name for name, so in found.items() if so] == []
    assert physics.at_samples(arc(1e9, 10.0, 60.0, 3.0), CAR)["drive"]
    assert physics.at_samples(arc(60.0**2 / 12.0, 10.0, 60.0, 3.0), CAR)["friction"]


def test_braking_at_the_limit_without_drag_is_what_everybody_knows() -> None:
    car = Car(**{**{name: getattr(CAR, name) for name in CAR.__dataclass_fields__}, "drag": 0.0})
    s, v, asks = braking.brake(path(arc(1e9, 200.0), 0.0), 5.0, 50.0, car)
    assert s[-1] - 5.0 == pytest.approx(50.0**2 / 26.0, abs=1e-6)
    assert v[-1] == 0.0
    assert asks < 1e-4


def test_distances_of_rss() -> None:
    """Response 9 m + 0.5 m, braking from 20 m/s 20 m; the car in front brakes from 10 m/s within 4 m."""
    front = rss.Response(0.5, 4.0, 10.0)
    assert rss.stopping(18.0, front) == pytest.approx(29.5, abs=1e-6)
    assert rss.same_direction(10.0, 30.0, front) == 0.0
    assert rss.opposite(18.0, 18.0, front) == pytest.approx(59.0, abs=1e-6)
    assert rss.as_printed(29.5, 18.0, 0.0, front) == pytest.approx(0.0, abs=1e-9)
    assert rss.aside(-9.0, -9.0, front) == 0.0


def test_a_slow_computer_is_no_warning() -> None:
    slow = (
        "Warning: One trajectory generation iteration took more than 0.100s (Actual calculation time: 0.100s)"
    )
    assert warning(slow) == ""
    assert warning(f"{slow} | Too close to object!") == "Too close to object!"
