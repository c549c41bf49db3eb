"""A Supervisor with a rule that is warned of as keeping it from starting does not start, whatever comes behind a first cycle that is not safe."""

from __future__ import annotations

from functools import partial
from typing import Any

import pytest

from property.test_ahead_supervisor import decided
from support.fourth.remembering import machine
from support.fourth.supervising import TOLD, Cycle, of_the_plan
from support.fourth.writing import Writer
from support.length import amount
from trackmarshal.semantics.compile import compile_text

pytestmark = pytest.mark.verifies("S-1-B-1")


HELD = 'event hold "for now"\nrule held "not yet"\n  require not hold\n'
#: For so long nothing is driven: for longer than windows reach that random rules have [s].
FOR = 1.4


def test_what_is_warned_of_never_starts() -> None:
    warned = started = 0
    for seed in amount((5, 10, 15, 278, 288, 293), range(2400)):
        writer = Writer(seed, "run", True)
        writer.asks.append(partial(of_the_plan, writer))
        machine(writer, 0, 2)
        rules = [writer.rule(f"f{number}", 2)[0] for number in range(2)]
        compiled = compile_text("\n".join([*writer.declared, TOLD, HELD, *rules]) + "\n")
        if compiled.errors:
            continue
        never = any(found.code == "W312" for found in compiled.found)
        if not never and seed % 5:
            continue
        states = {state for state, _ in decided(compiled.spec, "numpy", held(writer))}
        if never:
            warned += 1
            assert states == {"no_emergency_yet"}, (seed, rules)
        started += "drive" in states
    assert warned
    assert started


def held(writer: Writer) -> list[tuple[Cycle, dict[str, Any]]]:
    """Cycles a tenth of a second apart, none of which is refused, and all but the last ten of which are not safe."""
    found = []
    for number in range(round(FOR * 10) + 10):
        (given, meant), (other, its) = writer.cycle([1, 3]), writer.cycle([])
        stamp = number * 0.1003
        signals = {"ego": given["ego"], "objects": given["objects"], "hold": stamp < FOR}
        candidates = {"driving": given["plan"], "emergency": other["plan"]}
        found.append(
            (
                Cycle(stamp, meant, meant["plan"], its["plan"]),
                {"number": number, "t": stamp, "signals": signals, **candidates},
            )
        )
    return found
