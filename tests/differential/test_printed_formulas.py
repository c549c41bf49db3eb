"""What is printed is what is evaluated: the MathML of shipped rules is read back, evaluated, and held against the reference.

The reader (`support.mathml`, `support.read_rules`) shares nothing with what prints. Definitions are called by their names in one pass, and written
out in the other.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from typing import Any

import pytest

from support.length import AT_LENGTH, amount
from support.read_rules import Machinery
from support.supervised import everything
from trackmarshal.backends.reference.evaluator import Reference
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import PlaceInfo
from trackmarshal.reading.data import data
from trackmarshal.reading.rule import read
from trackmarshal.reading.sheet import Sheet
from trackmarshal.reading.words.english import ENGLISH
from trackmarshal.runtime.frame import Frame
from trackmarshal.runtime.verdict import About, RuleResult

INPUTS, EXPANDED = amount(20, 100), 20
#: Rules over the run are held against the first cycle of one: what state machines, counts and windows come to there.
OVER_THE_RUN = ("R_G1", "R_I5", "one_move", "no_overtaking_under_yellow", "leaves_room")
#: Not covered: nothing can have been won, or lost, or asked before, in the first cycle.
LATER = ("gives_back", "A-GRIP-ATTAINED")
#: Nor these: they have several predicates of one kind, and what is printed does not tell the reader which one it has before it.
SEVERAL = ("takeup_border", "takeup_rest")
#: What made-up cycles hardly ever ask for: of several as many, one counts.
SELDOM = {"cut_in": 5, "leaves_room": 10}
_Numbers = Callable[[random.Random], Any]


def rules() -> list[str]:
    return [
        rule.name
        for rule in everything().rules
        if rule.typed is not None and rule.name not in (*LATER, *SEVERAL)
    ]


#: Every day, these are asked about many inputs, and all others about a few, by which what the reader does not know is noticed.
OFTEN, FEW = frozenset(rules()[::8]), 4


def trajectory(choose: random.Random, fields: tuple[str, ...]) -> dict[str, list[float]]:
    """Four samples of something that drives about, a little inconsistent."""
    columns: dict[str, list[float]] = {name: [] for name in fields}
    t, s, x, y = -choose.uniform(0.0, 0.15), 0.0, choose.uniform(-4.0, 2.0), choose.uniform(-1.5, 1.5)
    heading, v = choose.uniform(-0.2, 0.2), choose.choice((0.0, 5.0, 20.0, 60.0)) + choose.uniform(-1.0, 4.0)
    for _ in range(4):
        step = choose.choice((0.004, 0.5, 2.0, 3.0))
        sample = {
            "t": t, "s": s, "x": x, "y": y, "heading": heading, "kappa": choose.choice((0.0, 0.002, -0.02, 0.09, 0.095)), "v": v,
            "a": choose.choice((0.0, -6.0, 3.0, -30.0, -36.0, 12.0)) + choose.uniform(-0.5, 0.5), "grip": choose.choice((1.0, 0.6, 1.2)),
        }  # fmt: skip
        for name in fields:
            columns[name].append(sample[name])
        t, s = t + choose.uniform(0.02, 0.2), s + step * choose.choice((1.0, 1.0, 1.2))
        x, y = x + step * math.cos(heading), y + step * math.sin(heading)
        heading, v = heading + choose.uniform(-0.4, 0.4), max(-1.0, v + choose.uniform(-6.0, 2.0))
    return columns


def body(choose: random.Random) -> dict[str, Any]:
    return {
        "x": choose.uniform(-40.0, 40.0), "y": choose.uniform(-6.0, 6.0), "heading": choose.choice((0.0, 0.2, -1.0, 3.1)),
        "v": choose.choice((0.0, 10.0, 40.0)) + choose.uniform(-2.0, 5.0), "length": choose.uniform(0.2, 6.0), "width": choose.uniform(0.2, 3.0),
        "age": choose.choice((0.0, 0.05, 0.1, 0.2)),
    }  # fmt: skip


def vehicle_in_lane(choose: random.Random) -> dict[str, Any]:
    front = choose.uniform(-60.0, 60.0)
    left = choose.uniform(-4.0, 4.0)
    return {
        "vehicle": 0.0, "lane": float(choose.choice((1, 1, 2))), "front": front, "rear": front - 4.0, "left": left, "right": left - 1.8,
        "offset": left - 0.9, "heading": choose.uniform(-0.5, 2.0), "to_left": choose.choice((0.1, 0.5)), "to_right": choose.choice((0.1, 0.5)),
    }  # fmt: skip


def lanelet(choose: random.Random, number: int) -> dict[str, Any]:
    return {
        "number": float(number), "road": 1.0, "left": float(choose.choice((-1, 1, 2))), "right": float(choose.choice((-1, 1, 2))),
        **{name: choose.random() < 0.5 for name in ("left_along", "right_along", "main", "ramp", "shoulder", "limited")},
        "limit": choose.choice((10.0, 36.0)), "width": choose.choice((3.0, 3.75)),
    }  # fmt: skip


#: By signal, what a case has there; fields that a signal does not have are left out.
SIGNALS: dict[str, _Numbers] = {
    "ego": lambda choose: body(choose) | {"x": choose.uniform(-1.0, 4.0), "y": choose.uniform(-1.0, 1.0), "heading": choose.uniform(-0.3, 0.3)},
    "objects": lambda choose: [body(choose) for _ in range(choose.randint(1, 3))],
    "obstacles": lambda choose: [body(choose) for _ in range(choose.randint(1, 2))],
    "track": lambda _: {"left": [[-90.0, 5.0], [3.0, 5.5], [120.0, 40.0]], "right": [[-90.0, -5.0], [4.0, -4.0], [120.0, 26.0]]},
    "yellow_sectors": lambda choose: [{"from": start, "to": start + choose.uniform(5.0, 60.0)} for start in (choose.uniform(0.0, 140.0),)],
    "emergency": lambda choose: choose.random() < 0.9,
    "measured": lambda choose: {"ahead": choose.uniform(-15.0, 6.0), "left": choose.uniform(-15.0, 15.0)},
    "ego_vehicle": lambda _: {"number": 1.0},
    "vehicles": lambda choose: [
        {"number": float(k), "v": choose.choice((0.5, 2.0, 8.0, 12.0, 45.0)), "a": choose.uniform(-6.0, 1.0), "truck": choose.random() < 0.3}
        for k in range(1, choose.randint(3, 7))
    ],
    "own": lambda choose: [vehicle_in_lane(choose) | {"vehicle": float(k)} | ({"front": -40.0, "lane": 1.0} if k == 1 else {}) for k in range(1, 6)],
    "places": lambda choose: [vehicle_in_lane(choose) | {"vehicle": float(k), "lane": lane} for k in range(1, 6) for lane in (1.0, 2.0)],
    "occupied": lambda choose: [vehicle_in_lane(choose) | {"vehicle": float(k)} for k in range(1, 6)],
    "touched": lambda choose: [{"vehicle": float(choose.randint(1, 3)), "lanelet": float(choose.randint(1, 2))} for _ in range(3)],
    "lanelets": lambda choose: [lanelet(choose, 1), lanelet(choose, 2)],
}  # fmt: skip


def case(
    rule_reads: frozenset[tuple[str, str]], zones: tuple[PlaceInfo, ...], choose: random.Random
) -> dict[str, Any]:
    """What a rule reads, made up, in SI."""
    signals: dict[str, Any] = {}
    for name in sorted({signal for signal, _ in rule_reads}):
        declared = everything().signals.get(name)
        if declared is None:
            signals[name] = SIGNALS[name](choose)
            continue
        fields = tuple(field.name for field in declared.fields_)
        if declared.sequence:
            signals[name] = trajectory(choose, fields)
            if zones and "ego" not in signals:  # not far from where they begin
                x, y = choose.choice(choose.choice(zones).points)
                signals[name] |= {
                    "x": [x + each for each in signals[name]["x"]],
                    "y": [y + each for each in signals[name]["y"]],
                }
            continue
        made = SIGNALS[name](choose)
        if isinstance(made, list):
            signals[name] = [
                {"id": str(k), **{field: one[field] for field in fields}} for k, one in enumerate(made)
            ]
        else:
            signals[name] = {field: made[field] for field in fields}
    few = (
        {"many": 1.0} if ("vehicles", "v") in rule_reads and choose.random() < 0.8 else {}
    )  # of few vehicles, three are seldom in one lane
    return {"signals": signals, "params": few}


def said(evaluator: Evaluator, frame: Frame, name: str) -> tuple[RuleResult | About, tuple[str, ...]]:
    """What the reference says of one cycle, by itself or as the only one of a run."""
    if name not in OVER_THE_RUN:
        (case,) = evaluator.evaluate([frame])
        return case.rules[name], case.faults
    run = evaluator.over_run()
    case = run.step(frame)
    if case.rules[name].verdict != "open":
        return case.rules[name], case.faults
    return run.end()[name][-1], case.faults


@pytest.mark.parametrize(
    ("name", "expand"),
    [
        pytest.param(
            name, expand,
            marks=[pytest.mark.acceptance] if expand and name not in OFTEN else [],
            id=f"{name}-{'expanded' if expand else 'called'}",
        )
        for name in rules()
        for expand in (False, True)
    ],
)  # fmt: skip
def test_the_printed_formula_says_what_the_reference_says(name: str, expand: bool) -> None:
    rule = everything().rule(name)
    assert rule is not None
    reading = read(rule, everything(), None, expand)
    printed = data(Sheet(rule, ENGLISH, None, reading, None, None, ()))["formula"]
    assert bool(printed["definitions"]) is (not expand) or not read(rule, everything()).definitions
    evaluator = Evaluator(everything(), [name], "reference")
    choose = random.Random(name)
    seen: dict[str, int] = {}
    seldom = SELDOM.get(name, 1)
    enough = AT_LENGTH or name in OFTEN
    for _ in range(seldom * (EXPANDED if expand else INPUTS) if enough else FEW):
        made = case(rule.reads, reading.places, choose)
        frame = evaluator.read({"t": 0.0, **made} if name in OVER_THE_RUN else made)
        result, faults = said(evaluator, frame, name)
        assert not faults
        machinery = Machinery(printed, rule, Reference(evaluator.spec, frame), made)
        verdict, margin = machinery.verdict()
        assert verdict == result.verdict, made
        if not machinery.undefined and verdict != "inactive":
            assert margin == pytest.approx(result.margin, rel=1e-12, abs=1e-12), made
        seen[verdict] = seen.get(verdict, 0) + 1
    assert not enough or seen.get("satisfied", 0) + seen.get("violated", 0) >= sum(seen.values()) / (
        20 * seldom
    ), seen


def test_each_rule_that_is_over_the_run_is_named() -> None:
    from trackmarshal.ir.overrun import over_run

    remembering = {
        rule.name for rule in everything().rules if rule.formula is not None and over_run(rule.formula)
    }
    assert {*OVER_THE_RUN, *LATER} == remembering
