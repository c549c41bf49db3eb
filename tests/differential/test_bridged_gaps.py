"""State machines that bridge gaps: short ones leave them as they were, longer ones as the language has it; every evaluator says the same."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator
from typing import Any

import pytest

from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import Evaluator, loads

C = pytest.param("c", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"))
BACKENDS = ("reference", "numpy", C)
#: Who came near from behind is a rival until it is far; the bridge is `BRIDGES` nanoseconds. `told` asks for the state, `long` for what is kept.
SPEC = """module t
signal objects : set of object {{ x: m }} {lasting}
event flag

state shown : {{ clear, caution }} starts clear bridges 0.3 s
  becomes caution when flag
  becomes clear when not flag

state role : {{ none, near, far }} for each o in objects starts none bridges 0.3 s
  becomes near from none, far when o.x in [0 m, 2 m]
    remember place = o.x
  becomes far from near when o.x > 6 m
  becomes none from near, far when o.x < -6 m

rule told "x"
  for all   o in objects
  require   not (role(o) is near)

rule long "x"
  for all   o in objects where role(o) is near
  require   time_in(role(o)) <= 0.5 s and role(o).place <= 1 m

rule waved "x"
  require   shown is clear implies time_in(shown) <= 0.4 s
"""
BRIDGES = 300_000_000
#: From each state, where ways lead that nobody saw.
LEADS = {"none": ("near",), "near": ("far", "none"), "far": ("near", "none")}


def step(state: str, x: float) -> str:
    if state != "near" and 0 <= x <= 2:
        return "near"
    if state == "near" and x > 6:
        return "far"
    return "none" if state != "none" and x < -6 else state


#: A world: the state, since when, and the place that is remembered; None: nobody knows.
World = tuple[str, int | None, float | None]


def told(seen: list[tuple[int, float, int]]) -> Iterator[tuple[str, str]]:
    """What `told` and `long` say of one car, of its stamps [ns] and places and how many cycles were lost before each: by all worlds that may be."""
    worlds: set[World] = set()
    last = 0
    for t, x, lost in seen:
        if not worlds:
            worlds = {("none", t, None)}
        elif lost and t - last > BRIDGES:
            names = {state for state, _, _ in worlds}
            while more := {to for name in names for to in LEADS[name]} - names:
                names |= more
            worlds |= {(name, None, None) for name in names}
        after: set[World] = set()
        for state, since, place in worlds:
            now = step(state, x)
            after.add((state, since, place) if now == state else (now, t, x if now == "near" else place))
        worlds, last = after, t
        states = {state for state, _, _ in worlds}
        near = None if "near" in states and len(states) > 1 else "near" in states
        sinces, places = {world[1] for world in worlds}, {world[2] for world in worlds}
        since = sinces.pop() if len(sinces) == 1 else None
        place = places.pop() if len(places) == 1 else None
        long = None if since is None else t - since > 500_000_000
        wide = None if place is None else place > 1
        # Kleene: both are asked, and one that is surely broken is enough.
        broken = True if True in (long, wide) else None if None in (long, wide) else False
        yield (
            "undefined" if near is None else "violated" if near else "satisfied",
            "inactive" if near is False
            else "undefined" if broken is None or (near is None and broken)
            else "satisfied" if not broken
            else "violated",
        )  # fmt: skip


def a_run(r: random.Random, unseen: float) -> list[tuple[int, float | None, bool]]:
    """Stamps, where the one car is (None: it is not seen), and whether the cycle is lost."""
    x, v, made, t, lost = r.uniform(-8, 8), 0.0, [], 0, 0
    for _ in range(60):
        lost = max(lost - 1, r.choice([0] * 11 + [1, 2, 5]))
        t += r.choice([100_000_000, 100_000_000, 50_000_000, 150_000_000])
        v = max(-3.0, min(3.0, v + r.uniform(-1.5, 1.5)))
        x += v
        if abs(x) > 9:
            v = -v
        made.append((t, None if r.random() < unseen else x, lost > 0))
    return made


def said(backend: str, spec: str, run: list[tuple[int, float | None, bool]]) -> list[tuple[str, str] | None]:
    evaluator = Evaluator(loads(spec), backend=backend)
    over, found = evaluator.over_run(), list[tuple[str, str] | None]()
    for t, x, lost in run:
        if lost:
            over.missed()
            continue
        objects: list[dict[str, Any]] = [] if x is None else [{"id": "o", "x": x}]
        given = {"t": t / 1e9, "signals": {"objects": objects, "flag": x is not None and x > 0}}
        rules = over.step(evaluator.read(given)).rules
        found.append(None if x is None else (rules["told"].verdict, rules["long"].verdict))
    return found


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("lasting", ["", "capacity 2 forget 0.45 s"])
def test_what_a_plain_simulation_of_all_worlds_says(backend: str, lasting: str) -> None:
    seen = set()
    for seed in range(amount(4, 60)):
        run = a_run(random.Random(seed), 0.12 if lasting else 0.0)
        # Lives: an absence ends one where nothing is kept, or after 0.45 s; lost cycles end none, but hide.
        lives: list[list[tuple[int, float, int]]] = []
        last, lost, absent, any_cycle = -1, 0, False, False
        for t, x, missing in run:
            if missing:
                lost += any_cycle
                continue
            any_cycle = True
            if x is None:
                absent, lost = True, lost + 1
                continue
            if not lives or (absent and t - last > 450_000_000):
                lives.append([])
            lives[-1].append((t, x, lost))
            last, lost, absent = t, 0, False
        wanted = [one for life in lives for one in told(life)]
        found = [one for one in said(backend, SPEC.format(lasting=lasting), run) if one is not None]
        assert found == wanted, seed
        seen |= {verdict for one in found for verdict in one}
    assert seen == {"satisfied", "violated", "undefined", "inactive"}


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize(("later", "verdict"), [(0.3, "violated"), (0.300000001, "undefined")])
def test_exactly_as_long_as_it_says(backend: str, later: float, verdict: str) -> None:
    """Lost for 0.3 s, it is what it was, and not so a nanosecond longer; in the meantime it may be anything."""
    evaluator = Evaluator(loads(SPEC.format(lasting="")), backend=backend)
    over = evaluator.over_run()
    for t, x in ((1.0, 1.0), (1.0 + later, 3.0)):
        given = {"t": t, "signals": {"objects": [{"id": "o", "x": x}], "flag": False}}
        found = over.step(evaluator.read(given)).rules
        over.missed()
    assert found["told"].verdict == verdict


@pytest.mark.parametrize("backend", ["numpy", C])
def test_saved_in_a_gap(backend: str) -> None:
    evaluator = Evaluator(loads(SPEC.format(lasting="")), backend=backend)

    def cycle(t: float, x: float) -> Any:
        return evaluator.read({"t": t, "signals": {"objects": [{"id": "o", "x": x}], "flag": True}})

    over = evaluator.over_run()
    over.step(cycle(0.0, 1.0))
    over.missed()
    again = evaluator.over_run(over.save())
    for t in (0.2, 0.4, 0.6):
        one, other = over.step(cycle(t, 3.0)).rules, again.step(cycle(t, 3.0)).rules
        for name in one:
            assert (one[name].verdict, float(one[name].margin).hex()) == (
                other[name].verdict,
                float(other[name].margin).hex(),
            )
    assert one["told"].verdict == "violated"
    assert not math.isnan(one["long"].margin)


def test_how_long_is_a_time_from_zero_on() -> None:
    for wrong in ("-1 s", "1 m", "4000001 h"):
        with pytest.raises(Diagnostics):
            loads(
                SPEC.format(lasting="").replace(
                    "bridges 0.3 s\n  becomes near", f"bridges {wrong}\n  becomes near"
                )
            )
