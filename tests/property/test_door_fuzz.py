"""The door names what is wrong with a cycle that breaks the contract: never a crash, never a pass, always the field."""

from __future__ import annotations

import math
import os
import random
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from support.cycles import MUTATIONS, PERIOD, cycle, mutate
from trackmarshal.evaluation import load
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.contract import Contract, contract_of
from trackmarshal.runtime.cycle import Cycle, Limits
from trackmarshal.runtime.door import Door
from trackmarshal.runtime.faults import name_of

ROOT = Path(__file__).resolve().parents[2]
#: Cycles that `make test` mutates; `make acceptance` sets a million.
CYCLES = int(os.environ.get("TRACKMARSHAL_FUZZ_CYCLES", "10000"))


@pytest.fixture(scope="module")
def spec() -> Spec:
    return load([ROOT / "specs" / "supervisor"])


@pytest.fixture(scope="module")
def contract(spec: Spec) -> Contract:
    return contract_of(spec, [rule for rule in spec.rules if rule.formula is not None])


def check(door: Door, good: Cycle, bad: Cycle) -> list[tuple[str, str, str, int | None]]:
    """The faults of a bad cycle in the place of a good one; the good one before it is flawless."""
    before = good.number - 1
    door.check(cycle(before - 1), (before - 1) * PERIOD)  # whatever the last mutation left behind
    assert not door.check(cycle(before), before * PERIOD)[0]
    found = door.check(bad, good.t)[0]
    return [(name_of(f), f.signal, f.field, f.index) for f in found]


def test_every_mutation_is_named_with_its_field(contract: Contract) -> None:
    rng = random.Random(20261121)
    seen: Counter[str] = Counter()
    door = Door(contract, Limits())
    for run in range(CYCLES):
        if run % 500 == 0:
            door = Door(contract, Limits())
            number = 0
        number += 3
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
        found, pose = door.check(cycle(number, number % 33, number % 5), number * PERIOD)
        assert found == []
        assert pose is not None
        assert (pose.t, pose.x) == (number * PERIOD, 20.0 * number * PERIOD)


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
    assert door.check(Cycle(a, b, c, d, e), 0.0)[0]


@given(ANYTHING, st.sampled_from(["ego", "objects", "obstacles", "track"]))
def test_anything_as_one_signal(contract: Contract, value: object, name: str) -> None:
    good = cycle(3)
    faults = Door(contract, Limits()).check(
        Cycle(3, good.t, good.driving, good.emergency, {**good.signals, name: value}), good.t
    )[0]
    empty = name in ("objects", "obstacles") and isinstance(value, list | tuple) and not value
    assert bool(faults) != empty
    assert all(f.signal == name for f in faults)


def test_what_passes_is_finite_and_what_was_handed_in(contract: Contract) -> None:
    door = Door(contract, Limits())
    given_cycle = cycle(0)
    assert door.check(given_cycle, 0.0)[0] == []
    driving, emergency = door.signals()
    assert driving["emergency"] is False
    assert emergency["emergency"] is True
    for name, column in given_cycle.driving.items():
        assert np.array_equal(driving["plan"][name], column)
    assert np.array_equal(driving["plan"]["grip"], np.ones(30))
    given_cycle.driving["v"][3] = math.nan
    assert np.isfinite(driving["plan"]["v"]).all()
