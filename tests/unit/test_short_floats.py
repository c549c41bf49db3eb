"""Places that went through a float of 32 bits: where its numbers are decimetres apart, a car beyond its border had a margin that is positive."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import trackmarshal as tm
from support.cycles import cycle
from support.supervised import BACKENDS, shipped
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of


def moved(north: float, borders: type[np.floating[Any]]) -> Cycle:
    """The straight road of all tests, so far to the north."""
    given = cycle(0, objects=0, obstacles=0)
    for columns in (given.driving, given.emergency):
        columns["y"] = np.asarray(columns["y"], dtype=float) + north
    given.signals["ego"]["y"] += north
    for side in ("left", "right"):
        given.signals["track"][side] = (
            np.array(given.signals["track"][side]) + np.array([0.0, north])
        ).astype(borders)
    return given


@BACKENDS
@pytest.mark.parametrize(
    ("borders", "north", "refused"),
    [
        (np.float64, 5334572.35, ""),
        (np.float32, 0.0, ""),
        (np.float32, 5334572.35, "float32 has no two numbers nearer than 0.5 m there"),
        (np.float16, 5000.0, "float16 has no two numbers nearer than 4 m there"),
    ],
)
def test_borders_that_have_lost_digits_are_refused(
    borders: type[np.floating[Any]], north: float, refused: str, backend: str
) -> None:
    given = moved(north, borders)
    decision = tm.supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: 0.0).step(
        given
    )
    found = {(name_of(fault), fault.signal, fault.field) for fault in decision.faults}
    wanted = {("wrong_type", "track", side) for side in ("left", "right")} if refused else set()
    assert (found, decision.safe) == (wanted, not refused)
    if refused:
        assert refused in str(decision.faults[0])
        with pytest.raises(ValueError, match=refused):
            tm.line(given.signals["track"]["left"])


@BACKENDS
@pytest.mark.parametrize(
    "shape",
    [
        list,
        lambda array: [list(row) for row in array],
        lambda array: tuple(map(tuple, array)),
        lambda array: np.array([list(row) for row in array], dtype=object),
        lambda array: [[float(x), y] for x, y in array],
    ],
    ids=["list of arrays", "list of lists", "tuples", "array of objects", "one axis alone"],
)
def test_whatever_holds_them(shape: Callable[[Any], Any], backend: str) -> None:
    """A list of rows, or of numbers out of an array, is as short as the array was."""
    given = moved(5334572.35, np.float32)
    given.signals["track"]["left"] = shape(given.signals["track"]["left"])
    given.signals["track"]["right"] = given.signals["track"]["right"].astype(float).tolist()
    decision = tm.supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: 0.0).step(
        given
    )
    assert [(name_of(fault), fault.signal, fault.field) for fault in decision.faults] == [
        ("wrong_type", "track", "left")
    ]
    assert "float32 has no two numbers nearer than 0.5 m there" in str(decision.faults[0])
    assert not decision.safe
    with pytest.raises(ValueError, match=r"nearer than 0\.5 m"):
        tm.line(given.signals["track"]["left"])


@pytest.mark.parametrize("shape", [np.asarray, list, lambda array: [[float(x), y] for x, y in array]])
def test_places_that_data_brings_are_held_to_the_same(shape: Callable[[Any], Any]) -> None:
    """0.9 m from a line was 1.1 m from what float32 makes of it."""
    evaluator = tm.Evaluator(
        tm.loads(
            'module m\nsignal ego : state { x: m, y: m }\nline stop "s" = (0 m, 0 m) (10 m, 0 m)\n'
            "rule near\n  require distance_to(ego, stop) >= 1 m\n"
        )
    )
    north = 5300000.3
    stop = np.array([[0.0, north], [10.0, north]])
    signals = {"ego": {"x": 5.0, "y": north - 0.9}}
    assert not evaluator.case({"places": {"stop": stop}, "signals": signals}).safe
    with pytest.raises(
        tm.TrackmarshalError, match=r"places\.stop\[0\]: float32 has no two numbers"
    ) as caught:
        evaluator.case({"places": {"stop": shape(stop.astype(np.float32))}, "signals": signals})
    assert caught.value.code == "D204"
    near = (stop - [0.0, north]).astype(np.float32)
    assert not evaluator.case(
        {"places": {"stop": shape(near)}, "signals": {"ego": {"x": 5.0, "y": -0.9}}}
    ).safe


@BACKENDS
@pytest.mark.parametrize("shape", [np.asarray, list, lambda column: np.array(list(column), dtype=object)])
def test_trajectories_are_held_to_the_same(shape: Callable[[Any], Any], backend: str) -> None:
    """Both lead 5 cm beyond what the border leaves of the road, and float32 moves them by 15 cm: back to where there is room."""
    north, aside = 5334572.0, 4.65

    def driven(candidates: Callable[[Any], Any]) -> Decision:
        given = moved(north, np.float64)
        for columns in (given.driving, given.emergency):
            columns["y"] = candidates(columns["y"] + aside)
        given.signals["ego"]["y"] = float(given.driving["y"][0])
        return tm.supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: 0.0).step(
            given
        )

    assert not driven(lambda y: y).safe
    assert driven(
        lambda y: y.astype(np.float32).astype(float)
    ).safe  # of what has become doubles nobody knows
    decision = driven(lambda y: shape(y.astype(np.float32)))
    assert [(name_of(fault), fault.signal, fault.field) for fault in decision.faults] == [
        ("wrong_type", "driving", "y"),
        ("wrong_type", "emergency", "y"),
    ]
    assert "float32 has no two numbers nearer than 0.5 m there" in str(decision.faults[0])
    assert not decision.safe


@BACKENDS
@pytest.mark.parametrize("far", [False, True])
def test_whatever_else_has_a_place(far: bool, backend: str) -> None:
    """The car itself, a set of columns and one of records; near the origin, all may be short. What is no length may always be."""
    given = moved(5334572.0 if far else 0.0, np.float64)
    things = {"x": 300.0, "y": 8.0 + 5334572.0 * far, "heading": 0.0, "length": 0.4, "width": 0.4}
    given.signals["obstacles"] = [{"id": "c", **{name: np.float32(one) for name, one in things.items()}}]
    given.signals["ego"] = {name: np.float32(one) for name, one in given.signals["ego"].items()}
    other = {"x": 150.0, "y": 3.0 + 5334572.0 * far, "heading": 0.0, "v": 25.0, "length": 4.5, "width": 2.0}
    given.signals["objects"] = {name: np.array([one], np.float32) for name, one in other.items()}
    decision = tm.supervisor(shipped(), backend=backend, limits={"budget": 60.0}, clock=lambda: 0.0).step(
        given
    )
    found = {(name_of(fault), fault.signal, fault.field, fault.index) for fault in decision.faults}
    wanted = {("wrong_type", signal, "y", None) for signal in ("ego", "objects", "obstacles")}
    assert (found, decision.safe) == ((wanted, False) if far else (set(), True))


def test_lengths_are_held_to_it_in_whatever_unit() -> None:
    """A force of 1e9 N may be rounded to 64 N; 3000 km to 0.25 m may not."""
    evaluator = tm.Evaluator(
        tm.loads(
            "module m\nsignal ego : state { x: km, f: N }\n"
            "rule near\n  require ego.x <= 3000.0001 km and ego.f >= 0 N\n"
        )
    )
    x, f = np.array([3000.0002, 1.0]), np.array([1e9, 1e9], np.float32)
    assert evaluator.batch({"ego": {"x": x, "f": f}}).safe.tolist() == [False, True]
    with pytest.raises(tm.TrackmarshalError, match=r"float32 has no two numbers nearer than 0\.244141 m"):
        evaluator.batch({"ego": {"x": x.astype(np.float32), "f": f}})
    case = {"signals": {"ego": {"x": np.float32(3000.0002), "f": f[0]}}}
    with pytest.raises(tm.TrackmarshalError, match="float32 has no two numbers"):
        evaluator.case(case)
