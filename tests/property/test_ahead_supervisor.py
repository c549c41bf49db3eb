"""What is decided of earlier cycles: Supervisors with random rules that look ahead decide alike, whatever rates them."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

import trackmarshal as tm
from property.test_fourth_supervisor import OPEN, cycles
from support.fourth.remembering import machine
from support.fourth.supervising import TOLD, of_the_plan
from support.fourth.writing import Writer
from support.length import amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.backends.c.layout import layout
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.evaluation import loads
from trackmarshal.ir.overrun import looks_ahead
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.cycle import Limits

REFUSED = {"E223", "E241", "E243"}


def written(seed: int) -> tuple[Writer, Spec | None]:
    """Rules of which about each second looks ahead, with what was driven and a state machine; None: refused with a word."""
    writer = Writer(seed, "run", True)
    writer.asks.append(lambda scope: of_the_plan(writer, scope))
    machine(writer, 0, 2)
    lines = [writer.rule(f"f{number}", 2)[0] for number in range(2)]
    held = f" capacity 4 forget {writer.dice.choice([0, 0.35])!r} s"
    declared = [one + held * one.startswith("signal objects") for one in writer.declared]
    try:
        return writer, loads("\n".join([*declared, TOLD, *lines]) + "\n")
    except Diagnostics as error:
        assert {one.code for one in error.items} <= REFUSED, error
        return writer, None


def decided(spec: Spec, backend: str, given: list[tuple[Any, dict[str, Any]]]) -> list[tuple[Any, ...]]:
    now = [0.0]
    supervisor = tm.supervisor(spec, backend=backend, clock=lambda: now[0], limits=Limits(**OPEN))
    said = []
    for cycle, raw in given:
        now[0] = cycle.stamp
        decision = supervisor.step(tm.Cycle(**raw))
        assert bool(decision.faults) == (cycle.signals is None), decision.faults
        against = [(one.rule, one.candidate, one.verdict, repr(one.margin)) for one in decision.violations]
        said.append((decision.state, sorted(against)))
    return said


@pytest.mark.parametrize(
    ("other", "seeds"),
    [
        ("reference", range(amount(24, 800))),
        pytest.param(
            "c",
            range(10, amount(13, 90)),
            marks=pytest.mark.skipif(compiler() is None, reason="no C compiler"),
        ),
    ],
)
def test_decisions(other: str, seeds: range) -> None:
    seen = Counter[str]()
    for seed in seeds:
        writer, spec = written(seed)
        if spec is None:
            continue
        given = cycles(writer)
        ours = decided(spec, "numpy", given)
        for number, (one, two) in enumerate(zip(ours, decided(spec, other, given), strict=True)):
            assert one == two, (seed, number)
        seen.update(state for state, _ in ours)
        seen["ahead"] += any(rule.formula is not None and looks_ahead(rule.formula) for rule in spec.rules)
    assert seen["ahead"], seen
    assert seen["drive"], seen


def test_generated_c_knows_again_what_the_door_asks_for() -> None:
    """Generation refuses where it would read ids of a set of which nobody demands any."""
    made = 0
    for seed in range(amount(25, 1500)):
        _, spec = written(seed)
        if spec is None:
            continue
        made += bool(layout(spec, spec.rules).named)
    assert made


def test_generation_refuses_to_know_again_what_no_door_asks_for(monkeypatch: pytest.MonkeyPatch) -> None:
    text = """module m
signal ego : state { v: m/s }
signal objects : set of object { x: m }
rule later "made up"
  exists o in objects
  require next ego.v < 3 m/s
"""
    spec = loads(text)
    assert [one.name for one in layout(spec, spec.rules).named] == ["objects"]
    monkeypatch.setattr("trackmarshal.backends.c.layout.known_again", lambda formula: frozenset())
    with pytest.raises(AssertionError, match=r"ids of \['objects'\]"):
        layout(spec, spec.rules)
