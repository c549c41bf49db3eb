"""Slips that leave a rule nothing to say are warned of, and what looks like them is not."""

from __future__ import annotations

import pytest

from trackmarshal.semantics.advice import bounds
from trackmarshal.semantics.compile import compile_text

HEAD = """module made
enum flag { green, yellow, red }
shape placed = { x: m }
signal ego : state { x: m, v: m/s in [-10, 150], age: s in [0, 10], flag: flag, lane: 1 in [1, 3] }
signal plan : trajectory { t: s increasing, v: m/s in [-10, 150], a: m/s^2 }
signal objects : set of object { x: m, v: m/s in [-10, 150], parked: bool }
signal few : set of object { x: m, v: m/s in [-10, 150] } capacity 4 forget 1 s
event yellow "y"
event blue "b"
param limit : m/s = 30 m/s in [0, 100]
param free : m/s = 30 m/s
table curve(x: m) -> m/s = linear clamp | 0 m: 3 m/s | 5 m: 4 m/s |
predicate ahead(o: placed) = o.x > ego.x
define gap(o: placed) -> m = abs(o.x - ego.x)
state light : { off, on } starts off
  becomes on when yellow
  becomes off when blue
state role : { near, far, gone } for each o in few starts near
  becomes far when o.x > 5 m
  becomes gone when o.x > 50 m
  becomes near when o.x < 1 m
"""
#: Clauses above `require`, the demand, and what is warned of.
SLIPS = {
    "a speed beyond the contract": ("for all o in objects where o.v > 200 m/s", "o.parked", "W305"),
    "the same in the demand": ("", "ego.v <= 200 m/s", "W306"),
    "and for or": ("for all o in objects where o.v > 20 m/s and o.v < 10 m/s", "o.parked", "W305"),
    "and for or, of one limit": ("for all o in objects where o.v > limit and o.v < limit", "o.parked", "W305"),
    "or for and": ("", "ego.v >= 10 m/s or ego.v <= 20 m/s", "W306"),
    "an interval turned round": ("for all p in plan where p.v in [20 m/s, 10 m/s]", "p.a < 1 m/s^2", "W305"),
    "a demand that is a condition": ("whenever ego.v > 20 m/s", "ego.v > 20 m/s", "W306"),
    "a condition that denies another": ("whenever yellow\n for all o in objects where not yellow", "o.parked", "W305"),
    "left out and asked for": ("for all o in objects where ahead(o)\n except ahead(o) \"x\"", "o.parked", "W306"),
    "left out twice": ("for all o in objects where not o.parked\n except o.parked \"x\"", "ahead(o)", "W305"),
    "one number on both sides": ("for all o in objects", "gap(o) <= gap(o)", "W306"),
    "no number is below its absolute one": ("", "abs(ego.x) >= 0 m", "W306"),
    "a square below 0": ("whenever ego.x^2 < 0 m^2", "yellow", "W305"),
    "a sine beyond 1": ("", "sin(ego.x / 1 m) <= 1.5", "W306"),
    "a difference and its sign": ("whenever ego.v > limit and ego.v - limit < 0 m/s", "yellow", "W305"),
    "two members at once": ("whenever ego.flag is red and ego.flag is green", "yellow", "W305"),
    "a count below 0": ("whenever count(o in objects where o.parked) < 0", "yellow", "W305"),
    "a count of cycles from 0 on": ("", "count(yellow, last: 3 s) >= 0", "W306"),
    "a count of what never holds": ("", "count(ego.v > 200 m/s, last: 3 s) <= 1", "W306"),
    "time that goes back": ("for all consecutive p, q in plan where q.t <= p.t", "q.a < 1 m/s^2", "W305"),
    "once what never holds": ("whenever once[0 s, 3 s] ego.v > 200 m/s", "yellow", "W305"),
    "a time in a state below 0": ("whenever time_in(light) < 0 s", "yellow", "W305"),
    "unless it is so": ("", "yellow implies yellow or blue", "W306"),
    "both sides of a choice": ("", "(if yellow then 3 m/s else 4 m/s) <= 5 m/s", "W306"),
    "a case of numbers": ("", "(case ego.flag { red: 0 m/s, else: 10 m/s }) <= 20 m/s", "W306"),
    "at once both": ("", "ego.v <= 10 m/s and ego.v >= 20 m/s", "W305"),
    "two states at once": ("whenever light is on and light is off", "yellow", "W305"),
    "two states of one object at once": ("for all o in few where role(o) is far\n except role(o) is near \"x\"", "o.v < 9 m/s", "W305"),
    "no state at all": ("whenever not (light is on) and not (light is off)", "yellow", "W305"),
    "what a state leaves over": ("whenever not (light is on)", "light is off", "W306"),
    "more than there is room for": ("whenever count(o in few where o.x > 3 m) > 4", "yellow", "W305"),
    "as many as there is room for": ("", "count(o in few) <= 4", "W306"),
    "a sum of as many as there is room for": ("", "sum(o.v for o in few) <= 600 m/s", "W306"),
    "a count of one cycle": ("", "count(rising(yellow), last: 0 s) <= 1", "W306"),
    "an exists inside": ("whenever exists o in objects where o.v > 200 m/s: ahead(o)", "yellow", "W305"),
}  # fmt: skip
FINE = {
    "the end of a range": ("for all o in objects where o.v >= 150 m/s", "o.parked"),
    "a demand at the end of a range": ("", "ego.v < 150 m/s"),
    "limits that touch": ("for all o in objects where o.v >= 20 m/s and o.v <= 20 m/s", "o.parked"),
    "a parameter that may be set to anything": ("", "ego.v <= free"),
    "a parameter in its range": ("for all o in objects where o.v > limit", "o.v <= 100 m/s"),
    "a table that may be replaced": ("", "curve(ego.x) <= 100 m/s"),
    "another object": (
        "whenever exists o in objects: o.v > 20 m/s",
        "exists o in objects: o.v < 10 m/s",
    ),
    "another time": ("whenever ego.v > 20 m/s", "once[0 s, 3 s] ego.v < 10 m/s"),
    "a window that does not begin now": ("whenever yellow", "once[1 s, 3 s] yellow"),
    "the cycle before": ("whenever yellow", "previous yellow"),
    "another sample": ("along plan as p\n whenever p.v > 20 m/s", "eventually p.v < 10 m/s"),
    "two samples": ("for all consecutive p, q in plan where p.v > 20 m/s", "q.v > 10 m/s"),
    "a denial that is said": ("whenever yellow", "false"),
    "nothing is sought in vain": ("exists o in objects", "o.v <= 150 m/s"),
    "a division through zero": ("", "ego.x / ego.v <= 1 s or ego.x / ego.v >= 2 s"),
    "what is left of a range": ("for all o in objects where ahead(o)\n except o.parked \"x\"", "o.v < 10 m/s"),
    "a whole number between": ("", "ego.lane > 1"),
    "a state of another object": ("for all o in few where role(o) is far", "exists q in few: role(q) is near"),
    "one of the states that are left": ("for all o in few where not (role(o) is far)", "role(o) is near"),
    "a state of before": ("whenever light is on", "previous (light is off)"),
    "all that there is room for": ("whenever count(o in few) >= 4", "yellow"),
    "a sum below that of all": ("", "sum(o.v for o in few) <= 599 m/s"),
    "a count of those without a capacity": ("", "count(o in objects) <= 4"),
    "a count of one cycle that may be it": ("", "count(yellow, last: 0 s) <= 0"),
    "a count of two cycles": ("", "count(yellow, last: 1 s) <= 1"),
    "not that member": ("whenever not (ego.flag is red)", "ego.flag is green"),
}  # fmt: skip


def warned(clauses: str, demand: str) -> list[str]:
    lines = "".join(f"  {clause.strip()}\n" for clause in clauses.splitlines())
    compiled = compile_text(
        f'{HEAD}rule r "r"\n{lines}  require {demand}\nrule asks "r"\n  require light is on\nrule also "r"\n  for all o in few\n  require role(o) is far\n'
    )
    assert compiled.errors == []
    return [found.code for found in compiled.found]


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_warned_of(slip: str) -> None:
    clauses, demand, code = SLIPS[slip]
    assert warned(clauses, demand) == [code]


@pytest.mark.parametrize("fine", FINE)
def test_what_can_hold_and_fail_is_not(fine: str) -> None:
    assert warned(*FINE[fine]) == []


def test_a_rule_that_is_too_large_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, "MOST", 4)
    assert warned("", "ego.v <= 200 m/s") == ["W306"]
    assert warned("", "ego.v + ego.v + ego.v + ego.v + ego.v <= 900 m/s") == []


def test_a_guard_of_a_state_is_looked_at() -> None:
    made = HEAD.replace("becomes on when yellow", "becomes on when yellow and not yellow")
    compiled = compile_text(
        f'{made}rule asks "r"\n  require light is on\nrule also "r"\n  for all o in few\n  require role(o) is far\n'
    )
    assert [(found.code, found.span.text) for found in compiled.found] == [("W305", "yellow and not yellow")]
