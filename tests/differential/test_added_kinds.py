"""A kind of check that is added to the table is one of every door: of cases, of cycles with each backend, of generated C."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from support import typed
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import FieldType, SignalType
from trackmarshal.runtime.contract import KINDS, Condition, Kind
from trackmarshal.runtime.contract.checks import Constants
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.supervision import supervisor

BACKENDS = [
    "reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
]  # fmt: skip


def of(*names: str, **constants: float) -> Callable[[FieldType | SignalType], Constants | None]:
    """Constants for fields, or signals, of these names."""
    return lambda info: tuple(constants.items()) if info.name in names else None


#: Largest step between neighbours; numbers but not near zero; flags that have to be set; at most two elements; points not too far away.
STEEP = Kind("out_of_range", "step", Condition("fabs(x - before) <= most"), of("v", "w", most=2.0))
EDGE = Kind("out_of_range", "value", Condition("((x * x) > low) | (x == 0)"), of("load", "age", low=0.25))
SET = Kind("out_of_range", "value", Condition("x == 1"), of("ready", "on"))
FEW = Kind("over_capacity", "count", Condition("n <= few"), of("objects", few=2.0))
NEAR = Kind(
    "out_of_range",
    "point",
    Condition("fabs(x) <= far"),
    lambda info: (("far", 1000.0),) if info.kind == "polyline" else None,
)


@pytest.fixture(autouse=True)
def added() -> Iterator[None]:
    before = list(KINDS)
    KINDS.extend([STEEP, EDGE, SET, FEW, NEAR])
    yield
    KINDS[:] = before


def cycle(number: int, t: float) -> Cycle:
    """Nobody breaks them here."""
    return typed.complete(typed.cycle(number, t))


class Run:
    def __init__(self, backend: str) -> None:
        self.now = -1
        self.supervisor = supervisor(
            typed.spec(), backend=backend, limits=typed.LIMITS, clock=lambda: float(self.now)
        )

    def step(self, change: Callable[[Cycle], Cycle] = lambda c: c) -> Decision:
        self.now += 1
        return self.supervisor.step(change(cycle(self.now, float(self.now))))


Change = tuple[str, Callable[[Any], Any], tuple[str, str, str, int | None]]


def column(name: str, values: list[Any]) -> Callable[[Any], Any]:
    return lambda given: {**given, name: values}


def thrice(given: Any) -> Any:
    return {name: [*values, "c" if name == "id" else values[-1]] for name, values in given.items()}


CHANGES: list[Change] = [
    ("driving", column("v", [1.0, 3.5, 0.0]), ("out_of_range", "driving", "v", 1)),
    ("emergency", column("v", [1.0, 3.0, 0.0]), ("out_of_range", "emergency", "v", 2)),
    ("objects", column("w", np.array([3.0, 30.0])), ("out_of_range", "objects", "w", 1)),  # type: ignore[arg-type]
    ("objects", column("age", [1.0, 0.4]), ("out_of_range", "objects", "age", 1)),
    ("car", column("load", -0.5), ("out_of_range", "car", "load", None)),  # type: ignore[arg-type]
    ("emergency", column("ready", [True, True, False]), ("out_of_range", "emergency", "ready", 2)),
    ("car", column("on", False), ("out_of_range", "car", "on", None)),  # type: ignore[arg-type]
    ("objects", thrice, ("over_capacity", "objects", "", None)),
    ("track", column("left", [[-50.0, 9.0], [1000.5, 9.0]]), ("out_of_range", "track", "left", 1)),
    ("border", lambda _: [[0.0, 0.0], [1.0, 1.0], [2.0, -1000.5]], ("out_of_range", "border", "", 2)),
]  # fmt: skip


@pytest.mark.parametrize("backend", BACKENDS)
def test_doors_of_cycles(backend: str) -> None:
    run = Run(backend)
    assert run.step().safe
    for where, change, expected in CHANGES:

        def changed(given: Cycle, where: str = where, change: Callable[[Any], Any] = change) -> Cycle:
            if where in ("driving", "emergency"):
                return replace(given, **{where: change(getattr(given, where))})
            return replace(given, signals={**given.signals, where: change(given.signals[where])})

        decision = run.step(changed)
        assert not decision.safe
        assert [(name_of(f), f.signal, f.field, f.index) for f in decision.faults] == [expected], (
            decision.reasons
        )
        assert run.step().safe


@pytest.mark.parametrize("together", [1, 3])
@pytest.mark.parametrize("backend", BACKENDS)
def test_the_door_of_cases(backend: str, together: int) -> None:
    """Also where many cases are read at once."""
    given = cycle(0, 0.0)
    signals = {**given.signals, "plan": given.driving}
    evaluator = Evaluator(typed.spec(), None, backend)
    good = evaluator.read_all([{"signals": signals}] * together)
    assert [frame.faults for frame in good] == [[]] * together
    assert all(result.safe for result in evaluator.evaluate(good))
    for where, change, (name, signal, field, index) in CHANGES:
        where, signal = ("plan", "plan") if where in ("driving", "emergency") else (where, signal)
        raw = {"signals": {**signals, where: change(signals[where])}}
        for frames in (
            evaluator.read_all([raw] * together),
            evaluator.read_all([{"signals": signals}] * (together - 1) + [raw]),
        ):
            assert [(name_of(f), f.signal, f.field, f.index) for f in frames[-1].faults] == [
                (name, signal, field, index)
            ]
            assert not list(evaluator.evaluate(frames))[-1].safe


@pytest.mark.parametrize("backend", BACKENDS)
def test_a_value_on_the_edge(backend: str) -> None:
    """Exactly as much as the kind allows, and the next double."""
    run = Run(backend)
    for value, safe in (
        (3.0, True),
        (math.nextafter(3.0, 4.0), False),
        (-1.0, True),
        (-1.0 - 2.0**-51, False),
    ):
        decision = run.step(
            lambda given, v=value: replace(given, driving={**given.driving, "v": [1.0, v, 1.0]})  # type: ignore[misc]
        )
        assert decision.safe == safe, (value, decision.reasons)
