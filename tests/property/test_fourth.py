"""The language by an evaluator that shares nothing with the engine, neither its parser nor its lowering: random specs and data mean the same to both.

Of what is not within a rounding of a boundary verdicts are the same, and margins to nine digits. What the engine refuses is left out: `E223`, of what
cannot be put together over the run, and machines whose guards forestall each other (`E241`, `E243`).
"""

from __future__ import annotations

import random
from typing import Any

import pytest

from support.fourth.meaning import judged
from support.fourth.remembering import machine, plain
from support.fourth.running import agree, scales
from support.fourth.writing import Writer
from support.length import AT_LENGTH, amount
from trackmarshal.backends.c.build import compiler
from trackmarshal.diagnostics.base import Diagnostics
from trackmarshal.errors import TrackmarshalError
from trackmarshal.evaluation import Evaluator, loads
from trackmarshal.ir.spec import Spec

SEEDS = amount(40, 1000)
DEPTH = 3
#: Whether generated C is held against it, too.
GENERATED = AT_LENGTH and compiler() is not None


def compiled(writer: Writer, lines: str, declared: list[str]) -> Spec | None:
    """The spec, or None where it says what cannot be asked over the run, or has guards that keep a machine from a state."""
    try:
        return loads("\n".join([*declared, lines]) + "\n")
    except Diagnostics as error:
        assert writer.axis == "run", lines
        assert {one.code for one in error.items} <= {"E223", "E241", "E243"}, (error, declared, lines)
        return None


@pytest.mark.parametrize("axis", ["alone", "along"])
def test_cases(axis: str) -> None:
    seen = set()
    for seed in range(SEEDS):
        writer = Writer(seed, axis, seed % 2 == 0)
        lines, clauses, require = writer.rule("f", DEPTH)
        spec = compiled(writer, lines, writer.declared)
        assert spec is not None
        given, meant = writer.cycle()
        env: dict[str, Any] = {"cycles": [meant], "k": 0, "scales": scales(writer, clauses, require)}
        if axis == "along":
            env |= {"along": "p", "p": ("plan", len(meant["plan"]) - 1 if "at last" in lines else 0)}
        ours = judged(clauses, require, env)
        seen.add(ours.verdict)
        for backend in ("numpy", "reference"):
            evaluator = Evaluator(spec, backend=backend)
            said = evaluator.case({"signals": given}).rules["f"]
            assert agree(ours, said.verdict, said.margin, writer.exact), (backend, seed, ours, lines, given)
    assert seen == {"satisfied", "violated", "inactive", "undefined"}


@pytest.mark.parametrize("machines", [0, 2])
def test_runs(machines: int) -> None:
    """Cycles are lost, objects come and go, and are forgotten after a while; what is open is said later, or at the end."""
    seen = set()
    for seed in range(SEEDS // (1 + machines)):
        writer = Writer(seed, "run", seed % 2 == 0)
        made = [machine(writer, number, DEPTH - 1) for number in range(machines)]
        rules = {"f": writer.rule("f", DEPTH)}
        rules |= {name: plain(writer, one, name) for one in made for name in (f"{one.name}s", f"{one.name}t")}
        forget = writer.dice.choice([None, 0, 0.25, 0.5, 1.0])
        kept = "" if forget is None else f" capacity 4 forget {forget!r} s"
        declared = [one + kept * one.startswith("signal objects") for one in writer.declared]
        spec = compiled(writer, "\n".join(text for text, _, _ in rules.values()), declared)
        if spec is None:
            continue
        cycles, meant = made_up(writer)
        places = dict[Any, Any]()
        for backend in ("numpy", "reference", *["c"] * (GENERATED and seed % 10 == 0)):
            try:
                found = told(Evaluator(spec, backend=backend), cycles)
            except TrackmarshalError as error:
                assert (backend, error.code) == ("c", "E470"), (seed, error)
                continue
            for name, (lines, clauses, require) in rules.items():
                for number, position in enumerate(at for at, cycle in enumerate(cycles) if cycle is not None):
                    env = {"cycles": meant, "k": number, "scales": scales(writer, clauses, require)}
                    env |= {"forget": round((forget or 0) * 1e9), "places": places}
                    ours = judged(clauses, require, env)
                    seen.add(ours.verdict)
                    where = backend, seed, position, ours, lines, declared, cycles
                    assert agree(ours, *found[name, position], writer.exact), where
    assert seen == {"satisfied", "violated", "inactive", "undefined"}


def made_up(writer: Writer) -> tuple[list[dict[str, Any] | None], list[dict[str, Any]]]:
    """Cycles as data, None where one was lost, and those that came as `meaning` takes them."""
    dice: random.Random = writer.dice
    cycles, meant = list[dict[str, Any] | None](), list[dict[str, Any]]()
    t, missed, present = 0.0, 0, set(dice.sample([1, 2, 3], dice.randint(0, 3)))
    for _ in range(dice.randint(3, 9)):
        if dice.random() < 0.15 and meant:
            cycles.append(None)
            missed += 1
            t += dice.choice([0.1, 0.2])
            continue
        present ^= {name for name in (1, 2, 3) if dice.random() < 0.25}
        ids = sorted(present)
        dice.shuffle(ids)
        given, its = writer.cycle(ids)
        cycles.append({"t": t, "id": len(cycles), "signals": given})
        meant.append({**its, "stamp": round(t * 1e9), "missed": missed})
        missed = 0
        t += dice.choice([0.1, 0.1, 0.2, 0.5])
    return cycles, meant


def told(
    evaluator: Evaluator, cycles: list[dict[str, Any] | None]
) -> dict[tuple[str, object], tuple[str, float]]:
    """By rule and cycle what is said of it in the end; what was said once does not become better."""
    run, found = evaluator.over_run(), dict[tuple[str, object], tuple[str, float]]()
    abouts = list[tuple[str, Any]]()
    for number, cycle in enumerate(cycles):
        if cycle is None:
            run.missed()
            continue
        for name, said in run.step(evaluator.read(cycle)).rules.items():
            abouts += [(name, one) for one in said.about]
            if not said.about:
                found[name, number] = said.verdict, said.margin
    abouts += [(name, one) for name, ones in run.end().items() for one in ones]
    for name, one in abouts:
        if one.verdict != "open":
            before, _ = found.get((name, one.cycle), (one.verdict, 0.0))
            # What nothing can make hold any more is undefined, until it is known to be violated.
            assert before == one.verdict or (before, one.verdict) == ("undefined", "violated")
            found[name, one.cycle] = one.verdict, one.margin
    return found
