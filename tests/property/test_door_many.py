"""Cycles that are admitted together are what they are one by one: frames, faults, poses."""

from __future__ import annotations

import random
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from support.cycles import cycle, mutate
from support.supervised import shipped
from trackmarshal.runtime.contract import Contract, of_cycles
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.door.door import Admission, Door

ROOT = Path(__file__).resolve().parents[2]
ALSO = frozenset({"driving.jerk", "emergency.jerk", "objects.colour", "mood"})


@pytest.fixture(scope="module")
def contract() -> Contract:
    spec = shipped()
    return of_cycles(spec, [rule for rule in spec.rules if rule.formula is not None])


def listed(given: Cycle, extra: bool) -> Cycle:
    """A cycle as a recording has it: lists, and records of elements, some with names that the spec does not have."""
    signals = dict(given.signals)
    for name in ("objects", "obstacles"):
        columns = {key: np.asarray(column).tolist() for key, column in signals[name].items()}
        signals[name] = [dict(zip(columns, values)) for values in zip(*columns.values())]
    plans = [
        {key: column.tolist() for key, column in plan.items()} for plan in (given.driving, given.emergency)
    ]
    if extra:
        for plan in plans:
            plan["jerk"] = [0.0] * len(plan["t"])
        signals["objects"] = [{**one, "colour": 1.0} for one in signals["objects"]]
        signals["mood"] = 1.0
    return replace(given, driving=plans[0], emergency=plans[1], signals=signals, also=ALSO)


def seen(found: Admission) -> Any:
    """All that anybody sees of an admission."""
    frame = found.frame
    columns = [
        (where, name, each.values.tobytes(), each.count, each.ids, each.absent, each.names.rows)
        for where, of in (("candidate", frame.candidates), ("signal", frame.columns))
        for name, each in of.items()
    ]
    lines = [(place, line.points.tobytes()) for place, line in frame.lines.items()]
    return (
        columns,
        lines,
        frame.events,
        frame.closed,
        frame.faults,
        found.faults,
        found.pose,
        found.number,
        found.t,
    )


def test_admitted_together_and_one_by_one(contract: Contract) -> None:
    rng = random.Random(20261123)
    limits = replace(Limits(), oldest=1e9, clock_tolerance=1e9)
    given: list[Cycle] = []
    for number in range(300):
        good = cycle(number, rng.randrange(0, 4), rng.randrange(0, 3))
        kind = rng.random()
        if kind < 0.3:
            given.append(good)
        elif kind < 0.7:
            given.append(listed(good, extra=kind < 0.5))
        elif kind < 0.8:  # a name that nobody knows
            given.append(replace(listed(good, extra=True), also=frozenset({"mood"})))
        else:
            given.append(mutate(rng, cycle(number, rng.randrange(1, 4), rng.randrange(1, 3)))[0])
    single, many = Door(contract, limits), Door(contract, limits)
    by_one = [single.admit(-1, one, one.t) for one in given]
    together: list[Admission] = []
    while len(together) < len(given):
        size = rng.choice((1, 2, 7, 40))
        together += many.admit_all(given[len(together) : len(together) + size])
    assert sum(bool(found.faults) for found in by_one) > 40
    assert sum(not found.faults for found in by_one) > 100
    for one, other in zip(by_one, together, strict=True):
        assert seen(one) == seen(other)
    assert single.last == many.last


def test_what_is_known_besides_excuses_nothing_that_is_declared(contract: Contract) -> None:
    """A recording may name fields that rules of another project read; what is wrong with one of ours is wrong."""
    rng = random.Random(20261128)
    limits = replace(Limits(), oldest=1e9, clock_tolerance=1e9)
    also = frozenset(
        f"{name}.{field}"
        for name, columns in cycle(0).signals.items() if name != "track" for field in columns
    ) | {f"{name}.{field}" for name in ("driving", "emergency") for field in cycle(0).driving}  # fmt: skip
    told = 0
    for number in range(150):
        given = mutate(rng, cycle(number, 2, 2))[0]
        plain, excused = (Door(contract, limits).admit(-1, one, given.t) for one in (given, replace(given, also=also)))  # fmt: skip
        assert excused.faults == plain.faults
        told += bool(plain.faults)
    assert told > 50


def test_what_was_admitted_together_stays_as_it_is(contract: Contract) -> None:
    """Whatever a caller does to its lists later, and nobody writes to a plan."""
    given = [listed(cycle(number), extra=False) for number in range(3)]
    found = Door(contract, Limits()).admit_all(given)
    before = [seen(one) for one in found]
    for one in given:
        one.driving["x"][0] = 99.0
        one.signals["objects"][0]["x"] = 99.0
    assert [seen(one) for one in found] == before
    with pytest.raises(ValueError, match="read-only"):
        found[0].frame.candidates["driving"].values[0, 0] = 1.0
