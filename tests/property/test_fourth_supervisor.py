"""What is driven, by the fourth evaluator: rules that look back, or live along a course, decide alike by every Supervisor, at what was driven and at what is rated."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import fields
from typing import Any

import pytest

import trackmarshal as tm
from support.fourth.remembering import machine
from support.fourth.supervising import TOLD, Cycle, Decided, Deciding, Rule, of_the_plan
from support.fourth.writing import Writer
from support.length import AT_LENGTH, amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import loads
from trackmarshal.runtime.cycle import Limits

SEEDS = amount(range(26, 38), range(300))
#: None but capacities, and times that Supervisors count in: whatever comes is judged, and driven until it is over.
OPEN: dict[str, Any] = {
    one.name: math.inf
    for one in fields(Limits)
    if one.name not in ("samples", "elements", "border", "rate", "shortest_gap", "clock_tolerance")
}
C = pytest.param(
    "c", marks=[pytest.mark.acceptance, pytest.mark.skipif(compiler() is None, reason="no C compiler")]
)


def written(seed: int, axes: tuple[str, ...]) -> tuple[Writer, str, dict[str, Rule], dict[str, Any]]:
    """Exact, so that no verdict is a matter of rounding; the last rule is advisory. What `Deciding` has to know besides."""
    writer = Writer(seed, "run", True)
    writer.ahead = False
    writer.asks.append(lambda scope: of_the_plan(writer, scope))
    machine(writer, 0, 2)
    asks, rules, lines, along = list(writer.asks), dict[str, Rule](), [], dict[str, bool]()
    for number, axis in enumerate(axes):
        writer.axis = axis
        writer.asks[:] = asks if axis == "run" else asks[:1]  # along a timeline there are no states
        writer.ahead = axis == "course"
        text, clauses, require = writer.rule(f"f{number}", 2)
        advisory = number == 2
        rules[f"f{number}"] = clauses, require, advisory
        if axis == "course":
            along[f"f{number}"] = "at last" in text
        lines.append(text.replace("\n", "\n  severity advisory\n", 1) if advisory else text)
    forget = writer.dice.choice([0, 0.35])
    declared = [
        one + f" capacity 4 forget {forget!r} s" * one.startswith("signal objects") for one in writer.declared
    ]
    known: dict[str, Any] = {"forget": round(forget * 1e9)}
    if along:
        tenths = writer.dice.choice([1, 4, 100])
        declared.append(f"course driven_so_far = ego for {tenths / 10!r} s then plan")
        known |= {"along": along, "lasting": tenths * 10**8}
        lines = [one.replace("along driven as", "along driven_so_far as") for one in lines]
    return writer, "\n".join([*declared, TOLD, *lines]) + "\n", rules, known


def cycles(writer: Writer) -> list[tuple[Cycle, dict[str, Any]]]:
    """As `Deciding` takes them, and the arguments of the Supervisor's. No stamp is one at which a sample is due, or at the edge of a window."""
    dice, stamp, present = writer.dice, 0.0, set[int]()
    found = []
    for number in range(9):
        present ^= {name for name in (1, 2, 3) if dice.random() < 0.3}
        given, meant = writer.cycle(sorted(present))
        other, its = writer.cycle([])
        refused = dice.random() < 0.15
        ego = {**given["ego"], "v": math.nan} if refused else given["ego"]
        signals = {"ego": ego, "objects": given["objects"]}
        candidates = {"driving": given["plan"], "emergency": other["plan"]}
        found.append(
            (
                Cycle(stamp, None if refused else meant, meant["plan"], its["plan"]),
                {"number": number, "t": stamp, "signals": signals, **candidates},
            )
        )
        stamp += dice.choice([0.1003, 0.1003, 0.2003, 0.5003])
    return found


@pytest.mark.parametrize("axes", [("run", "run", "run"), ("course", "run", "course")])
@pytest.mark.parametrize("backend", ["numpy", "reference", C])
def test_decisions(backend: str, axes: tuple[str, ...]) -> None:
    seen = Counter[str]()
    for seed in SEEDS if backend != "c" else SEEDS[::10]:
        writer, text, rules, known = written(seed, axes)
        try:
            spec = loads(text)
        except Diagnostics as error:
            assert {one.code for one in error.items} <= {"E223", "E241", "E243"}, (error, text)
            continue
        now = [0.0]
        supervisor = tm.supervisor(spec, backend=backend, clock=lambda now=now: now[0], limits=Limits(**OPEN))  # type: ignore[misc]
        deciding = Deciding(writer, rules, **known)
        for cycle, given in cycles(writer):
            now[0] = cycle.stamp
            decision = supervisor.step(tm.Cycle(**given))
            assert bool(decision.faults) == (cycle.signals is None), decision.faults
            ours = deciding.step(cycle)
            against = frozenset(
                (one.rule, one.candidate) for one in (*decision.violations, *decision.advisories)
            )
            said = Decided(decision.state, against)
            assert said == ours, (seed, given["number"], said, ours, text)
            seen[ours.state] += 1
    if backend != "c" or AT_LENGTH:  # of a few seeds there are not all
        assert set(seen) == {"no_emergency_yet", "drive", "previous_emergency", "no_safe_trajectory"}, seen
