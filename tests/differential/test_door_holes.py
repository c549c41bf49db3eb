"""Ways past the door that were open once, each by the surface that callers have, with each backend."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import trackmarshal as tm
from support.typed import of_no_unit
from trackmarshal.backends.c.build import compiler
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.faults import name_of

BACKENDS = pytest.mark.parametrize(
    "backend",
    [
        "reference",
        "numpy",
        pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
    ],
)
TEXT = """
module holes
signal plan : trajectory { t: s increasing default 0 s, x: m, y: m, heading: rad, v: m/s in [-10, 150] }
signal ego : state { x: m, y: m, heading: rad, age: s in [0, 1] default 0 s }
signal objects : set of object { x: m, y: m, v: m/s in [-50, 50], age: s default 0 s }
signal track : corridor { left: polyline, right: polyline }
param fast : m/s = 60 m/s in [0, 200]
param faster : m/s = 70 m/s in [0, 200]
constrain fast < faster because "else it is neither"

rule speed "Speed"
  for all p in plan
  require p.v <= fast

rule order "The last sample is the latest"
  for all p in plan
  require p.t <= 100 s

rule off_border "Whatever is seen is off the left border"
  for all o in objects
  require distance_to(o, track.left) >= 1 m

rule apart "Nothing is near"
  for all o in objects
  require o.x - ego.x >= 5 m + o.v * o.age
"""


@cache
def spec(text: str = TEXT) -> Spec:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "holes.spec"
        path.write_text(text, encoding="utf-8")
        return tm.load([path])


TRACK = {"left": [[-50.0, 9.0], [500.0, 9.0]], "right": [[-50.0, -9.0], [500.0, -9.0]]}


def cycle(number: int, t: Any) -> tm.Cycle:
    def plan() -> dict[str, Any]:
        return {"t": [0.0, 1.0], "x": [0.0, 1.0], "y": [0.0, 0.0], "heading": [0.0, 0.0], "v": [1.0, 0.0]}

    ego = {"x": 0.0, "y": 0.0, "heading": 0.0, "age": 0.0}
    objects = {"x": [50.0, 60.0], "y": [0.0, 1.0], "v": [1.0, 2.0], "age": [0.0, 0.0]}
    return tm.Cycle(number, t, plan(), plan(), {"ego": ego, "objects": objects, "track": dict(TRACK)})


class Run:
    def __init__(self, backend: str, **limits: Any) -> None:
        self.number = -1
        self.readings: list[Any] = []
        free = tm.Limits(budget=1e9, longest_gap=1e9, **limits)
        self.supervisor = tm.supervisor(spec(), backend=backend, limits=free, clock=self._clock)

    def _clock(self) -> float:
        reading = self.readings.pop(0) if self.readings else float(self.number)
        if isinstance(reading, Exception):
            raise reading
        return reading

    def step(self, change: Callable[[tm.Cycle], Any] = lambda c: c) -> Any:
        self.number += 1
        return self.supervisor.step(change(cycle(self.number, float(self.number))))


def names(decision: Any) -> set[tuple[str, str, str]]:
    return {(name_of(f), f.signal, f.field) for f in decision.faults}


def signals(**others: Any) -> Callable[[tm.Cycle], tm.Cycle]:
    return lambda given: replace(given, signals={**given.signals, **others})


@BACKENDS
@pytest.mark.parametrize("empty", [[], (), np.zeros((0, 2))])
@pytest.mark.parametrize("when", [0, 1, 2])
def test_empty_borders_where_nothing_asks_for_them(backend: str, empty: Any, when: int) -> None:
    """In the first cycle, and behind another one; rules ask for the track for no object."""
    run = Run(backend)
    nobody: dict[str, list[float]] = {name: [] for name in ("x", "y", "v")}
    for _ in range(when):
        assert run.step(signals(objects=nobody)).safe
    for _ in range(2):
        decision = run.step(signals(objects=nobody, track={"left": empty, "right": empty}))
        assert names(decision) == {("bad_border", "track", "left"), ("bad_border", "track", "right")}
        assert not decision.safe
    assert run.step(signals(objects=nobody)).safe


@BACKENDS
def test_what_a_mask_hides_is_missing(backend: str) -> None:
    run = Run(backend)
    for where, name in (("driving", "v"), ("emergency", "x"), ("objects", "v")):
        for kind in (float, int):

            def masked(given: tm.Cycle, where: str = where, name: str = name, kind: type = kind) -> tm.Cycle:
                own = getattr(given, where, None) or given.signals[where]
                column: Any = np.ma.array(np.array(own[name]).astype(kind), mask=[False, True])
                changed: dict[str, Any] = {where: {**own, name: column}}
                return signals(**changed)(given) if where == "objects" else replace(given, **changed)

            assert names(run.step(masked)) == {("not_finite", where, name)}
    track = {**TRACK, "left": np.ma.array(TRACK["left"], mask=[[False, False], [False, True]])}
    assert names(run.step(signals(track=track))) == {("not_finite", "track", "left")}
    assert run.step().safe


@BACKENDS
def test_stamps_of_every_kind(backend: str) -> None:
    run = Run(backend)
    for kind in (float, int, np.float64, np.float32, np.int64, np.uint8, np.array):
        decision = run.step(
            lambda given, kind=kind: replace(given, t=kind(int(given.t)), number=given.number)  # type: ignore[misc]
        )
        assert decision.safe, (kind, decision.reasons)
        assert (type(decision.t), decision.t) == (float, float(run.number))
    for kind in (int, np.int64, np.uint8, np.array):
        decision = run.step(lambda given, kind=kind: replace(given, number=kind(given.number)))  # type: ignore[misc]
        assert decision.safe, (kind, decision.reasons)
        assert (type(decision.number), decision.number) == (int, run.number)


@BACKENDS
def test_times_and_dates_are_no_numbers(backend: str) -> None:
    """numpy makes whole numbers of those of nanoseconds, and of those without a unit."""
    run = Run(backend)
    assert run.step().safe
    units: tuple[Literal["generic", "ns", "ps"], ...] = ("generic", "ns", "ps")
    for unit in units:
        seven = of_no_unit(run.number + 1) if unit == "generic" else np.timedelta64(run.number + 1, unit)
        bad = (
            (lambda given, t=seven: replace(given, t=t), ("wrong_type", "cycle", "t")),
            (lambda given, t=seven: replace(given, number=t), ("wrong_type", "cycle", "number")),
            (signals(ego={"x": seven, "y": 0.0, "heading": 0.0}), ("wrong_type", "ego", "x")),
            (
                signals(objects={"x": [50.0, seven], "y": [0.0, 0.0], "v": [1.0, 1.0]}),
                ("wrong_type", "objects", "x"),
            ),
            (
                signals(track={**TRACK, "left": [[-50.0, seven], [500.0, 9.0]]}),
                ("wrong_type", "track", "left"),
            ),
        )
        for change, expected in bad:
            fresh = Run(backend)
            fresh.number = run.number
            assert expected in names(fresh.step(change))
    for dtype in ("m8[ns]", "M8[ns]", "m8"):
        border = np.array([[-50, 9], [500, 9]]).astype(dtype)
        assert ("wrong_type", "track", "left") in names(
            Run(backend).step(signals(track={**TRACK, "left": border}))
        )


@BACKENDS
def test_arrays_with_fields_are_no_points(backend: str) -> None:
    """Whose first field need not be x."""
    border = np.array([(9.0, -50.0), (9.0, 500.0)], dtype=[("y", "f8"), ("x", "f8")])
    for given in (border, border.view(np.recarray)):
        assert names(Run(backend).step(signals(track={**TRACK, "left": given}))) == {
            ("wrong_type", "track", "left")
        }


class Refilled(Mapping[str, Any]):
    """Fills one array for every value that it is asked for, as whoever reads from a bus does."""

    def __init__(self, given: Mapping[str, Any]) -> None:
        self.given = given
        self.array = np.zeros(2)

    def __getitem__(self, name: str) -> Any:
        self.array[:] = self.given[name]
        return self.array

    def __iter__(self) -> Iterator[str]:
        return iter(self.given)

    def __len__(self) -> int:
        return len(self.given)


@BACKENDS
def test_a_mapping_that_fills_one_array(backend: str) -> None:
    run = Run(backend)
    plain = run.step()
    decision = run.step(
        lambda given: replace(given, driving=Refilled(given.driving), emergency=Refilled(given.emergency))
    )
    assert decision.safe, decision.reasons
    assert decision.driven.matrix.tobytes() == plain.driven.matrix.tobytes()
    wrong = run.step(lambda given: replace(given, driving=Refilled({**given.driving, "v": [61.0, 0.0]})))
    assert not wrong.safe


@BACKENDS
def test_an_order_that_is_left_to_its_default(backend: str) -> None:
    run = Run(backend)

    def without(given: tm.Cycle) -> tm.Cycle:
        return replace(given, driving={name: column for name, column in given.driving.items() if name != "t"})

    assert names(run.step(without)) == {("not_increasing", "driving", "t")}
    assert run.step().safe
    evaluator = Evaluator(spec(), None, backend)
    given = cycle(0, 0.0)
    plan = {name: column for name, column in given.driving.items() if name != "t"}
    frame = evaluator.read({"signals": {**given.signals, "plan": plan}})
    assert [f.code for f in frame.faults] == ["D214"]
    assert not next(iter(evaluator.evaluate([frame]))).safe


@BACKENDS
def test_columns_without_axes(backend: str) -> None:
    run = Run(backend)
    for value in (
        np.array(1.0),
        np.array(None),
        np.array([1.0, 0.0], dtype=object)[0:1].reshape(()),
        np.float64(1.0),
        1.0,
    ):
        for where in ("driving", "emergency"):
            decision = run.step(
                lambda given, w=where, v=value: replace(given, **{w: {**getattr(given, w), "v": v}})  # type: ignore[misc]
            )
            assert names(decision) == {("wrong_type", where, "v")}
            decision = run.step(
                lambda given, w=where, v=value: replace(given, **{w: dict.fromkeys(given.driving, v)})  # type: ignore[misc]
            )
            assert {name for name, _, _ in names(decision)} == {"wrong_type"}
    assert run.step().safe


@BACKENDS
@pytest.mark.parametrize("wrong", [math.nan, -1.0, math.inf, RuntimeError()])
def test_the_cycle_after_a_wrong_clock_is_as_good_as_any(backend: str, wrong: Any) -> None:
    run = Run(backend, blind=100.0)
    assert run.step().safe
    run.readings = [wrong]
    decision = run.step()
    assert ("bad_clock", "clock", "") in names(decision)
    assert not decision.safe
    after = run.step()
    assert after.safe, after.reasons


@BACKENDS
def test_numbers_that_no_float_holds(backend: str) -> None:
    run = Run(backend)
    for huge in (10**400, -(10**400), 2**1024):
        bad: list[tuple[Callable[[tm.Cycle], Any], tuple[str, str, str]]] = [
            (lambda given, h=huge: replace(given, driving={**given.driving, "x": [0.0, h]}), ("not_finite", "driving", "x")),  # type: ignore[misc]
            (signals(ego={"x": huge, "y": 0.0, "heading": 0.0}), ("not_finite", "ego", "x")),
            (signals(objects=[{"x": huge, "y": 0.0, "v": 0.0}]), ("not_finite", "objects", "x")),
            (signals(track={**TRACK, "right": [[huge, -9.0], [500.0, -9.0]]}), ("not_finite", "track", "right")),
            (lambda given, h=huge: replace(given, t=h), ("not_finite", "cycle", "t")),  # type: ignore[misc]
            (lambda given, h=huge: replace(given, number=h), ("out_of_range", "cycle", "number")),  # type: ignore[misc]
        ]  # fmt: skip
        for change, expected in bad:
            decision = Run(backend).step(change)
            assert names(decision) == {expected}
            assert not decision.safe
    assert run.step().safe


@BACKENDS
def test_names_that_are_almost_right(backend: str) -> None:
    run = Run(backend)
    for where, field in (("ego", "Age"), ("objects", "AGE"), ("track", "Left"), ("driving", "T")):

        def misspelt(given: tm.Cycle, where: str = where, field: str = field) -> tm.Cycle:
            own = dict(getattr(given, where, None) or given.signals[where])
            own[field] = 9 if where == "ego" else next(iter(own.values()))
            return replace(given, driving=own) if where == "driving" else signals(**{where: own})(given)

        decision = run.step(misspelt)
        assert names(decision) == {("unknown", where, field)}
        assert not decision.safe
    assert names(run.step(signals(Ego={}))) == {("unknown", "signals", "Ego")}
    assert run.step().safe


@BACKENDS
def test_names_of_cases_that_are_almost_right(backend: str) -> None:
    evaluator = Evaluator(spec(), None, backend)
    given = cycle(0, 0.0)
    good = {"id": 1, "signals": {**given.signals, "plan": given.driving}}
    assert next(iter(evaluator.evaluate([evaluator.read(good)]))).safe
    for key, value in {
        "PARAMS": {"fast": 0.5},
        "data": good["signals"],
        "zzz": 1,
        "note": "mine",
        "Tables": {},
    }.items():
        with pytest.raises(TrackmarshalError) as caught:
            evaluator.read({**good, key: value})
        assert caught.value.code == "D203"
        assert f"`{key}`" in caught.value.message
        assert caught.value.help
    for where, field in (("ego", "Age"), ("objects", "AGE"), ("plan", "T"), ("track", "LEFT")):
        own = {**good["signals"][where], field: 9}  # type: ignore[index]
        with pytest.raises(TrackmarshalError) as caught:
            evaluator.read({"signals": {**good["signals"], where: own}})  # type: ignore[dict-item]
        assert caught.value.code == "D203"
        assert f"`{field}`" in caught.value.message
        assert f"`{field.lower()}`" in str(caught.value.help)


@BACKENDS
def test_parameters_that_break_a_constraint(backend: str) -> None:
    """Whatever the rules say with them, it is not safe; and no Supervisor is made with them."""
    evaluator = Evaluator(spec(), None, backend)
    given = cycle(0, 0.0)
    raw = {"signals": {**given.signals, "plan": given.driving}}
    for params, safe in (
        ({}, True),
        ({"fast": 69.0}, True),
        ({"fast": 71.0}, False),
        ({"faster": 60.0}, False),
    ):
        (alone,) = evaluator.evaluate([evaluator.read({**raw, "params": params})])
        assert (alone.safe, len(alone.broken)) == (safe, 0 if safe else 1)
        assert all(rule.verdict == "satisfied" for rule in alone.rules.values())
        together = list(evaluator.evaluate(evaluator.read_all([raw, {**raw, "params": params}, raw])))
        assert [one.safe for one in together] == [True, safe, True]
        if not safe:
            with pytest.raises(TrackmarshalError) as caught:
                tm.supervisor(spec(), backend=backend, params=params)
            assert caught.value.code == "E403"
