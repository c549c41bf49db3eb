"""What is demanded of a cycle as a whole, at its limits and one step beyond, as docs/supervisor.md says it: both doors have the same conditions, and no
comparison of them would show one that is wrong."""

from __future__ import annotations

import math
from typing import Any

import pytest

from trackmarshal.runtime.contract import cycles
from trackmarshal.runtime.cycle import Limits
from trackmarshal.runtime.door.door import holds
from trackmarshal.runtime.supervisor import watch

#: All numbers here are whole multiples of powers of two: what is equal is equal.
LIMITS = Limits(
    shortest_gap=0.25, longest_gap=0.5, oldest=0.5, clock_tolerance=0.125, budget=0.5, start_distance=0.5, start_turn=0.25, start_speed=0.5,
    rest_speed=0.125, beside=1.5, turned=0.25, overspeed=4.0, blind=0.5,
)  # fmt: skip
NAN, BEYOND = math.nan, 2.0**-20

STAMP = {"t": 10.0, "now": 10.0, "begun": 1, "since": 0.5}
FIRST = {"begun": 0, "since": 0.0}
NUMBER = {"begun": 1, "number": 7, "last": 6}
START = {"dx": 0.0, "dy": 0.0, "turn": 0.0, "faster": 0.0}
STORED = {"now": 10.0, "end": 12.0, "posed": 1, "paced": 1, "away": 0.0, "turn": 0.0, "speed": 8.0, "planned": 8.0, "confirmed": 10.0}  # fmt: skip


@pytest.mark.parametrize(
    ("rows", "given", "changed", "faults"),
    [
        (cycles.STAMP, STAMP, {}, ""),
        (cycles.STAMP, STAMP, FIRST, ""),
        (cycles.STAMP, STAMP, {"since": 0.25}, "repeated"),
        (cycles.STAMP, STAMP, {"since": 0.25 + BEYOND}, ""),
        (cycles.STAMP, STAMP, {"since": 0.0}, "repeated out_of_order"),
        (cycles.STAMP, STAMP, {"since": -0.25}, "repeated out_of_order"),
        (cycles.STAMP, STAMP, {"since": -0.25 - BEYOND}, "out_of_order"),
        (cycles.STAMP, STAMP, {"t": 10.125}, ""),
        (cycles.STAMP, STAMP, {"t": 10.125 + BEYOND}, "early"),
        (cycles.STAMP, STAMP, {"now": NAN}, ""),
        (cycles.STAMP, STAMP, {"now": NAN, "since": 0.5 + BEYOND}, "early"),
        (cycles.STAMP, STAMP, {"now": NAN, **FIRST}, "early"),
        (cycles.STAMP, STAMP, {"t": -math.inf, **FIRST}, "not_finite"),
        (cycles.STAMP, STAMP, {"t": math.inf, **FIRST}, "not_finite early"),
        (cycles.TIMELY, STAMP, {"since": 0.5}, ""),
        (cycles.TIMELY, STAMP, {"since": 0.5 + BEYOND}, "late"),
        (cycles.TIMELY, STAMP, {"since": 0.5 + BEYOND, "begun": 0}, ""),
        (cycles.TIMELY, STAMP, {"now": 10.5}, ""),
        (cycles.TIMELY, STAMP, {"now": 10.5 + BEYOND}, "stale"),
        (cycles.TIMELY, STAMP, {"now": NAN}, ""),
        (cycles.COUNTED, STAMP, {"t": 1.0, "since": 1.0 - 0.999999999}, "repeated"),
        (cycles.COUNTED, STAMP, {"t": 1.0, "since": 1.0 - 0.999999998}, ""),
        (cycles.NUMBER, NUMBER, {}, ""),
        (cycles.NUMBER, NUMBER, {"number": 6}, "repeated out_of_order"),
        (cycles.NUMBER, NUMBER, {"number": 5}, "out_of_order"),
        (cycles.NUMBER, NUMBER, {"number": 8}, "skipped"),
        (cycles.NUMBER, NUMBER, {"number": 8, "begun": 0, "last": 0}, ""),
        (cycles.START, START, {"dx": -0.5}, ""),
        (cycles.START, START, {"dx": 0.5 + BEYOND}, "x"),
        (cycles.START, START, {"dy": 0.5}, ""),
        (cycles.START, START, {"dy": -0.5 - BEYOND}, "y"),
        (cycles.START, START, {"dx": 0.4375, "dy": -0.4375}, "x"),
        (cycles.START, START, {"dx": 0.25, "dy": 0.75}, "y"),
        (cycles.START, START, {"turn": 0.25}, ""),
        (cycles.START, START, {"turn": -0.25 - BEYOND}, "heading"),
        (cycles.START, START, {"turn": 0.25 + BEYOND}, "heading"),
        (cycles.START, START, {"turn": math.tau}, ""),
        (cycles.START, START, {"turn": math.pi}, "heading"),
        (cycles.START, START, {"faster": 0.5}, ""),
        (cycles.START, START, {"faster": -0.5}, ""),
        (cycles.START, START, {"faster": 0.5 + BEYOND}, "v"),
        (cycles.START, START, {"faster": -0.5 - BEYOND}, "v"),
        (cycles.END, {"last": 0.125}, {}, ""),
        (cycles.END, {"last": 0.125 + BEYOND}, {}, "v"),
        (cycles.END, {"last": -0.125}, {}, ""),
        (cycles.END, {"last": -0.125 - BEYOND}, {}, "v"),
        (cycles.STORED, STORED, {}, ""),
        (cycles.STORED, STORED, {"now": 12.0, "confirmed": 12.0}, ""),
        (cycles.STORED, STORED, {"now": 12.0 + BEYOND, "confirmed": 12.0}, "expired"),
        (cycles.STORED, STORED, {"now": NAN}, "unconfirmed"),
        (cycles.STORED, STORED, {"away": 1.5}, ""),
        (cycles.STORED, STORED, {"away": 1.5 + BEYOND}, "apart"),
        (cycles.STORED, STORED, {"away": math.inf, "turn": NAN}, "apart"),
        (cycles.STORED, STORED, {"turn": -0.25}, ""),
        (cycles.STORED, STORED, {"turn": 0.25 + BEYOND}, "apart"),
        (cycles.STORED, STORED, {"turn": -0.25 - BEYOND}, "apart"),
        (cycles.STORED, STORED, {"turn": -math.tau}, ""),
        (cycles.STORED, STORED, {"speed": 12.0}, ""),
        (cycles.STORED, STORED, {"speed": 12.0 + BEYOND}, "too_fast"),
        (cycles.STORED, STORED, {"planned": 50.0}, ""),
        (cycles.STORED, STORED, {"speed": -4.0}, ""),
        (cycles.STORED, STORED, {"speed": -4.0 - BEYOND}, "too_fast"),
        (cycles.STORED, STORED, {"speed": -12.0, "planned": -8.0}, ""),
        (cycles.STORED, STORED, {"speed": -12.0 - BEYOND, "planned": -8.0}, "too_fast"),
        (cycles.STORED, STORED, {"speed": -8.0, "planned": -50.0}, ""),
        (cycles.STORED, STORED, {"speed": 4.0, "planned": -8.0}, ""),
        (cycles.STORED, STORED, {"speed": 4.0 + BEYOND, "planned": -8.0}, "too_fast"),
        (cycles.STORED, STORED, {"speed": NAN}, "too_fast"),
        (cycles.STORED, STORED, {"planned": NAN}, "too_fast"),
        (cycles.STORED, STORED, {"speed": 1.0, "planned": NAN}, "too_fast"),
        (cycles.STORED, STORED, {"speed": 19.0, "paced": 0}, ""),
        (cycles.STORED, STORED, {"away": 9.0, "turn": 9.0, "speed": 19.0, "posed": 0}, ""),
        (cycles.STORED, STORED, {"confirmed": 9.5}, ""),
        (cycles.STORED, STORED, {"confirmed": 9.5 - BEYOND}, "unconfirmed"),
        (cycles.STORED, STORED, {"confirmed": -math.inf}, "unconfirmed"),
    ],
)  # fmt: skip
def test_at_a_limit_and_beyond(
    rows: tuple[cycles.Demand, ...], given: dict[str, Any], changed: dict[str, Any], faults: str
) -> None:
    """Of what is demanded of candidates, which have one fault for several fields, the field."""
    fields = rows in (cycles.START, cycles.END)
    found = [
        each.field if fields else each.fault for each in rows if not holds(each, {**given, **changed}, LIMITS)
    ]
    assert found == faults.split()


@pytest.mark.parametrize(
    ("now", "finished", "late"),
    [(10.0, 10.5, False), (10.0, 10.5 + BEYOND, True), (NAN, 10.0, True), (10.0, NAN, True), (10.0, math.inf, True)],
)  # fmt: skip
def test_a_verdict_is_in_time_up_to_the_budget(now: float, finished: float, late: bool) -> None:
    found = watch(3, now, finished, LIMITS)
    assert (found.about, found.late is not None) == (3, late)
