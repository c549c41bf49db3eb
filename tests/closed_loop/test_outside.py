"""What became of the car is judged by shapely alone, and both ways."""

from __future__ import annotations

import math

import pytest

from closed_loop.car import Build
from closed_loop.loop import Trace
from closed_loop.outside import outcome, swept
from closed_loop.road import Road, Spot

BUILD = Build()


def ring(inner: float = 50.0, outer: float = 60.0) -> Road:
    """A round road about the origin, driven to the left; the race line in its middle."""
    turns = [math.tau * i / 720 for i in range(720)]
    left = tuple((inner * math.cos(t), inner * math.sin(t)) for t in turns)
    right = tuple((outer * math.cos(t), outer * math.sin(t)) for t in turns)
    middle = (inner + outer) / 2
    spots = tuple(Spot(middle * math.cos(t), middle * math.sin(t), t + math.pi / 2, 10.0) for t in turns)
    return Road("ring", left, right, tuple(middle * t for t in turns), spots, middle * math.tau)


def drive(
    radius: float, others: list[tuple[str, float, float, float]] | None = None, stop: bool = True
) -> Trace:
    """Half a lap at some radius; the others stand."""
    trace = Trace()
    for i in range(181):
        t = math.pi * i / 180
        v = 0.0 if stop and i == 180 else 10.0
        trace.poses.append((0.1 * i, radius * math.cos(t), radius * math.sin(t), t + math.pi / 2, v))
        trace.others.append(list(others or []))
    return trace


def test_in_the_middle_of_the_road() -> None:
    found = outcome(drive(55.0), ring(), BUILD)
    assert found.rest
    assert found.contact == ""
    # the body's outer corners are nearest to the outer border
    assert found.clearance == pytest.approx(60.0 - math.hypot(56.0, 2.35), abs=0.01)


def test_off_the_road_to_either_side() -> None:
    assert outcome(drive(59.5), ring(), BUILD).clearance == pytest.approx(
        60.0 - math.hypot(60.5, 2.35), abs=0.01
    )
    assert outcome(drive(50.5), ring(), BUILD).clearance == pytest.approx(-0.5, abs=0.03)


def test_contact_and_the_least_gap() -> None:
    hit = outcome(drive(55.0, [("o", -55.0, 0.0, -math.pi / 2)]), ring(), BUILD)
    assert hit.contact.startswith("o at ")
    assert hit.gap == 0.0
    past = outcome(drive(55.0, [("o", 0.0, 58.5, math.pi)]), ring(), BUILD)
    assert past.contact == ""
    assert past.gap == pytest.approx(1.5, abs=0.05)


def test_rolling_is_no_rest() -> None:
    assert not outcome(drive(55.0, stop=False), ring(), BUILD).rest


def test_a_trajectory_is_swept_on_its_curve() -> None:
    turns = [2.5 * i / 16.0 for i in range(10)]
    path = {
        "s": [16.0 * t for t in turns],
        "x": [16.0 * math.sin(t) for t in turns],
        "y": [16.0 * (1.0 - math.cos(t)) for t in turns],
        "heading": turns,
    }
    found = swept(path)
    assert len(found) > 200
    assert all(math.hypot(x, y - 16.0) == pytest.approx(16.0, abs=0.002) for x, y, _ in found)
