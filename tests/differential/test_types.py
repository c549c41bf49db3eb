"""The table of types in docs/supervisor.md, line by line, place by place, with each backend."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from support import typed
from support.length import shared_out
from trackmarshal.backends.c.build import compiler
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.runtime.cycle import Cycle
from trackmarshal.runtime.decision import Decision
from trackmarshal.runtime.faults import name_of
from trackmarshal.supervision import supervisor

BACKENDS = [
    "reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
]  # fmt: skip
TABLE = typed.table()


def test_every_line_has_examples_and_every_example_a_line() -> None:
    assert TABLE.keys() == typed.EXAMPLES.keys()
    assert all(typed.EXAMPLES.values())


def test_the_page_speaks_of_every_place_and_of_no_other() -> None:
    places = {place.name for place in typed.PLACES}
    spoken = {place for taken, refused in TABLE.values() for place in (*taken, *refused)}
    assert spoken == places
    assert all(not taken & refused.keys() for taken, refused in TABLE.values())


class Run:
    """A Supervisor that gets one cycle after the other, numbered as it wants them."""

    def __init__(self, backend: str, variant: str = "lists") -> None:
        self.now = self.number = 0
        self.variant = variant
        self.supervisor = supervisor(
            typed.spec(variant), backend=backend, limits=typed.LIMITS, clock=lambda: float(self.now)
        )

    def step(self, change: Callable[[Cycle], Cycle]) -> Decision:
        self.now += 1
        given = change(typed.complete(typed.cycle(self.number, float(self.now), self.variant)))
        decision = self.supervisor.step(typed.arrayed(given) if self.variant == "arrays" else given)
        if not any(fault.signal == "cycle" for fault in decision.faults):
            self.number += 1
        return decision


def said(decision: Decision) -> tuple[Any, ...]:
    """What was made of the numbers: margins to the bit, and the trajectory that is driven."""
    assert decision.judged is not None
    assert decision.driven is not None
    margins = [tuple(map(float.hex, map(float, rated.margins))) for rated in decision.judged.rated.values()]
    return margins, decision.driven.names, decision.driven.matrix.tobytes()


@pytest.mark.parametrize(
    ("what", "variant", "backend"), shared_out(product(TABLE, typed.VARIANTS, BACKENDS), 7)
)
def test_a_line_of_the_table(what: str, variant: str, backend: str) -> None:
    taken, refused = TABLE[what]
    run = Run(backend, variant)
    plain = said(run.step(lambda given: given))
    assert said(run.step(typed.records)) == plain
    for example in typed.EXAMPLES[what]:
        for place in typed.places(variant):
            handed: list[Any] = []

            def put(given: Cycle, place: typed.Place = place, example: typed.Example = example) -> Cycle:
                handed.append(example.of(given, place))  # noqa: B023 - called at once
                return typed.put(given, place, handed[0])  # noqa: B023

            decision = run.step(put)
            shown = f"{what} ({type(handed[0]).__name__}) as {place.name} {place.at}: {decision.reasons}"
            if place.name in taken:
                assert decision.safe, shown
                assert said(decision) == plain, shown
                continue
            expected = refused.get(place.name, "wrong_type")
            found = {(name_of(fault), fault.signal, fault.field) for fault in decision.faults}
            assert not decision.safe, shown
            assert (expected, *place.told) in found, shown
            if place.told != ("signals", ""):  # without them, all of them are missing
                assert {name for name, _, _ in found} == {expected}, shown


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("variant", typed.VARIANTS)
def test_what_is_left_out_is_counted_or_has_its_default(variant: str, backend: str) -> None:
    run = Run(backend, variant)
    plain = said(run.step(lambda given: given))

    def without(given: Cycle) -> Cycle:
        objects = [
            {name: value for name, value in one.items() if name != "id"}
            for one in typed.records(given).signals["objects"]
        ]
        objects[1]["id"] = None
        emergency = {name: column for name, column in given.emergency.items() if name != "grip"}
        ego = {name: value for name, value in given.signals["ego"].items() if name != "age"}
        return replace(given, emergency=emergency, signals={**given.signals, "objects": objects, "ego": ego})

    assert said(run.step(without)) == plain


@pytest.mark.parametrize("backend", BACKENDS)
def test_nobody_is_there_in_arrays_without_entries(backend: str) -> None:
    """Of an empty list numpy makes an array of floats, whatever the column is of."""

    def nobody(given: Cycle) -> Cycle:
        objects = {name: np.array([]) for name in given.signals["objects"]}
        return replace(given, signals={**given.signals, "objects": objects})

    decision = Run(backend).step(nobody)
    assert decision.safe, decision.reasons


def test_an_array_of_numbers_is_none_of_booleans() -> None:
    evaluator = Evaluator(loads('module m\nsignal ego : state { on: bool }\nrule a "" require ego.on\n'))
    with pytest.raises(
        TrackmarshalError, match=r"ego\.on\[0\]: a number is neither true nor false"
    ) as caught:
        evaluator.batch({"ego": {"on": np.array([1.0, 0.0])}})
    assert caught.value.help is not None
    assert "of bool" in caught.value.help
