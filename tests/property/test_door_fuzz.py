"""The door names what is wrong with a cycle that breaks the contract: never a crash, never a pass, always the field."""

from __future__ import annotations

import math
import os
import random
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.cycles import MUTATIONS, PERIOD, cycle, mutate
from support.supervised import shipped
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.contract import Contract, of_cycles
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.door.door import Admission, Door
from trackmarshal.runtime.faults import name_of

#: Cycles that each of four parts mutates; `make acceptance` sets 60,000, 240,000 together.
CYCLES = int(os.environ.get("TRACKMARSHAL_FUZZ_CYCLES", "190"))
PARTS = 4


@pytest.fixture(scope="module")
def spec() -> Spec:
    return shipped()


@pytest.fixture(scope="module")
def contract(spec: Spec) -> Contract:
    return of_cycles(spec, [rule for rule in spec.rules if rule.formula is not None])


def admit(door: Door, given: Cycle, now: float) -> Admission:
    """What a door says, asked at some step or other."""
    found = door.admit(7, given, now)
    assert found.about == 7
    assert list(found.faults) == found.frame.faults
    return found


def flawless(door: Door, number: int) -> int:
    """The number of a good cycle that was flawless: of this one, or of the one after it where the last mutation left something behind."""
    if admit(door, cycle(number), number * PERIOD).faults:
        number += 1
        assert not admit(door, cycle(number), number * PERIOD).faults
    return number


def check(door: Door, good: Cycle, bad: Cycle) -> list[tuple[str, str, str, int | None]]:
    """The faults of a bad cycle in the place of a good one; the one before it was flawless."""
    found = admit(door, bad, good.t).faults
    named = [(name_of(f), f.signal, f.field) for f in found]
    assert len(set(named)) == len(named)  # one of every kind in every field
    return [(name_of(f), f.signal, f.field, f.index) for f in found]


@pytest.mark.parametrize("part", range(PARTS))
def test_every_mutation_is_named_with_its_field(contract: Contract, part: int) -> None:
    rng = random.Random(20261121 + part)
    seen: Counter[str] = Counter()
    door = Door(contract, Limits())
    for run in range(CYCLES):
        if run % 500 == 0:
            door = Door(contract, Limits())
            number = 0
        number = flawless(door, number + 1) + 1
        good = cycle(number, rng.randrange(1, 6), rng.randrange(1, 4))
        bad, expected = mutate(rng, good)
        found = check(door, good, bad)
        assert any(
            name in expected.faults
            and signal == expected.signal
            and field in expected.fields
            and (expected.index is None or index == expected.index)
            for name, signal, field, index in found
        ), (run, expected, found)
        seen[expected.faults[0]] += 1
    assert len(seen) >= 16, seen
    assert all(callable(m) for m in MUTATIONS)


def test_unbroken_cycles_pass(contract: Contract) -> None:
    door = Door(contract, Limits())
    for number in range(300):
        found = admit(door, cycle(number, number % 33, number % 5), number * PERIOD)
        assert found.faults == ()
        assert (found.number, found.t) == (number, number * PERIOD)
        assert found.pose is not None
        assert (found.pose.t, found.pose.x) == (number * PERIOD, 20.0 * number * PERIOD)


#: Anything at all, nested, with what floats and containers have to offer.
ANYTHING = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=4) | st.binary(max_size=4),
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(
            st.sampled_from(["t", "x", "y", "v", "id", "ego", "plan", "left"]), inner, max_size=4
        )
        | st.tuples(inner, inner)
        | st.lists(st.floats(), max_size=4).map(np.array)
    ),
    max_leaves=12,
)


@given(ANYTHING, ANYTHING, ANYTHING, ANYTHING, ANYTHING)
def test_anything_at_all_is_refused_without_a_crash(
    contract: Contract, a: object, b: object, c: object, d: object, e: object
) -> None:
    door = Door(contract, Limits())
    assert admit(door, Cycle(a, b, c, d, e), 0.0).faults


@given(ANYTHING, st.sampled_from(["ego", "objects", "obstacles", "track"]))
def test_anything_as_one_signal(contract: Contract, value: object, name: str) -> None:
    good = cycle(3)
    bad = Cycle(3, good.t, good.driving, good.emergency, {**good.signals, name: value})
    faults = admit(Door(contract, Limits()), bad, good.t).faults
    empty = name in ("objects", "obstacles") and isinstance(value, list | tuple) and not value
    assert bool(faults) != empty
    assert all(f.signal == name for f in faults)


def test_what_passes_is_finite_and_what_was_handed_in(contract: Contract) -> None:
    door = Door(contract, Limits())
    given_cycle = cycle(0)
    given_cycle.signals["track"]["left"] = given_cycle.signals["track"]["left"].copy()
    found = admit(door, given_cycle, 0.0)
    assert found.faults == ()
    driving, emergency = found.frame.of("driving"), found.frame.of("emergency")
    assert driving.flag("emergency", "") is False
    assert emergency.flag("emergency", "") is True
    for name, column in given_cycle.driving.items():
        assert np.array_equal(driving.columns["plan"].column(name), column)
    assert np.array_equal(driving.columns["plan"].column("grip"), np.ones(30))
    given_cycle.driving["v"][3] = math.nan
    given_cycle.signals["track"]["left"][:] = math.nan
    assert np.isfinite(driving.columns["plan"].values).all()
    assert np.isfinite(driving.line("track", "left").points).all()


def test_what_a_door_was_handed_first_cannot_pass_for_something_else(contract: Contract) -> None:
    """No border has passed before the first one, none of no points, and none after another cycle's."""
    lists: dict[str, list[list[float]]] = {"left": [], "right": []}
    for borders in (lists, {"left": np.zeros((0, 2)), "right": np.zeros((0, 2))}):
        for before in (None, cycle(0)):
            door = Door(contract, Limits())
            if before is not None:
                admit(door, before, before.t)
            good = cycle(1, 0, 0)
            bad = Cycle(1, good.t, good.driving, good.emergency, {**good.signals, "track": borders})
            faults = admit(door, bad, good.t).faults
            assert [(name_of(f), f.signal, f.field) for f in faults] == [
                ("bad_border", "track", "left"),
                ("bad_border", "track", "right"),
            ]


def test_the_order_of_faults(contract: Contract) -> None:
    """Structure, number and stamp, candidates, everything else; in each signal as its fields are declared."""
    good = cycle(1)
    driving = {**good.driving, "v": [math.nan] * 30, "kappa": [7.0] * 30, "a": "?"}
    emergency = {**good.emergency, "t": good.emergency["t"][::-1].copy(), "s": [math.inf] * 30}
    objects = [{"id": "a", "x": 1.0}, {"x": 2.0, "zz": 1, "y": 2.0}]
    signals = {
        **good.signals,
        "objects": objects,
        "ego": {**good.signals["ego"], "v": 1e9, "x": math.nan},
        "trakc": 1,
    }
    door = Door(contract, Limits())
    assert not admit(door, cycle(0), 0.0).faults
    found = admit(door, Cycle(3, good.t, driving, emergency, signals), good.t + 0.2).faults
    assert [(name_of(f), f.signal, f.field, f.index) for f in found] == [
        ("wrong_type", "driving", "a", None), ("unknown", "signals", "trakc", None),
        ("unknown", "objects", "zz", 1), ("missing", "objects", "heading", 0), ("missing", "objects", "length", 0),
        ("missing", "objects", "v", 0), ("missing", "objects", "width", 0), ("missing", "objects", "y", 0),
        ("stale", "cycle", "t", None), ("skipped", "cycle", "number", None),
        ("not_increasing", "emergency", "t", 1), ("not_finite", "emergency", "s", 0),
        ("not_finite", "ego", "x", None), ("out_of_range", "ego", "v", None),
    ]  # fmt: skip
    assert [f.message for f in found if (f.signal, f.field) == ("objects", "length")] == [
        "it is not there, and 1 more"
    ]
