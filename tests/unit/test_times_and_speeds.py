"""Trajectories whose times, positions and speeds say different things are driven by nobody, whichever evaluator looks at them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from support.cycles import cycle
from support.supervised import BACKENDS, against
from trackmarshal.runtime.cycle import Cycle


def as_planned(given: Cycle) -> None:
    """Nothing is wrong with it."""


def never_brakes(given: Cycle) -> None:
    speeds = given.emergency["v"]
    speeds[:-1], given.emergency["a"][:] = speeds[0], 0.0


def in_a_tenth_of_the_time(given: Cycle) -> None:
    given.driving["t"] = given.driving["t"] * 0.1


def in_ten_times_the_time(given: Cycle) -> None:
    given.emergency["t"] = given.emergency["t"] * 10.0


def brakes_on_the_spot(given: Cycle) -> None:
    for name in ("x", "y", "s"):
        given.emergency[name][-5:] = given.emergency[name][-5]
    given.emergency["v"][-5:] = np.linspace(4.0, 0.0, 5)


def driven(points: np.ndarray, v: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of a path (n, 3) of x, y and heading, of which the car says that it is straight and driven without any force."""
    x, y, heading = points.T
    way = np.hypot(np.diff(x), np.diff(y))
    s, t = (np.concatenate([[0.0], np.cumsum(one)]) for one in (way, 2.0 * way / (v[1:] + v[:-1])))
    nothing = np.zeros(len(x))
    return {"t": t, "s": s, "x": x, "y": y, "heading": heading, "kappa": nothing, "v": v, "a": nothing}


def bend(radius: float, way: np.ndarray) -> np.ndarray:
    turned = way / radius
    return np.column_stack([radius * np.sin(turned), radius * (1.0 - np.cos(turned)), turned])


def turns_a_corner(given: Cycle) -> None:
    """Within 8 mm, which other rules leave out."""
    ahead = np.arange(0.0, 31.0, 2.0)
    before, after = np.zeros((len(ahead), 3)), np.zeros((len(ahead), 3))
    before[:, 0], after[:, 0], after[:, 1], after[:, 2] = ahead, ahead[-1], ahead, 0.5 * np.pi
    after[0, :2] = ahead[-1] + 0.004, 0.004
    corner = np.array([[ahead[-1] + 0.002, 0.001, 0.25 * np.pi]])
    after[1:, 0] = after[0, 0]
    points = np.concatenate([before, corner, after])
    given.driving.clear()
    given.driving.update(driven(points, np.full(len(points), 20.0)))


def turns_within_the_tolerance_of_curvature(given: Cycle) -> None:
    given.driving.clear()
    given.driving.update(driven(bend(21.0, np.arange(0.0, 26.0, 1.0)), np.full(26, 20.0)))


def brakes_in_a_bend_at_its_ends(given: Cycle) -> None:
    """In two steps, of which each is the first or the last."""
    way = np.array([0.0, 8.0, 16.0])
    given.emergency.clear()
    given.emergency.update(driven(bend(40.0, way), np.sqrt(400.0 * (1.0 - way / 16.0))))
    given.emergency["kappa"][:] = 1.0 / 40.0


def swings_to_and_fro(given: Cycle) -> None:
    """By 0.36 m within 6 m, while headings and curvatures say that it goes straight on."""
    way = np.arange(0.0, 60.0, 1.0)
    points = np.column_stack([way, 0.18 * np.sin(2.0 * np.pi * way / 12.0), np.zeros(len(way))])
    given.driving.clear()
    given.driving.update(driven(points, np.full(len(way), 20.0)))


def goes_sideways(given: Cycle) -> None:
    """Along a straight line that is 0.2 rad off where the car points: its corners are half a metre from where they were looked for."""
    way = np.arange(0.0, 60.0, 2.0)
    points = np.column_stack([np.cos(0.2) * way, np.sin(0.2) * way, np.zeros(len(way))])
    given.driving.clear()
    given.driving.update(driven(points, np.full(len(way), 20.0)))


@BACKENDS
@pytest.mark.parametrize(
    ("change", "safe"),
    [
        (as_planned, True), (never_brakes, False), (in_a_tenth_of_the_time, False), (in_ten_times_the_time, False), (brakes_on_the_spot, False),
        (turns_a_corner, False), (turns_within_the_tolerance_of_curvature, False), (brakes_in_a_bend_at_its_ends, False),
        (swings_to_and_fro, False), (goes_sideways, False),
    ],
)  # fmt: skip
def test_it_is_driven_only_as_planned(change: Callable[[Cycle], None], safe: bool, backend: str) -> None:
    given = cycle(0)
    given.signals["track"].update(
        {side: np.array([[-100.0, y], [400.0, y]]) for side, y in (("left", 60.0), ("right", -60.0))}
    )
    change(given)
    found = {rule for rule, _ in against(given, backend)}
    assert bool(found) is not safe
    assert safe or {"pace_integrity", "speed_integrity", "path_integrity", "heading_integrity"} & found
