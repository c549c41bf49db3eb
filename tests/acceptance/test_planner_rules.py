"""The shipped rules on a real planner's output: what fires is so, by a computation that shares nothing with the engine, and what is so fires.

The planner's own limits count, with 1 % more of grip and drive. `make acceptance` looks at all cycles, the default suite at some.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import cache

import pytest

from support import planner_runs
from support.dense import car, compare, recording
from support.dense.facts import Facts, facts
from support.length import at_length
from support.shared import shared

pytestmark = pytest.mark.verifies("S-1-A-2", "S-1-A-4", "S-1-A-5")

ALLOWANCE = 0.01
#: The rules about taking up the emergency trajectory: docs/takeup.md, tests/acceptance/test_planner_takeup.py.
TAKE_UP: Collection[str] = ("take_up",)

SOME, ALL = 23, 1
EVERYTHING = [pytest.param(name, ALL, marks=pytest.mark.acceptance) for name in recording.NAMES]
CASES = [at_length("berlin", SOME), ("modena_cars", SOME), *EVERYTHING]


@cache
def read(name: str) -> recording.Recording:
    return recording.read(shared("data", "planner"), name)


@cache
def found(name: str, every: int) -> dict[tuple[int, str], Facts]:
    limits = car.read(shared("data", "planner", "ltpl_car.spec")).allowed(ALLOWANCE)
    return facts(read(name), limits, read(name).cycles[::every])


@cache
def table(name: str, every: int) -> compare.Table:
    run = planner_runs.run(name, ALLOWANCE, every)
    fired = {key: {firing.name for firing in firings} for key, firings in run.fired.items()}
    return compare.compare(read(name), found(name, every), fired, run.rules, TAKE_UP)


@pytest.mark.parametrize(("name", "every"), CASES)
def test_what_fires_is_so(name: str, every: int) -> None:
    """Alone, nothing fires but what is confirmed; in traffic, what is confirmed or what the planner itself warns of."""
    result = table(name, every)
    without = result.unconfirmed()
    if name in recording.ALONE:
        without |= {rule for (rule, _), row in result.rows.items() if row.warned}
    assert not without, f"\n{result}"


@pytest.mark.parametrize(("name", "every"), CASES)
def test_what_is_so_fires(name: str, every: int) -> None:
    assert not table(name, every).missed, f"\n{table(name, every)}"


@pytest.mark.parametrize(("name", "every"), [case for case in CASES if "cars" not in str(case)])
def test_alone_the_planner_keeps_to_its_limits(name: str, every: int) -> None:
    """What the whole comparison rests on: a planner that did nothing wrong."""
    physical = {
        "off the road",
        "friction",
        "drive",
        "radius",
        "fast",
        "backwards",
        "does not stop",
        "speed jumps",
    }
    assert not {fact for said in found(name, every).values() for fact in said.possible} & physical


@pytest.mark.acceptance
def test_every_contact_is_preceded_by_a_firing() -> None:
    """In the half second before two cars first touch, a rule about the other cars fires.

    Not in the cycle before: at 30.3 s on modena, the car is beside another one, its middle ahead, and cuts in; the other one counts as behind, which
    is exempt, until they touch at 30.6 s. What fired until 30.2 s had taken the car out of there.
    """
    contacts = 0
    for name in recording.NAMES:
        run, said = planner_runs.run(name, ALLOWANCE, ALL), found(name, ALL)
        touched = {index for index, candidate in said if "touches" in said[index, candidate].certain}
        for index in touched - {index + 1 for index in touched}:
            before = {
                firing.name
                for earlier in range(index - 5, index)
                for firing in run.fired.get((earlier, "driving"), ())
            }
            assert before & {"safe_gap", "safe_gap_oncoming", "safe_side"}, (name, index)
            contacts += 1
    assert contacts > 0, "the recordings have contacts"
