"""The rulebook for duels: made-up races, in which cars come, go, pass and are passed; every evaluator says the same in every cycle."""

from __future__ import annotations

import math
import random
from collections import Counter
from functools import cache
from typing import Any

import pytest

from support.length import amount
from support.shared import REPOSITORY
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator, load

SPEC = REPOSITORY / "specs" / "rulebooks" / "racing.spec"
RULES = ["one_move", "no_overtaking_under_yellow", "gives_back", "leaves_room"]
STEP = 0.1
#: Races in which every rule is kept, broken, and of no matter.
TELLING = (10, 12, 14, 19)
SEEDS = amount(TELLING, range(40))


@cache
def evaluator(backend: str) -> Evaluator:
    return Evaluator(load([SPEC]), RULES, backend)


def ring(radius: float, width: float, points: int = 90) -> dict[str, Any]:
    turn = [2 * math.pi * i / points for i in range(points)]
    left, right = (
        [[r * math.cos(a), r * math.sin(a)] for a in turn] for r in (radius - width / 2, radius + width / 2)
    )
    return {"left": left, "right": right, "closed": True}


def race(seed: int) -> list[dict[str, Any] | None]:
    """Some seconds of a race on a ring: each car has a speed and a line that change; a flag is shown now and then; cycles get lost."""
    r = random.Random(seed)
    # On the large one the road is as good as straight, and a line is kept or changed; on the small one all of it is a corner.
    radius, width = r.choice([80.0, 900.0]), r.choice([9.0, 14.0])
    track = ring(radius, width, 90 if radius < 100.0 else 360)
    cars: list[dict[str, Any]] = [
        {"id": name, "s": r.uniform(-15, 25), "d": r.uniform(-3, 3), "v": r.uniform(14, 26)} for name in "abc"
    ]
    me = {"s": 0.0, "d": 0.0, "v": r.choice([14.0, 26.0]), "across": 0.0}
    flag: list[dict[str, float]] = []
    cycles: list[dict[str, Any] | None] = []

    def pose(s: float, d: float) -> dict[str, float]:
        a = s / radius
        return {
            "x": (radius - d) * math.cos(a),
            "y": (radius - d) * math.sin(a),
            "heading": math.remainder(a + math.pi / 2, 2 * math.pi),
        }

    shown = r.random() < 0.8
    for k in range(50):
        if r.random() < 0.15:
            me["across"] = r.choice([0.0, 2.5, -2.5])
        if r.random() < 0.01 or (shown and k == 0):
            start = r.uniform(0, 6 * radius) if k else -0.5 * radius
            flag = (
                []
                if flag
                else [
                    {
                        "from": start % (2 * math.pi * radius),
                        "to": (start + 2.5 * radius) % (2 * math.pi * radius),
                    }
                ]
            )
        me["v"] = max(5.0, me["v"] + r.uniform(-1.5, 1.5))
        me["s"] += STEP * me["v"]
        me["d"] = max(-3.0, min(3.0, me["d"] + STEP * me["across"]))
        for car in cars:
            car["v"] = max(5.0, car["v"] + r.uniform(-1.5, 1.5))
            car["s"] += STEP * car["v"]
        here = pose(me["s"], me["d"])
        here["heading"] += math.atan2(me["across"], me["v"])
        steps = [0.25 * i for i in range(9)]
        plan = [pose(me["s"] + me["v"] * t, me["d"]) for t in steps]
        there = [c for c in cars if r.random() > 0.002]
        objects = [
            {"id": c["id"], **pose(c["s"], c["d"]), "v": c["v"], "length": 4.7, "width": 2.0, "age": 0.0}
            for c in there
        ]
        if r.random() < 0.01:
            cycles.append(None)
            continue
        v = math.nan if r.random() < 0.02 else me["v"]
        cycles.append(
            {
                "t": round(STEP * k, 3),
                "params": {"rulebooks.racing.give_back": 0.2},
                "signals": {
                    "ego": {**here, "v": v, "age": 0.0}, "objects": objects, "track": track,
                    "yellow_sectors": [{"id": str(n), **one} for n, one in enumerate(flag)],
                    "plan": {
                        "t": steps, "s": [me["v"] * t for t in steps], "v": [me["v"]] * 9, "a": [0.0] * 9, "kappa": [1 / radius] * 9,
                        "grip": [1.0] * 9, **{name: [p[name] for p in plan] for name in ("x", "y", "heading")},
                    },
                },
            }
        )  # fmt: skip
    return cycles


def said(backend: str, cycles: list[dict[str, Any] | None]) -> list[list[tuple[str, str]]]:
    one = evaluator(backend)
    run, found = one.over_run(), []
    for cycle in cycles:
        if cycle is None:
            run.missed()
            continue
        rules = run.step(one.read(cycle)).rules
        found.append(
            [(rules[n].verdict, "nan" if math.isnan(m := rules[n].margin) else float(m).hex()) for n in RULES]
        )
    return found


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
def test_all_evaluators_say_the_same() -> None:
    seen: Counter[str] = Counter()
    for seed in SEEDS:
        cycles = race(seed)
        numpy = said("numpy", cycles)
        assert said("c", cycles) == numpy
        if seed == 12:
            some = said("reference", cycles[:8])
            assert some == numpy[: len(some)]
        seen.update(f"{name} {verdict}" for row in numpy for name, (verdict, _) in zip(RULES, row))
    for name in RULES:  # races in which nothing happens would show nothing
        assert min(seen[f"{name} {verdict}"] for verdict in ("satisfied", "inactive")) >= 3, dict(seen)
        assert seen[f"{name} violated"] >= 3, dict(seen)


def under_yellow(ahead: list[float], radius: float = 300.0) -> list[dict[str, Any] | None]:
    """The whole lap is under a yellow flag; by cycle, how far ahead the only other car is."""
    cycles: list[dict[str, Any] | None] = []
    for k, lead in enumerate(ahead):
        poses = [
            {
                "x": radius * math.cos(s / radius),
                "y": radius * math.sin(s / radius),
                "heading": s / radius + math.pi / 2,
            }
            for s in (50.0 + 2.0 * k, 50.0 + 2.0 * k + lead, 52.0 + 2.0 * k)
        ]
        cycles.append(
            {
                "t": round(STEP * k, 3),
                "params": {"rulebooks.racing.give_back": 0.2},
                "signals": {
                    "ego": {**poses[0], "v": 20.0, "age": 0.0},
                    "objects": [{"id": "o", **poses[1], "v": 20.0, "length": 4.7, "width": 2.0, "age": 0.0}],
                    "track": ring(radius, 12.0), "yellow_sectors": [{"id": "0", "from": 10.0, "to": 10.0}],
                    "plan": {
                        "t": [0.0, STEP], "s": [0.0, 2.0], "v": [20.0] * 2, "a": [0.0] * 2, "kappa": [1 / radius] * 2,
                        "grip": [1.0] * 2, **{name: [poses[0][name], poses[2][name]] for name in ("x", "y", "heading")},
                    },
                },
            }
        )  # fmt: skip
    return cycles


HALF = math.pi * 300.0
#: How far ahead the other car is, and whether it was passed. At the half-lap mark, whoever pulls away is first ahead and then behind.
PASSED = {
    "past the half-lap mark": ([HALF - 3.0 + k for k in range(10)], False),
    "past it": ([3.0 - k for k in range(10)], True),
    "past it within a cycle, far": ([40.0, *[-40.0] * 9], True),
}


@pytest.mark.parametrize(
    "backend", ["reference", "numpy", pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))]
)  # fmt: skip
@pytest.mark.parametrize("way", PASSED)
def test_half_a_lap_away_nobody_is_passed(way: str, backend: str) -> None:
    ahead, passed = PASSED[way]
    verdicts = [row[RULES.index("gives_back")][0] for row in said(backend, under_yellow(ahead))]
    assert ("violated" in verdicts) is passed, verdicts
