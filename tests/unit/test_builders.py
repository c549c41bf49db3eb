"""Builders of test signals: every trajectory is consistent in itself, and the registry tells the truth."""

from __future__ import annotations

import math
import subprocess
import sys
from typing import Any

import pytest

from trackmarshal.errors import TrackmarshalError
from trackmarshal.testing import builders
from trackmarshal.testing.builders import BUILDERS

COLUMNS = ["t", "s", "x", "y", "heading", "kappa", "v", "a"]

#: name, arguments
TRAJECTORIES: list[tuple[str, dict[str, float]]] = [
    ("line", {"v": 20.0}),
    ("line", {"v": 20.0, "a": -3.0, "heading": 1.0, "x": 5.0, "y": -2.0}),
    ("line", {"v": 0.0, "a": 2.0}),
    ("line", {"v": -5.0}),
    ("line", {"v": -5.0, "a": 0.1, "points": 7.0}),
    ("arc", {"radius": 60.0, "v": 20.0}),
    ("arc", {"radius": -25.0, "v": 10.0, "angle": 3.0, "a": 1.0, "heading": -2.0}),
    ("arc", {"radius": 11.0, "v": -4.0, "length": 10.0}),
    ("clothoid", {"kappa0": 0.0, "kappa1": 0.02, "v": 20.0}),
    ("clothoid", {"kappa0": 0.05, "kappa1": -0.05, "v": 12.0, "length": 80.0, "a": 0.5}),
    ("constant_speed", {"v": 30.0}),
    ("constant_speed", {"v": 30.0, "duration": 2.0, "points": 5.0}),
    ("braking", {"v": 40.0, "a": 12.0}),
    ("braking", {"v": 15.0, "a": 6.0, "radius": -40.0, "points": 12.0}),
    ("stationary", {}),
    ("stationary", {"x": 3.0, "duration": 1.0, "points": 3.0}),
]


def build(name: str, **arguments: float) -> Any:
    return BUILDERS[name].build(**arguments)


@pytest.mark.parametrize(("name", "arguments"), TRAJECTORIES)
def test_trajectories_are_consistent(name: str, arguments: dict[str, float]) -> None:
    plan = build(name, **arguments)
    count = int(arguments.get("points", 50))
    assert list(plan) == COLUMNS
    assert all(type(x) is float for column in plan.values() for x in column)
    assert {len(column) for column in plan.values()} == {count}
    assert (plan["t"][0], plan["s"][0]) == (0.0, 0.0)
    for i in range(count - 1):
        dt = plan["t"][i + 1] - plan["t"][i]
        ds = plan["s"][i + 1] - plan["s"][i]
        v, w, a = plan["v"][i], plan["v"][i + 1], plan["a"][i]
        assert dt > 0.0
        assert ds == pytest.approx(abs(v + w) / 2.0 * dt, abs=1e-9)
        assert w - v == pytest.approx(a * dt, abs=1e-9)
        turn = plan["heading"][i + 1] - plan["heading"][i]
        driven = math.copysign(ds, v + w)
        assert turn == pytest.approx((plan["kappa"][i] + plan["kappa"][i + 1]) / 2.0 * driven, abs=1e-9)
        # The chord of a bend against its arc, to second order in the turn.
        dx, dy = plan["x"][i + 1] - plan["x"][i], plan["y"][i + 1] - plan["y"][i]
        assert math.hypot(dx, dy) == pytest.approx(ds * (1.0 - turn * turn / 24.0), abs=1e-4)
        if ds > 0.0:
            way = math.atan2(dy, dx) + (math.pi if driven < 0.0 else 0.0)
            # The chord's direction is the mean heading; where curvature changes, that is not the middle one.
            mean = plan["heading"][i] + turn / 2.0 - (plan["kappa"][i + 1] - plan["kappa"][i]) * driven / 12.0
            assert math.remainder(way - mean, math.tau) == pytest.approx(0.0, abs=1e-6)


def test_the_arc_of_the_language_document() -> None:
    plan = builders.arc(radius=60.0, v=20.0)
    assert plan["a"] == [0.0] * 50
    assert plan["kappa"] == [1.0 / 60.0] * 50
    assert plan["v"] == [20.0] * 50
    assert builders.arc(radius=-60.0, v=20.0)["kappa"] == [-1.0 / 60.0] * 50


def test_arcs_close() -> None:
    plan = builders.arc(radius=25.0, v=10.0, angle=2.0 * math.pi, x=3.0, y=4.0)
    assert (plan["x"][-1], plan["y"][-1]) == pytest.approx((3.0, 4.0), abs=1e-12)
    quarter = builders.arc(radius=-25.0, v=10.0, angle=math.pi / 2.0)
    assert (quarter["x"][-1], quarter["y"][-1]) == pytest.approx((25.0, -25.0), abs=1e-12)


def test_clothoid_against_its_series() -> None:
    # x = integral of cos(s^2 / (2 A^2)), y = integral of sin(s^2 / (2 A^2)), A^2 = length / kappa1
    length, kappa = 50.0, 0.02
    plan = builders.clothoid(kappa0=0.0, kappa1=kappa, v=10.0, length=length)
    q = kappa / (2.0 * length)
    x = sum(
        (-1) ** n * q ** (2 * n) * length ** (4 * n + 1) / (math.factorial(2 * n) * (4 * n + 1))
        for n in range(9)
    )
    y = sum(
        (-1) ** n * q ** (2 * n + 1) * length ** (4 * n + 3) / (math.factorial(2 * n + 1) * (4 * n + 3))
        for n in range(9)
    )
    assert (plan["x"][-1], plan["y"][-1]) == pytest.approx((x, y), abs=1e-11)
    assert (plan["kappa"][0], plan["kappa"][-1]) == (0.0, kappa)


def test_braking_ends_exactly_at_rest() -> None:
    plan = builders.braking(v=40.0, a=12.0)
    assert plan["v"][-1] == 0.0
    assert plan["s"][-1] == 40.0**2 / 24.0
    assert plan["t"][-1] == 40.0 / 12.0
    assert set(plan["a"]) == {-12.0}


def test_a_line_may_end_at_rest() -> None:
    assert builders.line(v=10.0, a=-2.0, length=25.0)["v"][-1] == 0.0


def test_samples_of_a_line_are_a_metre_apart() -> None:
    assert builders.line(v=1.0)["x"] == [float(i) for i in range(50)]


def test_one_point_is_a_trajectory() -> None:
    assert builders.line(v=1.0, points=1)["s"] == [0.0]


def area(points: list[list[float]]) -> float:
    return 0.5 * sum(x0 * y1 - x1 * y0 for (x0, y0), (x1, y1) in zip(points, [*points[1:], points[0]]))


def test_straight_track() -> None:
    track = builders.straight_track(length=80.0, width=8.0, before=10.0, x=1.0, y=2.0, heading=math.pi / 2.0)
    assert track["left"][0] == pytest.approx([-3.0, -8.0])
    assert track["left"][-1] == pytest.approx([-3.0, 82.0])
    assert track["right"][-1] == pytest.approx([5.0, 82.0])
    assert track["closed"] is False


@pytest.mark.parametrize("radius", [60.0, -60.0])
def test_arc_track(radius: float) -> None:
    track = builders.arc_track(radius=radius, width=8.0, angle=1.5)
    for side, distance in (
        ("left", 60.0 - math.copysign(4.0, radius)),
        ("right", 60.0 + math.copysign(4.0, radius)),
    ):
        assert all(math.hypot(x, y - radius) == pytest.approx(distance) for x, y in track[side])
        assert len(track[side]) == 200
    x, y = track["left"][-1]
    assert math.atan2(x, math.copysign(radius - y, 1.0)) == pytest.approx(1.5)


@pytest.mark.parametrize("radius", [60.0, -60.0])
def test_ring_track(radius: float) -> None:
    track = builders.ring_track(radius=radius, width=8.0)
    assert track["closed"] is True
    assert track["left"][0] == pytest.approx([0.0, 4.0])
    assert track["left"][0] != pytest.approx(track["left"][-1], abs=0.1)
    inner, outer = (track["left"], track["right"]) if radius > 0.0 else (track["right"], track["left"])
    assert abs(area(inner)) == pytest.approx(math.pi * 56.0**2, rel=1e-3)
    assert abs(area(outer)) == pytest.approx(math.pi * 64.0**2, rel=1e-3)
    assert math.copysign(1.0, area(outer)) == math.copysign(1.0, radius)


def test_default_trajectories_are_on_default_tracks() -> None:
    track = builders.straight_track()
    assert track["left"][0][0] < -3.0
    assert track["left"][-1][0] > builders.line(v=20.0)["x"][-1] + 3.0


def test_the_registry_describes_all_builders() -> None:
    assert set(BUILDERS) == {
        "line", "arc", "clothoid", "constant_speed", "braking", "stationary",
        "straight_track", "arc_track", "ring_track",
    }  # fmt: skip
    assert {name for name, b in BUILDERS.items() if b.builds == "corridor"} == {
        "straight_track", "arc_track", "ring_track",
    }  # fmt: skip
    arc = BUILDERS["arc"].parameters
    assert arc["radius"] == ("m", None, True)
    assert arc["angle"] == ("rad", None, False)
    assert arc["points"] == ("1", 50, False)
    assert arc["a"] == ("m/s^2", 0.0, False)
    assert list(arc) == ["radius", "v", "length", "angle", "points", "a", "x", "y", "heading"]
    assert all(builder.doc for builder in BUILDERS.values())


@pytest.mark.parametrize("name", BUILDERS)
def test_required_parameters_are_enough(name: str) -> None:
    # 0.02 is in range as a radius' inverse and 20 as everything else
    needed = {
        n: 0.02 if p.unit == "1/m" else 20.0 for n, p in BUILDERS[name].parameters.items() if p.required
    }
    assert build(name, **needed)
    for left_out in needed:
        with pytest.raises(TypeError):
            build(name, **{n: v for n, v in needed.items() if n != left_out})


@pytest.mark.parametrize(
    ("name", "arguments", "code"),
    [
        ("line", {"v": math.nan}, "E451"),
        ("line", {"v": math.inf}, "E451"),
        ("line", {"v": 1e10}, "E451"),
        ("line", {"v": 1.0, "length": 0.0}, "E451"),
        ("line", {"v": 1.0, "length": -1.0}, "E451"),
        ("line", {"v": 1.0, "points": 2.5}, "E451"),
        ("line", {"v": 1.0, "points": 0.0}, "E451"),
        ("line", {"v": 1.0, "points": 1e6}, "E451"),
        ("line", {"v": 1.0, "points": math.nan}, "E451"),
        ("line", {"v": 1.0, "heading": math.nan}, "E451"),
        ("line", {"v": 0.0}, "E452"),
        ("line", {"v": 10.0, "a": -2.0, "length": 25.1}, "E452"),
        ("arc", {"v": 10.0, "radius": 0.0}, "E451"),
        ("arc", {"v": 10.0, "radius": 10.0, "angle": 1.0, "length": 10.0}, "E452"),
        ("arc", {"v": 10.0, "radius": 10.0, "angle": -1.0}, "E451"),
        ("clothoid", {"v": 10.0, "kappa0": 0.0, "kappa1": math.nan}, "E451"),
        ("clothoid", {"v": 10.0, "kappa0": 0.0, "kappa1": 1e6}, "E452"),
        ("constant_speed", {"v": 0.0}, "E452"),
        ("constant_speed", {"v": 5.0, "duration": 0.0}, "E451"),
        ("braking", {"v": 0.0, "a": 1.0}, "E451"),
        ("braking", {"v": 10.0, "a": -1.0}, "E451"),
        ("braking", {"v": 10.0, "a": 1.0, "points": 1.0}, "E451"),
        ("stationary", {"duration": -1.0}, "E451"),
        ("straight_track", {"width": 0.0}, "E451"),
        ("arc_track", {"radius": 4.0}, "E452"),
        ("arc_track", {"radius": 20.0, "angle": 5.5}, "E452"),
        ("ring_track", {"radius": 5.0, "width": 10.0}, "E452"),
    ],
)
def test_bad_arguments_are_refused(name: str, arguments: dict[str, float], code: str) -> None:
    with pytest.raises(TrackmarshalError) as caught:
        build(name, **arguments)
    assert caught.value.code == code
    assert code in builders.CODES
    assert caught.value.help


def test_builders_are_there_where_docstrings_are_left_out() -> None:
    """`python -OO`, or PYTHONOPTIMIZE=2 in the environment of a job: every command that reads a spec broke."""
    asked = "from trackmarshal.testing.builders import BUILDERS; print({b.doc for b in BUILDERS.values()})"
    done = subprocess.run([sys.executable, "-OO", "-c", asked], capture_output=True, text=True, check=False)
    assert (done.stdout, done.stderr) == ("{''}\n", "")
