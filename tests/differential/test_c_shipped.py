"""Generated C against the reference evaluator, bit for bit: the shipped rules on the paper's cases and on recordings."""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import pytest

from support import seed
from support.agreement import outcomes, same_witness
from support.length import at_length
from support.shared import oracle, shared
from support.supervised import shipped
from trackmarshal.backends.c.build import compiler
from trackmarshal.evaluation import Evaluator
from trackmarshal.ir.spec import Spec
from trackmarshal.runtime.frame import Frame
from trackmarshal.scenarios import load as load_recording
from trackmarshal.scenarios.fields import own_names
from trackmarshal.scenarios.overrides import known_tables
from trackmarshal.scenarios.recording import CANDIDATES

pytestmark = [pytest.mark.skipif(compiler() is None, reason="no C compiler"), pytest.mark.verifies("S-1-B-1")]

KINDS: dict[str, tuple[Callable[[dict[str, Any]], dict[str, Any]], list[str]]] = {
    "trajectory": (seed.trajectory, list(seed.TRAJECTORY_RULES.values())),
    "rss_eq1": (seed.following, ["rss_eq1", "safe_gap", "safe_gap_oncoming", "safe_side", "contact"]),
    "rect_rect": (seed.rectangles, ["contact"]),
    "corridor": (seed.corridor, ["static_collision"]),
}


@cache
def spec() -> Spec:
    return shipped()


@cache
def in_c() -> Evaluator:
    """All rules, optimized as they ship, in one program for whoever asks for several of them."""
    return Evaluator(spec(), None, "c")


def bits(x: float) -> bytes:
    """A double's bits; all NaNs are one."""
    return b"nan" if math.isnan(x) else struct.pack("<d", x)


def differences(rules: Sequence[str] | None, cases: Sequence[Frame]) -> list[str]:
    """Where C and the reference differ in a verdict or in any bit of a margin."""
    evaluator = Evaluator(spec(), rules, "reference")
    one = rules is not None and len(rules) == 1
    run = outcomes(Evaluator(spec(), rules, "c") if one else in_c(), cases)
    found = []
    for index, expected in enumerate(evaluator.evaluate(cases)):
        for rule in evaluator.rules:
            verdict, margin = run[index][rule.name]
            wanted = expected.rules[rule.name]
            if verdict != wanted.verdict or bits(margin) != bits(wanted.margin):
                found.append(
                    f"{expected.id} {rule.name}: C {verdict} {margin!r}, reference {wanted.verdict} {wanted.margin!r}"
                )
    return found


@pytest.mark.parametrize("kind", KINDS)
def test_seed_oracle(kind: str) -> None:
    convert, rules = KINDS[kind]
    door = Evaluator(spec(), rules if len(rules) == 1 else None, "reference")
    cases = [door.read(convert(case)) for case in oracle("seed_dev.json")["cases"] if case["kind"] == kind]
    assert len(cases) >= 70
    assert not differences(rules, cases)


@pytest.mark.parametrize(
    "name", [at_length("modena_T1_cutin_collision"), "modena_T1_infeasible", at_length("modena_T1_valid")]
)
def test_recording(name: str) -> None:
    """Both candidates of every tenth cycle, all rules."""
    recording = load_recording(shared("data", "scenarios", f"{name}.saa"))
    evaluator = Evaluator(spec(), None, "reference", lambda: own_names(recording))
    tables, _ = known_tables(recording, spec())
    cases = [
        evaluator.read(
            {
                "id": f"{cycle.t:g} {candidate}",
                "params": recording.params,
                "tables": tables,
                "signals": recording.signals(cycle, candidate),
            }
        )
        for cycle in recording.cycles[::10]
        for candidate in CANDIDATES
        if candidate in cycle.candidates
    ]
    assert len(cases) >= 10
    assert not differences(None, cases)


NAMES = ["friction", "pose_match", "braking_limit"]


def test_results_have_the_witnesses_of_the_reference() -> None:
    evaluator = Evaluator(spec(), NAMES, "reference")
    cases = [
        evaluator.read(seed.trajectory(case))
        for case in oracle("seed_dev.json")["cases"]
        if case["kind"] == "trajectory"
    ][:40]
    for one, other in zip(
        Evaluator(spec(), NAMES, "c").evaluate(cases), evaluator.evaluate(cases), strict=True
    ):
        assert one.safe == other.safe
        for name, result in one.rules.items():
            assert same_witness(result, other.rules[name])
            assert (result.unit, result.reason) == (other.rules[name].unit, other.rules[name].reason)
